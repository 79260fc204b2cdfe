//! A comparison as a folder: triptychs, maps of what is seen, and a page.
//!
//! ```text
//! triptych.png            or frame-0003.png …   expected | differing | actual
//! differing.png           of two images: the middle alone
//! flip.png                or frame-0003-flip.png
//! report.html
//! ```

use super::text::{channel_notes, channel_table, look_facts};
use super::triptych::differing;
use super::{Flip, ImageDifference, LookDifference, RunDifference, triptych};
use crate::math::index_u32;
use crate::report::thumbnail::shrink;
use crate::report::{
    Cell, Column, Comparison, OutputFolder, Page, PageImage, Picture, ReportError, Section, Table,
};

/// The longer sides of pictures on a page: the first with which it is small enough.
const SIDES: [u32; 5] = [640, 320, 160, 80, 40];

/// The frames of a run that a page shows: each takes seven of a page's 24 pictures.
const MOST_FRAMES: usize = 3;

/// The side of a detail, in pixels of the pictures.
const DETAIL: u32 = 48;

/// A folder of a comparison that is being written.
#[derive(Debug)]
pub struct DiffFolder {
    folder: OutputFolder,
    tolerance: u8,
    looks: Vec<(String, LookDifference)>,
}

impl DiffFolder {
    /// Begins a folder in which what differs by up to the tolerance is shown as the same.
    #[must_use]
    pub fn new(folder: OutputFolder, tolerance: u8) -> Self {
        Self {
            folder,
            tolerance,
            looks: Vec::new(),
        }
    }

    /// Writes a frame's triptych and map, and keeps the first few for the page.
    ///
    /// # Errors
    ///
    /// When a file cannot be written.
    pub fn add_frame(&mut self, frame: u32, look: &LookDifference) -> Result<(), ReportError> {
        self.write_pictures(
            look,
            &format!("frame-{frame:04}.png"),
            &format!("frame-{frame:04}-flip.png"),
        )?;
        if self.looks.len() < MOST_FRAMES {
            self.looks.push((format!("Frame {frame}"), look.clone()));
        }
        Ok(())
    }

    /// Writes the page of two runs and puts the folder in its place; `names` are those of the runs.
    ///
    /// # Errors
    ///
    /// When a file cannot be written, or as [`OutputFolder::commit`].
    pub fn finish_runs(self, names: [&str; 2], found: &RunDifference) -> Result<(), ReportError> {
        let mut before = vec![Section::Table {
            caption: String::new(),
            table: name_table(names),
        }];
        before.push(Section::Text(found.sentences().join("; ") + "."));
        let unequal = found.frames.iter().filter(|frame| frame.look.is_some());
        let unequal = unequal.count();
        if unequal > self.looks.len() {
            let shown = self.looks.len();
            before.push(Section::Text(format!(
                "Shown are the first {shown} of {unequal} frames whose pictures differ."
            )));
        }
        let mut after = Vec::new();
        for (heading, table) in found.tables() {
            after.push(Section::Heading(heading));
            after.push(Section::Table {
                caption: String::new(),
                table,
            });
        }
        for file in found.files.iter().filter(|file| !file.detail.is_empty()) {
            after.push(Section::Heading(file.name.clone()));
            after.extend(file.detail.iter().cloned().map(Section::Text));
        }
        self.finish("Two runs compared", found.is_within(), &before, &after)
    }

    /// Writes everything about two images and puts the folder in its place; `names` are those of the
    /// images.
    ///
    /// # Errors
    ///
    /// As [`finish_runs`](Self::finish_runs).
    pub fn finish_images(
        mut self,
        names: [&str; 2],
        found: &ImageDifference,
    ) -> Result<(), ReportError> {
        let mut before = vec![Section::Table {
            caption: String::new(),
            table: name_table(names),
        }];
        if let Some(channels) = &found.channels {
            before.push(Section::Heading("Channels".to_owned()));
            before.push(Section::Table {
                caption: String::new(),
                table: channel_table(channels),
            });
            before.extend(channel_notes(channels).into_iter().map(Section::Text));
        }
        if let Some(look) = &found.look {
            self.write_pictures(look, "triptych.png", "flip.png")?;
            let [expected, actual] = &look.pictures;
            if let Ok(marked) = differing(expected, actual, self.tolerance, 1) {
                self.folder.write("differing.png", &marked.to_png()?)?;
            }
            let heading = match found.channels {
                Some(_) => "As colours of 8 bits",
                None => "Pictures",
            };
            self.looks.push((heading.to_owned(), look.clone()));
        }
        let title = "Two images compared";
        self.finish(title, found.is_within(), &before, &[])
    }

    fn write_pictures(
        &self,
        look: &LookDifference,
        three: &str,
        map: &str,
    ) -> Result<(), ReportError> {
        let [expected, actual] = &look.pictures;
        // Pictures may be too large to stand beside each other; the page shows them all the same.
        if let Ok(picture) = triptych(expected, actual, self.tolerance) {
            self.folder.write(three, &picture.to_png()?)?;
        }
        if let Ok(metrics) = &look.found {
            let size = metrics.difference.size;
            self.folder
                .write(map, &flip_map(size, &metrics.flip)?.to_png()?)?;
        }
        Ok(())
    }

