//! What an OBJ file's surfaces look like: its libraries, and the pictures that these name.

use super::text::Obj;
use crate::limits::PLANT_TEXELS;
use crate::plant::import::mesh::{self, decode_png, says_leaves};
use crate::plant::import::{ImportReport, ReportKind, Source};
use crate::plant::texture::linear_of_srgb;
use crate::plant::{Foliage, Material, Texture};
use std::collections::BTreeMap;
use std::convert::Infallible;

/// Below this alpha a texel is not there, as glTF has it for masked materials.
const CUTOFF: f32 = 0.5;

/// The colours of wood and leaves of which nothing is known, sRGB: those of species.
const BARK: [u8; 3] = [0x6b, 0x5d, 0x4d];
const LEAF: [u8; 3] = [0x4f, 0x7a, 0x2c];

/// The materials that a file uses.
#[derive(Debug)]
pub(super) struct Library {
    /// By their names' numbers, their places in `used`.
    numbers: BTreeMap<u32, usize>,
    used: Vec<Used>,
}

#[derive(Debug)]
struct Used {
    material: Material,
    has_alpha: bool,
    /// Whether no library holds it.
    is_missing: bool,
}

/// Pictures, each read once.
struct Pictures<'a, 's> {
    source: &'a Source<'s>,
    known: BTreeMap<String, Option<Texture>>,
    texels: u64,
}

impl Library {
    /// Reads the libraries that a file names. What is missing is reported, and its colour guessed.
    pub(super) fn read(source: &Source<'_>, obj: &Obj, report: &mut ImportReport) -> Self {
        let mut found: BTreeMap<String, (tobj::Material, String)> = BTreeMap::new();
        for (files, line) in &obj.libraries {
            for file in library_files(files) {
                let place = format!("line {line}");
                let bytes = match source.beside(file) {
                    Ok(bytes) => bytes,
                    Err(error) => {
                        let message = format!("material library {file:?}: {error}");
                        report.add(ReportKind::Missing, 1, place, message);
                        continue;
                    }
                };
                let folder = folder_of(file);
                for material in parse(file, &bytes, &place, report) {
                    let name = material.name.clone();
                    found.entry(name).or_insert((material, folder.clone()));
                }
            }
        }
        let mut pictures = Pictures {
            source,
            known: BTreeMap::new(),
            texels: 0,
        };
        let mut library = Self {
            numbers: BTreeMap::new(),
            used: Vec::new(),
        };
        for number in obj.materials() {
            let name = &obj.names[number as usize];
            let used = match found.get(name) {
                Some((material, folder)) => pictures.material(material, folder, report),
                None => {
                    let message = "materials that no library holds: their colours are guessed";
                    report.add(ReportKind::Missing, 1, format!("usemtl {name}"), message);
                    unknown(name)
                }
            };
            library.numbers.insert(number, library.used.len());
            library.used.push(used);
        }
        library
    }

    /// The place of a material by its name's number.
    pub(super) fn number(&self, name: u32) -> Option<usize> {
        self.numbers.get(&name).copied()
    }

    /// Whether a material leaves out what is transparent.
    pub(super) fn has_alpha(&self, material: usize) -> bool {
        self.used[material].has_alpha
    }

    /// Gives leaves of which no material is known a leaf's colour.
    pub(super) fn color_leaves(&self, foliage: &mut Foliage) {
        let is_known = |material: &Material| {
            let mut known = self.used.iter().filter(|used| !used.is_missing);
            known.any(|used| used.material == *material)
        };
        for group in &mut foliage.groups {
            if !is_known(&group.material) {
                group.material = Material::plain(group.material.name.clone(), linear(LEAF));
            }
        }
    }
}

impl mesh::Materials for Library {
    type Fault = Infallible;

    fn read(&mut self, index: Option<usize>, _: &mut ImportReport) -> Result<Material, Infallible> {
        Ok(match index {
            Some(index) => self.used[index].material.clone(),
            None => unknown("default").material,
        })
    }

    fn title(&self, index: usize) -> String {
        format!("{:?}", self.used[index].material.name)
    }

    fn name_and_place(&self, index: usize) -> (String, String) {
        let name = &self.used[index].material.name;
        (name.clone(), format!("usemtl {name}"))
    }
}

fn unknown(name: &str) -> Used {
    let color = if says_leaves(Some(name)) { LEAF } else { BARK };
    Used {
        material: Material::plain(name, linear(color)),
        has_alpha: false,
        is_missing: true,
    }
}

fn linear(color: [u8; 3]) -> [f32; 3] {
    color.map(linear_of_srgb)
}

/// The files of an `mtllib` line: one whose name has spaces, or several.
fn library_files(files: &str) -> Vec<&str> {
    let words: Vec<&str> = files.split_whitespace().collect();
    let is_library = |word: &&str| word.to_lowercase().ends_with(".mtl");
    if words.iter().all(is_library) {
        words
    } else {
        vec![files]
    }
}

/// The path of a file's folder, with a `/` at its end unless it is empty.
fn folder_of(file: &str) -> String {
    let end = file.rfind(['/', '\\']).map_or(0, |end| end + 1);
    file[..end].to_owned()
}

