//! Laws of what lies on a device, what was sent there, and what is drawn from it.

use std::ops::Range;

use super::super::device::{Change, Counted, DeviceModel, Picture, Reads, Residency, Resource};
use super::super::{Law, Violation};
use crate::math::index_usize;

/// Residency: every byte that a draw of the state can read equals what a model holds that was made
/// anew in the state; what draws pull from host memory is the same, primitive by primitive.
///
/// Catches: a slot left stale; a changed range that was not sent; a count that was not updated; a
/// range sent to the wrong offset; a commit of another state than the one asked for.
///
/// # Errors
///
/// The first byte that differs.
pub fn residency<S>(
    walked: &mut dyn DeviceModel<S>,
    fresh: &mut dyn DeviceModel<S>,
) -> Result<(), Violation> {
    let law = Law::Residency;
    let reads = fresh.reads();
    let (wanted, found) = (fresh.resources(), walked.resources());
    if wanted.len() != found.len() {
        let what = "number of resources";
        return Err(Violation::new(
            law,
            "on the device",
            what,
            wanted.len(),
            found.len(),
        ));
    }
    residency_of(&reads.ranges, &wanted, &found)?;
    if !reads.fetched.is_empty() {
        let fetched = walked.reads().fetched;
        let place = "in host memory";
        if reads.fetched.len() != fetched.len() {
            let what = "primitives that a draw pulls";
            let (wanted, found) = (reads.fetched.len(), fetched.len());
            return Err(Violation::new(law, place, what, wanted, found));
        }
        let mut pairs = reads.fetched.iter().zip(&fetched).enumerate();
        if let Some((number, (wanted, found))) = pairs.find(|(_, (wanted, found))| wanted != found)
        {
            let what = format!("bytes that primitive {number} pulls");
            return Err(Violation::new(law, place, what, hex(wanted), hex(found)));
        }
    }
    Ok(())
}

