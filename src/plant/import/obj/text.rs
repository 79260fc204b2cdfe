//! The lines of an OBJ file.
//!
//! The file is read twice: once for its points, in 64 bits, and once for its faces, which may name points
//! that follow. `tobj` does not serve here: it keeps positions in 32 bits, forgets the names of materials
//! whose library is missing, mixes up texture coordinates that only some corners have, names no line in its
//! errors, and takes a hundred bytes a face.

use crate::document::DocumentError;
use crate::limits::{PLACED_CORNERS, PLACED_PRIMITIVES};
use crate::math::{DVec3, Vec2, Vec3, index_u32};
use crate::plant::import::{ImportError, ImportReport, ReportKind, Source};
use std::collections::BTreeMap;

/// No point, or no name.
pub(super) const NONE: u32 = u32::MAX;

/// A corner of a face: its position, texture coordinate and normal, by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Corner {
    pub(super) position: u32,
    /// Or [`NONE`].
    pub(super) coordinate: u32,
    /// Or [`NONE`].
    pub(super) normal: u32,
}

/// Faces of one object, group and material.
#[derive(Debug)]
pub(super) struct Run {
    /// The names by number, or [`NONE`].
    pub(super) object: u32,
    pub(super) group: u32,
    pub(super) material: u32,
    /// The line of its first face.
    pub(super) line: usize,
    /// Polygons as fans around their first corners.
    pub(super) triangles: Vec<[Corner; 3]>,
}

/// What a file holds.
#[derive(Debug, Default)]
pub(super) struct Obj {
    pub(super) positions: Vec<DVec3>,
    /// As they stand in the file: (0, 0) is the image's bottom-left corner.
    pub(super) coordinates: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    pub(super) runs: Vec<Run>,
    /// Names of objects, groups and materials.
    pub(super) names: Vec<String>,
    /// What stands behind `mtllib`, and its line.
    pub(super) libraries: Vec<(String, usize)>,
}

/// Reads all of a file.
pub(super) fn read(source: &Source<'_>, report: &mut ImportReport) -> Result<Obj, ImportError> {
    let mut obj = points(source, report)?;
    Faces {
        source,
        obj: &mut obj,
        seen: [0; 3],
        names: BTreeMap::new(),
        runs: BTreeMap::new(),
        key: [NONE; 3],
        corners: 0,
        flat: 0,
        faces: 0,
    }
    .read(report)?;
    Ok(obj)
}

/// A line without its end; a `\` at its end joins it with the next.
#[derive(Debug, Clone, Copy)]
struct Line<'a> {
    /// From 1.
    number: usize,
    offset: usize,
    bytes: &'a [u8],
}

/// The lines of a file, after a byte order mark.
fn lines(bytes: &[u8]) -> impl Iterator<Item = Line<'_>> {
    let mut next = if bytes.starts_with(b"\xef\xbb\xbf") {
        3
    } else {
        0
    };
    let mut next_number = 1;
    std::iter::from_fn(move || {
        let (offset, number) = (next, next_number);
        let rest = bytes.get(offset..).filter(|rest| !rest.is_empty())?;
        let mut end = 0;
        next_number += 1;
        loop {
            let Some(length) = rest[end..].iter().position(|&byte| byte == b'\n') else {
                end = rest.len();
                break;
            };
            end += length;
            let before = rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end]);
            if !before.ends_with(b"\\") {
                break;
            }
            end += 1;
            next_number += 1;
        }
        next = offset + end + 1;
        Some(Line {
            number,
            offset,
            bytes: &rest[..end],
        })
    })
}

impl<'a> Line<'a> {
    /// The words and their offsets in the file.
    fn words(self) -> impl Iterator<Item = (usize, &'a [u8])> {
        let Self { offset, bytes, .. } = self;
        let is_gap = |byte: u8| byte.is_ascii_whitespace() || byte == b'\\';
        let mut next = 0;
        std::iter::from_fn(move || {
            let rest = &bytes[next..];
            let start = next + rest.iter().position(|&byte| !is_gap(byte))?;
            let rest = &bytes[start..];
            let length = rest.iter().position(|&byte| is_gap(byte));
            next = start + length.unwrap_or(rest.len());
            Some((offset + start, &bytes[start..next]))
        })
    }

    /// What stands behind the first word.
    fn rest(self) -> String {
        let text = String::from_utf8_lossy(self.bytes);
        let text = text.trim_start();
        let rest = text
            .find(char::is_whitespace)
            .map_or("", |end| &text[end..]);
        rest.trim().to_owned()
    }
}

