//! Filters as linear maps: what a scale-limited surface keeps of functions over some places, and of noise.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::cells::Cells;
use super::datum::MeanPlane;
use super::regression::{MOMENTS, Sums, TERMS, terms_of};
use super::surface::{Nodes, Support};
use super::{Datum, Gaussian, Order, Scale};

/// Functions over places: a row a place, an entry a function.
pub type Functions = Vec<Vec<f64>>;

/// What noise that is independent from point to point leaves in a scale-limited surface, borders aside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseLeft {
    /// Its variance over that of the noise: g = a·∫T², with T the share that passes and a the area of a point; above 0
    /// up to 1. As far as first orders go, g of the points are independent.
    pub variance: f64,
    /// a·∫T⁴. The sum of the squares varies as that of g²/q of the points would.
    pub square: f64,
}

impl Scale {
    /// Remainder of functions over places that stand for `areas`, by `f_operation`, the filters and the `datum`
    /// at the end. Robust filters count as the linear ones. `O(k·m)` a place for k places within the window and m
    /// functions.
    pub fn of_functions(
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
    pub fn of_noise(&self, area_mm2: f64) -> NoiseLeft {
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

    /// The variance that is left at the places `at` of noise of variance 1, the border regarded: a quadric rests on few
    /// neighbours there and passes far more. `None` without an S-filter, which alone makes a difference. Of many neighbours
    /// some stand for all.
    pub fn of_noise_at(
        &self,
        places_mm: &[[f64; 2]],
        areas_mm2: &[f64],
        at: &[usize],
    ) -> Option<Vec<f64>> {
        let filter = self.s?;
        let mean_mm2 = areas_mm2.iter().sum::<f64>() / areas_mm2.len() as f64;
        let within = PI * filter.window_mm() * filter.window_mm() / mean_mm2;
        let step = (within / MOST_NEIGHBOURS).ceil().max(1.0) as usize;
        let some = |step: usize| (0..places_mm.len()).step_by(step);
        let thinned_mm: Vec<[f64; 2]> = some(step).map(|i| places_mm[i]).collect();
        let areas: Vec<f64> = some(step).map(|i| areas_mm2[i]).collect();
        let cells = Cells::new(&thinned_mm, filter.window_mm());
        let of_place = |&index: &usize| {
            let near = filter.neighbours(&cells, &areas, places_mm[index]);
            let gains = filter.gains(&near)?;
            Some(gains.iter().map(|gain| gain * gain).sum::<f64>() / step as f64)
        };
        let short = Scale { s: self.s, l: None };
        let by_l = self.of_noise(mean_mm2).variance / short.of_noise(mean_mm2).variance;
        let found = at.par_iter().map(of_place).collect::<Vec<Option<f64>>>().into_iter();
        Some(found.map(|variance| by_l * variance.unwrap_or(1.0).min(1.0)).collect())
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
        let cells = Cells::new(places_mm, self.window_mm());
        let of_place = |index: usize| {
            let near = self.neighbours(&cells, areas, places_mm[index]);
            let Some(gains) = self.gains(&near) else { return functions[index].clone() };
            let mut found = vec![0.0; functions[index].len()];
            for (Neighbour { index: other, .. }, gain) in near.iter().zip(gains) {
                for (sum, value) in found.iter_mut().zip(&functions[*other]) {
                    *sum += gain * value;
                }
            }
            found
        };
        (0..places_mm.len()).into_par_iter().map(of_place).collect()
    }

    /// Samples within the window about a place.
    fn neighbours(&self, cells: &Cells<'_>, areas: &[f64], [x, y]: [f64; 2]) -> Vec<Neighbour> {
        let (unit_mm, window_mm) = (self.unit_mm(), self.window_mm());
        let near = cells.near([x, y]).filter_map(|index| {
            let place_mm = cells.place(index);
            let [u, v] = [place_mm[0] - x, place_mm[1] - y];
            if areas[index] <= 0.0 || u * u + v * v > window_mm * window_mm {
                return None;
            }
            let at = [u / unit_mm, v / unit_mm];
            let weight = areas[index] * (-PI * (at[0] * at[0] + at[1] * at[1])).exp();
            Some(Neighbour { index, weight, at })
        });
        near.collect()
    }

    /// What each of the neighbours counts in the value at the place; `None` if none has a weight.
    fn gains(&self, near: &[Neighbour]) -> Option<Vec<f64>> {
        let power =
            |[u, v]: [f64; 2], &(i, j): &(usize, usize)| u.powi(i as i32) * v.powi(j as i32);
        let mut sums = Sums::default();
        for Neighbour { weight, at, .. } in near {
            for (sum, exponents) in sums.moments.iter_mut().zip(&MOMENTS) {
                *sum += weight * power(*at, exponents);
            }
        }
        let answer = sums.answer(&terms_of(self.order(), true, true))?;
        let gain = |Neighbour { weight, at, .. }: &Neighbour| {
            let polynomial = answer.iter().zip(&TERMS).map(|(of, term)| of * power(*at, term));
            weight * polynomial.sum::<f64>()
        };
        Some(near.iter().map(gain).collect())
    }

    fn passed(&self, frequency_per_mm2: f64) -> f64 {
        let y = PI * self.unit_mm() * self.unit_mm() * frequency_per_mm2;
        match self.order() {
            Order::Zero => (-y).exp(),
            Order::Two => (1.0 + y) * (-y).exp(),
        }
    }
}

/// A place within the window of another.
struct Neighbour {
    index: usize,
    weight: f64,
    /// How far off, in units of the filter.
    at: [f64; 2],
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
/// Neighbours that tell what a filter makes of noise.
const MOST_NEIGHBOURS: f64 = 400.0;

#[cfg(test)]
mod tests {
    use asphera_geometry::Numbers;

    use super::super::Mesh;
    use super::*;

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

    /// At a corner, a border and inside, over 200 lattices of noise: a variance is then known to 10 %.
    #[test]
    fn at_the_border_more_noise_is_left() {
        let scale = scale(Some(0.6), None, Order::Two);
        let quiet = lattice(|_, _| 0.0);
        let at = [0, SIDE / 2, SIDE * SIDE / 2 + SIDE / 2];
        let told = scale.of_noise_at(quiet.places_mm(), quiet.areas_mm2(), &at).unwrap();
        let mut sums = [0.0; 3];
        for seed in 0..200 {
            let numbers = Numbers::new(seed, 0, 0);
            let noise = (0..SIDE * SIDE).map(|i| vec![numbers.normal(i)]).collect();
            let datums = [Datum::AsGiven; 2];
            let left = scale.of_functions(quiet.places_mm(), quiet.areas_mm2(), noise, datums);
            for (sum, index) in sums.iter_mut().zip(at) {
                *sum += left[index][0].powi(2) / 200.0;
            }
        }
        for (told, found) in told.iter().zip(sums) {
            assert!((found / told - 1.0).abs() < 0.35, "{told} {found}");
        }
        assert!(told[0] > 2.0 * told[1] && told[1] > 1.5 * told[2], "{told:?}");
        assert!((told[2] / scale.of_noise(0.01).variance - 1.0).abs() < 0.02, "{told:?}");
    }

    const SIDE: usize = 60;
}
