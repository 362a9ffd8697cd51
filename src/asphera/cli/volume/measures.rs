//! Volume and area of a volume, by every method, with their bounds.

use asphera_volume::{
    Ambiguity, BALL_RADIUS, Fractions, Histogram, Majority, VolumeBounds, area_bounds,
    ball_fractions, blurred_area, counting_uncertainty, difference_area, majority_fractions,
    marching_fractions, open_area, semi_local_area, trilinear_fractions, tube_counts,
    voxel_fractions,
};
use serde::Serialize;

use super::figures::GridFigures;
use super::meshed::Meshed;
use super::opened::Opened;

#[derive(Debug, Serialize)]
pub(super) struct Measures {
    pub(super) volume_mm3: VolumeMeasure,
    pub(super) area_mm2: AreaMeasure,
}

#[derive(Debug, Serialize)]
pub(super) struct VolumeMeasure {
    /// Foreground samples times the volume of a voxel.
    pub(super) value: f64,
    /// The same with missing samples as material; absent where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) with_missing: Option<f64>,
    /// Certain bounds, where r is stated and nothing contradicts the grid; they hold whatever missing samples hide.
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
    /// Standard uncertainty from the place of the grid alone; absent where the surface is open.
    pub(super) u: Option<f64>,
    pub(super) by: ByMethod,
    /// The value at the threshold moved by −1 % and +1 % of the contrast; of grey values only.
    pub(super) at_threshold_moved: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
pub(super) struct ByMethod {
    voxels: f64,
    // Absent where the surface is open.
    mi: Option<f64>,
    cmi: Option<f64>,
    balls: Option<f64>,
    mmc: Option<f64>,
    trilinear: Option<f64>,
    mesh: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct AreaMeasure {
    pub(super) value: f64,
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
    /// Standard uncertainty where only some places of a large volume were looked at, or the surface is open.
    pub(super) u: Option<f64>,
    pub(super) estimator: &'static str,
    /// The order with which blur takes area away: 2 for smooth bodies, 1 for edges.
    pub(super) order: Option<f64>,
    pub(super) has_edges: Option<bool>,
    /// The value at the threshold moved by −1 % and +1 % of the contrast, by the vertices of marching cubes; of grey values only.
    pub(super) at_threshold_moved: Option<[f64; 2]>,
    pub(super) others: OtherAreas,
    /// Whether detail is too fine for the blur.
    #[serde(skip)]
    pub(super) is_fine: bool,
}

#[derive(Debug, Serialize)]
pub(super) struct OtherAreas {
    mesh: f64,
    semi_local: Option<f64>,
    difference: Option<f64>,
}

/// Figures of the cells of a volume.
#[derive(Clone, Copy)]
pub(super) struct Cells<'a> {
    pub(super) histogram: &'a Histogram,
    /// Euler number of the solid, connected across faces.
    pub(super) euler: i64,
    /// Cells with surface beside missing samples.
    pub(super) near_missing: u64,
    /// Whether the surface ends at missing samples or at the border.
    pub(super) are_open: bool,
}

impl Cells<'_> {
    /// The volumes of all methods; where the surface is open, only the count of samples is left.
    fn volumes(&self, voxel_mm3: f64, mesh_mm3: Option<f64>) -> ByMethod {
        let volume = |fractions: &Fractions| voxel_mm3 * self.histogram.volume(fractions);
        let closed = |fractions: Fractions| (!self.are_open).then(|| volume(&fractions));
        ByMethod {
            voxels: volume(&voxel_fractions()),
            mi: closed(majority_fractions(Majority::Foreground)),
            cmi: closed(majority_fractions(Majority::Complement)),
            balls: closed(ball_fractions(BALL_RADIUS)),
            mmc: closed(marching_fractions(Ambiguity::Paired)),
            trilinear: closed(trilinear_fractions()),
            mesh: mesh_mm3,
        }
    }
}

/// Measures a volume and its surface.
pub(super) fn of(
    opened: &Opened,
    cells: Cells<'_>,
    meshed: &Meshed,
    grid: &GridFigures,
) -> Measures {
    let Opened { samples, frame, missing, .. } = opened;
    let voxel_mm3 = determinant(frame.steps_mm).abs();
    let by = cells.volumes(voxel_mm3, meshed.figures.volume);
    let h_mm = frame.spacing_mm()[0];
    let is_cubic = frame.is_orthogonal()
        && frame.spacing_mm().iter().all(|side| (side / h_mm - 1.0).abs() < 1e-5);
    let regular = grid.regular_mm.filter(|_| grid.is_regular).map(|r| r / h_mm);
    let bounds = regular.map(|r| VolumeBounds::with_missing(samples, missing.as_ref(), Some(r)));
    let mesh = meshed.figures.area;
    let mut area = if is_cubic {
        cubic_area(opened, cells, h_mm, regular, mesh)
    } else {
        AreaMeasure::of_mesh(mesh)
    };
    let moved = meshed.moved_areas.filter(|_| !opened.is_chosen);
    area.at_threshold_moved =
        moved.map(|[less, own, more]| [less, more].map(|moved| area.value * moved / own));
    let volume_mm3 = VolumeMeasure {
        value: by.voxels,
        with_missing: missing
            .as_ref()
            .map(|_| by.voxels + voxel_mm3 * opened.levels.missing as f64),
        low: bounds.map(|bounds| bounds.low * voxel_mm3),
        high: bounds.map(|bounds| bounds.high * voxel_mm3),
        u: (is_cubic && cells.near_missing == 0)
            .then(|| counting_uncertainty(area.value / (h_mm * h_mm)) * voxel_mm3),
        by,
        at_threshold_moved: opened
            .moved_foreground
            .map(|counts| counts.map(|count| count as f64 * voxel_mm3)),
    };
    Measures { volume_mm3, area_mm2: area }
}

fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

impl AreaMeasure {
    /// The area of the mesh, where no other is known.
    fn of_mesh(mesh: f64) -> AreaMeasure {
        AreaMeasure {
            value: mesh,
            low: None,
            high: None,
            u: None,
            estimator: "mesh",
            order: None,
            has_edges: None,
            at_threshold_moved: None,
            others: OtherAreas { mesh, semi_local: None, difference: None },
            is_fine: false,
        }
    }
}

/// Area where voxels are cubes. The distances from the surface are looked at in volumes of up to [`TUBE_SAMPLES`].
///
/// Where the surface is open they say nothing of the part.
fn cubic_area(
    opened: &Opened,
    cells: Cells<'_>,
    h_mm: f64,
    regular: Option<f64>,
    mesh: f64,
) -> AreaMeasure {
    let samples = &opened.samples;
    let (square_mm2, surface_euler) = (h_mm * h_mm, 2 * cells.euler);
    let gaps = opened.gaps();
    let blurred = if gaps.is_any() { open_area(samples, gaps) } else { blurred_area(samples) };
    let mut others = OtherAreas { mesh, semi_local: None, difference: None };
    let (mut low, mut high) = (None, None);
    if samples.len() <= TUBE_SAMPLES && !gaps.is_any() {
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
        u: Some(blurred.u * square_mm2),
        estimator: "blurred boundary",
        order: blurred.order,
        has_edges: Some(blurred.has_edges),
        at_threshold_moved: None,
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
