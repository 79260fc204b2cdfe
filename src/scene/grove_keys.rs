//! The table `grove` of a scene file: read, written, and in the scene's digest.

use crate::math::Digester;

use super::parse::small;
use super::reader::Reader;
use super::write::{Text, quoted};
use super::{
    Forest, GroveBlend, GroveChoice, GroveOrder, GrovePacking, ModelChoice, SceneError, TrunkName,
};

/// What the table says, where there is one: of a scene whose forests stand in patches and whose wood is drawn
/// as branches.
pub(super) fn read(
    root: &Reader<'_>,
    model: &ModelChoice,
    forests: &[Forest],
) -> Result<Option<GroveChoice>, SceneError> {
    /// The table of keys holds the same names as the type.
    const NAMED: &str = "the table of keys allows these names only";
    let Some(table) = root.table("grove")? else {
        return Ok(None);
    };
    if model.trunk != TrunkName::Branches {
        let wanted = "nothing, unless `model.trunk` is \"branches\"";
        return Err(root.refuse("grove", wanted));
    }
    if !forests.iter().any(Forest::is_of_patches) {
        let wanted = "nothing, unless the `layout` of a [[forest]] is \"patches\"";
        return Err(root.refuse("grove", wanted));
    }
    let name = |key| table.have::<String>(key);
    let blend = GroveBlend::from_name(&name("blend")?).expect(NAMED);
    let layers = table.get::<u64>("layers")?;
    if layers.is_some() && blend != GroveBlend::Peeled {
        return Err(table.refuse("layers", "nothing, unless `blend` is \"peeled\""));
    }
    Ok(Some(GroveChoice {
        levels: small(table.have("levels")?),
        packing: GrovePacking::from_name(&name("packing")?).expect(NAMED),
        levels_a_pass: small(table.have("levels_a_pass")?),
        order: GroveOrder::from_name(&name("order")?).expect(NAMED),
        blend,
        layers: layers.map_or(GroveChoice::LAYERS, small),
    }))
}

pub(super) fn write(text: &mut Text, grove: GroveChoice) {
    text.heading("[grove]");
    text.key("levels", &grove.levels.to_string());
    text.key("packing", &quoted(grove.packing.name()));
    text.key("levels_a_pass", &grove.levels_a_pass.to_string());
    text.key("order", &quoted(grove.order.name()));
    text.key("blend", &quoted(grove.blend.name()));
    if grove.blend == GroveBlend::Peeled {
        text.key("layers", &grove.layers.to_string());
    }
}

pub(super) fn digest(digester: &mut Digester, grove: GroveChoice) {
    digester
        .u32(grove.levels)
        .u32(grove.packing as u32)
        .u32(grove.levels_a_pass)
        .u32(grove.order as u32)
        .u32(grove.blend as u32);
    if grove.blend == GroveBlend::Peeled {
        digester.u32(grove.layers);
    }
}
