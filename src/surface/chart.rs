//! Charts: the sampling of a mesh, cell by cell, coarse enough to be looked at.
//!
//! A triangle counts in the cell its centre lies in, and in every cell whose own centre it holds. So
//! triangles smaller than a cell all count, and larger ones leave no cell between them empty.

use asphera_geometry::{PointMm, Triangle, VertexId};

use crate::noise::{Noise, facet_tilt_rad};
use crate::rim::refined_gaps;
use crate::{Criteria, Grid, RasterError, State};

/// The sampling in the cells about the nodes of a grid, x fastest; `None` where there is no triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// The largest gap, mm.
    pub gap_mm: Vec<Option<f64>>,
    /// The largest ε; `None` also where a local feature size is not known.
    pub epsilon: Vec<Option<f64>>,
    /// The mean tilt of the facets by noise, by area, in rad; `None` also where the noise is not known, and
    /// where nothing but gaps above the limit is.
    pub tilt_rad: Vec<Option<f64>>,
    /// The share of the area of triangles that are not within the criteria, 0 to 1.
    pub undersampled: Vec<Option<f64>>,
}

/// Triangles whose corners are indices into points.
#[derive(Clone, Copy, Debug)]
pub struct Facets<'a> {
    /// Points in mm.
    pub points: &'a [PointMm],
    /// The triangles.
    pub triangles: &'a [[VertexId; 3]],
}

/// Charts facets by the criteria of [`crate::assess`].
///
/// `on_chart` says where on the grid a point lies, and may turn and shift. `lfs_mm(x, y)` is the local
/// feature size, infinite over a plane, `None` where it is not known; it is asked for once for each point
/// and once for each triangle. Triangles without area have no tilt.
///
/// Takes time in proportion to points, triangles and nodes.
///
/// # Errors
///
/// When the grid is none.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn chart(
    Facets { points, triangles }: Facets<'_>,
    criteria: &Criteria,
    noise: Option<Noise>,
    grid: &Grid,
    on_chart: impl Fn(PointMm) -> [f64; 2],
    lfs_mm: impl Fn(f64, f64) -> Option<f64>,
) -> Result<Chart, RasterError> {
    let lfs_mm = |x: f64, y: f64| lfs_mm(x, y).filter(|lfs_mm| *lfs_mm > 0.0);
    let lfs_at_points_mm: Vec<Option<f64>> = points.iter().map(|&[x, y, _]| lfs_mm(x, y)).collect();
    let cells = Cells::new(grid)?;
    let places: Vec<[f64; 2]> = points.iter().map(|point| cells.place(on_chart(*point))).collect();
    let mut refined = refined_gaps(points, triangles).into_iter().peekable();
    let mut tallies = vec![Tally::default(); cells.count()];
    for (index, &corners) in triangles.iter().enumerate() {
        let triangle = Triangle::new(points, corners);
        let gap = match refined.next_if(|&(thin, _)| thin == index) {
            Some((_, gap)) => gap,
            None => triangle.gap(),
        };
        let [a, b, c] = corners.map(|corner| lfs_at_points_mm[corner as usize]);
        let at_gap = lfs_mm(gap.at_mm[0], gap.at_mm[1]);
        let lfs_mm = [a, b, c, at_gap]
            .into_iter()
            .try_fold(f64::INFINITY, |least, lfs_mm| Some(lfs_mm?.min(least)));
        let epsilon = lfs_mm.map(|lfs_mm| gap.mm / lfs_mm);
        let corners_mm = corners.map(|corner| points[corner as usize]);
        let state = criteria.state(gap.mm, epsilon.unwrap_or(f64::INFINITY));
        let seen = Seen {
            gap_mm: gap.mm,
            epsilon,
            // What bridges a gap is no facet of the surface.
            tilt_rad: noise
                .filter(|_| state != State::OverGap)
                .and_then(|noise| facet_tilt_rad(corners_mm, noise)),
            good: state == State::Good,
        };
        let places = corners.map(|corner| places[corner as usize]);
        cells.held(places, |cell| tallies[cell].hold(&seen));
        if let Some(cell) = cells.at(centre(places)) {
            tallies[cell].take(&seen, triangle.projected_area_mm2().max(0.0));
        }
    }
    Ok(Chart {
        gap_mm: tallies.iter().map(|tally| tally.gap_mm).collect(),
        epsilon: tallies.iter().map(Tally::epsilon).collect(),
        tilt_rad: tallies.iter().map(Tally::tilt_rad).collect(),
        undersampled: tallies.iter().map(Tally::undersampled).collect(),
    })
}

