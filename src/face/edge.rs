//! The edge of material across a face: levels on both sides, blur, noise.

use std::f64::consts::TAU;

use asphera_form::Pose;
use asphera_surface::Plane;
use rayon::prelude::*;

use crate::body::{Body, Skin};
use crate::noise::{Noise, noise};
use asphera_geometry::vector::{Vector, dot, plus};

/// The edge across a face, from grey values along its normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Grey values inside and outside, beyond the blur.
    pub(crate) material: f64,
    pub(crate) background: f64,
    /// Fall of the grey value at the face, 1/mm; above 0.
    pub(crate) slope_per_mm: f64,
    /// Variance of the blur along the normal, mm².
    pub(crate) blur_mm2: f64,
    /// Standard deviation of a grey value where a crossing is interpolated, about the level of its patch, and its correlation length.
    pub(crate) noise: f64,
    pub(crate) noise_length_mm: f64,
    /// Standard deviation, over the face, of the value halfway between the levels, noise taken out.
    pub(crate) uneven: f64,
    /// Standard uncertainty of its mean by noise.
    pub(crate) statistical: f64,
    /// The width of a patch, mm.
    pub(crate) patch_mm: f64,
}

/// Why an edge is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NoEdge {
    /// Too little of the face has values on both sides of it.
    TooNear,
    /// Inside is not lighter than outside.
    Flat { material: f64, background: f64 },
}

impl Edge {
    /// The threshold halfway between the levels.
    pub(crate) fn halfway(&self) -> f64 {
        f64::midpoint(self.material, self.background)
    }

    /// Across the vertices of a face, which lie in the part's frame by `plane` and `pose`.
    pub(crate) fn across(
        body: &Body,
        skin: &Skin,
        vertices: &[u32],
        (plane, pose): (&Plane, &Pose),
    ) -> Result<Edge, NoEdge> {
        let some = vertices.len().min(SOME);
        let some: Vec<u32> =
            (0..some).map(|index| vertices[index * vertices.len() / some]).collect();
        let h_mm = body.scan.lattice.least_mm();
        let profiles = profiles(body, skin, &some, h_mm);
        let seen: Vec<(u32, &[f64])> = some
            .iter()
            .zip(&profiles)
            .filter_map(|(&vertex, profile)| Some((vertex, profile.as_deref()?)))
            .collect();
        if seen.len() < LEAST || 2 * seen.len() < some.len() {
            return Err(NoEdge::TooNear);
        }
        let mean = mean_of(&seen);
        let ends = [mean[ZERO - FIRST], mean[ZERO + FIRST]];
        let flat = NoEdge::Flat { material: ends[0], background: ends[1] };
        let (reach, fall) = plateau(&mean).ok_or(flat)?;
        let patches = Patches::new(skin, &seen, (reach, h_mm), (plane, pose));
        let interpolation_mm2 = interpolation_mm2(body, skin, &seen);
        let side_mm = h_mm * STEP;
        let near = (0.5 / STEP) as usize;
        let slope_per_mm = (mean[ZERO - near] - mean[ZERO + near]) / (2.0 * near as f64 * side_mm);
        let blur_mm2 = (fall.variance * side_mm * side_mm - interpolation_mm2).max(0.0);
        if slope_per_mm <= 0.0 || blur_mm2 <= 0.0 {
            return Err(flat);
        }
        // A difference over one spacing, between interpolated values, is that of an edge blurred so much more.
        let more_mm2 = interpolation_mm2 + h_mm * h_mm / 12.0;
        let slope_per_mm = slope_per_mm * (1.0 + more_mm2 / blur_mm2).sqrt();
        let with_levels: Vec<(u32, [f64; 2])> = seen
            .iter()
            .zip(&patches.levels)
            .map(|(&(vertex, _), &levels)| (vertex, levels))
            .collect();
        let noise = noise(body, skin, &with_levels, reach as f64 * side_mm);
        let (uneven, statistical) = patches.uneven(&noise, h_mm);
        Ok(Edge {
            material: fall.material,
            background: fall.background,
            slope_per_mm,
            blur_mm2,
            noise: noise.sigma * noise.between,
            noise_length_mm: noise.length_mm,
            uneven,
            statistical,
            patch_mm: patches.width_mm,
        })
    }
}

