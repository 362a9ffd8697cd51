//! Filters as linear maps: what a scale-limited surface keeps of functions over some places, and of noise.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::cells::Cells;
use super::datum::MeanPlane;
use super::regression::{MOMENTS, Sums, TERMS, terms_of};
use super::surface::{Nodes, Support};
use super::{Datum, Gaussian, Order, Scale};

/// Functions over places: a row a place, an entry a function.
pub(crate) type Functions = Vec<Vec<f64>>;

/// What noise that is independent from point to point leaves in a scale-limited surface, borders aside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NoiseLeft {
    /// Its variance over that of the noise: g = a·∫T², with T the share that passes and a the area of a point; above 0
    /// up to 1. As far as first orders go, g of the points are independent.
    pub(crate) variance: f64,
    /// a·∫T⁴. The sum of the squares varies as that of g²/q of the points would.
    pub(crate) square: f64,
}

impl Scale {
    /// What is left of functions over places that stand for `areas`, by `f_operation`, the filters and the `datum`
    /// at the end. Robust filters count as the linear ones. `O(k·m)` a place for k places within the window and m
    /// functions.
    pub(crate) fn of_functions(
        &self,
        places_mm: &[[f64; 2]],
        areas: &[f64],
        functions: Functions,
        [f_operation, datum]: [Datum; 2],
    ) -> Functions {
        let smooth = levelled(places_mm, areas, functions, f_operation);
        let smooth = match &self.s {
            Some(filter) => filter.of_functions(places_mm, areas, &smooth),
            None => smooth,
        };
        let Some(filter) = &self.l else { return levelled(places_mm, areas, smooth, datum) };
        let long = filter.of_functions(places_mm, areas, &smooth);
        let pairs = smooth.into_iter().zip(long);
        let less = |(smooth, long): (Vec<f64>, Vec<f64>)| {
            smooth.iter().zip(long).map(|(smooth, long)| smooth - long).collect()
        };
        levelled(places_mm, areas, pairs.map(less).collect(), datum)
    }

    /// For points that stand for `area_mm2` each: their noise has all frequencies of a disc of 1/area, and no others.
    pub(crate) fn of_noise(&self, area_mm2: f64) -> NoiseLeft {
        if self.s.is_none() && self.l.is_none() {
            return NoiseLeft { variance: 1.0, square: 1.0 };
        }
        // Over the square of the frequency, in shares of that disc, by midpoints in the frequency.
        let [mut variance, mut square] = [0.0; 2];
        for step in 0..STEPS {
            let [low, high] = [step, step + 1].map(|step| step as f64 / STEPS as f64);
            let middle = 0.5 * (low + high);
            let passed = self.passed(middle * middle / (PI * area_mm2)).powi(2);
            let share = high * high - low * low;
            variance += share * passed;
            square += share * passed * passed;
        }
        NoiseLeft { variance, square }
    }

    /// The share of a wave that passes, by the square of its frequency in mm⁻².
    fn passed(&self, frequency_per_mm2: f64) -> f64 {
        let s = self.s.map_or(1.0, |filter| filter.passed(frequency_per_mm2));
        let l = self.l.map_or(0.0, |filter| filter.passed(frequency_per_mm2));
        s * (1.0 - l)
    }
}

impl Gaussian {
    /// [`Gaussian::of_mesh`] for many functions at once: their weights are the same.
    fn of_functions(
        &self,
        places_mm: &[[f64; 2]],
        areas: &[f64],
        functions: &Functions,
    ) -> Functions {
        let (unit_mm, window_mm) = (self.unit_mm(), self.window_mm());
        let cells = Cells::new(places_mm, window_mm);
        let terms = terms_of(self.order(), true, true);
        let of_place = |index: usize| {
            let [x, y] = places_mm[index];
            let near = cells.near([x, y]).filter_map(|other| {
                let [u, v] = [places_mm[other][0] - x, places_mm[other][1] - y];
                let square_mm2 = u * u + v * v;
                if areas[other] <= 0.0 || square_mm2 > window_mm * window_mm {
                    return None;
                }
                let [u, v] = [u / unit_mm, v / unit_mm];
                Some((other, areas[other] * (-PI * (u * u + v * v)).exp(), [u, v]))
            });
            let near: Vec<(usize, f64, [f64; 2])> = near.collect();
            let mut sums = Sums::default();
            for (_, weight, [u, v]) in &near {
                for (sum, &(i, j)) in sums.moments.iter_mut().zip(&MOMENTS) {
                    *sum += weight * u.powi(i as i32) * v.powi(j as i32);
                }
            }
            let Some(answer) = sums.answer(&terms) else { return functions[index].clone() };
            let mut found = vec![0.0; functions[index].len()];
            for (other, weight, [u, v]) in near {
                let at = |&(i, j): &(usize, usize)| u.powi(i as i32) * v.powi(j as i32);
                let gain: f64 = answer.iter().zip(&TERMS).map(|(of, term)| of * at(term)).sum();
                let gain = weight * gain;
                for (sum, value) in found.iter_mut().zip(&functions[other]) {
                    *sum += gain * value;
                }
            }
            found
        };
        (0..places_mm.len()).into_par_iter().map(of_place).collect()
    }

