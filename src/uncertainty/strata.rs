//! The area of a part shared out among its points: strata of neighbours and the area each of them stands for.
//!
//! The places are halved at the median of their longer extent until 8 to 15 points, or a part in 8192, are left. The area
//! of a stratum is what of the aperture lies on its side of all cuts, no farther from its points than half their extent: what
//! was not measured belongs to nobody. It is counted by nodes of an additive recurrence, which fill any box evenly
//! (Roberts, The unreasonable effectiveness of quasirandom sequences, 2018: the plastic number). Within a stratum points
//! weigh so that their middle is that of the area: what rises evenly over it has the mean it has over the area (the
//! regression estimator: Cochran, Sampling Techniques, 3rd ed., 7.2).

use asphera_geometry::BoundsMm;
use nalgebra::{Matrix2, Vector2};

use super::halve::{halve, longer_side};
use asphera_form::Aperture;

/// Neighbours, and the share of the area they stand for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stratum {
    /// In ascending order.
    pub(super) members: Vec<usize>,
    /// What each of them stands for of the stratum, above 0 or, without an area, 0: they add up to 1.
    pub(super) weights: Vec<f64>,
    /// All shares add up to 1.
    pub(super) share: f64,
    /// Places of the members.
    pub(super) places_mm: Vec<[f64; 2]>,
    /// Share of an even rise over the stratum that the weights leave in its mean, from 0 to 1.
    pub(super) rise_left: f64,
    /// Middle of its area.
    pub(super) middle_mm: [f64; 2],
    /// Means over the area of the products of [`terms`] about its middle, less those by the weights; 0 where it is not known.
    pub(super) bends_left: Products,
}

/// Products of six terms in mm and its powers.
pub(super) type Products = [[f64; 6]; 6];

/// Terms of a quadratic: 1, x, y, x², xy, y².
fn terms([x, y]: [f64; 2]) -> [f64; 6] {
    [1.0, x, y, x * x, x * y, y * y]
}

impl Stratum {
    /// What a variance within the stratum makes of that of a mean over the area.
    pub(super) fn weight(&self) -> f64 {
        let crowding: f64 = self.weights.iter().map(|weight| weight * weight).sum();
        self.share * self.share * crowding
    }

    /// Variance of values of its members, in their order, as it goes into the mean by the weights: about an even rise, as far
    /// as the weights take that off. 0 of one value.
    pub(super) fn variance(&self, values: &[f64]) -> f64 {
        let count = values.len() as f64;
        let mean = |of: &dyn Fn(usize) -> f64| (0..values.len()).map(of).sum::<f64>() / count;
        let middle = mean(&|at| values[at]);
        let square = count * mean(&|at| (values[at] - middle).powi(2));
        let plain = square / (count - 1.0).max(1.0);
        let origin = [0, 1].map(|axis| mean(&|at| self.places_mm[at][axis]));
        let off = |at: usize, axis: usize| self.places_mm[at][axis] - origin[axis];
        let moment = |i: usize, j: usize| count * mean(&|at| off(at, i) * off(at, j));
        let along = |axis: usize| count * mean(&|at| off(at, axis) * values[at]);
        let gram = Matrix2::new(moment(0, 0), moment(0, 1), moment(0, 1), moment(1, 1));
        let pull = Vector2::new(along(0), along(1));
        let is_told =
            count >= LEAST_FOR_RISE && gram.determinant() > FLAT * (0.5 * gram.trace()).powi(2);
        let Some(rise) = gram.try_inverse().filter(|_| is_told).map(|inverse| inverse * pull)
        else {
            return plain;
        };
        let left = (square - rise.dot(&pull)).max(0.0) / (count - 3.0);
        let rise_left = self.rise_left.max(RISE_LEAST);
        left + rise_left * rise_left * (plain - left).max(0.0)
    }
}

