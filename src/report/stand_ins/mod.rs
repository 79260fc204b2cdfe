//! What stands in for leaves, judged: tables, curves, and a sheet of pictures.
//!
//! ```text
//! run::stand_ins ─▶ StandInFound, … ─add─▶ StandInMeter ─finish─▶ StandInReport ─┬─ stand-ins.json, .csv
//!                   (leaves first)                                               ├─ plots/*.svg
//!                                                                                ├─ pictures/*.png
//!                                                                                └─ report.html
//! ```
//!
//! **Invariant.** Leaves held against themselves have FLIP 0 and SSIM 1, exactly. Bytes of different
//! streams are never added; modelled times are.

mod plots;
mod sheet;
mod switches;
mod table;
mod textures;

pub use plots::{Crossover, crossover, stand_in_plots};
pub use switches::{StepChange, SwitchQuality, switch_table};
pub use table::{stand_in_cost_table, stand_in_notes, stand_in_table, stand_in_text};
pub use textures::{EqualDirect, TextureQuality, TextureReport, equal_direct, texture_table};

use std::collections::BTreeMap;

use serde::Serialize;

use self::sheet::Strip;
use self::textures::TextureMeter;
use super::run::json;
use super::{
    Comparison, OutputFolder, Page, PageImage, PictureView, QualitySummary, ReportError, Section,
    Spread, ViewQuality, grouped,
};
use crate::gpu::{Card, Ledger, Link, nanoseconds};
use crate::math::Vec3;
use crate::run::{
    CURVE_VIEWS, ClusterLook, Leaves, StandIn, StandInCost, StandInFound, StandInLook, SwitchLook,
    TextureFound, ViewScale, directions,
};

/// The value of `schema` in `stand-ins.json`.
pub const STAND_IN_SCHEMA: &str = "spinney.stand-ins/1";

/// What was looked at, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct StandInHeader {
    /// The scene's name.
    pub scene: String,
    /// The plant's name.
    pub plant: String,
    /// The link by which upload times are modelled.
    pub link: Link,
    /// The card by which GPU times are modelled.
    pub card: Card,
    /// The rows of the screen of which pictures are cut.
    pub height: u32,
    /// The angle that these rows span, in degrees.
    pub field_of_view: f32,
    /// The scales, in the order of looks.
    pub scales: Vec<ViewScale>,
}

/// Everything that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct StandInReport {
    /// What was looked at.
    pub header: StandInHeader,
    /// How things look: stand-in by stand-in, of each scale by scale.
    pub looks: Vec<StandInQuality>,
    /// What they take.
    pub costs: Vec<StandInCost>,
    /// The leaves of single clusters.
    pub clusters: Vec<ClusterLook>,
    /// What switches of levels do.
    pub switches: Vec<SwitchQuality>,
    /// What textures of impostors take.
    pub textures: TextureReport,
    /// A strip of pictures of each stand-in for the plant's own leaves.
    strips: Vec<Strip>,
}

/// How a stand-in looks at one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct StandInQuality {
    /// What.
    pub stand_in: StandIn,
    /// Which scale of the header's.
    pub scale: usize,
    /// Against its [reference](StandIn::reference), over all directions.
    pub views: QualitySummary,
    /// The pictures' sides, in pixels.
    pub side: u32,
    /// What the frames took, all together.
    pub frames: Ledger,
}

/// Takes looks one after another and holds each against what it stands for.
#[derive(Debug)]
pub struct StandInMeter {
    report: StandInReport,
    /// By scale: the plant's leaves, and the flattened ones that came last.
    references: BTreeMap<(usize, Leaves), (StandIn, Vec<PictureView>)>,
    textures: TextureMeter,
}

impl StandInMeter {
    /// With nothing found yet.
    #[must_use]
    pub fn new(header: StandInHeader) -> Self {
        Self {
            report: StandInReport {
                header,
                looks: Vec::new(),
                costs: Vec::new(),
                clusters: Vec::new(),
                switches: Vec::new(),
                textures: TextureReport::default(),
                strips: Vec::new(),
            },
            references: BTreeMap::new(),
            textures: TextureMeter::default(),
        }
    }

    /// Takes what was found; what a stand-in is held against comes before it.
    ///
    /// # Errors
    ///
    /// When a picture is larger than a picture may be, or not of its reference's size.
    pub fn add(&mut self, found: StandInFound) -> Result<(), ReportError> {
        match found {
            StandInFound::Cost(cost) => self.report.costs.push(cost),
            StandInFound::Cluster(cluster) => self.report.clusters.push(cluster),
            StandInFound::Look(look) => self.look(look)?,
        }
        Ok(())
    }

    /// Takes the pictures around a switch of levels.
    ///
    /// # Errors
    ///
    /// When a picture is larger than a picture may be, or they are of different sizes.
    pub fn add_switch(&mut self, look: SwitchLook) -> Result<(), ReportError> {
        switches::add(&mut self.report.switches, look)
    }

