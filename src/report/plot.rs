//! Line plots as SVG: self-contained, light or dark as the reader has it.

use super::axis::{Axis, AxisRange};
use super::html::escape;

/// A line plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// What it shows, as a sentence without its point.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The lines, in the order of the legend.
    pub series: Vec<Series>,
}

/// One line of a plot.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// The name in the legend.
    pub name: String,
    /// Points (x, y), in the order in which the line visits them. The line is broken at points that
    /// cannot be shown: not finite, or not above 0 on a logarithmic axis.
    pub points: Vec<[f64; 2]>,
}

impl Plot {
    /// The plot as an SVG file.
    ///
    /// Of a line of very many points only the highest and lowest in each pixel's width are drawn.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let legend = self.legend();
        let frame = Frame {
            left: LEFT,
            right: WIDTH - RIGHT,
            top: TOP + LEGEND_LINE * legend.lines,
            bottom: HEIGHT - BOTTOM,
        };
        let (x, y) = self.ranges();
        let mut svg = self.head();
        svg += &grid(&frame, &x, &y);
        svg += &self.labels(&frame);
        svg += &legend.svg;
        for (index, series) in self.series.iter().enumerate() {
            svg += &line(index, &pixels(&series.points, &frame, &x, &y));
        }
        if self.shown().next().is_none() {
            svg += &text(
                middle(frame.left, frame.right),
                middle(frame.top, frame.bottom),
                "middle",
                "",
                "nothing to show",
            );
        }
        svg += "</svg>\n";
        svg
    }

    /// The points that can be shown.
    fn shown(&self) -> impl Iterator<Item = [f64; 2]> + Clone {
        let points = self.series.iter().flat_map(|series| &series.points);
        points
            .copied()
            .filter(|[x, y]| self.x.scale.shows(*x) && self.y.scale.shows(*y))
    }

    fn ranges(&self) -> (AxisRange, AxisRange) {
        let x = AxisRange::tight(self.x.scale, self.shown().map(|[x, _]| x));
        let y = AxisRange::round(self.y.scale, self.shown().map(|[_, y]| y));
        (x, y)
    }

    fn head(&self) -> String {
        let title = escape(&self.title);
        let style = style();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"spinney-plot\" role=\"img\" \
             aria-label=\"{title}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
             viewBox=\"0 0 {WIDTH} {HEIGHT}\">\n{style}\
             <rect class=\"ground\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/>\n"
        )
    }

    fn labels(&self, frame: &Frame) -> String {
        let across = middle(frame.left, frame.right);
        let down = middle(frame.top, frame.bottom);
        let turn = format!(" transform=\"rotate(-90 14 {down:.1})\"");
        let bold = " font-size=\"14\" font-weight=\"600\"";
        text(frame.left, 22.0, "start", bold, &self.title)
            + &text(across, HEIGHT - 10.0, "middle", "", &self.x.label)
            + &text(14.0, down, "middle", &turn, &self.y.label)
    }

    /// Names with a piece of their line, as many beside each other as fit.
    fn legend(&self) -> Legend {
        let mut svg = String::new();
        let (mut left, mut lines) = (LEFT, 1.0);
        for (index, series) in self.series.iter().enumerate() {
            let width = 32.0 + letters_width(&series.name) + 16.0;
            if left > LEFT && left + width > WIDTH {
                left = LEFT;
                lines += 1.0;
            }
            let height = 22.0 + LEGEND_LINE * lines;
            let (class, dashes) = look(index);
            let end = left + 24.0;
            let middle = height - 4.0;
            svg += &format!(
                "<path class=\"line {class}\"{dashes} d=\"M{left:.1} {middle:.1}H{end:.1}\"/>\n"
            );
            svg += &text(left + 30.0, height, "start", "", &series.name);
            left += width;
        }
        Legend { svg, lines }
    }
}

struct Legend {
    svg: String,
    lines: f64,
}

/// The rectangle that lines are drawn in, in pixels.
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

pub(super) const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 68.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 36.0;
const BOTTOM: f64 = 50.0;
const LEGEND_LINE: f64 = 18.0;

/// Pixels from left to right of the frame, where lines are thinned.
const COLUMNS: usize = 552;

/// The colours of lines, on light and on dark ground: of like strength, and told apart by people
/// who do not see red or green.
pub(super) const COLORS: [(&str, &str); 6] = [
    ("#0068a8", "#5ab4f0"),
    ("#c85200", "#ff9a4d"),
    ("#00805c", "#3ecfa3"),
    ("#a8488a", "#e896c8"),
    ("#7a6a00", "#e0cc40"),
    ("#555e68", "#aab4be"),
];

/// Dashes, for the lines after the first six: colours begin again with the next.
const DASHES: [&str; 4] = ["", "7 4", "2 3", "10 3 2 3"];