/// An error at a byte of the file.
fn error(source: &Source<'_>, offset: usize, message: String) -> ImportError {
    let before = &source.bytes()[..offset];
    let start = before
        .iter()
        .rposition(|&byte| byte == b'\n')
        .map_or(0, |end| end + 1);
    ImportError::Syntax(DocumentError {
        file: source.file().to_owned(),
        line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
        column: 1 + String::from_utf8_lossy(&before[start..]).chars().count(),
        message,
    })
}

fn number(source: &Source<'_>, (offset, word): (usize, &[u8])) -> Result<f64, ImportError> {
    let value = std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse::<f64>().ok());
    value.filter(|value| value.is_finite()).ok_or_else(|| {
        let word = String::from_utf8_lossy(word);
        error(source, offset, format!("{word:?}, wanted a finite number"))
    })
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "what does not fit is refused"
)]
fn small(source: &Source<'_>, word: (usize, &[u8])) -> Result<f32, ImportError> {
    let value = number(source, word)?;
    let rounded = value as f32;
    if rounded.is_finite() {
        return Ok(rounded);
    }
    let message = format!(
        "{}, wanted at most {:e} either way",
        String::from_utf8_lossy(word.1),
        f32::MAX
    );
    Err(error(source, word.0, message))
}

/// The points of a file.
fn points(source: &Source<'_>, report: &mut ImportReport) -> Result<Obj, ImportError> {
    let mut obj = Obj::default();
    let (mut colors, mut weights) = (0, 0);
    let mut first = [1; 2];
    for line in lines(source.bytes()) {
        let mut words = line.words();
        let Some((offset, keyword @ (b"v" | b"vt" | b"vn"))) = words.next() else {
            continue;
        };
        let wanted = if keyword == b"vt" { 1 } else { 3 };
        let mut found: Vec<(usize, &[u8])> = Vec::with_capacity(8);
        found.extend(words.take(8));
        if found.len() < wanted {
            let keyword = String::from_utf8_lossy(keyword);
            let message = format!("{keyword} has {} numbers, wanted {wanted}", found.len());
            return Err(error(source, offset, message));
        }
        match keyword {
            b"v" => {
                let [x, y, z] = [found[0], found[1], found[2]].map(|word| number(source, word));
                obj.positions.push(DVec3::new(x?, y?, z?));
                if found.len() > 5 {
                    if colors == 0 {
                        first[0] = line.number;
                    }
                    colors += 1;
                } else if found.len() > 3 {
                    if weights == 0 {
                        first[1] = line.number;
                    }
                    weights += 1;
                }
            }
            b"vt" => {
                let u = small(source, found[0])?;
                let v = found.get(1).map_or(Ok(0.0), |&word| small(source, word))?;
                obj.coordinates.push(Vec2::new(u, v));
            }
            _ => {
                let [x, y, z] = [found[0], found[1], found[2]].map(|word| small(source, word));
                obj.normals.push(Vec3::new(x?, y?, z?));
            }
        }
        for (what, count) in [
            ("vertices", obj.positions.len()),
            ("texture coordinates", obj.coordinates.len()),
            ("normals", obj.normals.len()),
        ] {
            source.limit(what, count as u64, PLACED_CORNERS)?;
        }
    }
    for (count, place, message) in [
        (colors, first[0], "vertex colours"),
        (weights, first[1], "weights of vertices"),
    ] {
        report.add(ReportKind::Ignored, count, format!("line {place}"), message);
    }
    Ok(obj)
}

/// Reading faces.
struct Faces<'a, 's> {
    source: &'a Source<'s>,
    obj: &'a mut Obj,
    /// How many positions, texture coordinates and normals stand above: negative numbers count back
    /// from there.
    seen: [usize; 3],
    names: BTreeMap<String, u32>,
    runs: BTreeMap<[u32; 3], usize>,
    /// The object, group and material of what follows.
    key: [u32; 3],
    corners: u64,
    flat: u64,
    faces: u64,
}

