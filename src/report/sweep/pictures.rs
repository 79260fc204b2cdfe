//! Small pictures of some levels of a walk, each once, for its page.

use std::collections::{BTreeMap, BTreeSet};

use crate::math::Digest;
use crate::report::html::{Choice, Comparison, SMALLER};
use crate::report::thumbnail::{SIDE, small};
use crate::report::{Page, PageImage, Picture, ReportError, decimal, grouped};
use crate::run::{Frame, Sweep, SweepModel, looked_at};

/// How many levels beyond full detail have pictures, at most.
const LEVELS: u32 = 8;

/// How many different pictures of a level are kept. By law most models show the same.
const MOST_OF_A_LEVEL: usize = 6;

/// Small pictures of some levels of the models of a walk. What several show is kept once.
///
/// What is kept of a level depends on the frames of that level alone, so that shards keep together
/// what one walk keeps.
#[derive(Debug, Clone, Default)]
pub struct SweepPictures {
    pictures: BTreeMap<Digest, Picture>,
    /// What was seen of each level.
    seen: BTreeMap<u32, BTreeSet<Digest>>,
}

impl SweepPictures {
    /// Takes a frame of a step and the last step, as [`sweep_seen`](crate::run::sweep_seen) shows them;
    /// of most levels nothing is kept.
    ///
    /// # Errors
    ///
    /// When the frame's bytes do not fill its picture.
    pub fn add(&mut self, [step, last]: [u32; 2], frame: &Frame) -> Result<(), ReportError> {
        let digest = frame.image_digest;
        if !looked_at(last, LEVELS).any(|level| level == step) {
            return Ok(());
        }
        let seen = self.seen.entry(step).or_default();
        if seen.len() == MOST_OF_A_LEVEL
            || !seen.insert(digest)
            || self.pictures.contains_key(&digest)
        {
            return Ok(());
        }
        let image = &frame.image;
        let picture = Picture::new(image.width, image.height, image.rgba.clone())?;
        self.pictures.insert(digest, small(&picture)?);
        Ok(())
    }

    /// Takes a picture that was kept before; says what is wrong with one that cannot have been.
    pub(in crate::report) fn insert(
        &mut self,
        digest: Digest,
        picture: Picture,
    ) -> Result<(), String> {
        let [width, height] = [picture.width(), picture.height()];
        if width.max(height) > SIDE {
            return Err(format!(
                "a picture of {width} × {height} pixels, wanted at most {SIDE} a side"
            ));
        }
        self.pictures.insert(digest, picture);
        let (found, most) = (self.pictures.len(), (LEVELS as usize + 1) * MOST_OF_A_LEVEL);
        match found <= most {
            true => Ok(()),
            false => Err(format!("{found} pictures of levels, wanted at most {most}")),
        }
    }

    /// The pictures, each with the digest of the frame that it shows smaller.
    pub(in crate::report) fn iter(&self) -> impl Iterator<Item = (Digest, &Picture)> {
        self.pictures
            .iter()
            .map(|(digest, picture)| (*digest, picture))
    }

    /// Which pictures a page shows of a walk: of as many levels as there is room for.
    pub(super) fn gallery(&self, sweep: &Sweep) -> Gallery {
        let all = std::iter::successors(Some(LEVELS), |levels| Some(levels / 2));
        let all = all.take_while(|levels| *levels > 0);
        let mut galleries = all.map(|levels| self.of_levels(sweep, levels, usize::MAX));
        let fits = |gallery: &Gallery| gallery.order.len() <= Page::MAX_IMAGES;
        galleries.find(fits).unwrap_or_else(|| {
            let fewer = (0..sweep.models.len()).rev();
            let mut fewer = fewer.map(|models| self.of_levels(sweep, 1, models));
            fewer.find(fits).unwrap_or_default()
        })
    }