/// [Residency](residency()) of parts that are at hand: the ranges that a draw may read, what a fresh
/// upload holds, and what is held.
///
/// # Errors
///
/// The first byte that differs.
pub fn residency_of(
    ranges: &[(usize, Range<usize>)],
    fresh: &[Resource<'_>],
    walked: &[Resource<'_>],
) -> Result<(), Violation> {
    let law = Law::Residency;
    for (resource, range) in ranges {
        let (Some(wanted), Some(found)) = (fresh.get(*resource), walked.get(*resource)) else {
            continue;
        };
        if wanted.bytes.len() != found.bytes.len() {
            let place = format!("in {:?}", wanted.name);
            let (wanted, found) = (wanted.bytes.len(), found.bytes.len());
            return Err(Violation::new(law, place, "size in bytes", wanted, found));
        }
        let range = range.start.min(wanted.bytes.len())..range.end.min(wanted.bytes.len());
        let [anew, held] =
            [wanted, found].map(|resource| resource.bytes.get(range.clone()).unwrap_or(&[]));
        same_bytes(
            law,
            wanted.name,
            "which a draw reads",
            range.start,
            anew,
            held,
        )?;
    }
    Ok(())
}

/// Whether bytes from `from` on in the resource `name` are the same.
pub(in super::super) fn same_bytes(
    law: Law,
    name: &str,
    which: &str,
    from: usize,
    wanted: &[u8],
    found: &[u8],
) -> Result<(), Violation> {
    let Some(at) = first_difference(wanted, found) else {
        return Ok(());
    };
    let place = format!("in {name:?}");
    let what = format!("bytes from {} on, {which}", from + at);
    let [wanted, found] = [wanted, found].map(|bytes| hex(&bytes[at..]));
    Err(Violation::new(law, place, what, wanted, found))
}

fn first_difference(wanted: &[u8], found: &[u8]) -> Option<usize> {
    if wanted == found {
        return None;
    }
    let differs = wanted.iter().zip(found).position(|(a, b)| a != b);
    Some(differs.unwrap_or(wanted.len().min(found.len())))
}

/// The first bytes as people read them.
fn hex(bytes: &[u8]) -> String {
    let mut text: String = bytes
        .iter()
        .take(16)
        .map(|byte| format!("{byte:02x}"))
        .collect();
    if bytes.len() > 16 {
        text.push('…');
    }
    text
}

/// Fills every byte of device memory that is in no range of `reads` with `a5`, in resources that
/// `reads` knows. Dead bytes may hold anything; a model in which they matter is then seen.
///
/// A model may rely on dead bytes for its next change of detail, so this ends a walk.
pub fn poison_dead_bytes<S>(model: &mut dyn DeviceModel<S>, reads: &Reads) {
    let mut read = reads.ranges.clone();
    read.sort_by_key(|(resource, range)| (*resource, range.start));
    let sizes: Vec<Option<usize>> = model
        .resources()
        .iter()
        .map(|held| (held.residency == Residency::Device).then_some(held.bytes.len()))
        .collect();
    let mut known: Vec<usize> = read.iter().map(|(resource, _)| *resource).collect();
    known.dedup();
    for resource in known {
        let Some(size) = sizes.get(resource).copied().flatten() else {
            continue;
        };
        let mut from = 0;
        let ranges = read.iter().filter(|(number, _)| *number == resource);
        let end = std::iter::once(size..size);
        for range in ranges.map(|(_, range)| range.clone()).chain(end) {
            if from < range.start.min(size) {
                let gap = range.start.min(size) - from;
                model.overwrite(resource, from, &vec![0xa5; gap]);
            }
            from = from.max(range.end);
        }
    }
}

/// Conservation: the log of changes, replayed into zeros, gives what is held; the lengths and the
/// transfers of its writes add up to what was counted, however that is itemised.
///
/// Catches: a transfer that is not counted, or counted twice; a byte changed behind the bus's back.
///
/// Holds for a model without a log, since there is nothing to check.
///
/// # Errors
///
/// The first change that does not fit its resource, byte that differs, or sum that does.
pub fn conservation<S>(model: &mut dyn DeviceModel<S>) -> Result<(), Violation> {
    let counted = model.counted();
    match model.log() {
        Some(log) => conservation_of(&model.resources(), &log, counted.as_ref()),
        None => Ok(()),
    }
}

/// [Conservation](conservation()) of parts that are at hand: what is held, the log of changes, and
/// what was counted.
///
/// # Errors
///
/// As [`conservation()`].
pub fn conservation_of(
    resources: &[Resource<'_>],
    log: &[Change<'_>],
    counted: Option<&Counted>,
) -> Result<(), Violation> {
    let law = Law::Conservation;
    let sizes = resources.iter().map(|held| held.bytes.len());
    let mut memory: Vec<Vec<u8>> = sizes.map(|size| vec![0; size]).collect();
    let (mut payload, mut transfers, mut last) = (0_u64, 0_u64, None);
    for (number, change) in log.iter().enumerate() {
        if let Change::Write {
            transfer, bytes, ..
        } = change
        {
            payload += bytes.len() as u64;
            transfers += u64::from(last.replace(*transfer) != Some(*transfer));
        }
        if replay(&mut memory, *change).is_none() {
            let place = format!("in change {number} of the log");
            let what = "where it lies";
            return Err(Violation::new(
                law,
                place,
                what,
                "within its resource",
                "beyond",
            ));
        }
    }
    for (held, replayed) in resources.iter().zip(&memory) {
        if held.residency == Residency::Device {
            same_bytes(law, held.name, "replayed and held", 0, replayed, held.bytes)?;
        }
    }
    let Some(counted) = counted else {
        return Ok(());
    };
    let all = ("", counted.transfers, counted.payload_bytes);
    let itemised = counted.itemised.iter();
    let itemised = itemised.map(|items| (items.by, items.transfers, items.payload_bytes));
    for (by, counted_transfers, counted_payload) in std::iter::once(all).chain(itemised) {
        let place = match by {
            "" => "in the counters".to_owned(),
            by => format!("in the counters {by}"),
        };
        if counted_transfers != transfers {
            let what = "transfers of the log, and counted";
            return Err(Violation::new(
                law,
                place,
                what,
                transfers,
                counted_transfers,
            ));
        }
        if counted_payload != payload {
            let what = "bytes of the log, and counted";
            return Err(Violation::new(law, place, what, payload, counted_payload));
        }
    }
    Ok(())
}

/// Does one change to arrays that begin as zeros; `None` if it does not fit.
fn replay(memory: &mut [Vec<u8>], change: Change<'_>) -> Option<()> {
    let range = |at: u64, size: u64| {
        let end = at.checked_add(size)?;
        usize::try_from(end).ok()?;
        Some(index_usize(at)..index_usize(end))
    };
    match change {
        Change::Write {
            resource,
            at,
            bytes,
            ..
        }
        | Change::Computed {
            resource,
            at,
            bytes,
        } => {
            let range = range(at, bytes.len() as u64)?;
            memory
                .get_mut(resource)?
                .get_mut(range)?
                .copy_from_slice(bytes);
        }
        Change::Copy {
            source,
            source_at,
            resource,
            at,
            size,
        } => {
            let bytes = memory.get(source)?.get(range(source_at, size)?)?.to_vec();
            memory
                .get_mut(resource)?
                .get_mut(range(at, size)?)?
                .copy_from_slice(&bytes);
        }
        Change::Clear { resource, at, size } => {
            memory.get_mut(resource)?.get_mut(range(at, size)?)?.fill(0);
        }
    }
    Some(())
}

/// Image equality: a model draws after a walk, its [dead bytes poisoned](poison_dead_bytes), what
/// one draws that was made anew in its state, bit for bit; and both draw the `reference`, if there
/// is one: a picture of the same leaves by another model.
///
/// Catches: a draw that stops short of the last leaves; ties of depth that are decided by the order
/// of slots; a model in which dead bytes matter.
///
/// Holds for models without pictures, since there is nothing to check.
///
/// # Errors
///
/// The first pixel that differs.
pub fn image_equality<S>(
    walked: &mut dyn DeviceModel<S>,
    fresh: &mut dyn DeviceModel<S>,
    reference: Option<&Picture>,
) -> Result<(), Violation> {
    let Some(anew) = fresh.picture() else {
        return Ok(());
    };
    if let Some(reference) = reference {
        same_picture("drawn anew", reference, &anew)?;
    }
    let reads = fresh.reads();
    // What lies in host memory is fetched, not resident: there are no dead bytes to poison.
    if reads.fetched.is_empty() {
        poison_dead_bytes(walked, &reads);
    }
    match walked.picture() {
        Some(found) => same_picture("after the walk, dead bytes poisoned", &anew, &found),
        None => Ok(()),
    }
}

/// Whether two pictures are the same, bit for bit, as a check of [`Law::ImageEquality`].
///
/// # Errors
///
/// The first pixel that differs.
pub fn same_picture(place: &str, wanted: &Picture, found: &Picture) -> Result<(), Violation> {
    let law = Law::ImageEquality;
    let size = |picture: &Picture| format!("{} × {}", picture.width, picture.height);
    if (wanted.width, wanted.height) != (found.width, found.height) {
        return Err(Violation::new(
            law,
            place,
            "pixels",
            size(wanted),
            size(found),
        ));
    }
    if wanted.rgba == found.rgba {
        return Ok(());
    }
    let pixels = || wanted.rgba.chunks(4).zip(found.rgba.chunks(4));
    let count = pixels().filter(|(a, b)| a != b).count();
    let first = pixels().position(|(a, b)| a != b).unwrap_or(0);
    let width = index_usize(u64::from(wanted.width.max(1)));
    let (x, y) = (first % width, first / width);
    let what = format!("colour of pixel ({x}, {y}), the first of {count}");
    let pixel = |picture: &Picture| hex(picture.rgba.chunks(4).nth(first).unwrap_or(&[]));
    Err(Violation::new(
        law,
        place,
        what,
        pixel(wanted),
        pixel(found),
    ))
}
