//! Joining the folders of all shards.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::read::ShardFile;
use super::{Job, LookLine, PictureLine, StepLine};
use crate::gpu::Ledger;
use crate::limits;
use crate::math::index_u32;
use crate::report::image::read_file;
use crate::report::run::{FrameRow, PathEntry, RunFolder, RunHeader};
use crate::report::sweep::{SweepHeader, write_sweep};
use crate::report::{OutputFolder, Picture, ReportError, SweepPictures, SweepQuality};
use crate::run::{Appearance, Frame, Progress, Sweep, SweepModel, looked_at};

/// What was joined.
#[derive(Debug, Clone, PartialEq)]
pub enum Merged {
    /// A run.
    Run {
        /// What was run.
        header: Box<RunHeader>,
        /// Its frames in numbers.
        rows: Vec<FrameRow>,
        /// What the way of the camera was like, if it has one.
        path: Option<PathEntry>,
    },
    /// A walk.
    Sweep {
        /// What was walked.
        header: SweepHeader,
        /// All steps of all models.
        sweep: Sweep,
        /// What the levels do to the picture, if it was asked.
        quality: Option<SweepQuality>,
    },
}

/// Joins the folders of all shards of a run or walk; `target` says where to, by the scene's name and
/// whether it is a walk.
///
/// # Errors
///
/// When a folder is no shard's, they are not all the shards of one job, or something in them is not as
/// it was written; and as [`OutputFolder::create`].
pub fn merge(
    folders: &[PathBuf],
    target: impl FnOnce(&str, bool) -> PathBuf,
    progress: &dyn Progress,
) -> Result<(Merged, PathBuf), ReportError> {
    let mut shards = opened(folders)?;
    let Some(first) = shards.first() else {
        let message = "no folder, wanted those of all shards".to_owned();
        return Err(wrong(Path::new(""), message));
    };
    match first.head.job.clone() {
        Job::Run {
            header,
            initial,
            frames,
            layers,
            popping: _,
            exact: _,
        } => {
            let target = target(&header.scene, false);
            let run = RunJob {
                header: *header,
                initial: *initial,
                frames,
                layers,
            };
            Ok((merge_run(&mut shards, run, &target, progress)?, target))
        }
        Job::Sweep {
            header,
            scene_digest: _,
            exact: _,
            steps,
            looks,
            models,
        } => {
            let target = target(&header.scene, true);
            let folder = OutputFolder::create(&target)?;
            let sweep = Sweep {
                models: joined_steps(&mut shards, steps, models, progress)?,
            };
            let appearances = Appearance::all_of(sweep.models.iter().map(|model| model.variant));
            let quality = looks.map(|looks| joined_looks(&mut shards, steps, looks, &appearances));
            let quality = quality.transpose()?;
            let pictures = joined_pictures(&mut shards)?;
            write_sweep(&folder, &header, &sweep, quality.as_ref(), &pictures)?;
            folder.commit()?;
            let merged = Merged::Sweep {
                header: *header,
                sweep,
                quality,
            };
            Ok((merged, target))
        }
    }
}

/// All shards in their order, each there once and of the same job.
fn opened(folders: &[PathBuf]) -> Result<Vec<ShardFile>, ReportError> {
    let (found, most) = (folders.len(), limits::SHARDS);
    if found > most {
        let message = format!("{found} folders, wanted at most {most}");
        return Err(wrong(Path::new(""), message));
    }
    let mut shards: Vec<ShardFile> = Vec::new();
    for folder in folders {
        let shard = ShardFile::open(folder)?;
        if let Some(first) = shards.first() {
            let (ours, theirs) = (&shard.head, &first.head);
            if ours.job != theirs.job || ours.shard.count != theirs.shard.count {
                let first = first.folder.display();
                let (ours, theirs) = (ours.shard, theirs.shard);
                let message = format!(
                    "shard {ours} was made from another scene or with other flags than shard {theirs} in {first}"
                );
                return Err(shard.fail(message));
            }
        }
        shards.push(shard);
    }
    shards.sort_by_key(|shard| shard.head.shard.index);
    for (index, shard) in (0..).zip(&shards) {
        let found = shard.head.shard;
        if found.index != index {
            let missing = match found.index < index {
                true => format!("shard {found} is there twice"),
                false => format!("shard {index}/{} is missing", found.count),
            };
            return Err(wrong(&shard.folder, missing));
        }
    }
    if let Some(last) = shards.last()
        && last.head.shard.index + 1 < last.head.shard.count
    {
        let (next, count) = (last.head.shard.index + 1, last.head.shard.count);
        let message = format!("shard {next}/{count} is missing");
        return Err(wrong(&last.folder, message));
    }
    Ok(shards)
}