/// What counts of a triangle.
struct Seen {
    gap_mm: f64,
    epsilon: Option<f64>,
    tilt_rad: Option<f64>,
    good: bool,
}

/// Data known of a cell.
#[derive(Clone, Default)]
struct Tally {
    gap_mm: Option<f64>,
    epsilon: f64,
    epsilon_unknown: bool,
    /// Of the triangles whose centres lie in it.
    area_mm2: f64,
    undersampled_mm2: f64,
    tilted_mm2: f64,
    tilts_mm2_rad: f64,
    /// Of a triangle that holds the centre of the cell: what counts where no triangle has its own there.
    held: Option<(bool, Option<f64>)>,
}

impl Tally {
    fn note(&mut self, seen: &Seen) {
        self.gap_mm = Some(self.gap_mm.map_or(seen.gap_mm, |gap_mm| gap_mm.max(seen.gap_mm)));
        match seen.epsilon {
            Some(epsilon) => self.epsilon = self.epsilon.max(epsilon),
            None => self.epsilon_unknown = true,
        }
    }

    fn hold(&mut self, seen: &Seen) {
        self.note(seen);
        self.held = Some((seen.good, seen.tilt_rad));
    }

    fn take(&mut self, seen: &Seen, area_mm2: f64) {
        self.note(seen);
        self.area_mm2 += area_mm2;
        if !seen.good {
            self.undersampled_mm2 += area_mm2;
        }
        if let Some(tilt_rad) = seen.tilt_rad {
            self.tilted_mm2 += area_mm2;
            self.tilts_mm2_rad += area_mm2 * tilt_rad;
        }
    }

    fn epsilon(&self) -> Option<f64> {
        self.gap_mm.filter(|_| !self.epsilon_unknown).map(|_| self.epsilon)
    }

    fn tilt_rad(&self) -> Option<f64> {
        let mean = (self.tilted_mm2 > 0.0).then(|| self.tilts_mm2_rad / self.tilted_mm2);
        mean.or_else(|| self.held?.1)
    }

    fn undersampled(&self) -> Option<f64> {
        if self.area_mm2 > 0.0 {
            return Some((self.undersampled_mm2 / self.area_mm2).clamp(0.0, 1.0));
        }
        self.held.map(|(good, _)| if good { 0.0 } else { 1.0 })
    }
}

/// The cells about the nodes of a grid. A place among them is counted in cells: that of node (i, j)
/// reaches from i to i + 1 and from j to j + 1, and its centre is the node.
struct Cells {
    grid: Grid,
}

impl Cells {
    fn new(grid: &Grid) -> Result<Cells, RasterError> {
        let &Grid { x0_mm, y0_mm, dx_mm, dy_mm, nx, ny } = grid;
        let finite = [x0_mm, y0_mm, dx_mm, dy_mm].iter().all(|value| value.is_finite());
        if !(finite && dx_mm > 0.0 && dy_mm > 0.0) {
            return Err(RasterError::Grid { x0_mm, y0_mm, dx_mm, dy_mm });
        }
        if nx.checked_mul(ny).is_none_or(|nodes| nodes > MOST_NODES) {
            return Err(RasterError::Nodes { nx, ny });
        }
        Ok(Cells { grid: *grid })
    }

    fn count(&self) -> usize {
        self.grid.nx * self.grid.ny
    }