pub(super) fn style() -> String {
    let colors = |dark: bool| -> String {
        let of = |(index, (light, night)): (usize, &(&str, &str))| {
            let color = if dark { night } else { light };
            format!(".spinney-plot .c{index}{{stroke:{color};fill:{color}}}")
        };
        COLORS.iter().enumerate().map(of).collect()
    };
    format!(
        "<style>.spinney-plot{{font:12px system-ui,sans-serif}}.spinney-plot .ground{{fill:#fff}}\
         .spinney-plot text{{fill:#24292f}}.spinney-plot .grid{{stroke:#24292f;stroke-opacity:.15}}\
         .spinney-plot .axis{{stroke:#24292f;stroke-opacity:.6;fill:none}}{}\
         .spinney-plot .line{{fill:none;stroke-width:1.8;stroke-linejoin:round}}\
         @media screen and (prefers-color-scheme:dark){{.spinney-plot .ground{{fill:#15181c}}\
         .spinney-plot text{{fill:#dde3ea}}.spinney-plot .grid,.spinney-plot .axis{{stroke:#dde3ea}}{}\
         .spinney-plot .line{{fill:none}}}}</style>\n",
        colors(false),
        colors(true)
    )
}

/// The class and the dashes of a line.
fn look(index: usize) -> (String, String) {
    let class = format!("c{}", index % COLORS.len());
    match DASHES[index / COLORS.len() % DASHES.len()] {
        "" => (class, String::new()),
        dashes => (class, format!(" stroke-dasharray=\"{dashes}\"")),
    }
}

pub(super) fn grid(frame: &Frame, x: &AxisRange, y: &AxisRange) -> String {
    let Frame {
        left,
        right,
        top,
        bottom,
    } = *frame;
    let mut svg = String::new();
    let mut free = f64::NEG_INFINITY;
    for (share, label) in x.ticks() {
        let at = left + share * (right - left);
        svg += &format!("<path class=\"grid\" d=\"M{at:.1} {top:.1}V{bottom:.1}\"/>\n");
        // Where ticks are dense, not all have room for what they say.
        let half = 0.5 * letters_width(&label);
        if at - half >= free {
            svg += &text(at, bottom + 17.0, "middle", "", &label);
            free = at + half + 6.0;
        }
    }
    for (share, label) in y.ticks() {
        let at = bottom - share * (bottom - top);
        svg += &format!("<path class=\"grid\" d=\"M{left:.1} {at:.1}H{right:.1}\"/>\n");
        svg += &text(left - 7.0, at + 4.0, "end", "", &label);
    }
    svg + &format!("<path class=\"axis\" d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\"/>\n")
}

pub(super) fn text(x: f64, y: f64, anchor: &str, attributes: &str, text: &str) -> String {
    let text = escape(text);
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{attributes}>{text}</text>\n")
}

/// A letter of the 12-pixel font takes 7 pixels at most, nearly always.
pub(super) fn letters_width(text: &str) -> f64 {
    7.0 * text.chars().count() as f64
}

pub(super) fn middle(from: f64, to: f64) -> f64 {
    0.5 * (from + to)
}

/// Where points lie, thinned; `None` where the line is broken.
fn pixels(
    points: &[[f64; 2]],
    frame: &Frame,
    x: &AxisRange,
    y: &AxisRange,
) -> Vec<Option<[f64; 2]>> {
    let place = |[px, py]: [f64; 2]| {
        let (across, up) = (x.share(px)?, y.share(py)?);
        Some([
            frame.left + across * (frame.right - frame.left),
            frame.bottom - up * (frame.bottom - frame.top),
        ])
    };
    let placed: Vec<Option<[f64; 2]>> = points.iter().copied().map(place).collect();
    if placed.len() <= 4 * COLUMNS {
        return placed;
    }
    let size = placed.len().div_ceil(COLUMNS);
    placed.chunks(size).flat_map(thinned).collect()
}

/// The first, lowest, highest and last point of a run, in order; a break, if there is one.
fn thinned(run: &[Option<[f64; 2]>]) -> Vec<Option<[f64; 2]>> {
    let height = |index: &usize| run[*index].map_or(f64::NAN, |[_, y]| y);
    let there: Vec<usize> = (0..run.len())
        .filter(|index| run[*index].is_some())
        .collect();
    let by_height = |a: &usize, b: &usize| height(a).total_cmp(&height(b));
    let (Some(first), Some(last)) = (there.first(), there.last()) else {
        return vec![None];
    };
    let lowest = there.iter().copied().min_by(by_height).unwrap_or(*first);
    let highest = there.iter().copied().max_by(by_height).unwrap_or(*last);
    let mut kept = vec![*first, lowest, highest, *last];
    kept.extend(run.iter().position(Option::is_none));
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|index| run[index]).collect()
}