    /// The pictures of the first so many models that have one of each of so many levels.
    fn of_levels(&self, sweep: &Sweep, levels: u32, most: usize) -> Gallery {
        let steps = sweep.models.iter().flat_map(|model| &model.steps);
        let walked: BTreeMap<u32, f64> = steps
            .clone()
            .map(|step| (step.step, step.level()))
            .collect();
        let last = steps.map(|step| step.of).max().unwrap_or(0);
        let mut steps: Vec<u32> = looked_at(last, levels).collect();
        steps.dedup();
        steps.retain(|step| walked.contains_key(step));
        let digests = |model: &SweepModel| -> Option<Vec<Digest>> {
            let digest = |step: &u32| {
                let walked = model.steps.iter().find(|walked| walked.step == *step)?;
                let digest = walked.image_digest;
                self.pictures.contains_key(&digest).then_some(digest)
            };
            steps.iter().map(digest).collect()
        };
        let mut gallery = Gallery {
            levels: steps.iter().map(|step| decimal(walked[step], 3)).collect(),
            ..Gallery::default()
        };
        let mut found = Vec::new();
        for model in &sweep.models {
            match digests(model).filter(|_| found.len() < most) {
                Some(digests) => {
                    if model.variant.has_levels() {
                        gallery.begin.get_or_insert(found.len());
                    }
                    gallery.models.push(model.variant.label());
                    found.push(digests);
                }
                None => gallery.missing.push(model.variant.label()),
            }
        }
        // Full detail of all models first, then one level after another.
        for level in 0..steps.len() {
            for digests in &found {
                if !gallery.order.contains(&digests[level]) {
                    gallery.order.push(digests[level]);
                }
            }
        }
        let place = |digest: &Digest| gallery.order.iter().position(|known| known == digest);
        let row = |digests: &Vec<Digest>| digests.iter().filter_map(place).collect();
        gallery.shows = found.iter().map(row).collect();
        gallery
    }

    /// The pictures of a gallery, in its order.
    pub(super) fn of(&self, gallery: &Gallery) -> Vec<Picture> {
        let picture = |digest| self.pictures.get(digest).cloned();
        gallery.order.iter().filter_map(picture).collect()
    }
}

/// Which models and levels a page has pictures of.
#[derive(Debug, Default)]
pub(super) struct Gallery {
    models: Vec<String>,
    levels: Vec<String>,
    /// For each model and level the place of its picture in `order`.
    shows: Vec<Vec<usize>>,
    /// The frames that pictures show.
    order: Vec<Digest>,
    /// The first model with levels.
    begin: Option<usize>,
    /// Models that there are no pictures of.
    missing: Vec<String>,
}

impl Gallery {
    /// The comparison, which begins with full detail against the coarsest.
    pub(super) fn comparison(&self, files: Vec<Vec<u8>>) -> Comparison {
        let image = |(place, png)| PageImage {
            caption: self.caption(place),
            png,
        };
        let model = self.begin.unwrap_or(0);
        let choice = |name: &str, values: &[String]| Choice {
            name: name.to_owned(),
            values: values.to_vec(),
        };
        Comparison {
            ways: choice("model", &self.models),
            places: choice("level", &self.levels),
            shows: self.shows.clone(),
            pictures: files.into_iter().enumerate().map(image).collect(),
            begin: [[model, 0], [model, self.levels.len().saturating_sub(1)]],
        }
    }

    /// `level 0.5: lodf-slots and 11 others`, of the first level that looks so.
    fn caption(&self, place: usize) -> String {
        let shows = |level: usize| {
            let models = self.models.iter().zip(&self.shows);
            let here = models.filter(move |(_, row)| row.get(level) == Some(&place));
            here.map(|(model, _)| model.as_str()).collect::<Vec<&str>>()
        };
        let levels = (0..self.levels.len()).map(|level| (&self.levels[level], shows(level)));
        let found = levels.into_iter().find(|(_, models)| !models.is_empty());
        match found {
            None => String::new(),
            Some((level, models)) => match &models[..] {
                [first, _, _, ..] => {
                    format!("level {level}: {first} and {} others", models.len() - 1)
                }
                few => format!("level {level}: {}", few.join(" and ")),
            },
        }
    }