impl Faces<'_, '_> {
    fn read(mut self, report: &mut ImportReport) -> Result<(), ImportError> {
        let mut dropped: BTreeMap<&'static str, (u64, usize)> = BTreeMap::new();
        let mut corners = Vec::new();
        for line in lines(self.source.bytes()) {
            let mut words = line.words();
            let Some((_, keyword)) = words.next() else {
                continue;
            };
            let left_out = match keyword {
                b"v" => {
                    self.seen[0] += 1;
                    continue;
                }
                b"vt" => {
                    self.seen[1] += 1;
                    continue;
                }
                b"vn" => {
                    self.seen[2] += 1;
                    continue;
                }
                b"f" => {
                    corners.clear();
                    for word in words {
                        corners.push(self.corner(word)?);
                    }
                    if self.face(&corners, line.number)? {
                        continue;
                    }
                    "faces of fewer than three corners"
                }
                b"o" | b"g" | b"usemtl" => {
                    let name = self.name(line.rest());
                    self.key
                        [usize::from(keyword == b"g") + 2 * usize::from(keyword == b"usemtl")] =
                        name;
                    if keyword == b"o" {
                        self.key[1] = NONE;
                    }
                    continue;
                }
                b"mtllib" => {
                    self.obj.libraries.push((line.rest(), line.number));
                    continue;
                }
                b"l" => "lines",
                b"p" => "points",
                b"s" | b"mg" => continue,
                [b'#', ..] => continue,
                _ => "lines that are not of a mesh: curves, surfaces and what is not known",
            };
            dropped.entry(left_out).or_insert((0, line.number)).0 += 1;
        }
        for (message, (count, line)) in dropped {
            report.add(ReportKind::Dropped, count, format!("line {line}"), message);
        }
        let message = "triangles that name a vertex twice";
        report.add(ReportKind::Dropped, self.flat, "line 1", message);
        report.find("faces", self.faces);
        report.find("triangles", self.corners / 3);
        Ok(())
    }

    fn name(&mut self, name: String) -> u32 {
        if name.is_empty() {
            return NONE;
        }
        let next = index_u32(self.obj.names.len());
        let names = &mut self.obj.names;
        *self.names.entry(name).or_insert_with_key(|name| {
            names.push(name.clone());
            next
        })
    }

    /// A corner as `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 1, or from −1 back.
    fn corner(&self, (offset, word): (usize, &[u8])) -> Result<Corner, ImportError> {
        let wrong = |message: String| error(self.source, offset, message);
        let shown = || String::from_utf8_lossy(word).into_owned();
        let totals = [
            self.obj.positions.len(),
            self.obj.coordinates.len(),
            self.obj.normals.len(),
        ];
        let mut found = [NONE; 3];
        if word.iter().filter(|&&byte| byte == b'/').count() > 2 {
            let message = format!("corner {:?} has more than three numbers", shown());
            return Err(wrong(message));
        }
        for (place, part) in word.split(|&byte| byte == b'/').enumerate() {
            if part.is_empty() && place > 0 {
                continue;
            }
            let value = std::str::from_utf8(part)
                .ok()
                .and_then(|part| part.parse::<i64>().ok());
            let Some(value) = value else {
                let message = format!("corner {:?}, wanted whole numbers between '/'", shown());
                return Err(wrong(message));
            };
            let number = if value < 0 {
                let above = i64::try_from(self.seen[place]).unwrap_or(i64::MAX);
                above.checked_add(value)
            } else {
                value.checked_sub(1)
            };
            let number = number.and_then(|number| usize::try_from(number).ok());
            let Some(number) = number.filter(|&number| number < totals[place]) else {
                let what = ["vertex", "texture coordinate", "normal"][place];
                let message = format!("names {what} {value}, but there are {}", totals[place]);
                return Err(wrong(message));
            };
            found[place] = index_u32(number);
        }
        let [position, coordinate, normal] = found;
        Ok(Corner {
            position,
            coordinate,
            normal,
        })
    }

    /// Adds a face; tells whether it has an inside.
    fn face(&mut self, corners: &[Corner], line: usize) -> Result<bool, ImportError> {
        let [first, rest @ ..] = corners else {
            return Ok(false);
        };
        if rest.len() < 2 {
            return Ok(false);
        }
        self.faces += 1;
        self.corners += 3 * (rest.len() as u64 - 1);
        self.source
            .limit("triangle corners", self.corners, PLACED_CORNERS)?;
        let runs = &mut self.obj.runs;
        let key = self.key;
        let number = match self.runs.get(&key) {
            Some(&number) => number,
            None => {
                let count = runs.len() as u64 + 1;
                self.source
                    .limit("groups", count, PLACED_PRIMITIVES as u64)?;
                let [object, group, material] = key;
                runs.push(Run {
                    object,
                    group,
                    material,
                    line,
                    triangles: Vec::new(),
                });
                self.runs.insert(key, runs.len() - 1);
                runs.len() - 1
            }
        };
        for pair in rest.windows(2) {
            let triangle = [*first, pair[0], pair[1]];
            let [a, b, c] = triangle.map(|corner| corner.position);
            if a == b || b == c || c == a {
                self.flat += 1;
            } else {
                runs[number].triangles.push(triangle);
            }
        }
        Ok(true)
    }
}