/// Strata of the places at `indices`. `areas_mm2` has the area of each place, and counts where there is no aperture; without
/// it all count alike there. Empty without a place. `O(n log n)`.
pub(super) fn strata(
    indices: &[usize],
    places_mm: &[[f64; 2]],
    aperture: &Aperture,
    areas_mm2: Option<&[f64]>,
) -> Vec<Stratum> {
    if indices.is_empty() {
        return Vec::new();
    }
    let least = LEAST.max(indices.len() / MOST);
    let mut order = indices.to_vec();
    let mut nodes = match aperture {
        Aperture::None => Vec::new(),
        _ => nodes(indices, places_mm, aperture, NODES * indices.len() / least),
    };
    let mut found = part(&mut order, &mut nodes, places_mm, least);
    if *aperture == Aperture::None {
        let area = |index: &usize| areas_mm2.map_or(1.0, |areas_mm2| areas_mm2[*index]);
        for stratum in &mut found {
            stratum.share = stratum.members.iter().map(area).sum();
            if stratum.share > 0.0 {
                let weights = stratum.members.iter().map(|index| area(index) / stratum.share);
                stratum.weights = weights.collect();
            }
            // A mesh, which the areas are of, takes an even rise as it is.
            stratum.rise_left = if areas_mm2.is_some() { 0.0 } else { 1.0 };
        }
    }
    let all: f64 = found.iter().map(|stratum| stratum.share).sum();
    for stratum in &mut found {
        stratum.share = if all > 0.0 {
            stratum.share / all
        } else {
            stratum.members.len() as f64 / indices.len() as f64
        };
    }
    found
}

/// Some `count` nodes spread evenly over the box of the places and a margin, those inside the aperture.
fn nodes(
    indices: &[usize],
    places_mm: &[[f64; 2]],
    aperture: &Aperture,
    count: usize,
) -> Vec<[f64; 2]> {
    let [low, high] = extent(indices, places_mm);
    let margin = 0.5 * (high[0] - low[0]).max(high[1] - low[1]) / (indices.len() as f64).sqrt();
    let margin = margin * (LEAST as f64).sqrt();
    let node = |number: usize| {
        [0, 1].map(|axis| {
            let share = (number as f64 * STEPS[axis] + 0.5).fract();
            low[axis] - margin + share * (high[axis] - low[axis] + 2.0 * margin)
        })
    };
    (1..=count).map(node).filter(|&[x, y]| aperture.contains(x, y)).collect()
}

/// Halves places and nodes by the same cuts. The share of a stratum is how many nodes it has.
fn part(
    order: &mut [usize],
    nodes: &mut [[f64; 2]],
    places_mm: &[[f64; 2]],
    least: usize,
) -> Vec<Stratum> {
    if order.len() < 2 * least {
        let [low, high] = extent(order, places_mm);
        let reach = 0.5 * (high[0] - low[0]).max(high[1] - low[1]);
        let is_near = |node: &&[f64; 2]| {
            (0..2).all(|i| node[i] >= low[i] - reach && node[i] <= high[i] + reach)
        };
        let nodes: Vec<[f64; 2]> = nodes.iter().filter(is_near).copied().collect();
        return vec![stratum(order, &nodes, places_mm)];
    }
    let (axis, _) = longer_side(order, places_mm);
    let (low, high) = halve(order, places_mm);
    let most = low.iter().fold(f64::NEG_INFINITY, |most, &at| most.max(places_mm[at][axis]));
    let least_high = high.iter().fold(f64::INFINITY, |least, &at| least.min(places_mm[at][axis]));
    let cut = 0.5 * (most + least_high);
    let (mut first, mut last) = (0, nodes.len());
    while first < last {
        if nodes[first][axis] < cut {
            first += 1;
        } else {
            last -= 1;
            nodes.swap(first, last);
        }
    }
    let (below, above) = nodes.split_at_mut(first);
    let (mut found, more) =
        rayon::join(|| part(low, below, places_mm, least), || part(high, above, places_mm, least));
    found.extend(more);
    found
}