    fn place(&self, [x_mm, y_mm]: [f64; 2]) -> [f64; 2] {
        let Grid { x0_mm, y0_mm, dx_mm, dy_mm, .. } = self.grid;
        [(x_mm - x0_mm) / dx_mm + 0.5, (y_mm - y0_mm) / dy_mm + 0.5]
    }

    /// The cell of a place.
    fn at(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let within = |place: f64, cells: usize| {
            (place >= 0.0 && place < cells as f64).then_some(place as usize)
        };
        Some(within(y, self.grid.ny)? * self.grid.nx + within(x, self.grid.nx)?)
    }

    /// Every cell whose centre lies in a triangle, row by row: a thin triangle across the grid costs its
    /// rows. A centre on a side belongs to the triangle above it, or to the left, and to no other.
    fn held(&self, corners: [[f64; 2]; 3], mut found: impl FnMut(usize)) {
        let extent = |axis: usize| {
            let [a, b, c] = corners.map(|corner| corner[axis]);
            [a.min(b).min(c), a.max(b).max(c)]
        };
        // Most triangles are small and hold no centre.
        if centres(extent(0), self.grid.nx).is_empty() {
            return;
        }
        for row in centres(extent(1), self.grid.ny) {
            let y = row as f64 + 0.5;
            let mut span = [f64::INFINITY, f64::NEG_INFINITY];
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                // From below, so that both triangles beside a side have the same place on it.
                let ([x0, y0], [x1, y1]) = match (corners[from], corners[to]) {
                    (low, high) if low[1] <= high[1] => (low, high),
                    (high, low) => (low, high),
                };
                if y0 < y && y <= y1 {
                    let x = x0 + (x1 - x0) * ((y - y0) / (y1 - y0));
                    span = [span[0].min(x), span[1].max(x)];
                }
            }
            centres(span, self.grid.nx).for_each(|column| found(row * self.grid.nx + column));
        }
    }
}

/// The cells of a row or a column whose centres lie above `low` and up to `high`.
fn centres([low, high]: [f64; 2], cells: usize) -> std::ops::Range<usize> {
    // Casts round down, and take what is negative for 0.
    let before = |place: f64| ((place + 0.5) as usize).min(cells);
    before(low)..before(high)
}

fn centre(corners: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0)
}

/// Beyond, nothing is coarse enough to be looked at.
const MOST_NODES: usize = 1 << 20;

#[cfg(test)]
mod tests {
    use asphera_mesh::Mesh;

    use super::*;
    use crate::noise::Along;

    const GRID: Grid = Grid { x0_mm: 0.5, y0_mm: 0.5, dx_mm: 1.0, dy_mm: 1.0, nx: 8, ny: 8 };

    fn raster(step_mm: f64, skip: impl Fn(f64, f64) -> bool) -> Mesh {
        let nodes = (8.0 / step_mm) as usize;
        let points: Vec<PointMm> = (0..=nodes * (nodes + 2))
            .map(|k| [(k % (nodes + 1)) as f64 * step_mm, (k / (nodes + 1)) as f64 * step_mm, 0.0])
            .filter(|[x, y, _]| !skip(*x, *y))
            .collect();
        let mut mesh = Mesh::new();
        mesh.insert(&points);
        mesh
    }

    fn of(mesh: &Mesh, criteria: Criteria, noise: Option<Noise>) -> Chart {
        let lfs_mm = |_, _| Some(10.0);
        let flat = |[x, y, _]: PointMm| [x, y];
        let facets = Facets { points: mesh.points(), triangles: &mesh.triangles() };
        chart(facets, &criteria, noise, &GRID, flat, lfs_mm).unwrap()
    }

    fn limit(gap_mm: f64) -> Criteria {
        Criteria { gap_limit_mm: Some(gap_mm), ..Criteria::default() }
    }