    /// Takes what was found of textures.
    ///
    /// # Errors
    ///
    /// When a picture is larger than a picture may be, or not of its reference's size.
    pub fn add_textures(&mut self, found: TextureFound) -> Result<(), ReportError> {
        self.textures.add(found)
    }

    /// What was found.
    #[must_use]
    pub fn finish(self) -> StandInReport {
        StandInReport {
            textures: self.textures.report,
            ..self.report
        }
    }

    fn look(&mut self, look: StandInLook) -> Result<(), ReportError> {
        let StandInLook {
            stand_in,
            scale,
            shots,
            frames,
        } = look;
        let views = PictureView::all(shots)?;
        let wanted = stand_in.reference();
        let key = (scale, wanted.leaves);
        let itself = (stand_in, Vec::new());
        let known = self.references.get(&key).unwrap_or(&itself);
        // Leaves are their own reference.
        let against = if stand_in == wanted { &views } else { &known.1 };
        let found = ViewQuality::all(against, &views)?;
        self.report.looks.push(StandInQuality {
            stand_in,
            scale,
            views: QualitySummary::of(&found),
            side: views.first().map_or(0, |view| view.picture.width()),
            frames,
        });
        if stand_in.reference() == StandIn::LEAVES {
            self.picture(stand_in, &views)?;
        }
        if stand_in.kind == StandIn::LEAVES.kind {
            self.references
                .insert((scale, stand_in.leaves), (stand_in, views));
        }
        Ok(())
    }

    /// Adds the picture from the front to the stand-in's strip.
    fn picture(&mut self, stand_in: StandIn, views: &[PictureView]) -> Result<(), ReportError> {
        let front = directions()
            .iter()
            .position(|&direction| direction == Vec3::Z);
        let Some(view) = front.and_then(|front| views.get(front)) else {
            return Ok(());
        };
        let strips = &mut self.report.strips;
        if strips.last().is_none_or(|strip| strip.stand_in != stand_in) {
            strips.push(Strip::of(stand_in));
        }
        match strips.last_mut() {
            Some(strip) => strip.add(&view.picture),
            None => Ok(()),
        }
    }
}

/// Modelled time of one of so many frames, in nanoseconds: uploads, fetches, then the card.
pub(super) fn frame_ns(frames: &Ledger, count: u64) -> Option<u64> {
    Some(nanoseconds(frames.frame_ticks()?) / count.max(1))
}

/// A look's entry in `stand-ins.json`; fields in the order of the file.
#[derive(Debug, Serialize)]
struct LookEntry {
    stand_in: String,
    against: String,
    scale: &'static str,
    side: u32,
    flip: SpreadEntry,
    ssim: SpreadEntry,
    silhouette: SpreadEntry,
    covered: SpreadEntry,
    fragments: Option<u64>,
    texels: Option<u64>,
    frame_ns: Option<u64>,
}

#[derive(Debug, Serialize)]
struct SpreadEntry {
    mean: f64,
    worst: f64,
}

#[derive(Debug, Serialize)]
struct CostEntry {
    stand_in: String,
    triangles: u64,
    upload_bytes: u64,
    resident_bytes: u64,
    curve: Vec<PointEntry>,
}

#[derive(Debug, Serialize)]
struct PointEntry {
    radius: f32,
    fetch_bytes: u64,
    fragments: Option<u64>,
    frame_ns: Option<u64>,
}

/// Everything as JSON. Numbers of fragments, texels and nanoseconds are means of a frame.
#[must_use]
pub fn stand_in_json(report: &StandInReport) -> String {
    let spread = |Spread { mean, worst }| SpreadEntry { mean, worst };
    let header = &report.header;
    let look = |look: &StandInQuality| {
        let views = directions().len() as u64;
        let work = look.frames.work;
        LookEntry {
            stand_in: look.stand_in.label(),
            against: look.stand_in.reference().label(),
            scale: header.scales.get(look.scale).map_or("", |scale| scale.name),
            side: look.side,
            flip: spread(look.views.flip),
            ssim: spread(look.views.ssim),
            silhouette: spread(look.views.silhouette),
            covered: spread(look.views.covered),
            fragments: work.map(|work| work.covered / views),
            texels: work.map(|work| work.texels / views),
            frame_ns: frame_ns(&look.frames, views),
        }
    };
    let cost = |cost: &StandInCost| CostEntry {
        stand_in: cost.stand_in.label(),
        triangles: cost.triangles,
        upload_bytes: cost.initial.upload.payload_bytes,
        resident_bytes: cost.resident_bytes,
        curve: cost
            .curve
            .iter()
            .map(|point| PointEntry {
                radius: point.radius,
                fetch_bytes: point.frames.fetch.payload_bytes / CURVE_VIEWS,
                fragments: point.frames.work.map(|work| work.covered / CURVE_VIEWS),
                frame_ns: frame_ns(&point.frames, CURVE_VIEWS),
            })
            .collect(),
    };
    let cluster = |cluster: &ClusterLook| {
        serde_json::json!({
            "planes": cluster.planes,
            "cluster": cluster.cluster,
            "leaves": cluster.leaves,
        })
    };
    let scales: Vec<_> = header
        .scales
        .iter()
        .map(|scale| serde_json::json!({ "name": scale.name, "before_m": scale.before }))
        .collect();
    json(&serde_json::json!({
        "schema": STAND_IN_SCHEMA,
        "scene": header.scene,
        "plant": header.plant,
        "link": header.link.name(),
        "card": header.card.name(),
        "height": header.height,
        "field_of_view": header.field_of_view,
        "scales": scales,
        "clusters": report.clusters.iter().map(cluster).collect::<Vec<_>>(),
        "looks": report.looks.iter().map(look).collect::<Vec<_>>(),
        "costs": report.costs.iter().map(cost).collect::<Vec<_>>(),
        "switches": switches::switch_json(&report.switches, &header.scales),
        "textures": textures::texture_json(&report.textures, &header.scales),
    }))
}

