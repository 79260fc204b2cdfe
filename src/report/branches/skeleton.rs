//! What is left of a skeleton, as a drawing: Figures 4 and 8 (f–j) of
//! [ZBMJLDC17](crate::references).

use crate::report::decimal;
use crate::run::BranchLook;

/// Red, cyan and blue by the level of a branch, as in the paper; the last for all above.
const COLOURS: [&str; 3] = ["#c0392b", "#16a0b0", "#2c4fb0"];

/// The internodes of a look as lines, each node that stays a dot.
pub(super) fn to_svg(look: &BranchLook) -> String {
    let [width, height] = [look.images[0].width, look.images[0].height];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         stroke-width=\"0.6\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for (number, colour) in COLOURS.iter().enumerate() {
        let ours = |level: u32| (level as usize).min(COLOURS.len() - 1) == number;
        svg += &format!("<path fill=\"none\" stroke=\"{colour}\" d=\"");
        for line in look.skeleton.iter().filter(|line| ours(line.level)) {
            let [from, to] = line.ends.map(|end| {
                let [x, y] = end.map(|at| decimal(f64::from(at), 1));
                format!("{x} {y}")
            });
            svg += &format!("M{from}L{to}");
        }
        svg += "\"/>\n";
    }
    svg += "</svg>\n";
    svg
}