    #[test]
    fn a_raster_is_the_same_in_every_cell() {
        let noise = Noise::new(1e-3, Along::Z).unwrap();
        let found = of(&raster(0.25, |_, _| false), limit(0.2), Some(noise));
        let half_diagonal = 0.25 / 2.0_f64.sqrt();
        for cell in 0..64 {
            assert!((found.gap_mm[cell].unwrap() - half_diagonal).abs() < 1e-12);
            assert!((found.epsilon[cell].unwrap() - half_diagonal / 10.0).abs() < 1e-12);
            // 2σ/h: see `facet_tilt_rad`.
            assert!((found.tilt_rad[cell].unwrap() - 2e-3 / 0.25).abs() < 1e-12);
            assert_eq!(found.undersampled[cell], Some(0.0));
        }
    }

    #[test]
    fn triangles_larger_than_cells_leave_none_empty() {
        let found = of(&raster(4.0, |_, _| false), limit(2.0), None);
        assert!(found.undersampled.iter().all(|share| *share == Some(1.0)));
        assert!(found.gap_mm.iter().all(|gap_mm| (gap_mm.unwrap() - 8.0_f64.sqrt()).abs() < 1e-12));
        assert!(found.tilt_rad.iter().all(Option::is_none), "without noise there is no tilt");
    }

    #[test]
    fn a_hole_is_undersampled_and_the_rest_is_not() {
        let hole = |x: f64, y: f64| (2.0 < x && x < 5.0) && (2.0 < y && y < 5.0);
        let noise = Noise::new(1e-3, Along::Z).unwrap();
        let found = of(&raster(0.25, hole), limit(0.2), Some(noise));
        for (cell, share) in found.undersampled.iter().enumerate() {
            let (x, y) = ((cell % 8) as f64 + 0.5, (cell / 8) as f64 + 0.5);
            // At its corners some triangles are small enough.
            let expected = if hole(x, y) { 0.8..=1.0 } else { 0.0..=0.0 };
            assert!(expected.contains(&share.unwrap()), "({x}, {y}): {share:?}");
            assert_eq!(found.gap_mm[cell].unwrap() > 0.2, hole(x, y), "({x}, {y})");
            if !hole(x, y) {
                assert!(found.tilt_rad[cell].is_some(), "({x}, {y})");
            }
        }
        let middle = 3 * 8 + 3;
        assert_eq!(found.tilt_rad[middle], None, "a bridge is no facet");
        for cell in 0..64 {
            assert!(found.tilt_rad[cell].is_none_or(|tilt| tilt > 7e-3), "{cell}");
        }
    }

    #[test]
    fn beyond_the_hull_nothing_is_known_and_an_unknown_feature_size_leaves_no_epsilon() {
        let mesh = raster(0.25, |x, _| x > 4.0);
        let unknown = |x: f64, _| (x < 1.0).then_some(-1.0);
        let flat = |[x, y, _]: PointMm| [x, y];
        let criteria = Criteria { epsilon_limit: Some(0.1), ..Criteria::default() };
        let facets = Facets { points: mesh.points(), triangles: &mesh.triangles() };
        let found = chart(facets, &criteria, None, &GRID, flat, unknown).unwrap();
        for cell in 0..64 {
            let inside = cell % 8 < 4;
            assert_eq!(found.gap_mm[cell].is_some(), inside, "{cell}");
            assert_eq!(found.epsilon[cell], None);
            assert_eq!(found.undersampled[cell], inside.then_some(1.0), "{cell}");
        }
    }

    #[test]
    fn what_is_no_grid() {
        let nothing = Facets { points: &[], triangles: &[] };
        for grid in [Grid { dx_mm: 0.0, ..GRID }, Grid { x0_mm: f64::NAN, ..GRID }] {
            let found = chart(nothing, &limit(1.0), None, &grid, |_| [0.0; 2], |_, _| None);
            assert!(matches!(found, Err(RasterError::Grid { .. })), "{found:?}");
        }
        let grid = Grid { nx: 1 << 11, ny: 1 << 11, ..GRID };
        let found = chart(nothing, &limit(1.0), None, &grid, |_| [0.0; 2], |_, _| None);
        assert!(matches!(found, Err(RasterError::Nodes { .. })));
    }
}