/// Writes everything into a folder.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_stand_ins(folder: &OutputFolder, report: &StandInReport) -> Result<(), ReportError> {
    folder.write("stand-ins.json", stand_in_json(report).as_bytes())?;
    let table = stand_in_table(report);
    folder.write("looks.csv", table.to_csv().as_bytes())?;
    folder.write("costs.csv", stand_in_cost_table(report).to_csv().as_bytes())?;
    let scales = &report.header.scales;
    for (name, table) in [
        ("switches.csv", switch_table(&report.switches, scales)),
        ("textures.csv", texture_table(&report.textures, scales)),
    ] {
        if !table.rows.is_empty() {
            folder.write(name, table.to_csv().as_bytes())?;
        }
    }
    for (name, plot) in stand_in_plots(report) {
        folder.write(&format!("plots/{name}.svg"), plot.to_svg().as_bytes())?;
    }
    let (mut strips, mut clusters) = (Vec::new(), Vec::new());
    for strip in &report.strips {
        let png = strip.picture()?.to_small_png()?;
        let label = strip.stand_in.label();
        folder.write(&format!("pictures/{label}.png"), &png)?;
        strips.push(PageImage {
            caption: label,
            png,
        });
    }
    if let Some(sheet) = sheet::stacked(&report.strips)? {
        folder.write("sheet.png", &sheet.to_small_png()?)?;
    }
    for cluster in &report.clusters {
        let view = PictureView::of(cluster.shot.clone())?;
        let png = view.picture.to_small_png()?;
        let (number, planes) = (cluster.cluster, cluster.planes);
        folder.write(&format!("pictures/cluster-{number}-of-{planes}.png"), &png)?;
        let leaves = grouped(u64::from(cluster.leaves), ",");
        let caption = format!("cluster {number} of {planes}: {leaves} leaves");
        clusters.insert(0, PageImage { caption, png });
    }
    let page = stand_in_page(report, strips, clusters).to_html()?;
    folder.write("report.html", page.as_bytes())
}

/// The page; of pictures as many as a page may have.
fn stand_in_page(
    report: &StandInReport,
    mut strips: Vec<PageImage>,
    mut clusters: Vec<PageImage>,
) -> Page {
    clusters.truncate(Page::MAX_IMAGES);
    strips.truncate(Page::MAX_IMAGES - clusters.len());
    let strips = Comparison::of_ways("shown as", strips);
    let mut sections = vec![
        Section::Comparison(strips),
        Section::Table {
            caption: "How they look".to_owned(),
            table: table::looks_for_people(report),
        },
        Section::Table {
            caption: "What they take".to_owned(),
            table: stand_in_cost_table(report),
        },
    ];
    sections.extend(stand_in_notes(report).into_iter().map(Section::Text));
    let scales = &report.header.scales;
    if !report.switches.is_empty() {
        sections.push(Section::Table {
            caption: "Switches of levels".to_owned(),
            table: switch_table(&report.switches, scales),
        });
        sections.push(Section::Text(switches::CAPTION.to_owned()));
    }
    if !report.textures.settings.is_empty() {
        sections.push(Section::Table {
            caption: "Textures of impostors".to_owned(),
            table: texture_table(&report.textures, scales),
        });
        sections.push(Section::Text(textures::CAPTION.to_owned()));
    }
    sections.extend(textures::refused(&report.textures).map(Section::Text));
    let plots = stand_in_plots(report).into_iter();
    sections.extend(plots.map(|(_, plot)| Section::Figure(plot.to_svg())));
    if !clusters.is_empty() {
        sections.push(Section::Large(clusters));
    }
    Page {
        title: format!("{}: what stands in for leaves", report.header.scene),
        sections,
    }
}
