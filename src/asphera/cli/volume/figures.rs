//! The figures of a volume as JSON writes them: `asphera.volume/1`.

use asphera_formats::volume::UnitKnown;
use asphera_measure::Part;
use asphera_report::FormFigures;
use asphera_volume::{
    GridCheck, Histogram, Samples, Topology, Verdict, needed_spacing_mm, with_missing,
};
use clap::ValueEnum as _;
use serde::Serialize;

use super::super::output::Failure;
use super::VolumeArgs;
use super::measures::{self, Cells, Measures};
use super::meshed::Meshed;
use super::nominal::{self, NominalFigures};
use super::opened::{Border, Opened};
use super::regular::{self, MeshReachFigures};

/// All figures of a volume. Lengths are mm of the file's frame.
#[derive(Debug, Serialize)]
pub(super) struct VolumeReport {
    format: &'static str,
    pub(super) file: String,
    pub(super) volume: VolumeFigures,
    pub(super) grid: GridFigures,
    pub(super) topology: TopologyFigures,
    pub(super) measures: Measures,
    pub(super) mesh: MeshFigures,
    /// The form of the face of `--nominal`, as in `asphera.report/1`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) form: Option<FormFigures>,
    /// What the figures must be read with.
    pub(super) reasons: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(super) struct VolumeFigures {
    pub(super) size: [usize; 3],
    pub(super) spacing_mm: [f64; 3],
    pub(super) threshold: f64,
    pub(super) threshold_source: &'static str,
    pub(super) foreground: u64,
    /// Samples without a value.
    pub(super) missing: u64,
    /// Cells with surface that have a corner on such a sample: the surface there is not that of the part.
    pub(super) missing_cells: u64,
    /// Whether material touches the border of the volume.
    pub(super) touches_border: bool,
    /// Whether background beyond the border closes the surface there, by `--pad`; otherwise it ends there.
    pub(super) padded: bool,
    /// Connected parts of the volume; the figures are of those that `--part` asks for.
    pub(super) parts: u64,
}

#[derive(Debug, Serialize)]
pub(super) struct GridFigures {
    pub(super) verdict: &'static str,
    pub(super) why: String,
    pub(super) regular_mm: Option<f64>,
    pub(super) needed_spacing_mm: Option<f64>,
    /// Needed over real spacing: the grid is fine enough where this is above 1.
    pub(super) margin: Option<f64>,
    pub(super) case8: u64,
    pub(super) case8_unpaired: u64,
    pub(super) forbidden: u64,
    pub(super) c1: u64,
    pub(super) c2: u64,
    /// Of the cells at fault those beside what was not scanned; they contradict nothing.
    pub(super) doubtful: u64,
    pub(super) places: Vec<PlaceFigures>,
    /// What the face of `--nominal` asks of the grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) nominal: Option<NominalFigures>,
    /// What the mesh of `--regular` proves of r.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<MeshReachFigures>,
    #[serde(skip)]
    known: Verdict,
    /// Whether r is stated, the spacing is below r / √3 and no cell contradicts that. Missing samples leave it true.
    #[serde(skip)]
    pub(super) is_regular: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct PlaceFigures {
    centre_mm: [f64; 3],
    code: u8,
}

#[derive(Debug, Serialize)]
pub(super) struct TopologyFigures {
    pub(super) euler_6: i64,
    pub(super) euler_26: i64,
    pub(super) components: u64,
    pub(super) cavities: u64,
    pub(super) tunnels: i64,
    pub(super) surfaces: Vec<PieceFigures>,
    /// The same counts with missing samples as material; where they differ, the topology is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) with_missing: Option<TopologyCounts>,
}

/// Euler numbers and Betti numbers.
#[derive(Debug, Serialize)]
pub(super) struct TopologyCounts {
    pub(super) euler_6: i64,
    pub(super) euler_26: i64,
    pub(super) components: u64,
    pub(super) cavities: u64,
    pub(super) tunnels: i64,
}

#[derive(Debug, Serialize)]
pub(super) struct PieceFigures {
    euler: i64,
    /// Absent of an open surface.
    genus: Option<i64>,
    /// Sides of one triangle only; 0 of a closed surface.
    border_sides: u64,
    area_mm2: f64,
    /// Below 0 for the wall of a cavity; absent of an open surface.
    volume_mm3: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct MeshFigures {
    pub(super) method: String,
    pub(super) vertices: u64,
    pub(super) triangles: u64,
    pub(super) euler: i64,
    pub(super) closed: bool,
    pub(super) oriented: bool,
    /// Connected borders at which it ends, beside missing samples or at the border of the volume, and their sides.
    pub(super) borders: u64,
    pub(super) border_sides: u64,
}

impl VolumeReport {
    /// Whether the grid, or what a nominal asks of it, is contradicted.
    pub(super) fn is_contradicted(&self) -> bool {
        let nominal = self.grid.nominal.as_ref().map(|nominal| nominal.known);
        self.grid.known == Verdict::Contradicted || nominal == Some(Verdict::Contradicted)
    }
}

/// Measures a volume and its surface.
pub(super) fn of(
    args: &VolumeArgs,
    opened: &Opened,
    meshed: &Meshed,
    given: Option<&Part>,
) -> Result<VolumeReport, Failure> {
    let Opened { samples, frame, .. } = opened;
    let surface = &meshed.figures;
    let histogram = Histogram::new(samples);
    let topology = Topology::new(samples, &histogram);
    let spacing_mm = frame.spacing_mm();
    let check = GridCheck::with_missing(samples, &histogram, opened.missing.as_ref());
    let (regular_mm, mesh) = regular::of(args)?;
    let nominal = given.map(|part| nominal::of(part, frame.steps_mm, &check)).transpose()?;
    let grid = grid(opened, &check, regular_mm, nominal, mesh);
    let pieces = &surface.pieces;
    let surfaces = pieces.iter().map(|piece| PieceFigures {
        euler: piece.euler,
        genus: piece.genus,
        border_sides: piece.border_sides,
        area_mm2: piece.area,
        volume_mm3: piece.volume,
    });
    let topology = TopologyFigures {
        euler_6: topology.euler_6,
        euler_26: topology.euler_26,
        components: topology.components,
        cavities: topology.cavities,
        tunnels: topology.tunnels,
        surfaces: surfaces.collect(),
        with_missing: opened
            .missing
            .as_ref()
            .map(|missing| counts(&with_missing(samples, missing))),
    };
    let cells = Cells {
        histogram: &histogram,
        euler: topology.euler_6,
        near_missing: check.near_missing,
        are_open: check.near_missing > 0 || opened.border == Border::Open,
    };
    let measures = measures::of(opened, cells, meshed, &grid);
    let report = VolumeReport {
        format: "asphera.volume/1",
        file: args.file.display().to_string(),
        volume: VolumeFigures {
            size: samples.size(),
            spacing_mm,
            threshold: opened.threshold,
            threshold_source: opened.threshold_source,
            foreground: samples.foreground(),
            missing: opened.levels.missing,
            missing_cells: check.near_missing,
            touches_border: opened.border != Border::Free,
            padded: opened.border == Border::Padded,
            parts: opened.parts,
        },
        form: None,
        reasons: reasons(opened, &topology, check.near_missing, measures.area_mm2.is_fine),
        grid,
        topology,
        measures,
        mesh: MeshFigures {
            method: args
                .method
                .to_possible_value()
                .map_or_else(String::new, |value| value.get_name().to_owned()),
            vertices: surface.vertices,
            triangles: surface.triangles,
            euler: surface.euler(),
            closed: surface.is_closed,
            oriented: surface.is_oriented,
            borders: surface.borders,
            border_sides: surface.border_sides,
        },
    };
    Ok(report)
}

/// The topology of samples in short.
fn counts(samples: &Samples) -> TopologyCounts {
    let found = Topology::new(samples, &Histogram::new(samples));
    TopologyCounts {
        euler_6: found.euler_6,
        euler_26: found.euler_26,
        components: found.components,
        cavities: found.cavities,
        tunnels: found.tunnels,
    }
}

/// The word of a verdict.
pub(super) fn word(known: Verdict) -> &'static str {
    match known {
        Verdict::Proved => "proved",
        Verdict::Contradicted => "contradicted",
        Verdict::Unknown => "unknown",
    }
}

fn grid(
    opened: &Opened,
    check: &GridCheck,
    regular_mm: Option<f64>,
    nominal: Option<NominalFigures>,
    mesh: Option<MeshReachFigures>,
) -> GridFigures {
    let spacing_mm = opened.frame.spacing_mm();
    let (mut known, mut why) = check.verdict_on_axes(opened.frame.steps_mm, regular_mm);
    if let (Some(mesh), None, Verdict::Unknown) = (&mesh, regular_mm, known) {
        why.clone_from(&mesh.why);
    }
    let is_regular = known == Verdict::Proved && opened.border == Border::Free;
    if known == Verdict::Proved {
        let doubt = if opened.levels.missing > 0 {
            Some("samples are missing: what lies there is not known")
        } else if opened.border != Border::Free {
            Some("the part touches the border of the volume: what lies beyond is not known")
        } else {
            None
        };
        if let Some(doubt) = doubt {
            (known, why) = (Verdict::Unknown, doubt.into());
        }
    }
    let needed = regular_mm.map(needed_spacing_mm);
    let coarsest = spacing_mm.iter().copied().fold(0.0, f64::max);
    let places = check.places.iter().map(|place| PlaceFigures {
        centre_mm: opened.frame.place_mm(place.centre),
        code: place.code,
    });
    GridFigures {
        verdict: word(known),
        why,
        regular_mm,
        needed_spacing_mm: needed,
        margin: needed.map(|needed| needed / coarsest),
        case8: check.case8,
        case8_unpaired: check.case8_unpaired,
        forbidden: check.forbidden,
        c1: check.c1,
        c2: check.c2,
        doubtful: check.doubtful,
        places: places.collect(),
        nominal,
        mesh,
        known,
        is_regular,
    }
}

fn reasons(
    opened: &Opened,
    topology: &TopologyFigures,
    missing_cells: u64,
    is_fine: bool,
) -> Vec<String> {
    let mut reasons = Vec::new();
    if is_fine {
        reasons.push(
            "detail is as fine as the blur that the area comes from: if it has edges, that may be a tenth too small"
                .into(),
        );
    }
    if opened.frame.unit == UnitKnown::Assumed {
        reasons.push(
            "the file states no unit of length: mm is assumed; --spacing overrides it".into(),
        );
    }
    match opened.border {
        Border::Free => {}
        Border::Open => reasons.push(
            "the material touches the border of the volume: the surface ends there, in the outermost samples; figures are of what was \
             scanned; --pad closes it"
                .into(),
        ),
        Border::Padded => reasons.push(
            "the material touches the border of the volume: background beyond closes the surface there, as --pad asks; its faces there \
             are none of the part"
                .into(),
        ),
    }
    if opened.levels.missing > 0 {
        let found = opened.levels.missing;
        reasons.push(match missing_cells {
            0 => format!(
                "{found} samples have no value: they count as background, and none lies beside the surface"
            ),
            cells => format!(
                "{found} samples have no value: {cells} cells that would have surface lie beside one, and the surface ends there; the \
                 topology counts such samples as background, and with_missing as material"
            ),
        });
    }
    if topology.euler_6 != topology.euler_26 {
        reasons.push(
            "the Euler numbers 6 and 26 differ: the grid does not determine the topology".into(),
        );
    }
    if opened.is_chosen {
        reasons.push(format!("one of {} parts was chosen", opened.parts));
    }
    reasons
}