/// Grey values along the normal of each vertex, from inside to outside; `None` where one lacks.
fn profiles(body: &Body, skin: &Skin, vertices: &[u32], h_mm: f64) -> Vec<Option<Vec<f64>>> {
    let grey = body.grey(skin.threshold);
    let per_mm = body.scan.lattice.per_mm();
    let of_one = |&vertex: &u32| -> Option<Vec<f64>> {
        let normal = skin.normals[vertex as usize];
        let from = skin.surface.vertices[vertex as usize];
        let along: Vector = per_mm.map(|row| dot(row, normal) * h_mm);
        let at = |place: usize| {
            let step = (place as f64 - ZERO as f64) * STEP;
            grey.at(plus(from, step, along))
        };
        (0..=2 * ZERO).map(at).collect()
    };
    vertices.par_iter().map(of_one).collect()
}

/// The mean profile.
fn mean_of(seen: &[(u32, &[f64])]) -> Vec<f64> {
    let mut mean = vec![0.0; 2 * ZERO + 1];
    for (_, profile) in seen {
        mean.iter_mut().zip(*profile).for_each(|(sum, value)| *sum += value);
    }
    mean.iter_mut().for_each(|sum| *sum /= seen.len() as f64);
    mean
}

/// The mean edge: levels, and the variance of the blur in squares of a step.
struct Fall {
    material: f64,
    background: f64,
    variance: f64,
}

/// Where the levels begin, in steps from the face: beyond four standard deviations of the blur.
fn plateau(mean: &[f64]) -> Option<(usize, Fall)> {
    let mut reach = FIRST;
    let mut fall = Fall::of(mean, reach)?;
    for _ in 0..3 {
        let wanted = (4.0 * fall.variance.max(0.0).sqrt()).ceil() as usize;
        reach = wanted.clamp(LEAST_REACH, ZERO - WIDTH);
        fall = Fall::of(mean, reach)?;
    }
    Some((reach, fall))
}

impl Fall {
    fn of(mean: &[f64], reach: usize) -> Option<Fall> {
        let level =
            |from: usize| mean[from..=from + WIDTH].iter().sum::<f64>() / (WIDTH + 1) as f64;
        let material = level(ZERO - reach - WIDTH);
        let background = level(ZERO + reach);
        if material <= background {
            return None;
        }
        // 1 inside, 0 outside; moments of its fall by parts.
        let share = |at: usize| (mean[at] - background) / (material - background);
        let (mut first, mut second) = (0.0, 0.0);
        for step in 0..=reach {
            let weight = if step == 0 || step == reach { 0.5 } else { 1.0 };
            let (outside, inside) = (share(ZERO + step), 1.0 - share(ZERO - step));
            first += weight * (outside - inside);
            second += 2.0 * weight * step as f64 * (outside + inside);
        }
        // The sums are trapezoids; t·share has a kink at the face (Euler and Maclaurin).
        let variance = second + 1.0 / 6.0 - first * first;
        Some(Fall { material, background, variance })
    }
}

/// What the trilinear function between the samples adds to the variance of the blur along the normals: a sixth of a spacing squared.
fn interpolation_mm2(body: &Body, skin: &Skin, seen: &[(u32, &[f64])]) -> f64 {
    let steps_mm = body.scan.lattice.steps_mm;
    let of_one = |vertex: u32| {
        let normal = skin.normals[vertex as usize];
        steps_mm.iter().map(|&step| dot(step, normal).powi(2)).sum::<f64>() / 6.0
    };
    seen.iter().map(|&(vertex, _)| of_one(vertex)).sum::<f64>() / seen.len() as f64
}

