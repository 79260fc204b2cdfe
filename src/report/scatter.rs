//! Points in small plots beside each other, as SVG: what several measures say of the same things.

use super::axis::{Axis, AxisRange};
use super::html::escape;
use super::plot::{COLORS, Frame, WIDTH, grid, letters_width, middle, style, text};

/// Small plots of the same things.
#[derive(Debug, Clone, PartialEq)]
pub struct Scatter {
    /// What they show, as a sentence without its point.
    pub title: String,
    /// What is shown, numbered from 1 in the legend.
    pub things: Vec<Thing>,
    /// The plots, row by row.
    pub panels: Vec<Panel>,
    /// How many stand beside each other, at least 1.
    pub columns: usize,
}

/// What is shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Thing {
    /// Its name in the legend.
    pub name: String,
    /// Which colour, by number; things of a kind have the same.
    pub color: usize,
}

/// One of the plots.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// What tells it from the others.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// A point of each thing; one that cannot be shown, not finite or not above 0 on a logarithmic
    /// axis, is left out.
    pub points: Vec<Point>,
}

/// Where a thing stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Along both axes.
    pub at: [f64; 2],
    /// Whether it is marked: a full disc in place of a ring.
    pub marked: bool,
}

const TOP: f64 = 36.0;
const PANEL_HEIGHT: f64 = 270.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 18.0;
const PANEL_TOP: f64 = 24.0;
const BOTTOM: f64 = 44.0;
const LEGEND_LINE: f64 = 18.0;
const RADIUS: f64 = 4.0;

impl Scatter {
    /// The plots as one SVG file.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let columns = self.columns.max(1);
        let width = WIDTH / columns as f64;
        let rows = self.panels.len().div_ceil(columns);
        let legend_top = TOP + PANEL_HEIGHT * rows as f64;
        let (legend, lines) = self.legend(legend_top);
        let height = legend_top + LEGEND_LINE * lines + 12.0;
        let (title, style) = (escape(&self.title), style());
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"spinney-plot\" role=\"img\" \
             aria-label=\"{title}\" width=\"{WIDTH}\" height=\"{height}\" \
             viewBox=\"0 0 {WIDTH} {height}\">\n{style}<style>.spinney-plot .ring{{fill-opacity:0}}</style>\n\
             <rect class=\"ground\" width=\"{WIDTH}\" height=\"{height}\"/>\n"
        );
        let bold = " font-size=\"14\" font-weight=\"600\"";
        svg += &text(14.0, 22.0, "start", bold, &self.title);
        for (place, panel) in self.panels.iter().enumerate() {
            let across = width * (place % columns) as f64;
            let down = TOP + PANEL_HEIGHT * (place / columns) as f64;
            svg += &format!("<g transform=\"translate({across:.1} {down:.1})\">\n");
            svg += &self.panel(panel, width);
            svg += "</g>\n";
        }
        svg + &legend + "</svg>\n"
    }

    fn panel(&self, panel: &Panel, width: f64) -> String {
        let frame = Frame {
            left: LEFT,
            right: width - RIGHT,
            top: PANEL_TOP,
            bottom: PANEL_HEIGHT - BOTTOM,
        };
        let shows = |[x, y]: &[f64; 2]| panel.x.scale.shows(*x) && panel.y.scale.shows(*y);
        let shown = || panel.points.iter().map(|point| point.at).filter(shows);
        let x = AxisRange::round(panel.x.scale, shown().map(|[x, _]| x));
        let y = AxisRange::round(panel.y.scale, shown().map(|[_, y]| y));
        let across = middle(frame.left, frame.right);
        let down = middle(frame.top, frame.bottom);
        let turn = format!(" transform=\"rotate(-90 14 {down:.1})\"");
        let strong = " font-weight=\"600\"";
        let mut svg = grid(&frame, &x, &y)
            + &text(frame.left, 16.0, "start", strong, &panel.title)
            + &text(across, PANEL_HEIGHT - 10.0, "middle", "", &panel.x.label)
            + &text(14.0, down, "middle", &turn, &panel.y.label);
        let places: Vec<Place> = self.places(panel, &frame, &x, &y);
        for place in &places {
            let [x, y] = place.at;
            let ring = if place.marked { "" } else { " ring" };
            svg += &format!(
                "<circle class=\"c{}{ring}\" stroke-width=\"1.8\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{RADIUS}\"/>\n",
                place.color
            );
        }
        if places.is_empty() {
            svg += &text(across, down, "middle", "", "nothing to show");
        }
        svg + &labels(&places, &frame)
    }

    /// Where points lie; those in the same place together.
    fn places(&self, panel: &Panel, frame: &Frame, x: &AxisRange, y: &AxisRange) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        for ((number, thing), point) in (1..).zip(&self.things).zip(&panel.points) {
            let (Some(across), Some(up)) = (x.share(point.at[0]), y.share(point.at[1])) else {
                continue;
            };
            let at = [
                frame.left + across * (frame.right - frame.left),
                frame.bottom - up * (frame.bottom - frame.top),
            ];
            let color = thing.color % COLORS.len();
            let is_like = |place: &Place| place.color == color && place.marked == point.marked;
            let is_here = |place: &Place| match distance(place.at, at) {
                far if far < 1.0 => true,
                // Close by, only what looks the same.
                far => far < RADIUS && is_like(place),
            };
            match places.iter_mut().find(|place| is_here(place)) {
                Some(place) => {
                    place.name += &format!(" {number}");
                    place.marked |= point.marked;
                }
                None => places.push(Place {
                    at,
                    name: number.to_string(),
                    color,
                    marked: point.marked,
                }),
            }
        }
        places
    }

    /// Numbers and names in columns, and how many lines they take.
    fn legend(&self, top: f64) -> (String, f64) {
        let widest = self.things.iter().map(|thing| letters_width(&thing.name));
        let column = 36.0 + widest.fold(0.0, f64::max) + 12.0;
        let fits = |columns: &usize| 14.0 + column * *columns as f64 <= WIDTH;
        let columns = (1..=self.things.len()).take_while(fits).count().max(1);
        let lines = self.things.len().div_ceil(columns);
        let mut svg = String::new();
        for (index, thing) in self.things.iter().enumerate() {
            let left = 14.0 + column * (index / lines) as f64;
            let base = top + LEGEND_LINE * (index % lines) as f64 + 14.0;
            let color = thing.color % COLORS.len();
            svg += &format!(
                "<circle class=\"c{color}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{RADIUS}\"/>\n",
                left + RADIUS,
                base - RADIUS
            );
            svg += &text(left + 28.0, base, "end", "", &(index + 1).to_string());
            svg += &text(left + 34.0, base, "start", "", &thing.name);
        }
        (svg, lines as f64)
    }
}