/// Stratum of these places and of the nodes of its area.
fn stratum(order: &[usize], nodes: &[[f64; 2]], places_mm: &[[f64; 2]]) -> Stratum {
    let share = nodes.len() as f64;
    let mut members = order.to_vec();
    members.sort_unstable();
    let mean = |axis: usize| nodes.iter().map(|node| node[axis]).sum::<f64>() / share;
    let middle = (share > 0.0).then(|| [0, 1].map(mean));
    let (weights, rise_left) = weights(&members, places_mm, middle);
    let places_mm: Vec<[f64; 2]> = members.iter().map(|&at| places_mm[at]).collect();
    let middle_mm = middle.unwrap_or_default();
    let mut bends_left = [[0.0; 6]; 6];
    let mut add = |place: &[f64; 2], weight: f64| {
        let terms = terms([0, 1].map(|axis| place[axis] - middle_mm[axis]));
        for (row, one) in bends_left.iter_mut().zip(&terms) {
            row.iter_mut().zip(&terms).for_each(|(sum, other)| *sum += weight * one * other);
        }
    };
    if middle.is_some() {
        nodes.iter().for_each(|node| add(node, share.recip()));
        places_mm.iter().zip(&weights).for_each(|(place, weight)| add(place, -weight));
    }
    Stratum { members, weights, share, places_mm, rise_left, middle_mm, bends_left }
}

/// Weights that add up to 1, as alike as can be, by which the middle of the places is `middle`, or as near to it as it gets with
/// no weight below a tenth of their mean; and the share of the way to it that is left. All of it is without a middle.
fn weights(members: &[usize], places_mm: &[[f64; 2]], middle: Option<[f64; 2]>) -> (Vec<f64>, f64) {
    let count = members.len() as f64;
    let mean =
        [0, 1].map(|axis| members.iter().map(|&at| places_mm[at][axis]).sum::<f64>() / count);
    let off = members.iter().map(|&at| [0, 1].map(|axis| places_mm[at][axis] - mean[axis]));
    let off: Vec<[f64; 2]> = off.collect();
    let wanted = middle.map_or([0.0; 2], |middle| [0, 1].map(|axis| middle[axis] - mean[axis]));
    let moment = |i: usize, j: usize| off.iter().map(|off| off[i] * off[j]).sum::<f64>();
    let gram = Matrix2::new(moment(0, 0), moment(0, 1), moment(0, 1), moment(1, 1));
    let eigen = gram.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut more = vec![0.0; members.len()];
    for (&value, axis) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        // Places on a line tell nothing across it.
        if value > FLAT * largest {
            let along = |of: &[f64; 2]| of[0] * axis[0] + of[1] * axis[1];
            let rate = along(&wanted) / value;
            more.iter_mut().zip(&off).for_each(|(more, off)| *more += rate * along(off));
        }
    }
    let least = more.iter().copied().fold(0.0, f64::min);
    let allowed = if least < 0.0 { (LARGEST_LOSS / (count * -least)).min(1.0) } else { 1.0 };
    let weights = more.iter().map(|more| 1.0 / count + allowed * more).collect();
    (weights, if middle.is_some() { 1.0 - allowed } else { 1.0 })
}

/// Smallest and largest coordinates.
fn extent(indices: &[usize], places_mm: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let BoundsMm { low, high } = BoundsMm::about(indices.iter().map(|&index| places_mm[index]));
    [low, high]
}