    fn passed(&self, frequency_per_mm2: f64) -> f64 {
        let y = PI * self.unit_mm() * self.unit_mm() * frequency_per_mm2;
        match self.order() {
            Order::Zero => (-y).exp(),
            Order::Two => (1.0 + y) * (-y).exp(),
        }
    }
}

/// Every function about a datum of its own.
fn levelled(
    places_mm: &[[f64; 2]],
    areas: &[f64],
    mut functions: Functions,
    datum: Datum,
) -> Functions {
    let all: f64 = areas.iter().sum();
    if datum == Datum::AsGiven || functions.is_empty() || all <= 0.0 {
        return functions;
    }
    let mut nodes = Nodes {
        places_mm: places_mm.to_vec(),
        heights_nm: vec![0.0; places_mm.len()],
        shares: areas.iter().map(|area| area / all).collect(),
        support: Support { points: places_mm.len(), measured: 1.0, datum },
    };
    for function in 0..functions[0].len() {
        for (height, row) in nodes.heights_nm.iter_mut().zip(&functions) {
            *height = row[function];
        }
        let plane = MeanPlane::new(&nodes, datum);
        for (row, &place) in functions.iter_mut().zip(places_mm) {
            row[function] -= plane.height_nm(place);
        }
    }
    functions
}

/// Steps of the frequency: the last wave of 4 points is told by 256.
const STEPS: usize = 512;

#[cfg(test)]
mod tests {
    use super::super::Mesh;
    use super::*;
    use crate::uncertainty::Numbers;

    /// A lattice of 60 by 60 with its triangles, 0.1 mm apart.
    fn lattice(height_nm: impl Fn(usize, [f64; 2]) -> f64) -> Mesh {
        let at = |i: usize| [0.1 * (i % SIDE) as f64, 0.1 * (i / SIDE) as f64];
        let points: Vec<[f64; 3]> = (0..SIDE * SIDE)
            .map(|i| {
                let [x, y] = at(i);
                [x, y, 1e-6 * height_nm(i, [x, y])]
            })
            .collect();
        let corner = |i: usize| i as u32;
        let cells = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE);
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|i| [[i, i + 1, i + SIDE], [i + 1, i + SIDE + 1, i + SIDE]])
            .map(|corners| corners.map(corner))
            .collect();
        Mesh::new(&points, &triangles).unwrap()
    }

    fn scale(s_mm: Option<f64>, l_mm: Option<f64>, order: Order) -> Scale {
        let filter = |mm: f64| Gaussian::new(mm, order).unwrap();
        Scale::new(s_mm.map(filter), l_mm.map(filter)).unwrap()
    }

    #[test]
    fn functions_are_filtered_as_meshes_are() {
        let wave = |_: usize, [x, y]: [f64; 2]| 30.0 * (1.3 * x + 0.4 * y).sin() + 5.0 * x * y;
        let other = |i: usize, _: [f64; 2]| (i * 7919 % 101) as f64;
        for order in [Order::Zero, Order::Two] {
            let scale = scale(Some(0.4), Some(1.5), order);
            let meshes = [lattice(wave), lattice(other)];
            let mesh = &meshes[0];
            let rows = meshes[0].heights_nm().zip(meshes[1].heights_nm());
            let rows = rows.map(|(a, b)| vec![a.unwrap(), b.unwrap()]).collect();
            let kinds = [Datum::MeanPlane, Datum::Mean];
            let found = scale.of_functions(mesh.places_mm(), mesh.areas_mm2(), rows, kinds);
            for (column, mesh) in meshes.iter().enumerate() {
                let truth = scale.of_mesh(mesh, Datum::MeanPlane).surface.levelled(Datum::Mean);
                for (row, truth) in found.iter().zip(truth.heights_nm()) {
                    assert!((row[column] - truth.unwrap()).abs() < 1e-9, "{order:?}");
                }
            }
        }
    }

    /// The variance of filtered noise away from the border, over 8 lattices of noise.
    #[test]
    fn noise_is_left_as_its_frequencies_pass() {
        for (s_mm, l_mm) in
            [(None, None), (None, Some(1.0)), (Some(0.5), None), (Some(0.5), Some(1.6))]
        {
            for order in [Order::Zero, Order::Two] {
                let scale = scale(s_mm, l_mm, order);
                let told = scale.of_noise(0.01);
                let (mut sum, mut count) = (0.0, 0.0);
                for seed in 0..8 {
                    let numbers = Numbers::new(seed, 0, 0);
                    let mesh = lattice(|i, _| numbers.normal(i));
                    let left = scale.of_mesh(&mesh, Datum::AsGiven).surface;
                    for (i, height) in left.heights_nm().enumerate() {
                        let inside = |at: usize| (18..42).contains(&at);
                        if inside(i % SIDE) && inside(i / SIDE) {
                            sum += height.unwrap().powi(2);
                            count += 1.0;
                        }
                    }
                }
                let ratio = sum / count / told.variance;
                assert!((ratio - 1.0).abs() < 0.12, "{s_mm:?} {l_mm:?} {order:?}: {ratio}");
                assert!(told.square <= told.variance && told.variance <= 1.0 + 1e-12);
            }
        }
    }

    const SIDE: usize = 60;
}