/// Levels by patches of the face.
struct Patches {
    /// The value halfway between the levels of each patch with enough vertices, and how many it has.
    halves: Vec<(f64, f64)>,
    width_mm: f64,
    /// Level inside and outside of the patch of each vertex.
    levels: Vec<[f64; 2]>,
}

impl Patches {
    fn new(
        skin: &Skin,
        seen: &[(u32, &[f64])],
        (reach, h_mm): (usize, f64),
        (plane, pose): (&Plane, &Pose),
    ) -> Patches {
        let motion = pose.motion();
        let places: Vec<[f64; 2]> = seen
            .iter()
            .map(|&(vertex, _)| {
                let [x, y, _] = motion.to_part(plane.to_plane(skin.places_mm[vertex as usize]));
                [x, y]
            })
            .collect();
        let bounds = |axis: usize| {
            let first = (f64::INFINITY, f64::NEG_INFINITY);
            let sides = places.iter().map(|place| place[axis]);
            sides.fold(first, |(low, high), at| (low.min(at), high.max(at)))
        };
        let (x, y) = (bounds(0), bounds(1));
        // Patches of a few spacings would follow the noise.
        let across_mm = (x.1 - x.0).max(y.1 - y.0);
        let sides = ((across_mm / (PATCH_SPACINGS * h_mm)) as usize).clamp(LEAST_SIDES, SIDES);
        let width_mm = across_mm / sides as f64;
        let patch = |[at_x, at_y]: [f64; 2]| {
            let cell = |at: f64, low: f64| (((at - low) / width_mm) as usize).min(sides - 1);
            cell(at_y, y.0) * sides + cell(at_x, x.0)
        };
        let own = |profile: &[f64]| [profile[ZERO - reach], profile[ZERO + reach]];
        let mut sums = vec![[0.0; 3]; sides * sides];
        for (&(_, profile), &place) in seen.iter().zip(&places) {
            let [inside, outside] = own(profile);
            let sum = &mut sums[patch(place)];
            *sum = [sum[0] + inside, sum[1] + outside, sum[2] + 1.0];
        }
        let level = |sum: [f64; 3]| [sum[0] / sum[2], sum[1] / sum[2]];
        let levels: Vec<[f64; 2]> = places.iter().map(|&place| level(sums[patch(place)])).collect();
        let filled = sums.into_iter().filter(|sum| sum[2] >= PATCH as f64);
        let halves =
            filled.map(|sum| (f64::midpoint(level(sum)[0], level(sum)[1]), sum[2])).collect();
        Patches { halves, width_mm, levels }
    }

    /// Standard deviation of the value halfway between the levels from patch to patch, less what noise does to it; and the standard
    /// uncertainty of its mean by noise. A mean over an area has the variance of one sample times the area over which it is
    /// correlated, at least a voxel's, over its own. Patches at the border have few vertices: each counts by its noise (DerSimonian &
    /// Laird, Controlled Clinical Trials 7 (1986) 177, eq. 8), or the smallest would decide.
    fn uneven(&self, noise: &Noise, h_mm: f64) -> (f64, f64) {
        let correlated_mm2 = (TAU * noise.length_mm.powi(2)).max(h_mm * h_mm);
        let full = self.halves.iter().map(|(_, count)| *count).fold(1.0, f64::max);
        let patch_mm2 = self.width_mm * self.width_mm / full;
        // In variances of one sample; the mean of two sides has half that of one.
        let by_noise = |count: f64| 0.5 * (correlated_mm2 / (patch_mm2 * count)).max(1.0 / count);
        let weighted: Vec<(f64, f64)> =
            self.halves.iter().map(|&(half, count)| (half, by_noise(count).recip())).collect();
        let sum = |of: fn(&(f64, f64)) -> f64| weighted.iter().map(of).sum::<f64>();
        let whole = sum(|(_, weight)| *weight);
        let mean = sum(|(half, weight)| half * weight) / whole;
        let spread: f64 =
            weighted.iter().map(|(half, weight)| weight * (half - mean).powi(2)).sum();
        let noisy = (weighted.len() as f64 - 1.0) * noise.sigma.powi(2);
        let free = whole - sum(|(_, weight)| weight * weight) / whole;
        let uneven = if free > 0.0 { ((spread - noisy) / free).max(0.0).sqrt() } else { 0.0 };
        (uneven, noise.sigma * by_noise(self.levels.len() as f64).sqrt())
    }
}

