//! Species as text, with every default filled in.

use super::{Blade, FoliageKind, SPECIES_SCHEMA, Shape, Species, StemLevel};
use std::fmt::{Debug, Write as _};

impl Species {
    /// The species as a file in which nothing is left to a default. Reading it back gives an equal species.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = Text(String::new());
        text.key("schema", &quoted(SPECIES_SCHEMA));
        text.key("name", &quoted(&self.name));
        text.key("latin", &quoted(&self.latin));
        for (key, count) in [
            ("leaf_count", self.leaf_count),
            ("stop_leaves", self.stop_leaves),
            ("trunk_polygons", self.trunk_polygons),
        ] {
            if let Some(count) = count {
                text.key(key, &count.to_string());
            }
        }
        self.write_crown(&mut text);
        text.heading("[clump]");
        text.key("count", &self.clump.count.to_string());
        text.key("radius", &number(self.clump.radius));
        text.key("lean", &number(self.clump.lean));
        self.write_wood(&mut text);
        write_stems(&self.stems, &mut text);
        text.heading("[leaves]");
        text.key("per_stem", &number(self.leaves.per_stem));
        text.key("bend", &number(self.leaves.bend));
        text.key("attraction_up", &number(self.leaves.attraction_up));
        text.key("bare", &number(self.leaves.bare));
        text.key("omit", &format!("{:?}", self.omitted_leaves));
        for kind in &self.foliage {
            write_foliage(kind, &mut text);
        }
        text.0
    }

    fn write_crown(&self, text: &mut Text) {
        let crown = &self.crown;
        text.heading("[crown]");
        text.key("shape", &quoted(crown.shape.name()));
        text.key("levels", &crown.levels.to_string());
        for (key, value) in [
            ("base_size", crown.base_size),
            ("scale", crown.scale),
            ("scale_v", crown.scale_v),
            ("vertical_scale", crown.vertical_scale),
            ("vertical_scale_v", crown.vertical_scale_v),
            ("prune_ratio", crown.pruning.ratio),
            ("prune_width", crown.pruning.width),
            ("prune_width_peak", crown.pruning.width_peak),
            ("prune_power_low", crown.pruning.power_low),
            ("prune_power_high", crown.pruning.power_high),
        ] {
            text.key(key, &number(value));
        }
        text.key("attraction_up", &list(&crown.attraction_up));
    }

    fn write_wood(&self, text: &mut Text) {
        let wood = &self.wood;
        text.heading("[wood]");
        for (key, value) in [
            ("ratio", wood.ratio),
            ("ratio_power", wood.ratio_power),
            ("lobe_depth", wood.lobe_depth),
            ("flare", wood.flare),
            ("trunk_scale", wood.trunk_scale),
            ("trunk_scale_v", wood.trunk_scale_v),
        ] {
            text.key(key, &number(value));
        }
        text.key("lobes", &wood.lobes.to_string());
        text.key("base_splits", &wood.base_splits.to_string());
        text.key("bark_color", &color(wood.bark_color));
        text.key("tube_edges", &list(&wood.tube_edges));
    }
}

impl Shape {
    /// All of them, in the paper's order: `Shape` 0 to 8.
    pub const ALL: [Self; 9] = [
        Self::Conical,
        Self::Spherical,
        Self::Hemispherical,
        Self::Cylindrical,
        Self::TaperedCylindrical,
        Self::Flame,
        Self::InverseConical,
        Self::TendFlame,
        Self::Envelope,
    ];

    /// The name in species files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Conical => "conical",
            Self::Spherical => "spherical",
            Self::Hemispherical => "hemispherical",
            Self::Cylindrical => "cylindrical",
            Self::TaperedCylindrical => "tapered_cylindrical",
            Self::Flame => "flame",
            Self::InverseConical => "inverse_conical",
            Self::TendFlame => "tend_flame",
            Self::Envelope => "envelope",
        }
    }
}

/// A value of each level of stems.
type OfLevel = fn(&StemLevel) -> f32;

fn write_stems(stems: &[StemLevel; 4], text: &mut Text) {
    text.heading("[stems]");
    let keys: [(&str, OfLevel); 14] = [
        ("length", |stem| stem.length),
        ("length_v", |stem| stem.length_v),
        ("taper", |stem| stem.taper),
        ("segment_splits", |stem| stem.segment_splits),
        ("split_angle", |stem| stem.split_angle),
        ("split_angle_v", |stem| stem.split_angle_v),
        ("curve", |stem| stem.curve),
        ("curve_back", |stem| stem.curve_back),
        ("curve_v", |stem| stem.curve_v),
        ("down_angle", |stem| stem.down_angle),
        ("down_angle_v", |stem| stem.down_angle_v),
        ("rotate", |stem| stem.rotate),
        ("rotate_v", |stem| stem.rotate_v),
        ("branches", |stem| stem.branches),
    ];
    for (key, value) in keys {
        text.key(key, &list(&stems.each_ref().map(value)));
    }
    text.key(
        "curve_res",
        &list(&stems.each_ref().map(|stem| stem.curve_res)),
    );
}

fn write_foliage(kind: &FoliageKind, text: &mut Text) {
    text.heading("[[foliage]]");
    text.key("silhouette", &quoted(kind.silhouette.name()));
    text.key("share", &number(kind.share));
    text.key("length", &number(kind.length));
    text.key("length_v", &number(kind.length_v));
    text.key("width", &number(kind.width));
    text.key("color", &color(kind.color));
    match kind.blade {
        Blade::Flat => text.key("faces", "2"),
        Blade::Bent { faces, droop, fold } => {
            text.key("faces", &faces.to_string());
            text.key("droop", &number(droop));
            text.key("fold", &number(fold));
        }
        Blade::Needle { diameter } => text.key("needle_diameter", &number(diameter)),
    }
}

/// TOML under construction.
struct Text(String);

impl Text {
    fn heading(&mut self, heading: &str) {
        writeln!(self.0, "\n{heading}").expect("a string takes all");
    }

    fn key(&mut self, key: &str, value: &str) {
        writeln!(self.0, "{key} = {value}").expect("a string takes all");
    }
}

/// The shortest digits that are read as the same number, always with a point or an exponent.
fn number(value: f32) -> String {
    format!("{value:?}")
}

fn list<T: Debug>(values: &[T; 4]) -> String {
    format!("{values:?}")
}

fn color([red, green, blue]: [u8; 3]) -> String {
    format!("\"#{red:02x}{green:02x}{blue:02x}\"")
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
