//! What may hide where nothing was measured.

use asphera_geometry::BoundsMm;
use rayon::prelude::*;

use super::budget::{UncertaintyError, check};
use super::scatter::{quadratic, split};

/// What the unmeasured part of the aperture may add to a peak to valley deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hidden {
    /// At most this at either end, in nm: an extreme between the points.
    AtMost {
        /// What may be added to the highest and taken from the lowest deviation, in nm.
        each_end_nm: f64,
    },
    /// Anything: the figure is the least it can be.
    Unbounded,
}

/// How much may hide between points whose largest empty circle has radius `gap_radius_mm`, if the deviation
/// bends by no more than `bend_per_mm` (its largest second derivative in any direction, mm/mm²) anywhere.
///
/// Between the corners of a triangle with an empty circumcircle of radius R, a function lies within ½·bend·R² of
/// the plane through them (Waldron, SIAM J. Numer. Anal. 35 (1998) 1191), and a plane has its extremes at the
/// corners. Beyond the outermost points there is no such bound; neither is there without a gap or a bend: the
/// answer is then [`Hidden::Unbounded`].
pub fn unmeasured(
    gap_radius_mm: Option<f64>,
    bend_per_mm: Option<f64>,
) -> Result<Hidden, UncertaintyError> {
    let length = |name, value: Option<f64>| match value {
        Some(v) => check(name, v, v.is_finite() && v >= 0.0, "a finite number not below 0"),
        None => Ok(()),
    };
    length("radius of the largest gap in mm", gap_radius_mm)?;
    length("largest second derivative in 1/mm", bend_per_mm)?;
    Ok(match (gap_radius_mm, bend_per_mm) {
        (Some(radius_mm), Some(bend)) => {
            Hidden::AtMost { each_end_nm: 0.5 * bend * radius_mm * radius_mm * 1e6 }
        }
        _ => Hidden::Unbounded,
    })
}

/// The largest second derivative of a deviation in any direction, in mm/mm², that points tell: of quadratics laid into
/// groups of 48 to 95 neighbours, the places in the part frame. `None` where no group determines one, as with fewer points
/// than 48 or points on a line.
///
/// Noise of σ adds to it: by about 0.3·σ over the square of the distance of the points, which is a hundredth to a tenth
/// of σ in what may hide between them. What is narrower than a group, a speck of dust, counts by what a quadratic
/// takes of it. `O(n log n)`.
pub fn largest_bend(places_mm: &[[f64; 2]], deviations_mm: &[f64]) -> Option<f64> {
    let finite = |index: &usize| {
        let [x, y] = places_mm[*index];
        x.is_finite() && y.is_finite() && deviations_mm[*index].is_finite()
    };
    let count = places_mm.len().min(deviations_mm.len());
    let mut order: Vec<usize> = (0..count).filter(finite).collect();
    let mut groups = Vec::new();
    split(&mut order, places_mm, BEND_GROUP, &mut groups);
    let of_group = |group: &Vec<usize>| bend(group, places_mm, deviations_mm);
    groups.par_iter().filter_map(of_group).reduce_with(f64::max)
}

/// The same of `most` points where there are more: those in windows, 16 along either side of the box of all, that hold about as
/// many together. A place that bends more than any window is then passed over. `O(n)`, and `O(most·log most)`.
pub fn largest_bend_of_windows(
    places_mm: &[[f64; 2]],
    deviations_mm: &[f64],
    most: usize,
) -> Option<f64> {
    let count = places_mm.len().min(deviations_mm.len());
    let finite = |&index: &usize| {
        let [x, y] = places_mm[index];
        x.is_finite() && y.is_finite() && deviations_mm[index].is_finite()
    };
    let all = (0..count).filter(finite).count();
    if all <= most {
        return largest_bend(places_mm, deviations_mm);
    }
    let bounds = BoundsMm::about((0..count).filter(finite).map(|index| places_mm[index]));
    let widths = bounds.size_mm().map(|width| width.max(f64::MIN_POSITIVE));
    let half = 0.5 * (most as f64 / all as f64).sqrt();
    let mut windows: Vec<Vec<usize>> = vec![Vec::new(); WINDOWS * WINDOWS];
    for index in (0..count).filter(finite) {
        let at: [f64; 2] = std::array::from_fn(|axis| {
            WINDOWS as f64 * (places_mm[index][axis] - bounds.low[axis]) / widths[axis]
        });
        if at.iter().all(|at| (at.fract() - 0.5).abs() <= half) {
            let [column, row] = at.map(|at| (at as usize).min(WINDOWS - 1));
            windows[row * WINDOWS + column].push(index);
        }
    }
    let of_window = |window: &mut Vec<usize>| {
        let mut groups = Vec::new();
        split(window, places_mm, BEND_GROUP, &mut groups);
        let bends = groups.iter().filter_map(|group| bend(group, places_mm, deviations_mm));
        bends.reduce(f64::max)
    };
    windows.par_iter_mut().filter_map(of_window).reduce_with(f64::max)
}