/// A line through points, with dots where it has few, and where a point stands alone.
fn line(index: usize, points: &[Option<[f64; 2]>]) -> String {
    let (class, dashes) = look(index);
    let mut path = String::new();
    let mut dots = String::new();
    let is_there = |index: usize| points.get(index).is_some_and(Option::is_some);
    for (place, point) in points.iter().enumerate() {
        let Some([x, y]) = point else { continue };
        let follows = place > 0 && is_there(place - 1);
        let command = if follows { 'L' } else { 'M' };
        path += &format!("{command}{x:.1} {y:.1}");
        if points.len() <= 40 || !(follows || is_there(place + 1)) {
            dots += &format!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.2\"/>\n");
        }
    }
    if path.is_empty() {
        return String::new();
    }
    format!("<path class=\"line {class}\"{dashes} d=\"{path}\"/>\n{dots}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Scale;

    fn axis(label: &str, scale: Scale) -> Axis {
        Axis {
            label: label.to_owned(),
            scale,
        }
    }

    fn series(name: &str, points: Vec<[f64; 2]>) -> Series {
        Series {
            name: name.to_owned(),
            points,
        }
    }

    fn plot(scale: Scale, series: Vec<Series>) -> Plot {
        Plot {
            title: "Payload <of> \"each\" frame & more".to_owned(),
            x: axis("frame", Scale::Linear),
            y: axis("payload, B", scale),
            series,
        }
    }

    /// Every tag is closed in order, attributes are quoted, `&` begins an entity.
    fn assert_well_formed(svg: &str) {
        let mut open: Vec<&str> = Vec::new();
        for piece in svg.split('<').skip(1) {
            let (tag, text) = piece.split_once('>').expect("tags end");
            assert!(
                !text.contains('>') || open.last() == Some(&"style"),
                "{piece}"
            );
            assert!(tag.matches('"').count().is_multiple_of(2), "{tag}");
            let name = tag
                .trim_start_matches('/')
                .split([' ', '/'])
                .next()
                .unwrap_or("");
            if tag.starts_with('/') {
                assert_eq!(open.pop(), Some(name), "{tag}");
            } else if !tag.ends_with('/') {
                open.push(name);
            }
        }
        assert!(open.is_empty(), "{open:?}");
        let entities = ["amp;", "lt;", "gt;", "quot;", "#39;"];
        for rest in svg.split('&').skip(1) {
            assert!(
                entities.iter().any(|entity| rest.starts_with(entity)),
                "{rest}"
            );
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn points_stand_where_the_axes_say() {
        let svg = plot(
            Scale::Linear,
            vec![series("a", vec![[0.0, 0.0], [10.0, 100.0], [5.0, 50.0]])],
        )
        .to_svg();
        assert_well_formed(&svg);
        // Left 68, right 620, bottom 350, top 36 + one line of legend.
        assert!(
            svg.contains("d=\"M68.0 350.0L620.0 54.0L344.0 202.0\""),
            "{svg}"
        );
    }

    #[test]
    fn lines_break_where_nothing_can_be_shown() {
        let points = vec![
            [0.0, 1.0],
            [1.0, 0.0],
            [2.0, 10.0],
            [3.0, f64::NAN],
            [4.0, 100.0],
        ];
        let svg = plot(Scale::Log, vec![series("a", points)]).to_svg();
        assert_well_formed(&svg);
        assert!(
            svg.contains("d=\"M68.0 350.0M344.0 202.0M620.0 54.0\""),
            "{svg}"
        );
    }

    #[test]
    fn any_plot_is_well_formed() {
        let ends = [
            f64::NAN,
            f64::INFINITY,
            -1e300,
            -1.0,
            0.0,
            1e-300,
            5.0,
            1e300,
        ];
        let points: Vec<[f64; 2]> = ends
            .iter()
            .flat_map(|x| ends.iter().map(|y| [*x, *y]))
            .collect();
        for scale in [Scale::Linear, Scale::Log] {
            assert_well_formed(&plot(scale, Vec::new()).to_svg());
            assert_well_formed(&plot(scale, vec![series("]]>&\u{0}", points.clone())]).to_svg());
            let many = (0..40).map(|index| series(&format!("series {index}"), vec![[1.0, 2.0]]));
            assert_well_formed(&plot(scale, many.collect()).to_svg());
        }
    }

    #[test]
    fn long_lines_keep_their_peaks() {
        let mut points: Vec<[f64; 2]> = (0..100_000).map(|x| [f64::from(x), 1.0]).collect();
        points[54_321][1] = 9.0;
        let svg = plot(Scale::Linear, vec![series("a", points)]).to_svg();
        assert!(svg.len() < 60_000, "{}", svg.len());
        assert!(
            svg.contains(" 83.6L"),
            "the peak, at nine tenths of the height"
        );
    }
}
