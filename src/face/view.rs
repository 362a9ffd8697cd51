//! A measured volume to be looked at: its faces by their deviation, places where its grid is at fault, slices.

use std::collections::BTreeMap;
use std::sync::Arc;

use asphera_geometry::PointMm;
use asphera_report::{
    CellKind, CellView, FaceView, GridView, Refusal, SliceRequest, VOLUME_VIEW_FORMAT, VolumeSlice,
    VolumeView,
};
use asphera_volume::{
    Case, CriticalKind, GridCheck, Histogram, Samples, SizeError, SlabBuilder, Verdict,
};

use crate::body::{Body, Lattice, Scan};
use asphera_geometry::vector::{Vector, dot, minus};

/// A face that was measured: places in mm and the deviation there, nm. What is not finite does not count.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredFace<'a> {
    /// Points of the face, mm.
    pub points_mm: &'a [PointMm],
    /// Deviation of each, nm.
    pub deviations_nm: &'a [f64],
}

/// A volume with its measured faces.
pub struct VolumeViewer {
    body: Body,
    /// Column, row, slice and deviation of the points of all faces.
    points: Vec<[f64; 4]>,
    view: Arc<VolumeView>,
}

impl VolumeViewer {
    /// A viewer of a body whose surface lies at `threshold`, with what was measured of its faces.
    ///
    /// # Errors
    ///
    /// Where the body has no samples.
    pub fn new(
        body: Body,
        threshold: f64,
        faces: &[MeasuredFace<'_>],
    ) -> Result<VolumeViewer, SizeError> {
        let lattice = body.scan.lattice;
        let placed: Vec<Vec<[f64; 4]>> = faces.iter().map(|face| placed(&lattice, face)).collect();
        let view = VolumeView {
            format: VOLUME_VIEW_FORMAT,
            size: body.scan.size.map(|side| side as u64),
            origin_mm: lattice.origin_mm,
            steps_mm: lattice.steps_mm,
            smoothing_mm: body.smoothing_mm,
            shown_range: range(&body.scan.values),
            threshold,
            grid: grid(&body, threshold)?,
            faces: placed.iter().map(|points| gathered(points)).collect(),
        };
        Ok(VolumeViewer { body, points: placed.concat(), view: Arc::new(view) })
    }

    /// Everything but slices.
    pub fn view(&self) -> &Arc<VolumeView> {
        &self.view
    }

    /// A slice with the points of the faces within half a spacing.
    ///
    /// # Errors
    ///
    /// Where there is no slice of that number.
    pub fn slice(&self, request: SliceRequest) -> Result<VolumeSlice, Refusal> {
        let VolumeView { shown_range, threshold, .. } = *self.view;
        let mut slice = self.body.scan.slice(request, shown_range, threshold)?;
        let (across, [along, down]) = (request.axis.index(), request.axis.within());
        let near = |point: &&[f64; 4]| (point[across] - request.index as f64).abs() <= 0.5;
        let found = self.points.iter().filter(near).count();
        // Every so many, so that none of the slice is favoured.
        let every = found.div_ceil(MOST_POINTS).max(1);
        let shown = self.points.iter().filter(near).step_by(every);
        slice.points =
            shown.map(|point| [to(point[along], 3), to(point[down], 3), point[3]]).collect();
        slice.points_left_out = (found - slice.points.len()) as u64;
        Ok(slice)
    }
}

impl Lattice {
    /// Where a place lies, in samples.
    fn samples(&self, place_mm: PointMm) -> Vector {
        let from = minus(place_mm, self.origin_mm);
        self.per_mm().map(|row| dot(row, from))
    }
}

fn placed(lattice: &Lattice, face: &MeasuredFace<'_>) -> Vec<[f64; 4]> {
    let known = face.points_mm.iter().zip(face.deviations_nm);
    known
        .filter(|(_, deviation_nm)| deviation_nm.is_finite())
        .map(|(&place_mm, &deviation_nm)| {
            let [x, y, z] = lattice.samples(place_mm);
            [x, y, z, to(deviation_nm, 1)]
        })
        .collect()
}

/// Means of place and deviation over cubes as small as the number of places allows.
fn gathered(points: &[[f64; 4]]) -> FaceView {
    let mut side = 1_u64;
    loop {
        let mut cubes = BTreeMap::<[i64; 3], ([f64; 4], f64)>::new();
        for point in points {
            let cube = [2, 1, 0].map(|axis| (point[axis] / side as f64).round() as i64);
            let (sum, count) = cubes.entry(cube).or_default();
            sum.iter_mut().zip(point).for_each(|(sum, own)| *sum += own);
            *count += 1.0;
        }
        if cubes.len() <= MOST_PLACES {
            let mean = |([x, y, z, nm], count): &([f64; 4], f64)| {
                [to(x / count, 2), to(y / count, 2), to(z / count, 2), to(nm / count, 1)]
            };
            let places = cubes.values().map(mean).collect();
            return FaceView { points: points.len() as u64, gathered: side, places };
        }
        side += 1;
    }
}

/// The smallest and the largest value.
fn range(values: &[f32]) -> [f64; 2] {
    let first = [f64::INFINITY, f64::NEG_INFINITY];
    let finite = values.iter().copied().filter(|value| value.is_finite()).map(f64::from);
    finite.fold(first, |[low, high], value| [low.min(value), high.max(value)])
}

fn grid(body: &Body, threshold: f64) -> Result<GridView, SizeError> {
    let samples = body.samples(threshold)?;
    let missing = missing(&body.scan)?;
    let check = GridCheck::with_missing(&samples, &Histogram::new(&samples), missing.as_ref());
    let lattice = &body.scan.lattice;
    let cell = |kind, at: Vector, code| {
        let at_mm = lattice.place_mm(at).map(|mm| to(mm, 6));
        CellView { kind, at, at_mm, code }
    };
    let violations = check.places.iter().map(|found| {
        let kind =
            if found.case == Case::Paired { CellKind::Unpaired } else { CellKind::Forbidden };
        cell(kind, found.centre, Some(found.code))
    });
    let critical = check.critical.iter().map(|found| {
        let kind = match found.kind {
            CriticalKind::C1 => CellKind::C1,
            CriticalKind::C2 => CellKind::C2,
        };
        cell(kind, found.centre, None)
    });
    let mut cells: Vec<CellView> = violations.chain(critical).collect();
    let order = |cell: &CellView| [cell.at[2], cell.at[1], cell.at[0]];
    cells.sort_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(std::cmp::Ordering::Equal));
    let all = check.forbidden + check.case8_unpaired + check.c1 + check.c2;
    let (verdict, why) = check.verdict_on_axes(lattice.steps_mm, None);
    Ok(GridView {
        contradicted: verdict == Verdict::Contradicted,
        why,
        forbidden: check.forbidden,
        case8_unpaired: check.case8_unpaired,
        c1: check.c1,
        c2: check.c2,
        near_missing: check.near_missing,
        left_out: all - cells.len() as u64,
        cells,
    })
}