/// Of the quadratic laid into a group; `None` where that is not determined.
fn bend(group: &[usize], places_mm: &[[f64; 2]], deviations_mm: &[f64]) -> Option<f64> {
    let found = quadratic(group, places_mm, deviations_mm)?;
    let [.., xx, xy, yy] = found.coefficients;
    // The larger eigenvalue, by size, of the matrix of second derivatives.
    (found.determined == 6).then(|| (xx + yy).abs() + (xx - yy).hypot(xy))
}

/// Windows along either side.
const WINDOWS: usize = 16;
/// Enough neighbours that noise does not make the bend.
const BEND_GROUP: usize = 48;

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_geometry::Numbers;

    fn lattice(side: u32) -> Vec<[f64; 2]> {
        (0..side * side).map(|i| [f64::from(i % side) * 0.1, f64::from(i / side) * 0.1]).collect()
    }

    #[test]
    fn the_bend_of_a_saddle_and_of_a_wave() {
        let places = lattice(60);
        // Second derivatives of 2·3e-5 along one diagonal and of -2·1e-5 across it.
        let saddle: Vec<f64> = places
            .iter()
            .map(|[x, y]| 3e-5 * (x + y).powi(2) / 2.0 - 1e-5 * (x - y).powi(2) / 2.0 + 0.01 * x)
            .collect();
        assert!((largest_bend(&places, &saddle).unwrap() / 6e-5 - 1.0).abs() < 1e-9);
        // A wave 4 mm long of 100 nm: amplitude times (2π/λ)², a group being 0.7 to 1 mm wide.
        let wave: Vec<f64> =
            places.iter().map(|[x, _]| 1e-4 * (std::f64::consts::TAU * x / 4.0).sin()).collect();
        let bend = largest_bend(&places, &wave).unwrap();
        let truth = 1e-4 * (std::f64::consts::TAU / 4.0).powi(2);
        assert!((0.9..1.001).contains(&(bend / truth)), "{}", bend / truth);
        // Few points are all looked at, of many a part, which finds nearly as much of a wave.
        assert_eq!(largest_bend_of_windows(&places, &wave, 3600), Some(bend));
        let places = lattice(600);
        let wave: Vec<f64> =
            places.iter().map(|[x, _]| 1e-4 * (std::f64::consts::TAU * x / 4.0).sin()).collect();
        let [all, some] = [360_000, 60_000]
            .map(|most| largest_bend_of_windows(&places, &wave, most).unwrap() / truth);
        assert!((0.95..1.05).contains(&(some / all)), "{some} {all}");
        let nothing = largest_bend_of_windows(&[[f64::NAN; 2]; 9], &[0.0; 9], 4);
        assert_eq!(nothing, None);
    }

    #[test]
    fn noise_hides_little_and_few_points_tell_nothing() {
        let places = lattice(300);
        let numbers = Numbers::new(5, 0, 0);
        let noise: Vec<f64> = (0..places.len()).map(|i| 1e-5 * numbers.normal(i)).collect();
        let bend = largest_bend(&places, &noise).unwrap();
        // The gap of a lattice of 0.1 mm is 0.1/√2 mm.
        let Ok(Hidden::AtMost { each_end_nm }) = unmeasured(Some(0.1 / 2.0_f64.sqrt()), Some(bend))
        else {
            panic!("a bound");
        };
        assert!(each_end_nm < 0.1 * 10.0, "{each_end_nm} nm of noise of 10 nm");
        assert_eq!(largest_bend(&places[..47], &noise), None);
        let line: Vec<[f64; 2]> = places.iter().map(|[x, _]| [*x, 0.0]).collect();
        assert_eq!(largest_bend(&line, &noise), None);
        let gaps = [vec![f64::NAN; 300], noise[300..].to_vec()].concat();
        assert!(largest_bend(&places, &gaps).is_some());
    }

    /// The paraboloid −½·κ·r² about the circumcentre reaches the bound exactly, for an equilateral triangle.
    #[test]
    fn a_dome_between_three_points_is_just_hidden() {
        let (bend, radius_mm) = (3e-5, 0.4);
        let at_corners_nm = -0.5 * bend * radius_mm * radius_mm * 1e6;
        let Ok(Hidden::AtMost { each_end_nm }) = unmeasured(Some(radius_mm), Some(bend)) else {
            panic!("a bound");
        };
        assert!((each_end_nm + at_corners_nm).abs() < 1e-12);
    }

    #[test]
    fn without_gap_or_bend_there_is_no_bound() {
        assert_eq!(unmeasured(None, Some(1.0)), Ok(Hidden::Unbounded));
        assert_eq!(unmeasured(Some(1.0), None), Ok(Hidden::Unbounded));
        assert!(unmeasured(Some(f64::NAN), None).is_err() && unmeasured(None, Some(-1.0)).is_err());
    }
}
