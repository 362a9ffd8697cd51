//! Noise from the scatter of neighbours: what is smooth in a few points next to each other is no noise.
//!
//! The places are halved at the median of their longer extent until 12 to 23 points are left in a group. A
//! quadratic is taken from the deviations of each group; what it leaves is noise, and form only by its third
//! derivative over some four point spacings. The variance is the median over the groups, each against the
//! median of its own χ² distribution, so up to half of the groups may hold steps, spikes or steep form. The
//! price is a share of about 0.64 of the information (the efficiency of a median).
//!
//! Differences of neighbours for a variance: von Neumann, Kent, Bellinson & Hart, Ann. Math. Statist. 12 (1941)
//! 153; polynomials in place of differences: Gasser, Sroka & Jennen-Steinmetz, Biometrika 73 (1986) 625.

use rayon::prelude::*;

use super::budget::UncertaintyError;
use super::distribution::{chi_square_density, chi_square_median};
use super::halve::halve;
use asphera_form::linear::{System, Triangle};

/// A standard deviation found from the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scatter {
    pub(crate) sigma_mm: f64,
    pub(crate) dof: f64,
}

/// `O(n log n)`.
pub(crate) fn scatter(
    places_mm: &[[f64; 2]],
    deviations_mm: &[f64],
) -> Result<Scatter, UncertaintyError> {
    grouped(places_mm, deviations_mm, LEAST_GROUP)
        .ok_or(UncertaintyError::TooFewPoints { used: places_mm.len(), needed: LEAST_GROUP })
}

/// By groups of `least` points at least; `None` without one.
fn grouped(places_mm: &[[f64; 2]], deviations_mm: &[f64], least: usize) -> Option<Scatter> {
    let mut order: Vec<usize> = (0..places_mm.len()).collect();
    let mut groups = Vec::new();
    split(&mut order, places_mm, least, &mut groups);
    let stride = groups.len().div_ceil(MOST_GROUPS).max(1);
    let chosen: Vec<&Vec<usize>> = groups.iter().step_by(stride).collect();
    let of_group = |group: &&Vec<usize>| left_over(group, places_mm, deviations_mm);
    let found: Vec<(f64, usize)> = chosen.par_iter().filter_map(of_group).collect();
    if found.is_empty() {
        return None;
    }
    let medians: Vec<f64> =
        (0..2 * least).map(|dof| chi_square_median(dof.max(1) as f64)).collect();
    let mut variances: Vec<f64> =
        found.iter().map(|&(square, dof)| square / medians[dof]).collect();
    variances.sort_unstable_by(f64::total_cmp);
    let count = variances.len();
    let median = 0.5 * (variances[(count - 1) / 2] + variances[count / 2]);
    // The variance of a median is 1/(4·count·density²); that of a χ² over ν, 2/ν. A single group is no median.
    let density =
        found.iter().map(|&(_, dof)| medians[dof] * chi_square_density(medians[dof], dof as f64));
    let density = density.sum::<f64>() / count as f64;
    let all: usize = found.iter().map(|&(_, dof)| dof).sum();
    let dof = (8.0 * count as f64 * density * density).min(all as f64);
    Some(Scatter { sigma_mm: median.sqrt(), dof })
}

/// How much of the variance of the noise found may be form, in mm²; 0 where groups of more points tell of none.
///
/// What a quadratic misses of smooth form adds to the variance of a group by the third power of its number of points: 8 times as
/// much where that is doubled. So what groups twice as large have more tells what the smallest have, and groups four times
/// as large whether it goes by that power. Form that is as fine as the groups grows less: then more of the noise may be form,
/// all of it where it does not grow.
pub(crate) fn by_form_mm2(places_mm: &[[f64; 2]], deviations_mm: &[f64], found: &Scatter) -> f64 {
    let of = |times: usize| {
        let least = times * LEAST_GROUP;
        grouped(places_mm, deviations_mm, least).map(|of| of.sigma_mm.powi(2))
    };
    let smallest = found.sigma_mm * found.sigma_mm;
    let (Some(twice), fourfold) = (of(2), of(4)) else { return 0.0 };
    let more = twice - smallest;
    if more <= PLAINLY * smallest * (2.0 / found.dof).sqrt() {
        return 0.0;
    }
    let growth = fourfold.map_or(1.0, |fourfold| (fourfold - twice) / more);
    (more / (growth.min(8.0) - 1.0).max(f64::MIN_POSITIVE)).min(smallest)
}