/// A place with everything that stands there.
struct Place {
    at: [f64; 2],
    name: String,
    color: usize,
    marked: bool,
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// Left, right, top and bottom.
type Rectangle = [f64; 4];

fn meet(a: Rectangle, b: Rectangle) -> bool {
    a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3]
}

/// The names of places, each where it covers no place and no other name, if there is such.
fn labels(places: &[Place], frame: &Frame) -> String {
    let disc = |place: &Place| {
        let [x, y] = place.at;
        [x - RADIUS, x + RADIUS, y - RADIUS, y + RADIUS]
    };
    let mut taken: Vec<Rectangle> = places.iter().map(disc).collect();
    let mut svg = String::new();
    for place in places {
        let [x, y] = place.at;
        let width = letters_width(&place.name);
        // Left end and base line: beside, above, below, then farther away.
        let ends = [7.0, 15.0, 24.0].into_iter().flat_map(|far| {
            [
                (x + far, y + 4.0),
                (x - far - width, y + 4.0),
                (x - 0.5 * width, y - far),
                (x - 0.5 * width, y + far + 9.0),
                (x + 0.8 * far, y - 0.8 * far),
                (x + 0.8 * far, y + 0.8 * far + 8.0),
                (x - 0.8 * far - width, y - 0.8 * far),
                (x - 0.8 * far - width, y + 0.8 * far + 8.0),
            ]
        });
        let area = |(left, base): (f64, f64)| [left, left + width, base - 9.0, base + 1.0];
        let is_free = |end: &(f64, f64)| {
            let area = area(*end);
            let inside = area[0] >= frame.left && area[1] <= frame.right + RIGHT;
            let inside = inside && area[2] >= frame.top && area[3] <= frame.bottom;
            inside && !taken.iter().any(|other| meet(area, *other))
        };
        let (left, base) = ends.clone().find(is_free).unwrap_or((x + 7.0, y + 4.0));
        taken.push(area((left, base)));
        svg += &text(left, base, "start", "", &place.name);
    }
    svg
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Scale;

    fn scatter(points: Vec<Point>) -> Scatter {
        let axis = |label: &str| Axis {
            label: label.to_owned(),
            scale: Scale::Log,
        };
        let thing = |(number, _): (usize, &Point)| Thing {
            name: format!("thing <{number}>"),
            color: number,
        };
        Scatter {
            title: "Things & \"more\"".to_owned(),
            things: points.iter().enumerate().map(thing).collect(),
            panels: vec![Panel {
                title: "here".to_owned(),
                x: axis("x"),
                y: axis("y"),
                points,
            }],
            columns: 2,
        }
    }

    fn point(at: [f64; 2], marked: bool) -> Point {
        Point { at, marked }
    }

    #[test]
    fn marked_points_are_discs_and_equal_ones_are_one() {
        let svg = scatter(vec![
            point([1.0, 1.0], true),
            point([100.0, 100.0], false),
            point([100.0, 100.0], false),
            point([0.0, 1.0], true),
        ])
        .to_svg();
        // Left 62, right 302, top 24, bottom 226.
        let disc = "<circle class=\"c0\" stroke-width=\"1.8\" cx=\"62.0\" cy=\"226.0\"";
        let ring = "<circle class=\"c1 ring\" stroke-width=\"1.8\" cx=\"302.0\" cy=\"24.0\"";
        assert!(svg.contains(disc) && svg.contains(ring), "{svg}");
        assert!(svg.contains(">2 3</text>"), "{svg}");
        assert_eq!(svg.matches("stroke-width=\"1.8\" cx").count(), 2, "{svg}");
        assert!(
            svg.contains("thing &lt;3&gt;") && !svg.contains("NaN"),
            "{svg}"
        );
    }

    #[test]
    fn names_do_not_cover_each_other() {
        let frame = Frame {
            left: 0.0,
            right: 300.0,
            top: 0.0,
            bottom: 200.0,
        };
        let place = |index: u8| Place {
            at: [150.0 + f64::from(index), 100.0],
            name: "77".to_owned(),
            color: 0,
            marked: false,
        };
        let svg = labels(&[0, 2, 4, 6, 8].map(place), &frame);
        let mut spots: Vec<&str> = svg
            .lines()
            .filter_map(|line| line.split(" text-").next())
            .collect();
        spots.sort_unstable();
        spots.dedup();
        assert_eq!(spots.len(), 5, "{svg}");
    }

    #[test]
    fn nothing_can_be_shown_too() {
        for points in [vec![], vec![point([f64::NAN, -1.0], true)]] {
            assert!(scatter(points).to_svg().contains("nothing to show"));
        }
    }
}