/// Steps a spacing, as a share of it.
const STEP: f64 = 0.5;
/// The place of the face in a profile; as many steps lie on either side.
const ZERO: usize = 28;
/// Steps over which a level is averaged.
const WIDTH: usize = 6;
/// Steps from the face at which levels begin at first, and at least.
const FIRST: usize = 12;
const LEAST_REACH: usize = 8;
/// Vertices that are looked at, and how few are enough.
const SOME: usize = 20_000;
const LEAST: usize = 50;
/// Patches a side at most and at least, their width in spacings, and the vertices that one needs.
const SIDES: usize = 6;
const LEAST_SIDES: usize = 2;
const PATCH_SPACINGS: f64 = 10.0;
const PATCH: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::normal;
    use rand_core::SeedableRng as _;
    use rand_pcg::Pcg64Mcg;

    /// Patches of a round face, some full and some at its border, whose levels vary by `uneven` and by noise of one a vertex.
    fn patches(uneven: f64, random: &mut Pcg64Mcg) -> Patches {
        let counts = [400.0; 20].into_iter().chain([20.0; 4]).chain([120.0; 8]);
        let half = |count: f64, random: &mut Pcg64Mcg| {
            100.0 + uneven * normal(random) + (0.5 / count).sqrt() * normal(random)
        };
        let halves = counts.map(|count| (half(count, random), count)).collect();
        Patches { halves, width_mm: 1.0, levels: vec![[0.0; 2]] }
    }

    const NOISE: Noise = Noise { sigma: 1.0, between: 1.0, length_mm: 0.0 };

    /// What is taken for uneven levels of even ones is below 0.05, unless χ² of 31 is above 74, which is once in 45,000 draws.
    #[test]
    fn noise_is_not_taken_for_uneven_levels() {
        let mut random = Pcg64Mcg::seed_from_u64(11);
        for draw in 0..2000 {
            let (uneven, _) = patches(0.0, &mut random).uneven(&NOISE, 0.0);
            assert!(uneven < 0.05, "{draw}: {uneven}");
        }
    }

    #[test]
    fn uneven_levels_are_found() {
        let mut random = Pcg64Mcg::seed_from_u64(12);
        let found = (0..500).map(|_| patches(0.1, &mut random).uneven(&NOISE, 0.0).0.powi(2));
        let mean = (found.sum::<f64>() / 500.0).sqrt();
        assert!((mean / 0.1 - 1.0).abs() < 0.02, "{mean}");
    }

    #[test]
    fn without_noise_all_is_uneven_and_no_patch_nothing() {
        let quiet = Noise { sigma: 0.0, ..NOISE };
        let two = Patches {
            halves: vec![(1.0, 50.0), (3.0, 50.0)],
            width_mm: 1.0,
            levels: vec![[0.0; 2]],
        };
        assert_eq!(two.uneven(&quiet, 1.0), (2.0_f64.sqrt(), 0.0));
        for halves in [vec![], vec![(1.0, 50.0)]] {
            let few = Patches { halves, width_mm: 1.0, levels: vec![[0.0; 2]] };
            assert_eq!(few.uneven(&NOISE, 1.0).0, 0.0);
        }
    }
}