/// Samples without a value, as foreground; `None` where there are none.
fn missing(scan: &Scan) -> Result<Option<Samples>, SizeError> {
    if scan.values.iter().all(|value| value.is_finite()) {
        return Ok(None);
    }
    let mut builder = SlabBuilder::new(scan.size)?;
    builder.push_missing(&scan.values)?;
    builder.finish().map(Some)
}

/// To so many decimals.
fn to(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale
}

/// Places of a face: some 400 kB of JSON.
const MOST_PLACES: usize = 12_000;
/// Points over a slice.
const MOST_POINTS: usize = 5_000;

#[cfg(test)]
mod tests {
    use asphera_report::SliceAxis;

    use super::*;
    use crate::Scan;

    /// Two voxels that touch by an edge, two that touch by a corner, in a volume with unequal steps.
    #[test]
    fn places_at_fault_are_listed_in_mm() {
        let size = [8, 8, 8];
        let solid = [[1, 1, 1], [2, 2, 1], [5, 5, 5], [6, 6, 6]];
        let mut values = vec![0.0; 512];
        solid.iter().for_each(|[x, y, z]| values[(z * 8 + y) * 8 + x] = 100.0);
        let steps_mm = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.2]];
        let lattice = Lattice { origin_mm: [1.0, 2.0, 3.0], steps_mm };
        let of_solid = values.clone();
        let with_gaps = values.clone();
        let body = Body::new(Scan { values, size, lattice }, 0.0);
        let points_mm = [[1.1, 2.1, 3.2], [1.2, 2.1, 3.2], [1.7, 2.7, 4.4]];
        let face = MeasuredFace { points_mm: &points_mm, deviations_nm: &[10.0, 20.04, f64::NAN] };
        let viewer = VolumeViewer::new(body, 50.0, &[face]).unwrap();
        let view = viewer.view();
        let GridView { contradicted, forbidden, case8_unpaired, c1, c2, cells, left_out, .. } =
            &view.grid;
        // Both cells at the edge have 2 samples of 8: no partners, for a partner of 2 has 6. On voxels that are no cubes that
        // contradicts nothing.
        assert_eq!((*contradicted, *forbidden, *case8_unpaired), (false, 1, 2));
        let cubes =
            Lattice { steps_mm: [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]], ..lattice };
        let body = Body::new(Scan { values: of_solid, size, lattice: cubes }, 0.0);
        let on_cubes = VolumeViewer::new(body, 50.0, &[]).unwrap();
        assert!(on_cubes.view().grid.contradicted);
        // The same beside samples without a value, which may hide what would excuse it.
        let mut lacking = with_gaps;
        for [x, y, z] in [[2, 1, 1], [5, 6, 5]] {
            lacking[(z * 8 + y) * 8 + x] = f32::NAN;
        }
        let body = Body::new(Scan { values: lacking, size, lattice: cubes }, 0.0);
        let open = VolumeViewer::new(body, 50.0, &[]).unwrap().view().grid.clone();
        assert!(!open.contradicted && open.near_missing > 8, "{open:?}");
        assert_eq!((*c1, *c2, *left_out), (1, 1, 0));
        let found: Vec<_> = cells.iter().map(|cell| (cell.kind, cell.at)).collect();
        let corner = [5.5, 5.5, 5.5];
        let expected = [
            (CellKind::Unpaired, [1.5, 1.5, 0.5]),
            (CellKind::C1, [1.5, 1.5, 1.0]),
            (CellKind::Unpaired, [1.5, 1.5, 1.5]),
            (CellKind::Forbidden, corner),
            (CellKind::C2, corner),
        ];
        assert_eq!(found, expected);
        assert_eq!(cells[1].at_mm, [1.15, 2.15, 3.2]);
        assert_eq!(cells[3].code, Some(0b1000_0001));
        assert_eq!(view.shown_range, [0.0, 100.0]);
        assert_eq!(view.faces[0].points, 2);
        assert_eq!(view.faces[0].places, [[1.0, 1.0, 1.0, 10.0], [2.0, 1.0, 1.0, 20.0]]);
        let slice = |axis, index| viewer.slice(SliceRequest { axis, index }).unwrap();
        assert_eq!(slice(SliceAxis::Z, 1).points, [[1.0, 1.0, 10.0], [2.0, 1.0, 20.0]]);
        assert_eq!(slice(SliceAxis::X, 2).points, [[1.0, 1.0, 20.0]]);
        assert!(slice(SliceAxis::Z, 2).points.is_empty());
    }

    #[test]
    fn places_of_a_face_are_bounded_and_even() {
        let points: Vec<[f64; 4]> =
            (0..40_000).map(|i| [f64::from(i % 200), f64::from(i / 200), 7.0, 5.0]).collect();
        let view = gathered(&points);
        assert_eq!((view.points, view.gathered, view.places.len()), (40_000, 2, 101 * 101));
        assert_eq!(view.places[102], [1.5, 1.5, 7.0, 5.0]);
    }
}