/// Fewest points of a stratum, where there are so many.
const LEAST: usize = 8;
/// So many strata at most, but for a factor of 2.
const MOST: usize = 8192;
/// Places whose extent one way is the root of this of that the other way lie on a line.
const FLAT: f64 = 1e-3;
/// Share of an even rise that counts at least, as the middle of the area of so few points is known to that only: so chosen that
/// intervals of 300 to 1,200 scattered points hold what they say (`measure/interval_study.rs`).
const RISE_LEAST: f64 = 0.7;
/// Fewer values do not tell how they scatter about an even rise.
const LEAST_FOR_RISE: f64 = 6.0;
/// The share of its weight that a point may lose.
const LARGEST_LOSS: f64 = 0.9;
/// Nodes a stratum.
const NODES: usize = 64;
/// 1/ρ and 1/ρ² of the plastic number ρ, the root of ρ³ = ρ + 1.
const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_geometry::Numbers;

    fn scattered(count: usize) -> Vec<[f64; 2]> {
        let numbers = Numbers::new(4, 0, 0);
        let place = |i: usize| [0, 1].map(|axis| 2.0 * numbers.uniform(2 * i + axis) - 1.0);
        (0..).map(place).filter(|[x, y]| x.hypot(*y) <= 1.0).take(count).collect()
    }

    /// Means over the area of x⁴ and r⁸: 1/8 and 1/5. Scattered places alone tell them to 0.9 % and 1.5 %.
    #[test]
    fn shares_make_means_over_the_area() {
        let places = scattered(4000);
        let indices: Vec<usize> = (0..4000).collect();
        let aperture = Aperture::Circle { radius_mm: 1.0 };
        let of = |function: &dyn Fn([f64; 2]) -> f64| -> f64 {
            let strata = strata(&indices, &places, &aperture, None);
            let mean = |of: &Stratum| {
                let each = of.members.iter().zip(&of.weights);
                each.map(|(&i, weight)| weight * function(places[i])).sum::<f64>()
            };
            strata.iter().map(|stratum| stratum.share * mean(stratum)).sum()
        };
        assert!((of(&|[x, _]| x.powi(4)) / 0.125 - 1.0).abs() < 3e-3);
        assert!((of(&|[x, y]| x.hypot(y).powi(8)) / 0.2 - 1.0).abs() < 4e-3);
    }

    /// A half that was not measured belongs to nobody: else the strata beside it would have four times their share.
    #[test]
    fn what_was_not_measured_is_shared_by_nobody() {
        let places: Vec<[f64; 2]> = scattered(4000).into_iter().filter(|[x, _]| *x < 0.0).collect();
        let indices: Vec<usize> = (0..places.len()).collect();
        let strata = strata(&indices, &places, &Aperture::Circle { radius_mm: 1.0 }, None);
        let is_near = |of: &&Stratum| of.members.iter().any(|&i| places[i][0] > -0.02);
        let near: Vec<&Stratum> = strata.iter().filter(is_near).collect();
        let share: f64 = near.iter().map(|of| of.share).sum();
        let points: usize = near.iter().map(|of| of.members.len()).sum();
        let more = share / (points as f64 / places.len() as f64);
        assert!((1.0..2.0).contains(&more), "{more}");
        let sum: f64 = strata.iter().map(|of| of.share).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        let sums = strata.iter().map(|of| of.weights.iter().sum::<f64>());
        assert!(sums.into_iter().all(|sum| (sum - 1.0).abs() < 1e-12));
    }

    #[test]
    fn without_an_aperture_the_areas_count_and_else_all_points_alike() {
        let places = scattered(100);
        let indices: Vec<usize> = (0..100).collect();
        let areas: Vec<f64> = places.iter().map(|[x, _]| 1.0 + x).collect();
        for (areas, of) in [(None, vec![1.0; 100]), (Some(&areas[..]), areas.clone())] {
            let all: f64 = of.iter().sum();
            for stratum in strata(&indices, &places, &Aperture::None, areas) {
                let share: f64 = stratum.members.iter().map(|&i| of[i] / all).sum();
                assert!((stratum.share - share).abs() < 1e-12);
            }
        }
        assert!(strata(&[], &places, &Aperture::None, None).is_empty());
    }
}
