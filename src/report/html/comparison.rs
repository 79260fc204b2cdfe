//! Pictures of which any two can be held against each other.

use super::PageImage;
use super::text::{base64, escape};

/// Pictures of one thing, in several ways and at several places, such as models and their levels.
///
/// Shown beside each other; the page's script adds a view of two of them, chosen by way and place, with
/// a divider and with their difference.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Comparison {
    /// The ways.
    pub ways: Choice,
    /// The places.
    pub places: Choice,
    /// The number of the picture for each way and place. With a number that no picture has the pictures
    /// are shown, but not held against each other.
    pub shows: Vec<Vec<usize>>,
    /// The pictures, each once.
    pub pictures: Vec<PageImage>,
    /// Which two are shown first: way and place of each.
    pub begin: [[usize; 2]; 2],
}

/// What can be chosen.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Choice {
    /// What it is, in a word: `model`, `level`, `frame`.
    pub name: String,
    /// The names of what there is; of one nothing is chosen.
    pub values: Vec<String>,
}

impl Comparison {
    /// Pictures that differ in one thing only, by their captions: the first against the last.
    #[must_use]
    pub fn of_ways(name: &str, pictures: Vec<PageImage>) -> Self {
        let captions = pictures.iter().map(|picture| picture.caption.clone());
        Self {
            ways: Choice {
                name: name.to_owned(),
                values: captions.collect(),
            },
            places: Choice {
                name: String::new(),
                values: vec![String::new()],
            },
            shows: (0..pictures.len()).map(|index| vec![index]).collect(),
            begin: [[0, 0], [pictures.len().saturating_sub(1), 0]],
            pictures,
        }
    }

    /// Whether there are two pictures, and one for each way and place.
    fn is_whole(&self) -> bool {
        let (ways, places) = (self.ways.values.len(), self.places.values.len());
        let is_row = |row: &Vec<usize>| {
            row.len() == places && row.iter().all(|&at| at < self.pictures.len())
        };
        let has = |[way, place]: [usize; 2]| way < ways && place < places;
        let is_table = self.shows.len() == ways && self.shows.iter().all(is_row);
        is_table && self.pictures.len() > 1 && self.begin.into_iter().all(has)
    }

    /// The pictures with what the script makes into controls; `number` tells it from others on the page.
    pub(super) fn to_html(&self, number: usize) -> String {
        let thumbs = images_html("images thumbs", &self.pictures);
        if !self.is_whole() {
            return thumbs;
        }
        let row = |row: &Vec<usize>| {
            let row: Vec<String> = row.iter().map(ToString::to_string).collect();
            row.join(",")
        };
        let shows: Vec<String> = self.shows.iter().map(row).collect();
        let list = format!("places-{number}");
        let sides = ["A", "B"].into_iter().zip(self.begin);
        let sides: String = sides.map(|(name, at)| self.side(name, at, &list)).collect();
        let gain = |by: &str| {
            let pressed = by == "4";
            format!(
                "<button type=\"button\" value=\"{by}\" aria-pressed=\"{pressed}\">×{by}</button>"
            )
        };
        let gains: String = ["1", "4", "16"].into_iter().map(gain).collect();
        format!(
            "<div class=\"compare\" data-shows=\"{}\">\n\
             <div class=\"controls\" hidden>\n\
             <div class=\"stage\"><canvas role=\"img\"></canvas>\
             <span class=\"tag a\"></span><span class=\"tag b\"></span>\
             <div class=\"divider\" role=\"slider\" tabindex=\"0\" aria-label=\"Divider: A left of it, B right\" \
             aria-valuemin=\"0\" aria-valuemax=\"100\" aria-valuenow=\"50\"></div></div>\n\
             <div class=\"choose\">\n{sides}</div>\n{}\
             <div class=\"bar\"><button type=\"button\" class=\"toggle\" aria-pressed=\"false\">Difference</button>\
             <span class=\"gain\" role=\"group\" aria-label=\"Difference times\" hidden>{gains}</span>\
             <output></output></div>\n</div>\n{thumbs}</div>\n",
            shows.join(";"),
            self.place_list(&list)
        )
    }

