//! Noise and curvature of a measured surface, as far as a reduction needs them.

use super::fitted::Fitted;
use crate::{Mesh, PointMm, VertexId};

/// The noise of the heights of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation in mm.
    pub sigma_mm: f64,
    /// From the residuals of how many vertices.
    pub vertices: u64,
}

/// How strongly a surface bends, seen over windows of its extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvatureBound {
    /// The smallest radius of curvature that the data allow anywhere, in mm; infinite of an exact
    /// plane.
    pub radius_mm: f64,
    /// How many windows were looked at.
    pub windows: u64,
    /// The sides of a window along x and y in mm.
    pub window_mm: [f64; 2],
}

/// The noise of the heights, robust to outliers; `None` where fewer than 20 inner vertices have
/// neighbours enough.
///
/// A quadric is fitted to each of up to 4096 vertices with the two rings about it; its residual
/// there, over √(1 - leverage), has the noise's own deviation. The median of their sizes times
/// 1.4826 estimates it (F. R. Hampel, Journal of the American Statistical Association 69 (1974)
/// 383-393, doi:10.1080/01621459.1974.10482962), to about 2 % for 4096. What bends within two rings
/// counts as noise, and noise that neighbours share does not.
pub fn noise_of(mesh: &Mesh) -> Option<Noise> {
    let count = mesh.points().len();
    let mut sizes_mm: Vec<f64> = (0..count.min(LOOKED_AT))
        .filter_map(|turn| {
            // All of a small mesh; of a large one, places that no regular scan lines up with.
            let share = (turn as f64 * GOLDEN).fract();
            let index = if count <= LOOKED_AT { turn } else { (share * count as f64) as usize };
            residual_mm(mesh, index as VertexId).map(f64::abs)
        })
        .collect();
    if sizes_mm.len() < 20 {
        return None;
    }
    let middle = sizes_mm.len() / 2;
    let (_, median_mm, _) = sizes_mm.select_nth_unstable_by(middle, f64::total_cmp);
    let sigma_mm = 1.482_602 * *median_mm;
    Some(Noise { sigma_mm, vertices: sizes_mm.len() as u64 })
}

/// The residual of a vertex to the quadric through it and two rings about it; of a vertex on the
/// hull none.
fn residual_mm(mesh: &Mesh, vertex: VertexId) -> Option<f64> {
    if mesh.neighbours(vertex)?.on_hull {
        return None;
    }
    let points = mesh.points();
    let at = points[vertex as usize];
    let offset = |other: VertexId| {
        let point = points[other as usize];
        [point[0] - at[0], point[1] - at[1], point[2] - at[2]]
    };
    let rings = mesh.within(vertex, 2)?;
    let offsets_mm: Vec<[f64; 3]> = std::iter::once(vertex).chain(rings).map(offset).collect();
    if offsets_mm.len() < 9 {
        return None;
    }
    Fitted::<6>::to(&offsets_mm)?.residual_mm([0.0; 3])
}

/// An upper bound of the local feature size that holds everywhere at once: the smallest radius of
/// curvature over windows of an eighth of the extent along x and y, with noise of `sigma_mm` taken
/// against it.
///
/// A quadric is fitted to each window with at least 30 points, to up to 2000 of them. The radius is
/// 1 over the largest second derivative plus two of its standard uncertainties. What bends within a
/// window only, such as an edge or a scratch, is not seen, nor a second sheet of the surface
/// nearby. `None` where no window determines a quadric.
pub fn curvature_bound(points: &[PointMm], sigma_mm: f64) -> Option<CurvatureBound> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in points {
        for axis in [0, 1] {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let window_mm = [0, 1].map(|axis| (high[axis] - low[axis]) / WINDOWS as f64);
    let mut windows = vec![Vec::new(); WINDOWS * WINDOWS];
    for &point in points {
        let [column, row] = [0, 1].map(|axis| {
            let cell = (point[axis] - low[axis]) / window_mm[axis];
            (cell as usize).min(WINDOWS - 1)
        });
        windows[row * WINDOWS + column].push(point);
    }
    let mut largest_per_mm = None;
    let mut looked_at = 0;
    for window in windows.iter().filter(|window| window.len() >= 30) {
        if let Some(curvature_per_mm) = curvature_per_mm(window, sigma_mm) {
            looked_at += 1;
            let so_far = largest_per_mm.unwrap_or(0.0);
            largest_per_mm = Some(curvature_per_mm.max(so_far));
        }
    }
    largest_per_mm.map(|per_mm: f64| CurvatureBound {
        radius_mm: per_mm.recip(),
        windows: looked_at,
        window_mm,
    })
}

/// The largest size of a second derivative over a window, and two standard uncertainties. It is no
/// less than the larger principal curvature: slopes only make that smaller.
fn curvature_per_mm(window: &[PointMm], sigma_mm: f64) -> Option<f64> {
    let step = window.len().div_ceil(WINDOW_POINTS);
    let chosen = || window.iter().step_by(step);
    let count = chosen().count() as f64;
    let centre = [0, 1, 2].map(|axis| chosen().map(|point| point[axis]).sum::<f64>() / count);
    let offsets_mm: Vec<[f64; 3]> =
        chosen().map(|point| [0, 1, 2].map(|axis| point[axis] - centre[axis])).collect();
    let quadric = Fitted::<6>::to(&offsets_mm)?;
    let [xx, xy, yy] = quadric.second_per_mm();
    let [u_xx, u_xy, u_yy] = quadric.second_factors_per_mm2();
    let larger_eigenvalue = 0.5 * (xx + yy).abs() + (0.5 * (xx - yy)).hypot(xy);
    let uncertainty = sigma_mm * u_xx.hypot(u_yy).hypot(2.0_f64.sqrt() * u_xy);
    Some(larger_eigenvalue + 2.0 * uncertainty)
}

/// Vertices looked at for the noise.
const LOOKED_AT: usize = 4096;
/// The golden section: its multiples fill the unit interval most evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Windows along each axis.
const WINDOWS: usize = 8;
/// Points of a window that are fitted.
const WINDOW_POINTS: usize = 2000;
