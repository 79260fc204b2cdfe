//! Stacked bars as SVG: what several causes have of a whole, from frame to frame or step to step.

use super::axis::{Axis, AxisRange, Scale};
use super::html::escape;
use super::plot::{COLORS, Frame, grid, letters_width, middle, style, text};

/// Stacked bars.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// What it shows, in a few words.
    pub title: String,
    /// The horizontal axis, [linear](Scale::Linear).
    pub x: Axis,
    /// What the bars measure, with its unit.
    pub label: String,
    /// Where the bars stand, ascending.
    pub places: Vec<f64>,
    /// What stands above each other, from the axis up.
    pub layers: Vec<StackLayer>,
    /// Width and height in pixels.
    pub size: [f64; 2],
}

/// What one cause has of each bar.
#[derive(Debug, Clone, PartialEq)]
pub struct StackLayer {
    /// Its name in the legend.
    pub name: String,
    /// Which colour, by number; the same cause has the same in several plots.
    pub color: usize,
    /// A value a bar, none below 0; what is missing is 0.
    pub values: Vec<f64>,
}

impl Stack {
    /// A plot as wide as a page.
    pub const WIDE: [f64; 2] = [640.0, 320.0];

    /// A plot of which several stand beside each other.
    pub const SMALL: [f64; 2] = [320.0, 220.0];

    const LEFT: f64 = 54.0;
    const RIGHT: f64 = 14.0;
    const TOP: f64 = 30.0;
    const BOTTOM: f64 = 42.0;
    const LEGEND_LINE: f64 = 17.0;

    /// The narrowest bar in pixels; where they would be narrower, several become one with their mean.
    const NARROWEST: f64 = 3.0;

    /// The bars as an SVG file.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let [width, height] = self.size;
        let (legend, lines) = self.legend();
        let frame = Frame {
            left: Self::LEFT,
            right: width - Self::RIGHT,
            top: Self::TOP + Self::LEGEND_LINE * lines,
            bottom: height - Self::BOTTOM,
        };
        let bars = self.bars((frame.right - frame.left) / Self::NARROWEST);
        let sums = bars.iter().map(|bar| bar.values.iter().sum::<f64>());
        let ends = bars.iter().flat_map(|bar| bar.ends);
        let x = AxisRange::tight(Scale::Linear, ends);
        let y = AxisRange::round(Scale::Linear, sums.chain([0.0]));
        let (title, style) = (escape(&self.title), style());
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"spinney-plot\" role=\"img\" \
             aria-label=\"{title}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n{style}\
             <style>.spinney-plot .bar.bar{{stroke:none}}.spinney-plot .second{{fill-opacity:.5}}</style>\n\
             <rect class=\"ground\" width=\"{width}\" height=\"{height}\"/>\n"
        );
        let (across, down) = (
            middle(frame.left, frame.right),
            middle(frame.top, frame.bottom),
        );
        let turn = format!(" transform=\"rotate(-90 12 {down:.1})\"");
        svg += &text(
            4.0,
            18.0,
            "start",
            " font-size=\"14\" font-weight=\"600\"",
            &self.title,
        );
        svg += &legend;
        svg += &grid(&frame, &x, &y);
        svg += &text(across, height - 6.0, "middle", "", &self.x.label);
        svg += &text(12.0, down, "middle", &turn, &self.label);
        for index in 0..self.layers.len() {
            svg += &self.layer(index, &bars, &frame, (&x, &y));
        }
        if self.places.is_empty() || self.layers.is_empty() {
            svg += &text(across, down, "middle", "", "nothing to show");
        }
        svg + "</svg>\n"
    }

    /// Bars of which at most so many fit.
    fn bars(&self, most: f64) -> Vec<Bar> {
        let count = self.places.len();
        let together = (count as f64 / most).ceil().max(1.0);
        let size = (1..=count)
            .find(|&size| size as f64 >= together)
            .unwrap_or(1);
        let (first, last) = (self.places.first(), self.places.last());
        let step = match (first, last) {
            (Some(first), Some(last)) if last > first => (last - first) / (count - 1) as f64,
            _ => 1.0,
        };
        let bar = |(index, places): (usize, &[f64])| {
            let here = index * size..index * size + places.len();
            let mean = |layer: &StackLayer| {
                let values = here
                    .clone()
                    .map(|at| layer.values.get(at).copied().unwrap_or(0.0));
                let sound = values.filter(|value| *value > 0.0 && value.is_finite());
                sound.sum::<f64>() / places.len() as f64
            };
            let (first, last) = (places[0], places[places.len() - 1]);
            Bar {
                ends: [first - 0.5 * step, last + 0.5 * step],
                values: self.layers.iter().map(mean).collect(),
            }
        };
        self.places.chunks(size).enumerate().map(bar).collect()
    }

    /// A layer as one path: a rectangle a bar that has any of it.
    fn layer(
        &self,
        index: usize,
        bars: &[Bar],
        frame: &Frame,
        (x, y): (&AxisRange, &AxisRange),
    ) -> String {
        let across = |value| {
            let share = x.share(value).unwrap_or(0.0);
            frame.left + share * (frame.right - frame.left)
        };
        let up = |value| {
            let share = y.share(value).unwrap_or(0.0);
            frame.bottom - share * (frame.bottom - frame.top)
        };
        let mut path = String::new();
        for bar in bars.iter().filter(|bar| bar.values[index] > 0.0) {
            let below: f64 = bar.values[..index].iter().sum();
            let [low, high] = [up(below), up(below + bar.values[index])];
            let [left, right] = bar.ends.map(across);
            // A hair of ground between bars, where they are wide enough for it.
            let gap = (0.12 * (right - left)).clamp(0.0, 3.0);
            let gap = if right - left < 5.0 { 0.0 } else { 0.5 * gap };
            let (left, right) = (left + gap, right - gap);
            path += &format!("M{left:.1} {low:.1}V{high:.1}H{right:.1}V{low:.1}z");
        }
        match path.is_empty() {
            true => String::new(),
            false => format!(
                "<path class=\"bar {}\" d=\"{path}\"/>\n",
                look(&self.layers[index])
            ),
        }
    }

    /// Squares with names, as many beside each other as fit.
    fn legend(&self) -> (String, f64) {
        let mut svg = String::new();
        let (mut left, mut lines) = (4.0, 1.0);
        for layer in &self.layers {
            let width = 15.0 + letters_width(&layer.name) + 12.0;
            if left > 4.0 && left + width > self.size[0] {
                left = 4.0;
                lines += 1.0;
            }
            let base = Self::TOP + Self::LEGEND_LINE * (lines - 1.0) + 8.0;
            svg += &format!(
                "<rect class=\"bar {}\" x=\"{left:.1}\" y=\"{:.1}\" width=\"10\" height=\"10\"/>\n",
                look(layer),
                base - 9.0
            );
            svg += &text(left + 15.0, base, "start", "", &layer.name);
            left += width;
        }
        (svg, lines)
    }
}

