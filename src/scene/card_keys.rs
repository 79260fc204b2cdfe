//! The table `cards` of a scene file: read, written, and in the scene's digest.

use crate::math::Digester;

use super::parse::small;
use super::reader::Reader;
use super::write::{Text, quoted};
use super::{
    CardCounts, CardDepth, CardMode, CardOptions, CardOutline, CardSides, DetailRange, FarCards,
    Mode, ModelChoice, ModelName, SceneError, SpriteScale, Transparency,
};

pub(super) fn read(table: &Reader<'_>, model: &ModelChoice) -> Result<CardOptions, SceneError> {
    /// The table of keys holds the same names as the type.
    const NAMED: &str = "the table of keys allows these names only";
    let name = |key| table.have::<String>(key);
    let count = table.get("count")?.map(small);
    let levels: Option<Vec<u64>> = table.get("levels")?;
    let levels = match (levels, count) {
        (None, count) => {
            let most = count.unwrap_or(CardOptions::USUAL.levels.as_slice()[0]);
            CardCounts::halved_from(most)
        }
        (Some(levels), count) => {
            let levels: Vec<u32> = levels.into_iter().map(small).collect();
            if let Some(count) = count.filter(|count| levels.first() != Some(count)) {
                let wanted = format!("levels that begin with `count`, which is {count}");
                return Err(table.refuse("levels", &wanted));
            }
            CardCounts::new(&levels)
        }
    };
    let cards = CardOptions {
        levels: levels.expect("the table of keys allows descending numbers only"),
        texture: small(table.have("texture")?),
        orientation_weight: table.have("orientation_weight")?,
        plane_seeds: small(table.have("plane_seeds")?),
        depth: CardDepth::from_name(&name("depth")?).expect(NAMED),
        transparency: Transparency::from_name(&name("transparency")?).expect(NAMED),
        outline: CardOutline::from_name(&name("outline")?).expect(NAMED),
        sides: CardSides::from_name(&name("sides")?).expect(NAMED),
        map: small(table.have("map")?),
        layers: small(table.have("layers")?),
        sprites: small(table.have("sprites")?),
        sprite_texture: small(table.have("sprite_texture")?),
        scale: SpriteScale::from_name(&name("scale")?).expect(NAMED),
        far: far(table, model)?,
    };
    let (is_indirect, said) = match cards.far {
        None => (model.mode == Mode::Indirect, "model.mode"),
        Some(far) => (far.mode == CardMode::Indirect, "cards.mode"),
    };
    let pictures = [
        ("depth", cards.depth != CardDepth::Paper),
        ("transparency", cards.transparency != Transparency::Test),
        ("outline", cards.outline != CardOutline::Quad),
    ];
    for (key, chosen) in pictures {
        if chosen && is_indirect {
            let wanted = format!("its default, since `{said}` is indirect");
            return Err(table.refuse(key, &wanted));
        }
    }
    Ok(cards)
}

/// Where cards stand for the leaves of trees far away, if they do: of a model of leaves whose detail the host
/// selects.
fn far(table: &Reader<'_>, model: &ModelChoice) -> Result<Option<FarCards>, SceneError> {
    let (to, mode) = (table.get("to")?, table.get::<String>("mode")?);
    let Some(from) = table.get("from")? else {
        for key in ["to", "mode"] {
            if table.has(key) {
                return Err(table.refuse(key, "nothing, unless `from` is given"));
            }
        }
        return Ok(None);
    };
    let wanted = match model.name {
        ModelName::Lodf if model.mode == Mode::Device => Some(
            "nothing, since the device selects in `model.mode` \"device\": \"stamps\" sends least of the others",
        ),
        ModelName::Lodf | ModelName::Full | ModelName::Vdf => None,
        _ => Some("nothing, unless `model.name` is \"lodf\", \"vdf\" or \"full\""),
    };
    if let Some(wanted) = wanted {
        return Err(table.refuse("from", wanted));
    }
    let to = to.unwrap_or(4.0 * from);
    let Some(range) = DetailRange::new(from, to) else {
        return Err(table.refuse("to", &format!("more than `from`, which is {from}")));
    };
    Ok(Some(FarCards {
        mode: match mode {
            None => CardMode::Direct,
            Some(mode) => {
                CardMode::from_name(&mode).expect("the table of keys allows these names only")
            }
        },
        range,
    }))
}

pub(super) fn write(text: &mut Text, cards: &CardOptions) {
    text.heading("[cards]");
    let levels: Vec<String> = cards.levels.as_slice().iter().map(u32::to_string).collect();
    text.key("levels", &format!("[{}]", levels.join(", ")));
    text.key("texture", &cards.texture.to_string());
    text.key("orientation_weight", &cards.orientation_weight.to_string());
    text.key("plane_seeds", &cards.plane_seeds.to_string());
    text.key("depth", &quoted(cards.depth.name()));
    text.key("transparency", &quoted(cards.transparency.name()));
    text.key("outline", &quoted(cards.outline.name()));
    text.key("sides", &quoted(cards.sides.name()));
    text.key("map", &cards.map.to_string());
    text.key("layers", &cards.layers.to_string());
    text.key("sprites", &cards.sprites.to_string());
    text.key("sprite_texture", &cards.sprite_texture.to_string());
    text.key("scale", &quoted(cards.scale.name()));
    if let Some(far) = &cards.far {
        text.key("from", &far.range.d_min().to_string());
        text.key("to", &far.range.d_max().to_string());
        text.key("mode", &quoted(far.mode.name()));
    }
}

pub(super) fn digest(digester: &mut Digester, cards: &CardOptions) {
    let levels = cards.levels.as_slice();
    digester.u64(levels.len() as u64);
    for &count in levels {
        digester.u32(count);
    }
    digester
        .u32(cards.texture)
        .f32(cards.orientation_weight)
        .u32(cards.plane_seeds)
        .u32(cards.depth as u32)
        .u32(cards.transparency as u32)
        .u32(cards.outline as u32)
        .u32(cards.sides as u32)
        .u32(cards.map)
        .u32(cards.layers)
        .u32(cards.sprites)
        .u32(cards.sprite_texture)
        .u32(cards.scale as u32);
    if let Some(far) = &cards.far {
        digester
            .text("far")
            .u32(far.mode as u32)
            .f32(far.range.d_min())
            .f32(far.range.d_max());
    }
}
