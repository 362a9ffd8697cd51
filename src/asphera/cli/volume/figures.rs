//! The figures of a volume as JSON writes them: `asphera.volume/1`.

use asphera_formats::volume::UnitKnown;
use asphera_measure::Part;
use asphera_report::FormFigures;
use asphera_volume::{
    Ambiguity, BALL_RADIUS, GridCheck, Histogram, Majority, SurfaceFigures, Topology, Verdict,
    VolumeBounds, area_bounds, ball_fractions, blurred_area, counting_uncertainty, difference_area,
    majority_fractions, marching_fractions, needed_spacing_mm, semi_local_area,
    trilinear_fractions, tube_counts, voxel_fractions,
};
use clap::ValueEnum as _;
use serde::Serialize;

use super::super::output::Failure;
use super::VolumeArgs;
use super::nominal::{self, NominalFigures};
use super::opened::Opened;

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
    #[serde(skip)]
    known: Verdict,
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
}

#[derive(Debug, Serialize)]
pub(super) struct PieceFigures {
    euler: i64,
    genus: i64,
    area_mm2: f64,
    /// Below 0 for the wall of a cavity.
    volume_mm3: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Measures {
    pub(super) volume_mm3: VolumeMeasure,
    pub(super) area_mm2: AreaMeasure,
}

#[derive(Debug, Serialize)]
pub(super) struct VolumeMeasure {
    /// Foreground samples times the volume of a voxel.
    pub(super) value: f64,
    /// Certain bounds, where r is stated and nothing contradicts the grid.
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
    /// Standard uncertainty from the place of the grid alone.
    pub(super) u: Option<f64>,
    pub(super) by: ByMethod,
    /// The value at the threshold moved by −1 % and +1 % of the contrast; of grey values only.
    pub(super) at_threshold_moved: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
pub(super) struct ByMethod {
    voxels: f64,
    mi: f64,
    cmi: f64,
    balls: f64,
    mmc: f64,
    trilinear: f64,
    mesh: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct AreaMeasure {
    pub(super) value: f64,
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
    /// Standard uncertainty where only some places of a large volume were looked at.
    pub(super) u: Option<f64>,
    pub(super) estimator: &'static str,
    /// The order with which blur takes area away: 2 for smooth bodies, 1 for edges.
    pub(super) order: Option<f64>,
    pub(super) has_edges: Option<bool>,
    pub(super) others: OtherAreas,
    /// Whether detail is too fine for the blur.
    #[serde(skip)]
    is_fine: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct OtherAreas {
    mesh: f64,
    semi_local: Option<f64>,
    difference: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct MeshFigures {
    pub(super) method: String,
    pub(super) vertices: u64,
    pub(super) triangles: u64,
    pub(super) euler: i64,
    pub(super) closed: bool,
    pub(super) oriented: bool,
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
    surface: &SurfaceFigures,
    given: Option<&Part>,
) -> Result<VolumeReport, Failure> {
    let Opened { samples, frame, .. } = opened;
    let histogram = Histogram::new(samples);
    let topology = Topology::new(samples, &histogram);
    let spacing_mm = frame.spacing_mm();
    let check = GridCheck::with_missing(samples, &histogram, opened.missing.as_ref());
    let nominal = given.map(|part| nominal::of(part, frame.steps_mm, &check)).transpose()?;
    let grid = grid(args, opened, &check, nominal);
    let pieces = &surface.pieces;
    let surfaces = pieces.iter().map(|piece| PieceFigures {
        euler: piece.euler,
        genus: piece.genus,
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
    };
    let measures = measures(args, opened, &histogram, surface, &grid, topology.euler_6);
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
            touches_border: samples.touches_border(),
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
        },
    };
    Ok(report)
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
    args: &VolumeArgs,
    opened: &Opened,
    check: &GridCheck,
    nominal: Option<NominalFigures>,
) -> GridFigures {
    let spacing_mm = opened.frame.spacing_mm();
    let (mut known, mut why) = check.verdict_on_axes(opened.frame.steps_mm, args.regular);
    if known == Verdict::Proved {
        let doubt = if opened.levels.missing > 0 {
            Some("samples are missing: what lies there is not known")
        } else if opened.samples.touches_border() {
            Some("the part touches the border of the volume: what lies beyond is not known")
        } else {
            None
        };
        if let Some(doubt) = doubt {
            (known, why) = (Verdict::Unknown, doubt.into());
        }
    }
    let needed = args.regular.map(needed_spacing_mm);
    let coarsest = spacing_mm.iter().copied().fold(0.0, f64::max);
    let places = check.places.iter().map(|place| PlaceFigures {
        centre_mm: opened.frame.place_mm(place.centre),
        code: place.code,
    });
    GridFigures {
        verdict: word(known),
        why,
        regular_mm: args.regular,
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
        known,
    }
}

fn measures(
    args: &VolumeArgs,
    opened: &Opened,
    histogram: &Histogram,
    surface: &SurfaceFigures,
    grid: &GridFigures,
    euler: i64,
) -> Measures {
    let Opened { samples, frame, .. } = opened;
    let [a, b, c] = frame.steps_mm;
    let voxel_mm3 = (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0]))
        .abs();
    let by = ByMethod {
        voxels: voxel_mm3 * histogram.volume(&voxel_fractions()),
        mi: voxel_mm3 * histogram.volume(&majority_fractions(Majority::Foreground)),
        cmi: voxel_mm3 * histogram.volume(&majority_fractions(Majority::Complement)),
        balls: voxel_mm3 * histogram.volume(&ball_fractions(BALL_RADIUS)),
        mmc: voxel_mm3 * histogram.volume(&marching_fractions(Ambiguity::Paired)),
        trilinear: voxel_mm3 * histogram.volume(&trilinear_fractions()),
        mesh: surface.volume,
    };
    let h_mm = frame.spacing_mm()[0];
    let is_cubic = frame.is_orthogonal()
        && frame.spacing_mm().iter().all(|side| (side / h_mm - 1.0).abs() < 1e-5);
    let regular = args.regular.filter(|_| grid.known == Verdict::Proved).map(|r| r / h_mm);
    let bounds = regular.map(|r| VolumeBounds::new(samples, Some(r)));
    let mesh = surface.area;
    let area = if is_cubic {
        cubic_area(opened, h_mm, regular, 2 * euler, mesh)
    } else {
        let others = OtherAreas { mesh, semi_local: None, difference: None };
        AreaMeasure {
            value: mesh,
            low: None,
            high: None,
            u: None,
            estimator: "mesh",
            order: None,
            has_edges: None,
            others,
            is_fine: false,
        }
    };
    let volume_mm3 = VolumeMeasure {
        value: by.voxels,
        low: bounds.map(|bounds| bounds.low * voxel_mm3),
        high: bounds.map(|bounds| bounds.high * voxel_mm3),
        u: is_cubic.then(|| counting_uncertainty(area.value / (h_mm * h_mm)) * voxel_mm3),
        by,
        at_threshold_moved: opened
            .moved_foreground
            .map(|counts| counts.map(|count| count as f64 * voxel_mm3)),
    };
    Measures { volume_mm3, area_mm2: area }
}

/// Area where voxels are cubes. The distances from the surface are looked at in volumes of up to [`TUBE_SAMPLES`].
fn cubic_area(
    opened: &Opened,
    h_mm: f64,
    regular: Option<f64>,
    surface_euler: i64,
    mesh: f64,
) -> AreaMeasure {
    let samples = &opened.samples;
    let square_mm2 = h_mm * h_mm;
    let blurred = blurred_area(samples);
    let mut others = OtherAreas { mesh, semi_local: None, difference: None };
    let (mut low, mut high) = (None, None);
    if samples.len() <= TUBE_SAMPLES {
        // Distances between 2r′ and r − 2r′, where the bounds hold; without r only the one of the plain estimate.
        let mut radii = vec![PLAIN_REACH, QUOTIENT_REACH / 2.0, QUOTIENT_REACH];
        if let Some(r) = regular {
            let (from, to) = (3_f64.sqrt(), (r - 3_f64.sqrt()).min(FARTHEST));
            radii.extend((1..=9).map(|step| from + (to - from) * f64::from(step) / 10.0));
        } else {
            radii.truncate(1);
        }
        if let Some(counts) = tube_counts(samples, &radii) {
            others.semi_local = Some(semi_local_area(counts[0], PLAIN_REACH) * square_mm2);
            if let Some(r) = regular {
                let is_far = r > QUOTIENT_REACH + 1.0;
                others.difference = is_far.then(|| {
                    difference_area(counts[2], counts[1], QUOTIENT_REACH, surface_euler)
                        * square_mm2
                });
                for (&s, &count) in radii.iter().zip(&counts).skip(3) {
                    if let Some([least, most]) = area_bounds(count, s, surface_euler, r) {
                        low = Some(low.map_or(least, |low: f64| low.max(least)));
                        high = Some(high.map_or(most, |high: f64| high.min(most)));
                    }
                }
            }
        }
    }
    AreaMeasure {
        value: blurred.area * square_mm2,
        low: low.map(|low| low * square_mm2),
        high: high.map(|high| high * square_mm2),
        u: blurred.u.map(|u| u * square_mm2),
        estimator: "blurred boundary",
        order: blurred.order,
        has_edges: Some(blurred.has_edges),
        others,
        is_fine: blurred.is_fine,
    }
}

/// Samples up to which distances from the surface are looked at: some ten seconds.
const TUBE_SAMPLES: u64 = 1 << 25;

/// s of the plain semi-local estimate, spacings.
const PLAIN_REACH: f64 = 4.0;

/// s of the difference quotient, spacings: s / 2 should be 7 or more.
const QUOTIENT_REACH: f64 = 14.0;

/// The largest s that bounds are looked for at, spacings.
const FARTHEST: f64 = 24.0;

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
    if opened.samples.touches_border() {
        reasons.push(
            "the material touches the border of the volume: the surface is closed there, one sample beyond; figures are of what was \
             scanned"
                .into(),
        );
    }
    if opened.levels.missing > 0 {
        reasons.push(format!(
            "{} samples have no value: they count as background; {missing_cells} cells of the surface lie beside one, and no surface of the \
             part",
            opened.levels.missing
        ));
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
