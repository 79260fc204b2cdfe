//! All strokes of a plant, and which of them show in a cut.

use std::ops::Range;

use super::branch_ranks::BranchRanks;
use super::record::StrokeRecord;
use crate::math::{Vec3, index_u32, whole_u32};
use crate::models::{State, StrokeCut};
use crate::plant::{Material, Plant};
use crate::scene::{PaintMark, PaintOptions, PaintReach};
use crate::simplify::strokes::{
    CollapseThresholds, Extraction, LeafStroke, LevelOptions, ShellOptions, Shells, StrokeLevels,
    extract, leaf_strokes, shells, strokes_at, thresholds_for,
};

/// All strokes of a plant: those of its leaves in rows and shells, then those of its branches.
#[derive(Debug, Clone)]
pub struct Painting {
    options: PaintOptions,
    levels: StrokeLevels,
    branches: BranchRanks,
    /// How many hulls were kept.
    hulls: u32,
    records: Vec<StrokeRecord>,
    /// Linear colours of the foliage groups, then of marked strokes, then of the bark.
    colours: Vec<Vec3>,
    center: Vec3,
    has_skeleton: bool,
}

impl Painting {
    /// Simplifies the leaves of a plant and lays strokes along its branches.
    #[must_use]
    pub fn of(plant: &Plant, options: &PaintOptions) -> Self {
        let leaves = leaf_strokes(plant.foliage());
        let centers: Vec<Vec3> = leaves.iter().map(|leaf| leaf.stroke.center).collect();
        let hulls = ShellOptions {
            hulls: options.hulls,
            core_percent: options.core_percent,
        };
        let parted = shells(&centers, hulls);
        let levels = LevelOptions {
            thresholds: thresholds(&leaves, &parted, options),
            most_at_once: options.at_once,
            inward: options.inward,
        };
        let levels = StrokeLevels::new(&leaves, &parted, &levels);
        let (branches, wood) = match plant.skeleton() {
            Some(skeleton) => BranchRanks::of(skeleton, options),
            None => BranchRanks::of(&crate::plant::Skeleton::default(), options),
        };
        let groups = &plant.foliage().groups;
        let mut colours: Vec<Vec3> = groups.iter().map(|group| mean(&group.material)).collect();
        let marked = index_u32(colours.len());
        colours.push(MARK);
        let bark = index_u32(colours.len());
        colours.push(plant.trunk().map_or(BARK, |trunk| mean(&trunk.material)));
        let innermost = levels.shells().saturating_sub(1).max(1) as f32;
        let mut records = Vec::with_capacity(levels.strokes().len() + wood.len());
        for shell in 0..levels.shells() {
            let outside = 1.0 - shell as f32 / innermost;
            // Every stroke of a shell is there in the row in which it is made.
            let made = levels.of_shell(shell);
            records.extend(
                levels.strokes()[range(made)]
                    .iter()
                    .map(|leaf| StrokeRecord {
                        stroke: leaf.stroke,
                        material: match options.mark {
                            PaintMark::Simplified if leaf.leaves > 1 => marked,
                            PaintMark::Simplified | PaintMark::None => leaf.group,
                        },
                        outside,
                    }),
            );
        }
        records.extend(wood.into_iter().map(|stroke| StrokeRecord {
            stroke,
            material: bark,
            outside: 1.0,
        }));
        let bounds = plant.bounds();
        Self {
            options: *options,
            levels,
            branches,
            hulls: index_u32(parted.hulls.len()),
            records,
            colours,
            center: 0.5 * (bounds.min + bounds.max),
            has_skeleton: plant.skeleton().is_some(),
        }
    }

    /// How it is painted.
    #[must_use]
    pub fn options(&self) -> &PaintOptions {
        &self.options
    }

    /// The leaf strokes.
    #[must_use]
    pub fn levels(&self) -> &StrokeLevels {
        &self.levels
    }

    /// How many hulls leaves are parted by: as many as asked, or all that there are.
    #[must_use]
    pub fn hulls(&self) -> u32 {
        self.hulls
    }

