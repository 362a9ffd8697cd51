//! Curvature of a measured surface, as far as a reduction needs it.

use asphera_geometry::{BoundsMm, PointMm, place};

use super::fitted::Fitted;

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

/// An upper bound of the local feature size that holds everywhere at once: the smallest radius of
/// curvature over windows of an eighth of the extent along x and y, with noise of `sigma_mm` taken
/// against it.
///
/// A quadric is fitted to each window with at least 30 points, to up to 2000 of them. The radius is
/// 1 over the largest second derivative plus two of its standard uncertainties. Readings that stand off the quadric
/// by more than six standard deviations, of the noise or as the median of the residuals tells them, are left out,
/// again and again: a fifth of a window off to one side moves it by less than its uncertainty. What bends within a
/// window only, such as an edge or a scratch, is not seen, nor a second sheet of the surface
/// nearby. `None` where no window determines a quadric.
pub fn curvature_bound(points: &[PointMm], sigma_mm: f64) -> Option<CurvatureBound> {
    let bounds = BoundsMm::about(points.iter().map(|&point| place(point)));
    let window_mm = bounds.size_mm().map(|side_mm| side_mm / WINDOWS as f64);
    let mut windows = vec![Vec::new(); WINDOWS * WINDOWS];
    for &point in points {
        let [column, row] = [0, 1].map(|axis| {
            let cell = (point[axis] - bounds.low[axis]) / window_mm[axis];
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
    let quadric = robust(&offsets_mm, sigma_mm)?;
    let [xx, xy, yy] = quadric.second_per_mm();
    let [u_xx, u_xy, u_yy] = quadric.second_factors_per_mm2();
    let larger_eigenvalue = 0.5 * (xx + yy).abs() + (0.5 * (xx - yy)).hypot(xy);
    let uncertainty = sigma_mm * u_xx.hypot(u_yy).hypot(2.0_f64.sqrt() * u_xy);
    Some(larger_eigenvalue + 2.0 * uncertainty)
}

/// Windows along each axis.
const WINDOWS: usize = 8;
/// A quadric that wrong readings do not move: by least squares, and if a reading stands far off, again and again
/// without those that do, first strictly so that what is wrong lets go of it, then as far as noise goes.
fn robust(offsets_mm: &[[f64; 3]], sigma_mm: f64) -> Option<Fitted<6>> {
    let mut quadric = Fitted::<6>::to(offsets_mm)?;
    let off_mm =
        |quadric: &Fitted<6>, &[u, v, w]: &[f64; 3]| (w - quadric.height_at_mm(u, v)).abs();
    if offsets_mm.iter().all(|offset| off_mm(&quadric, offset) <= FAR * sigma_mm) {
        return Some(quadric);
    }
    let mut within = Vec::with_capacity(offsets_mm.len());
    for far in [STRICT; ROUNDS].into_iter().chain([FAR; 2]) {
        let mut sizes_mm: Vec<f64> =
            offsets_mm.iter().map(|offset| off_mm(&quadric, offset)).collect();
        let middle = sizes_mm.len() / 2;
        let median_mm = *sizes_mm.select_nth_unstable_by(middle, f64::total_cmp).1;
        let limit_mm = far * (NORMAL * median_mm).max(sigma_mm);
        within.clear();
        let near = |offset: &&[f64; 3]| off_mm(&quadric, offset) <= limit_mm;
        within.extend(offsets_mm.iter().filter(near));
        quadric = Fitted::<6>::to(&within)?;
    }
    Some(quadric)
}

/// Standard deviations from which on a reading is left out: what a quadric does not follow of a smooth surface stays.
const FAR: f64 = 6.0;
/// Standard deviation of a normal distribution over the median of its sizes.
const NORMAL: f64 = 1.4826;
/// The same while wrong readings may still hold the quadric.
const STRICT: f64 = 2.5;
const ROUNDS: usize = 12;
/// Points of a window that are fitted.
const WINDOW_POINTS: usize = 2000;