/// The materials of a library. `tobj` panics at colours of fewer than three numbers: such lines are left
/// out.
fn parse(file: &str, bytes: &[u8], place: &str, report: &mut ImportReport) -> Vec<tobj::Material> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let is_short = |line: &str| {
        let mut words = line.split_whitespace();
        words.next().is_some_and(|word| word.starts_with('K')) && words.count() < 3
    };
    let kept: String = text
        .lines()
        .map(|line| {
            if is_short(line) {
                "\n".to_owned()
            } else {
                format!("{line}\n")
            }
        })
        .collect();
    let short = text.lines().filter(|line| is_short(line)).count() as u64;
    let message = format!("colours of fewer than three numbers in {file:?}");
    report.add(ReportKind::Dropped, short, place, message);
    match tobj::load_mtl_buf(&mut kept.as_bytes()) {
        Ok((materials, _)) => materials,
        Err(error) => {
            let message = format!("material library {file:?}: {error}");
            report.add(ReportKind::NotUnderstood, 1, place, message);
            Vec::new()
        }
    }
}

impl Pictures<'_, '_> {
    fn material(&mut self, told: &tobj::Material, folder: &str, report: &mut ImportReport) -> Used {
        let place = format!("newmtl {}", told.name);
        let color = told.diffuse.unwrap_or([1.0; 3]);
        let is_color = color
            .iter()
            .all(|channel| channel.is_finite() && *channel >= 0.0);
        if !is_color {
            let message = "colours that are no finite numbers of at least 0: white";
            report.add(ReportKind::Repaired, 1, &place, message);
        }
        let [r, g, b] = if is_color { color } else { [1.0; 3] };
        let lets_through = told.dissolve.is_some_and(|dissolve| dissolve < 1.0);
        let message = "materials that let light through everywhere (d below 1): opaque";
        report.add(
            ReportKind::Ignored,
            u64::from(lets_through),
            &place,
            message,
        );
        let unused = [
            &told.ambient_texture,
            &told.specular_texture,
            &told.normal_texture,
            &told.shininess_texture,
        ];
        let unused = unused.iter().filter(|texture| texture.is_some()).count() as u64;
        let message = "pictures other than map_Kd and map_d";
        report.add(ReportKind::Ignored, unused, &place, message);
        let picture = |pictures: &mut Self, texture: &Option<String>, report: &mut ImportReport| {
            let texture = texture.as_deref()?;
            pictures.picture(&format!("{folder}{}", path_of(texture)), &place, report)
        };
        let seen = picture(self, &told.diffuse_texture, report);
        let mask = picture(self, &told.dissolve_texture, report);
        let texture = match (seen, mask) {
            (seen, None) => seen,
            (seen, Some(mask)) => Some(masked(seen.as_ref(), &mask)),
        };
        let has_alpha = texture.as_ref().is_some_and(|texture| {
            let alphas = texture.rgba().iter().skip(3).step_by(4);
            alphas.min().is_some_and(|&alpha| alpha < 128)
        });
        Used {
            material: Material {
                name: told.name.clone(),
                base_color: [r, g, b, 1.0],
                texture,
                alpha_cutoff: if has_alpha { CUTOFF } else { 0.0 },
            },
            has_alpha,
            is_missing: false,
        }
    }

    fn picture(&mut self, path: &str, place: &str, report: &mut ImportReport) -> Option<Texture> {
        if let Some(known) = self.known.get(path) {
            return known.clone();
        }
        let found = match self.source.beside(path) {
            Err(error) => {
                let message = format!("picture {path:?}: {error}; the material stays without");
                report.add(ReportKind::Missing, 1, place, message);
                None
            }
            Ok(bytes) => match decode_png(&bytes, PLANT_TEXELS - self.texels) {
                Ok(texture) => {
                    self.texels += u64::from(texture.width()) * u64::from(texture.height());
                    Some(texture)
                }
                Err(error) => {
                    let message = format!("picture {path:?}: {error}; the material stays without");
                    report.add(ReportKind::NotUnderstood, 1, place, message);
                    None
                }
            },
        };
        self.known.insert(path.to_owned(), found.clone());
        found
    }
}

/// The path behind options such as `-s 1 1 1`: of these the last word, for nothing says where they end.
fn path_of(texture: &str) -> &str {
    if texture.starts_with('-') {
        texture.split_whitespace().next_back().unwrap_or_default()
    } else {
        texture
    }
}

/// A texture with the alpha of another picture: its own alpha if it has any, else its red. A picture of
/// another size is taken at the nearest texel.
fn masked(seen: Option<&Texture>, mask: &Texture) -> Texture {
    let alphas = mask.rgba().iter().skip(3).step_by(4);
    let channel = if alphas.min().is_some_and(|&alpha| alpha < 255) {
        3
    } else {
        0
    };
    let size = seen.unwrap_or(mask);
    let (width, height) = (size.width(), size.height());
    let mut rgba = match seen {
        Some(seen) => seen.rgba().to_vec(),
        None => vec![255; mask.rgba().len()],
    };
    let across = |at: usize, own: u32, other: u32| at * other as usize / own as usize;
    for (place, texel) in rgba.chunks_exact_mut(4).enumerate() {
        let (x, y) = (place % width as usize, place / width as usize);
        let x = across(x, width, mask.width());
        let y = across(y, height, mask.height());
        texel[3] = mask.rgba()[4 * (y * mask.width() as usize + x) + channel];
    }
    Texture::new(width, height, rgba).expect("as many texels as it had")
}