    fn finish(
        self,
        title: &str,
        is_within: bool,
        before: &[Section],
        after: &[Section],
    ) -> Result<(), ReportError> {
        let verdict = match (is_within, self.tolerance) {
            (true, 0) => "They are the same.".to_owned(),
            (true, tolerance) => format!("They are the same, within {tolerance} of 255."),
            (false, 0) => "They differ.".to_owned(),
            (false, tolerance) => format!("They differ, by more than {tolerance} of 255."),
        };
        let mut sides = SIDES.into_iter();
        loop {
            let side = sides.next();
            let mut sections = vec![Section::Text(verdict.clone())];
            sections.extend_from_slice(before);
            for (heading, look) in &self.looks {
                sections.push(Section::Heading(heading.clone()));
                sections.push(Section::Table {
                    caption: String::new(),
                    table: fact_table(look),
                });
                // Without any side a page has no pictures at all.
                if let Some(side) = side {
                    sections.extend(shown(look, self.tolerance, side)?);
                }
            }
            sections.extend_from_slice(after);
            let page = Page {
                title: title.to_owned(),
                sections,
            };
            match page.to_html() {
                Err(ReportError::TooLarge { .. }) if side.is_some() => {}
                page => {
                    self.folder.write("report.html", page?.as_bytes())?;
                    return self.folder.commit();
                }
            }
        }
    }
}

fn name_table(names: [&str; 2]) -> Table {
    let row = |(which, name): (&str, &str)| {
        [which, name]
            .map(|words| Cell::Text(words.to_owned()))
            .into()
    };
    Table {
        columns: ["", "compared"].map(Column::words).into(),
        rows: ["first", "second"]
            .into_iter()
            .zip(names)
            .map(row)
            .collect(),
    }
}

fn fact_table(look: &LookDifference) -> Table {
    let row =
        |(label, words): (&str, String)| vec![Cell::Text(label.to_owned()), Cell::Text(words)];
    Table {
        columns: ["measure", "value"].map(Column::words).into(),
        rows: look_facts(look).into_iter().map(row).collect(),
    }
}

/// The pictures of a comparison, and the neighbourhood of the largest difference.
fn shown(look: &LookDifference, tolerance: u8, side: u32) -> Result<Vec<Section>, ReportError> {
    let [expected, actual] = &look.pictures;
    let longest = |picture: &Picture| picture.width().max(picture.height());
    let factor = longest(expected).max(longest(actual)).div_ceil(side);
    let image = |caption: &str, picture: &Picture| {
        Ok(PageImage {
            caption: caption.to_owned(),
            png: picture.to_png()?,
        })
    };
    let both = vec![
        image("expected", &shrink(expected, factor)?)?,
        image("actual", &shrink(actual, factor)?)?,
    ];
    let both = Section::Comparison(Comparison::of_ways("picture", both));
    let mut whole = vec![image(
        "differing: the redder the more; grey is the same",
        &differing(expected, actual, tolerance, factor)?,
    )?];
    let Ok(metrics) = &look.found else {
        return Ok(vec![both, Section::Large(whole)]);
    };
    let found = &metrics.difference;
    let map = flip_map(found.size, &metrics.flip)?;
    whole.push(image(
        "FLIP: how much is seen; the lighter the more",
        &shrink(&map, factor)?,
    )?);
    let mut sections = vec![both, Section::Large(whole)];
    let [width, height] = found.size;
    if found.unequal > 0 && width.max(height) > 2 * DETAIL {
        let detail = |picture: &Picture| cropped(picture, found.largest_at);
        let [one, other] = [detail(expected)?, detail(actual)?];
        let [x, y] = found.largest_at;
        sections.push(Section::Text(format!(
            "Around the largest difference, at ({x}, {y}):"
        )));
        sections.push(Section::Images(vec![
            image("expected", &magnified(&one)?)?,
            image("actual", &magnified(&other)?)?,
            image(
                "differing",
                &magnified(&differing(&one, &other, tolerance, 1)?)?,
            )?,
        ]));
    }
    Ok(sections)
}

/// A square around a place, as far as the picture goes.
fn cropped(picture: &Picture, [x, y]: [u32; 2]) -> Result<Picture, ReportError> {
    let span = |at: u32, side: u32| {
        let length = side.min(DETAIL);
        let first = at.saturating_sub(DETAIL / 2).min(side - length);
        (first as usize, length)
    };
    let (left, width) = span(x, picture.width());
    let (top, height) = span(y, picture.height());
    let rows = super::difference::rows(picture)
        .skip(top)
        .take(height as usize);
    let pixels = rows.flat_map(|row| row[left..][..width as usize].as_flattened());
    Picture::new(width, height, pixels.copied().collect())
}