    /// The choosers of one of the two.
    fn side(&self, name: &str, [way, place]: [usize; 2], list: &str) -> String {
        let class = name.to_ascii_lowercase();
        let mut html = format!("<fieldset class=\"side {class}\"><legend>{name}</legend>\n");
        if self.ways.values.len() > 1 {
            let option = |(index, value): (usize, &String)| {
                let selected = if index == way { " selected" } else { "" };
                format!("<option{selected}>{}</option>", escape(value))
            };
            let options: String = self.ways.values.iter().enumerate().map(option).collect();
            html += &format!(
                "<label><span>{}</span><select autocomplete=\"off\">{options}</select></label>\n",
                escape(&self.ways.name)
            );
        }
        if self.places.values.len() > 1 {
            let (name, last) = (escape(&self.places.name), self.places.values.len() - 1);
            html += &format!(
                "<label><span>{name}</span><input type=\"range\" min=\"0\" max=\"{last}\" step=\"1\" \
                 value=\"{place}\" list=\"{list}\" data-name=\"{name}\" autocomplete=\"off\">\
                 <output></output></label>\n"
            );
        }
        html + "</fieldset>\n"
    }

    /// The names of places.
    fn place_list(&self, list: &str) -> String {
        if self.places.values.len() < 2 {
            return String::new();
        }
        let option = |(index, value): (usize, &String)| {
            format!(
                "<option value=\"{index}\" label=\"{}\"></option>",
                escape(value)
            )
        };
        let options: String = self.places.values.iter().enumerate().map(option).collect();
        format!("<datalist id=\"{list}\">{options}</datalist>\n")
    }
}

pub(super) fn images_html(class: &str, images: &[PageImage]) -> String {
    let images: String = images.iter().map(image_html).collect();
    format!("<div class=\"{class}\">\n{images}</div>\n")
}

fn image_html(image: &PageImage) -> String {
    let caption = escape(&image.caption);
    format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\">\
         <figcaption>{caption}</figcaption></figure>\n",
        base64(&image.png)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(caption: &str) -> PageImage {
        PageImage {
            caption: caption.to_owned(),
            png: vec![1, 2, 3],
        }
    }

    fn choice(name: &str, values: &[&str]) -> Choice {
        Choice {
            name: name.to_owned(),
            values: values.iter().map(|value| (*value).to_owned()).collect(),
        }
    }

    fn models_and_levels() -> Comparison {
        Comparison {
            ways: choice("model", &["full", "lodf <slots>"]),
            places: choice("level", &["0", "1"]),
            shows: vec![vec![0, 0], vec![0, 1]],
            pictures: vec![image("all leaves"), image("fewest")],
            begin: [[0, 0], [1, 1]],
        }
    }

    #[test]
    fn pictures_are_there_once_and_chosen_by_way_and_place() {
        let html = models_and_levels().to_html(3);
        assert!(html.contains("data-shows=\"0,0;0,1\""), "{html}");
        assert_eq!(html.matches("<img ").count(), 2);
        assert_eq!(html.matches("<option selected>").count(), 2, "{html}");
        assert!(
            html.contains("<option selected>lodf &lt;slots&gt;</option>"),
            "{html}"
        );
        assert!(
            html.contains("max=\"1\" step=\"1\" value=\"1\" list=\"places-3\""),
            "{html}"
        );
        assert!(html.contains("<datalist id=\"places-3\">"), "{html}");
        // What only a script can move is not there without one.
        assert!(html.contains("<div class=\"controls\" hidden>"), "{html}");
    }

    #[test]
    fn what_cannot_be_compared_is_only_shown() {
        let one = Comparison::of_ways("picture", vec![image("alone")]);
        let missing = Comparison {
            shows: vec![vec![0, 2], vec![0, 1]],
            ..models_and_levels()
        };
        let ragged = Comparison {
            shows: vec![vec![0, 1]],
            ..models_and_levels()
        };
        let nowhere = Comparison {
            begin: [[0, 0], [2, 0]],
            ..models_and_levels()
        };
        for (comparison, count) in [(one, 1), (missing, 2), (ragged, 2), (nowhere, 2)] {
            let html = comparison.to_html(0);
            assert!(!html.contains("data-shows"), "{html}");
            assert_eq!(html.matches("<img ").count(), count);
        }
        assert!(Comparison::of_ways("x", vec![image("a"), image("b")]).is_whole());
    }
}