    /// Whether branch strokes take the place of the trunk: where there is a skeleton.
    #[must_use]
    pub fn paints_trunk(&self) -> bool {
        self.has_skeleton
    }

    /// How many branches there are.
    #[must_use]
    pub fn branches(&self) -> u32 {
        self.branches.branches()
    }

    /// The middle of the plant.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        self.center
    }

    pub(super) fn records(&self) -> &[StrokeRecord] {
        &self.records
    }

    pub(super) fn colours(&self) -> &[Vec3] {
        &self.colours
    }

    /// All strokes.
    #[must_use]
    pub fn finest(&self) -> StrokeCut {
        self.cut(self.levels.totals()[0], 1.0, 0.0)
    }

    /// As many leaf strokes as nearest to a number ([CQHCVL06](crate::references), section 5.2); of the
    /// branches' strokes beyond the least a share (section 5.1), and no branch that is shorter, in metres.
    #[must_use]
    pub fn cut(&self, wanted: u32, share: f32, shortest: f32) -> StrokeCut {
        let found = extract(&self.levels, wanted);
        self.fitted(&StrokeCut {
            row: found.fine_row,
            switch: found.switch,
            limits: self.branches.limits(share),
            branches: self.branches.longer_than(shortest),
        })
    }

    /// What is wanted from a distance, where `pixels` says how many pixels a metre has at one.
    ///
    /// Branches are judged as they would be seen from the side at that distance. A branch that points at
    /// the viewer is seen shorter, but not less, and were it pruned it would come back with the next step
    /// around the tree.
    pub fn at_distance(&self, distance: f32, pixels: impl Fn(f32) -> f64) -> StrokeCut {
        let full = self.options.full_distance;
        let wanted = strokes_at(self.levels.totals()[0], full, distance);
        let share = if distance > full {
            full / distance
        } else {
            1.0
        };
        self.cut(wanted, share, self.shortest(pixels(distance)))
    }

    /// A fixed level from 0, all strokes, to 1, the coarsest row; rows are evenly spaced. Branches are those
    /// that are wanted from where there would be so many leaf strokes.
    pub fn at_level(&self, level: f32, pixels: impl Fn(f32) -> f64) -> StrokeCut {
        let totals = self.levels.totals();
        let place = f64::from(level.clamp(0.0, 1.0)) * (totals.len() - 1) as f64;
        let row = (whole_u32(place) as usize).min(totals.len() - 1);
        let next = totals[(row + 1).min(totals.len() - 1)];
        let gone = (place - row as f64) * f64::from(totals[row] - next);
        let wanted = totals[row] - whole_u32(gone);
        let share = f64::from(wanted) / f64::from(totals[0].max(1));
        #[expect(clippy::cast_possible_truncation, reason = "rounds")]
        let nearness = if totals[0] > 0 {
            share.sqrt() as f32
        } else {
            1.0 - level
        };
        let nearness = nearness.max(1e-3);
        let distance = self.options.full_distance / nearness;
        self.cut(wanted, nearness, self.shortest(pixels(distance)))
    }

    /// The shortest branch that is seen, where a metre has so many pixels.
    fn shortest(&self, pixels: f64) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "rounds")]
        let shortest = (f64::from(self.options.least_pixels) / pixels.max(1e-9)) as f32;
        shortest
    }

    /// The cut of a state, with nothing past what there is, and each content told in one way only; all
    /// strokes, where the state is of leaves or cards.
    pub(super) fn cut_of(&self, state: &State) -> StrokeCut {
        match state {
            State::Strokes(cut) => self.fitted(cut),
            State::Uniform { .. } | State::Variable { .. } | State::Cards(_) => self.finest(),
        }
    }

    fn fitted(&self, cut: &StrokeCut) -> StrokeCut {
        let (last, shells) = (self.levels.rows() - 1, self.levels.shells());
        let (row, switch) = match (cut.row.min(last), cut.switch.min(shells)) {
            // All of the next row.
            (row, 0) if row < last => (row + 1, shells),
            (row, _) if row == last => (row, shells),
            found => found,
        };
        let limits = self.branches.ranks.iter().enumerate();
        let limits = limits.map(|(level, ranks)| {
            let limit = cut.limits.get(level).copied().unwrap_or(0);
            limit.min(*ranks)
        });
        StrokeCut {
            row,
            switch,
            limits: limits.collect(),
            branches: cut.branches.min(self.branches()),
        }
    }

    /// What shows, as runs of the list: none is empty, and none begins where the one before ends.
    #[must_use]
    pub fn runs(&self, cut: &StrokeCut) -> Vec<Range<u32>> {
        let leaves = self.extraction(cut).runs(&self.levels);
        let first = index_u32(self.levels.strokes().len());
        let branches = self.branches.runs(&cut.limits, cut.branches).into_iter();
        let branches = branches.map(|run| first + run.start..first + run.end);
        let mut runs: Vec<Range<u32>> = Vec::new();
        for run in leaves.chain(branches).filter(|run| !run.is_empty()) {
            match runs.last_mut() {
                Some(last) if last.end == run.start => last.end = run.end,
                _ => runs.push(run),
            }
        }
        runs
    }

    fn extraction(&self, cut: &StrokeCut) -> Extraction {
        Extraction {
            fine_row: cut.row,
            switch: cut.switch,
            strokes: 0,
        }
    }

    /// How many strokes of leaves and of branches show.
    #[must_use]
    pub fn counts(&self, cut: &StrokeCut) -> [u32; 2] {
        let first = index_u32(self.levels.strokes().len());
        let mut counts = [0; 2];
        for run in self.runs(cut) {
            let leaves = run.end.min(first).saturating_sub(run.start);
            counts[0] += leaves;
            counts[1] += run.end - run.start - leaves;
        }
        counts
    }

    /// The most strokes that any cut shows.
    pub(super) fn most_strokes(&self) -> u32 {
        let leaves = index_u32(self.levels.strokes().len());
        self.levels.totals()[0] + (index_u32(self.records.len()) - leaves)
    }

    /// The most runs that any cut has.
    pub(super) fn most_runs(&self) -> u32 {
        self.levels.rows() * self.levels.shells() + self.branches.most_runs()
    }

    /// What the host keeps to find the runs of a cut, as bytes: for each shell and row in which strokes are
    /// made the first of them, and how many of them there are in each row; then the tables of branches.
    pub(super) fn table_bytes(&self) -> Vec<u8> {
        let words = self.levels.words().chain(self.branches.words());
        words.flat_map(u32::to_le_bytes).collect()
    }
}