struct RunJob {
    header: RunHeader,
    initial: Ledger,
    frames: Range<u32>,
    layers: bool,
}

fn merge_run(
    shards: &mut [ShardFile],
    job: RunJob,
    target: &Path,
    progress: &dyn Progress,
) -> Result<Merged, ReportError> {
    let mut folder = RunFolder::create(target, job.header.clone(), &job.initial)?;
    if let Some(first) = shards.first() {
        let plants = first.folder.join("plants");
        if plants.is_dir() {
            folder.folder().copy_below(&plants, "plants")?;
        }
    }
    progress.begin("frames", u64::from(job.frames.end - job.frames.start));
    for number in job.frames {
        let shard = shard_of(shards, number);
        let mut frame = match shard.next::<Frame>()? {
            Some(frame) if frame.frame == number => frame,
            Some(frame) => {
                return Err(shard.fail(format!("frame {}, wanted {number}", frame.frame)));
            }
            None => return Err(shard.fail(format!("frame {number} is missing"))),
        };
        let path = shard.folder.join(format!("frame-{number:04}.png"));
        let picture = Picture::read(&path)?;
        let size = [picture.width(), picture.height()];
        frame.set_image(size, picture.rgba().to_vec());
        let (found, wanted) = (frame.image.digest(), frame.image_digest);
        if found != wanted {
            let message = format!("the picture has digest {found}, its frame {wanted}");
            return Err(wrong(&path, message));
        }
        folder.add(&frame)?;
        if job.layers {
            let name = format!("frame-{number:04}.exr");
            folder.folder().copy(&shard.folder.join(&name), &name)?;
        }
        progress.step();
    }
    ended(shards)?;
    let header = Box::new(job.header);
    let path = folder.path();
    let rows = folder.finish()?;
    Ok(Merged::Run { header, rows, path })
}

fn joined_steps(
    shards: &mut [ShardFile],
    steps: u32,
    mut models: Vec<SweepModel>,
    progress: &dyn Progress,
) -> Result<Vec<SweepModel>, ReportError> {
    progress.begin("models", models.len() as u64);
    for (number, model) in models.iter_mut().enumerate() {
        for step in 0..=steps {
            let shard = shard_of(shards, step);
            let line = match shard.next::<StepLine>()? {
                Some(line) if line.model == number && line.step.step == step => line,
                _ => {
                    let label = model.variant.label();
                    return Err(shard.fail(format!("wanted step {step} of {label}")));
                }
            };
            model.steps.push(line.step);
        }
        progress.step();
    }
    Ok(models)
}

fn joined_looks(
    shards: &mut [ShardFile],
    steps: u32,
    looks: u32,
    appearances: &[Appearance],
) -> Result<SweepQuality, ReportError> {
    let mut quality = SweepQuality {
        plants: 0,
        steps: Vec::new(),
    };
    for (place, &appearance) in appearances.iter().enumerate() {
        for step in looked_at(steps, looks) {
            let shard = shard_of(shards, step);
            match shard.next::<LookLine>()? {
                Some(line) if (line.appearance, line.look) == (place, step) => {
                    quality.plants = line.plants;
                    quality.steps.push(line.quality(appearance));
                }
                _ => return Err(shard.fail(format!("wanted what step {step} does to the picture"))),
            }
        }
    }
    Ok(quality)
}

/// The pictures of all shards, which end their lines.
fn joined_pictures(shards: &mut [ShardFile]) -> Result<SweepPictures, ReportError> {
    let mut pictures = SweepPictures::default();
    for shard in shards {
        while let Some(line) = shard.next::<PictureLine>()? {
            let path = shard.folder.join(line.name());
            let png = read_file(&path)?;
            if PictureLine::of(line.picture, &png) != line {
                let message = "not the picture that was written there".to_owned();
                return Err(wrong(&path, message));
            }
            let picture = Picture::from_png(&path, &png)?;
            let kept = pictures.insert(line.picture, picture);
            kept.map_err(|message| wrong(&path, message))?;
        }
    }
    Ok(pictures)
}

/// The shard that drew a frame or step; there is one of every index.
fn shard_of(shards: &mut [ShardFile], number: u32) -> &mut ShardFile {
    let count = index_u32(shards.len()).max(1);
    &mut shards[(number % count) as usize]
}

/// Nothing may follow.
fn ended(shards: &mut [ShardFile]) -> Result<(), ReportError> {
    for shard in shards {
        if shard.next::<serde_json::Value>()?.is_some() {
            return Err(shard.fail("more lines than the shard has frames or steps".to_owned()));
        }
    }
    Ok(())
}

fn wrong(file: &Path, message: String) -> ReportError {
    ReportError::Shard {
        file: file.to_owned(),
        line: 0,
        message,
    }
}