    /// What the pictures are of.
    pub(super) fn note(&self) -> String {
        let mut note = format!(
            "The scene from its own camera at frame 0. Models that show the same share a picture: {} for {} models \
             at {} levels. {SMALLER}",
            grouped(self.order.len() as u64, ","),
            self.models.len(),
            self.levels.len()
        );
        if !self.missing.is_empty() {
            note += &format!(" There are no pictures of {}.", self.missing.join(", "));
        }
        note
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Ledger;
    use crate::run::{SweepStep, Variant};

    /// The frame of a model's step: pictures are told apart by one number.
    fn frame(number: u8) -> Frame {
        let mut frame = Frame::blank();
        frame.set_image([2, 1], [number; 8].to_vec());
        frame.image_digest = Digest([number; 32]);
        frame
    }

    /// A model that shows so many pictures from step 0 on.
    fn model(label: &str, shows: &[u8]) -> SweepModel {
        let step = |(step, &number): (u32, &u8)| SweepStep {
            step,
            of: u32::try_from(shows.len()).expect("few") - 1,
            leaves: 1,
            triangles: 2,
            trunk_triangles: 0,
            change: crate::models::Change::default(),
            trunk_change: crate::models::Change::default(),
            ledger: Ledger::default(),
            image_digest: Digest([number; 32]),
            covered_pixels: 1,
            leaf_area: 1.0,
            folded_leaves: 0,
        };
        SweepModel {
            variant: Variant::labelled(label).expect("a label"),
            initial: Ledger::default(),
            resident: Vec::new(),
            steps: (0..).zip(shows).map(step).collect(),
        }
    }

    fn seen(sweep: &Sweep, draws: impl Fn(u32) -> bool) -> SweepPictures {
        let mut pictures = SweepPictures::default();
        for model in &sweep.models {
            for step in model.steps.iter().filter(|step| draws(step.step)) {
                let frame = frame(step.image_digest.0[0]);
                pictures
                    .add([step.step, step.of], &frame)
                    .expect("two pixels");
            }
        }
        pictures
    }

    fn few() -> Sweep {
        Sweep {
            models: vec![
                model("full", &[1, 1, 1]),
                model("lodf-slots", &[1, 2, 3]),
                model("lodf-stamps", &[1, 2, 3]),
                model("lodf-stamps-quantised", &[4, 5, 6]),
            ],
        }
    }

    #[test]
    fn what_models_share_is_there_once() {
        let sweep = few();
        let pictures = seen(&sweep, |_| true);
        let gallery = pictures.gallery(&sweep);
        assert_eq!(gallery.levels, ["0", "0.5", "1"]);
        // Full detail first: 1 and 4, then 2 and 5, 3 and 6.
        let wanted = [[0, 0, 0], [0, 2, 4], [0, 2, 4], [1, 3, 5]];
        assert_eq!(gallery.shows, wanted);
        let files = pictures.of(&gallery).iter().map(|_| vec![1]).collect();
        let comparison = gallery.comparison(files);
        let captions = comparison
            .pictures
            .iter()
            .map(|picture| &picture.caption[..]);
        let wanted = [
            "level 0: full and 2 others",
            "level 0: lodf-stamps-quantised",
            "level 0.5: lodf-slots and lodf-stamps",
            "level 0.5: lodf-stamps-quantised",
            "level 1: lodf-slots and lodf-stamps",
            "level 1: lodf-stamps-quantised",
        ];
        assert_eq!(captions.collect::<Vec<_>>(), wanted);
        assert_eq!(comparison.begin, [[1, 0], [1, 2]]);
    }

    #[test]
    fn shards_keep_together_what_one_walk_keeps() {
        let sweep = few();
        let mut joined = SweepPictures::default();
        for shard in [
            seen(&sweep, |step| step == 1),
            seen(&sweep, |step| step != 1),
        ] {
            let kept: Vec<(Digest, Picture)> = shard.iter().map(|(d, p)| (d, p.clone())).collect();
            for (digest, picture) in kept {
                joined.insert(digest, picture).expect("few and small");
            }
        }
        assert_eq!(joined.pictures, seen(&sweep, |_| true).pictures);
    }

    #[test]
    fn what_no_walk_keeps_is_refused() {
        let mut pictures = SweepPictures::default();
        let wide = Picture::new(641, 1, vec![0; 4 * 641]).expect("filled");
        let said = pictures.insert(Digest([0; 32]), wide).unwrap_err();
        assert_eq!(
            said,
            "a picture of 641 × 1 pixels, wanted at most 640 a side"
        );
        let dot = Picture::new(1, 1, vec![0; 4]).expect("filled");
        for number in 0..54 {
            assert_eq!(pictures.insert(Digest([number; 32]), dot.clone()), Ok(()));
        }
        let said = pictures.insert(Digest([54; 32]), dot).unwrap_err();
        assert_eq!(said, "55 pictures of levels, wanted at most 54");
    }

    #[test]
    fn a_page_has_room_for_fewer_levels_or_models() {
        // Of seven models six are kept: with 9 and 5 levels too many pictures, with 3 levels 18.
        let labels = [
            "lodf-host",
            "lodf-slots",
            "lodf-stamps",
            "lodf-cluster",
            "lodf-device",
            "vdf-host",
            "vdf-indices",
        ];
        let numbers = |model: u8| (0..9).map(|step| 9 * model + step).collect::<Vec<u8>>();
        let models = (0..).zip(labels);
        let models = models.map(|(number, label)| model(label, &numbers(number)));
        let sweep = Sweep {
            models: models.collect(),
        };
        let pictures = seen(&sweep, |_| true);
        assert_eq!(pictures.pictures.len(), MOST_OF_A_LEVEL * 9);
        let gallery = pictures.gallery(&sweep);
        assert_eq!((gallery.levels.len(), gallery.models.len()), (3, 6));
        assert_eq!(
            (gallery.order.len(), &gallery.missing[..]),
            (18, &["vdf-indices".to_owned()][..])
        );
    }
}