/// Halves at the median of the longer extent, down to groups of `least` to just below twice that.
pub(super) fn split(
    order: &mut [usize],
    places_mm: &[[f64; 2]],
    least: usize,
    groups: &mut Vec<Vec<usize>>,
) {
    if order.len() < 2 * least {
        if order.len() >= least {
            groups.push(order.to_vec());
        }
        return;
    }
    let (low, high) = halve(order, places_mm);
    split(low, places_mm, least, groups);
    split(high, places_mm, least, groups);
}

/// Sum of the squares of what a quadratic leaves of a group, and its degrees of freedom.
fn left_over(
    group: &[usize],
    places_mm: &[[f64; 2]],
    deviations_mm: &[f64],
) -> Option<(f64, usize)> {
    let quadratic = quadratic(group, places_mm, deviations_mm)?;
    let dof = group.len().checked_sub(quadratic.determined).filter(|&dof| dof > 0)?;
    Some((quadratic.left_mm2, dof))
}

/// A quadratic laid into the deviations of a group.
pub(super) struct Quadratic {
    /// Coefficients of 1, x, y, x², xy, y² about the middle of the group, in mm and powers of 1/mm; 0 where the places do not
    /// determine one.
    pub(super) coefficients: [f64; 6],
    /// How many they determine.
    pub(super) determined: usize,
    /// Middle of the group.
    centre_mm: [f64; 2],
    /// Mean of the deviations, which the coefficients are from.
    level: f64,
    /// Sum of the squares of what it leaves.
    left_mm2: f64,
}

impl Quadratic {
    /// Coefficients of the deviations themselves about another place.
    pub(super) fn about(&self, place_mm: [f64; 2]) -> [f64; 6] {
        let [x, y] = [0, 1].map(|axis| place_mm[axis] - self.centre_mm[axis]);
        let [c, cx, cy, xx, xy, yy] = self.coefficients;
        let value = self.level + c + cx * x + cy * y + xx * x * x + xy * x * y + yy * y * y;
        [value, cx + 2.0 * xx * x + xy * y, cy + xy * x + 2.0 * yy * y, xx, xy, yy]
    }
}

/// `None` where a number is not finite. The order in which a selection leaves a group must not show in the bits, so
/// the group is sorted first.
pub(super) fn quadratic(
    group: &[usize],
    places_mm: &[[f64; 2]],
    deviations_mm: &[f64],
) -> Option<Quadratic> {
    let mut group = group.to_vec();
    group.sort_unstable();
    let count = group.len() as f64;
    let centre: [f64; 2] =
        std::array::from_fn(|axis| group.iter().map(|&i| places_mm[i][axis]).sum::<f64>() / count);
    let level = group.iter().map(|&i| deviations_mm[i]).sum::<f64>() / count;
    let mut triangle = Triangle::new(7);
    for &i in &group {
        let (x, y) = (places_mm[i][0] - centre[0], places_mm[i][1] - centre[1]);
        triangle.push(&[1.0, x, y, x * x, x * y, y * y, deviations_mm[i] - level]);
    }
    triangle.flush();
    if !triangle.is_finite() {
        return None;
    }
    let system = System::new(&triangle);
    let one_by_one: Vec<Vec<usize>> = (0..6).map(|column| vec![column]).collect();
    let whole = system.solve(&[0, 1, 2, 3, 4, 5], 0.0);
    let (kept, step) = if whole.condition * RANK_TOLERANCE < 1.0 {
        (vec![0, 1, 2, 3, 4, 5], whole)
    } else {
        let kept = system.determinate(&one_by_one, RANK_TOLERANCE);
        let step = system.solve(&kept, 0.0);
        (kept, step)
    };
    let mut change = [0.0; 6];
    kept.iter().zip(&step.change).for_each(|(&column, &value)| change[column] = value);
    // The step takes the deviations to zero: the quadratic is its negative.
    Some(Quadratic {
        coefficients: change.map(|value| -value),
        determined: kept.len(),
        centre_mm: centre,
        level,
        left_mm2: system.square_after(&change),
    })
}