/// A picture whose pixels are large squares.
fn magnified(picture: &Picture) -> Result<Picture, ReportError> {
    const SIDE: usize = 5;
    let rows = super::difference::rows(picture).flat_map(|row| {
        let wide = row.iter().flat_map(|pixel| [*pixel; SIDE]);
        wide.collect::<Vec<[u8; 4]>>().repeat(SIDE)
    });
    let rgba = rows.collect::<Vec<_>>().into_flattened();
    let [width, height] = super::difference::size(picture).map(|side| side * index_u32(SIDE));
    Picture::new(width, height, rgba)
}

/// A map of what is seen: from dark over violet and orange to white.
fn flip_map([width, height]: [u32; 2], flip: &Flip) -> Result<Picture, ReportError> {
    const STOPS: [[u8; 3]; 5] = [
        [12, 12, 20],
        [80, 32, 128],
        [200, 56, 88],
        [250, 152, 40],
        [255, 252, 216],
    ];
    let colour = |value: u8| {
        // 64 steps from stop to stop; 255 becomes 256, the last.
        let scaled = u32::from(value) * 256 / 255;
        let (stop, part) = (
            (scaled / 64).min(3) as usize,
            scaled - (scaled / 64).min(3) * 64,
        );
        let mixed = |channel: usize| {
            let [from, to] = [STOPS[stop], STOPS[stop + 1]].map(|stop| u32::from(stop[channel]));
            u8::try_from((from * (64 - part) + to * part + 32) / 64).unwrap_or(u8::MAX)
        };
        [mixed(0), mixed(1), mixed(2), 255]
    };
    let table: Vec<[u8; 4]> = (0..=255).map(colour).collect();
    let pixels = flip.map.iter().flat_map(|&value| table[usize::from(value)]);
    Picture::new(width, height, pixels.collect())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{example, variant};
    use super::*;

    #[test]
    fn maps_go_from_dark_to_light() {
        let flip = Flip {
            mean: 0.0,
            largest: 1.0,
            largest_at: [0; 2],
            map: vec![0, 64, 255],
        };
        let map = flip_map([3, 1], &flip).unwrap();
        let wanted = [[12, 12, 20, 255], [80, 32, 128, 255], [255, 252, 216, 255]];
        assert_eq!(map.rgba(), wanted.concat());
    }

    #[test]
    fn details_are_squares_within_the_picture() {
        let picture = example();
        for (at, corner) in [([0, 0], [0, 0]), ([20, 40], [0, 16]), ([63, 79], [16, 32])] {
            let found = cropped(&picture, at).unwrap();
            assert_eq!([found.width(), found.height()], [48, 48]);
            let first = 4 * (corner[1] * 64 + corner[0]);
            assert_eq!(found.rgba()[..4], picture.rgba()[first..first + 4]);
        }
        let large = magnified(&cropped(&picture, [0, 0]).unwrap()).unwrap();
        assert_eq!([large.width(), large.height()], [240, 240]);
        assert_eq!(large.rgba()[4 * 4..4 * 5], large.rgba()[..4]);
    }

    #[test]
    fn pages_are_as_small_as_they_must_be() {
        // Noise of 640 × 640 pixels, which no encoder makes smaller: twice four such pictures take
        // more than a page may.
        const BYTES: u64 = 4 * 640 * 640;
        let stream = crate::math::Stream::new(1, 0);
        let noise = |seed: u64| {
            let bytes = (0..BYTES).map(|index| {
                let byte = stream.below(seed * BYTES + index, 256);
                u8::try_from(byte).expect("a byte")
            });
            Picture::new(640, 640, bytes.collect()).expect("filled")
        };
        let look = LookDifference::between([noise(0), noise(1)], 0);
        let found = ImageDifference {
            channels: None,
            look: Some(look),
        };
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("out");
        let mut folder = DiffFolder::new(OutputFolder::create(&target).unwrap(), 0);
        let look = found.look.clone().unwrap();
        folder.looks.push(("Once".to_owned(), look));
        folder.finish_images(["a", "b"], &found).unwrap();
        let page = std::fs::read_to_string(target.join("report.html")).unwrap();
        assert!(page.len() <= Page::MAX_BYTES && page.len() > 1_000_000);
        assert_eq!(page.matches("<img").count(), 14);
    }

    #[test]
    fn folders_are_the_same_every_time() {
        let root = tempfile::tempdir().unwrap();
        let pages = ["one", "other"].map(|name| {
            let target = root.path().join(name);
            let folder = DiffFolder::new(OutputFolder::create(&target).unwrap(), 2);
            let look = LookDifference::between([example(), variant("noise")], 2);
            let found = ImageDifference {
                channels: None,
                look: Some(look),
            };
            folder.finish_images(["a.png", "b.png"], &found).unwrap();
            ["report.html", "triptych.png", "differing.png", "flip.png"]
                .map(|file| std::fs::read(target.join(file)).unwrap())
        });
        assert_eq!(pages[0], pages[1]);
    }
}