fn range(run: Range<u32>) -> Range<usize> {
    run.start as usize..run.end as usize
}

/// The thresholds of every row after the first.
fn thresholds(
    leaves: &[LeafStroke],
    parted: &Shells,
    options: &PaintOptions,
) -> Vec<CollapseThresholds> {
    let angles = options.rows.angles().iter().map(|angle| *angle as f32);
    match options.rows.reach() {
        PaintReach::Distances(distances) => {
            let rows = distances.iter().zip(angles);
            let rows = rows.map(|(distance, angle)| CollapseThresholds {
                distance: *distance as f32 / 100.0,
                angle,
            });
            rows.collect()
        }
        PaintReach::Strokes(counts) => {
            let wanted: Vec<(u32, f32)> = counts.iter().copied().zip(angles).collect();
            thresholds_for(leaves, parted, &wanted, options.at_once, options.inward)
        }
    }
}

/// The linear colour of strokes that are marked.
const MARK: Vec3 = Vec3::new(0.75, 0.02, 0.02);

/// The linear colour of bark of which nothing is known.
const BARK: Vec3 = Vec3::new(0.13, 0.09, 0.06);

/// The mean linear colour of what is opaque of a material.
fn mean(material: &Material) -> Vec3 {
    let [red, green, blue, _] = material.base_color;
    let base = Vec3::new(red, green, blue);
    let texture = material.texture.as_ref();
    texture.map_or(base, |texture| base * texture.mean_color())
}