/// A bar: from where to where, and a value a layer.
struct Bar {
    ends: [f64; 2],
    values: Vec<f64>,
}

/// The classes of a layer; after the first six colours they come again, paler.
fn look(layer: &StackLayer) -> String {
    let class = format!("c{}", layer.color % COLORS.len());
    match layer.color / COLORS.len() % 2 {
        0 => class,
        _ => class + " second",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stack(places: usize, layers: Vec<(&str, Vec<f64>)>) -> Stack {
        let layer = |(color, (name, values)): (usize, (&str, Vec<f64>))| StackLayer {
            name: name.to_owned(),
            color,
            values,
        };
        Stack {
            title: "Bytes & <causes>".to_owned(),
            x: Axis {
                label: "frame".to_owned(),
                scale: Scale::Linear,
            },
            label: "B".to_owned(),
            places: (0..places).map(|place| place as f64).collect(),
            layers: layers.into_iter().enumerate().map(layer).collect(),
            size: Stack::SMALL,
        }
    }

    #[test]
    fn bars_stand_on_each_other() {
        // Left 54, right 306, bottom 178, top 47; the axis goes to 10.
        let svg = stack(2, vec![("view", vec![4.0, 2.0]), ("slot", vec![6.0, 0.0])]).to_svg();
        let below = "<path class=\"bar c0\" d=\"M55.5 178.0V125.6H178.5V178.0zM181.5 178.0V151.8H304.5V178.0z\"/>";
        let above = "<path class=\"bar c1\" d=\"M55.5 125.6V47.0H178.5V125.6z\"/>";
        assert!(svg.contains(below) && svg.contains(above), "{svg}");
        assert!(svg.contains(">Bytes &amp; &lt;causes&gt;</text>"), "{svg}");
    }

    #[test]
    fn very_many_bars_become_fewer_with_their_means() {
        let ones = stack(1000, vec![("view", vec![2.0; 1000])]);
        let bars = ones.bars(84.0);
        assert_eq!(bars.len(), 84);
        assert_eq!((bars[0].ends, bars[0].values[0]), ([-0.5, 11.5], 2.0));
        // The last one has fewer, and its own mean.
        assert_eq!((bars[83].ends, bars[83].values[0]), ([995.5, 999.5], 2.0));
    }

    #[test]
    fn anything_can_be_shown() {
        assert!(stack(0, Vec::new()).to_svg().contains("nothing to show"));
        let wild = vec![f64::NAN, f64::INFINITY, -1.0, 0.0];
        let svg = stack(5, vec![("a", wild), ("b", Vec::new())]).to_svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let many = (0..14).map(|index| ("cause", vec![f64::from(index)]));
        let svg = stack(1, many.collect()).to_svg();
        assert!(
            svg.contains("class=\"bar c1 second\"") && !svg.contains("c6"),
            "{svg}"
        );
    }
}
