//! What surfaces look like: base colour, its texture, and the alpha cutoff.

use super::accessor::Reader;
use super::error::Fault;
use crate::limits::PLANT_TEXELS;
use crate::plant::import::mesh::{self, decode_png};
use crate::plant::import::{ImportReport, ReportKind};
use crate::plant::{Material, Texture};
use gltf_json::material::{AlphaCutoff, AlphaMode};
use gltf_json::texture::{Info, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use std::collections::BTreeMap;

/// The materials of a document; each image is decoded once.
#[derive(Debug)]
pub(super) struct Materials<'r, 'a> {
    root: &'a Root,
    reader: &'r Reader<'a>,
    images: BTreeMap<usize, Option<Texture>>,
    texels: u64,
}

impl<'r, 'a> Materials<'r, 'a> {
    pub(super) fn new(root: &'a Root, reader: &'r Reader<'a>) -> Self {
        Self {
            root,
            reader,
            images: BTreeMap::new(),
            texels: 0,
        }
    }

    /// The material at an index that was checked, or glTF's default one.
    pub(super) fn material(
        &mut self,
        index: Option<usize>,
        report: &mut ImportReport,
    ) -> Result<Material, Fault> {
        let Some(index) = index else {
            return Ok(Material::plain("default", [1.0; 3]));
        };
        let material = &self.root.materials[index];
        let pointer = format!("/materials/{index}");
        let base_color = material.pbr_metallic_roughness.base_color_factor.0;
        for (place, channel) in base_color.iter().enumerate() {
            not_negative(
                *channel,
                &format!("{pointer}/pbrMetallicRoughness/baseColorFactor/{place}"),
            )?;
        }
        let alpha_cutoff = match alpha_mode(self.root, index)? {
            AlphaMode::Opaque => 0.0,
            AlphaMode::Mask => material.alpha_cutoff.unwrap_or_default().0,
            AlphaMode::Blend => {
                let message = "blended materials: cut off at half alpha";
                report.add(
                    ReportKind::Guessed,
                    1,
                    format!("{pointer}/alphaMode"),
                    message,
                );
                AlphaCutoff::default().0
            }
        };
        not_negative(alpha_cutoff, &format!("{pointer}/alphaCutoff"))?;
        let unused = [
            material.normal_texture.is_some(),
            material.occlusion_texture.is_some(),
            material.emissive_texture.is_some(),
            material
                .pbr_metallic_roughness
                .metallic_roughness_texture
                .is_some(),
        ];
        let unused = unused.iter().filter(|&&has| has).count() as u64;
        let message = "textures other than the base colour's";
        report.add(ReportKind::Ignored, unused, &pointer, message);
        let texture = match &material.pbr_metallic_roughness.base_color_texture {
            None => None,
            Some(info) => self.texture(info, &pointer, report)?,
        };
        Ok(Material {
            name: material
                .name
                .clone()
                .unwrap_or_else(|| format!("material {index}")),
            base_color,
            texture,
            alpha_cutoff,
        })
    }

    fn texture(
        &mut self,
        info: &Info,
        material: &str,
        report: &mut ImportReport,
    ) -> Result<Option<Texture>, Fault> {
        let pointer = format!("{material}/pbrMetallicRoughness/baseColorTexture/index");
        let index = info.index.value();
        let Some(texture) = self.root.textures.get(index) else {
            return Err(Fault::index(
                pointer,
                "texture",
                index,
                self.root.textures.len(),
            ));
        };
        let pointer = format!("/textures/{index}");
        self.note_wrapping(
            texture.sampler.map(|sampler| sampler.value()),
            &pointer,
            report,
        )?;
        let image = texture.source.value();
        // What the parser puts where there is no source: extensions may have one instead.
        if image == u32::MAX as usize {
            let message = "textures without a PNG source: the material stays without texture";
            report.add(ReportKind::NotUnderstood, 1, pointer, message);
            return Ok(None);
        }
        if image >= self.root.images.len() {
            let pointer = format!("{pointer}/source");
            return Err(Fault::index(
                pointer,
                "image",
                image,
                self.root.images.len(),
            ));
        }
        if let Some(known) = self.images.get(&image) {
            return Ok(known.clone());
        }
        let found = self.image(image, report)?;
        self.images.insert(image, found.clone());
        Ok(found)
    }

    fn note_wrapping(
        &self,
        sampler: Option<usize>,
        texture: &str,
        report: &mut ImportReport,
    ) -> Result<(), Fault> {
        let Some(index) = sampler else {
            return Ok(());
        };
        let Some(sampler) = self.root.samplers.get(index) else {
            let pointer = format!("{texture}/sampler");
            return Err(Fault::index(
                pointer,
                "sampler",
                index,
                self.root.samplers.len(),
            ));
        };
        let repeat = Checked::Valid(WrappingMode::Repeat);
        let other = sampler.wrap_s != repeat || sampler.wrap_t != repeat;
        let message = "textures that clamp or mirror at their edges: they repeat here";
        report.add(
            ReportKind::Ignored,
            u64::from(other),
            format!("/samplers/{index}"),
            message,
        );
        Ok(())
    }

    /// An image, or nothing and an entry in the report.
    fn image(&mut self, index: usize, report: &mut ImportReport) -> Result<Option<Texture>, Fault> {
        let image = &self.root.images[index];
        let pointer = format!("/images/{index}");
        let label = image
            .name
            .as_deref()
            .or(image.uri.as_deref().filter(|uri| uri.len() < 99));
        let label = label.map_or_else(
            || format!("image {index}"),
            |name| format!("image {name:?}"),
        );
        let fetched;
        let bytes = match (
            &image.uri,
            image.buffer_view.map(|view: Index<_>| view.value()),
        ) {
            (_, Some(view)) => {
                self.reader
                    .buffers()
                    .view(view, &format!("{pointer}/bufferView"))?
                    .0
            }
            (Some(uri), None) => {
                match self.reader.buffers().fetch(uri, &format!("{pointer}/uri")) {
                    Ok(bytes) => {
                        fetched = bytes;
                        &fetched
                    }
                    Err(fault) => {
                        let message = format!(
                            "{label}: {}; the material stays without texture",
                            fault.message
                        );
                        report.add(ReportKind::Missing, 1, fault.pointer, message);
                        return Ok(None);
                    }
                }
            }
            (None, None) => {
                let message = format!("{label}: neither uri nor bufferView; without texture");
                report.add(ReportKind::Missing, 1, pointer, message);
                return Ok(None);
            }
        };
        match decode_png(bytes, PLANT_TEXELS - self.texels) {
            Ok(texture) => {
                self.texels += u64::from(texture.width()) * u64::from(texture.height());
                Ok(Some(texture))
            }
            Err(message) => {
                let message = format!("{label}: {message}; the material stays without texture");
                report.add(ReportKind::NotUnderstood, 1, pointer, message);
                Ok(None)
            }
        }
    }
}

impl mesh::Materials for Materials<'_, '_> {
    type Fault = Fault;

    fn read(&mut self, index: Option<usize>, report: &mut ImportReport) -> Result<Material, Fault> {
        self.material(index, report)
    }

    fn title(&self, index: usize) -> String {
        index.to_string()
    }

    fn name_and_place(&self, index: usize) -> (String, String) {
        let name = self.root.materials[index].name.clone().unwrap_or_default();
        (name, format!("/materials/{index}"))
    }
}

/// How a material treats alpha.
pub(super) fn alpha_mode(root: &Root, material: usize) -> Result<AlphaMode, Fault> {
    match root.materials[material].alpha_mode {
        Checked::Valid(mode) => Ok(mode),
        Checked::Invalid => Err(Fault::new(
            format!("/materials/{material}/alphaMode"),
            "wanted OPAQUE, MASK or BLEND",
        )),
    }
}

fn not_negative(value: f32, pointer: &str) -> Result<(), Fault> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    let message = format!("is {value}, wanted a finite number of at least 0");
    Err(Fault::new(pointer, message))
}