/// Twice the coefficients of a quadratic.
const LEAST_GROUP: usize = 12;
/// Groups looked at: 4096 tell a standard deviation to half a percent.
const MOST_GROUPS: usize = 4096;
/// As where a line or a lattice does not determine a quadratic.
const RANK_TOLERANCE: f64 = 1e-6;
/// Standard deviations from which on larger groups tell of form.
const PLAINLY: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_geometry::Numbers;

    fn places(count: usize) -> Vec<[f64; 2]> {
        (0..count)
            .map(|i| {
                let (r, phi) = (10.0 * (i as f64 / count as f64).sqrt(), 2.399_963 * i as f64);
                [r * phi.cos(), r * phi.sin()]
            })
            .collect()
    }

    fn noise(count: usize, sigma_mm: f64, seed: u64) -> Vec<f64> {
        let numbers = Numbers::new(seed, 0, 0);
        (0..count).map(|i| sigma_mm * numbers.normal(i)).collect()
    }

    #[test]
    fn form_steps_and_spikes_are_no_noise() {
        let places = places(4000);
        let deviations: Vec<f64> = places
            .iter()
            .zip(noise(4000, 10e-6, 1))
            .enumerate()
            .map(|(i, (&[x, y], noise))| {
                let step = if x > 3.0 { 2e-3 } else { 0.0 };
                let spike = if i % 200 == 7 { 1e-2 } else { 0.0 };
                noise + step + spike + 1e-3 * (0.5 * x).sin() * (0.4 * y).cos()
            })
            .collect();
        let found = scatter(&places, &deviations).unwrap();
        assert!((found.sigma_mm / 10e-6 - 1.0).abs() < 0.1, "{found:?}");
        let smooth = places.iter().map(|[x, y]| 1e-3 * (x * y + x * x)).collect::<Vec<_>>();
        assert!(scatter(&places, &smooth).unwrap().sigma_mm < 1e-15);
    }

    /// Waves 8 spacings long raise what is taken for noise; of none nothing is told.
    #[test]
    fn form_that_counts_as_noise_is_told() {
        let places = places(1200);
        let spacing_mm = 10.0 * (std::f64::consts::PI / 1200.0).sqrt();
        for (wave, is_told) in [(0.0, false), (4.0, true)] {
            let turns = std::f64::consts::TAU / (7.0 * spacing_mm);
            let deviations: Vec<f64> = places
                .iter()
                .zip(noise(1200, 1.0, 3))
                .map(|([x, y], noise)| noise + wave * (turns * x).sin() * (0.7 * turns * y).cos())
                .collect();
            let found = scatter(&places, &deviations).unwrap();
            let by_form = by_form_mm2(&places, &deviations, &found);
            assert_eq!(by_form > 0.0, is_told, "{by_form}");
            let more = found.sigma_mm.powi(2) - 1.0;
            assert!(more < 0.15 + 2.0 * by_form, "{more} {by_form}");
        }
    }

    /// Over 400 samples the variance scatters as its degrees of freedom say: that of a variance is 2/ν, and its
    /// own scatter over 400 samples is 7 %.
    #[test]
    fn degrees_of_freedom_are_those_of_the_scatter() {
        let places = places(1000);
        let found: Vec<Scatter> =
            (0..400).map(|seed| scatter(&places, &noise(1000, 1.0, seed)).unwrap()).collect();
        let variances: Vec<f64> = found.iter().map(|found| found.sigma_mm.powi(2)).collect();
        let mean = variances.iter().sum::<f64>() / 400.0;
        let scatter = variances.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 399.0;
        assert!((mean - 1.0).abs() < 0.015, "{mean}");
        let ratio = scatter / (2.0 / found[0].dof);
        assert!((ratio - 1.0).abs() < 0.25, "{ratio} {}", found[0].dof);
    }

    #[test]
    fn lines_lattices_and_few_points() {
        let line: Vec<[f64; 2]> = (0..600).map(|i| [f64::from(i), 0.0]).collect();
        let lattice: Vec<[f64; 2]> =
            (0..900).map(|i| [f64::from(i % 30), f64::from(i / 30)]).collect();
        for places in [line, lattice, vec![[1.0, 2.0]; 700]] {
            let found = scatter(&places, &noise(places.len(), 3.0, 9)).unwrap();
            assert!((found.sigma_mm / 3.0 - 1.0).abs() < 0.15, "{found:?}");
        }
        let few = scatter(&[[0.0; 2]; 11], &[0.0; 11]);
        assert_eq!(few, Err(UncertaintyError::TooFewPoints { used: 11, needed: 12 }));
    }
}
