//! What the deviations tell of the parameters, at a glance: roughly what [`type_a`] finds, at little cost.
//!
//! Deviations of all points make the means of few patches; their derivatives, which are smooth, are taken at some points
//! only. Waves shorter than the distance of the patches count as independent from patch to patch.
//!
//! [`type_a`]: super::type_a

use rayon::prelude::*;

use super::patches::{Independence, Patch, Sums, groups, patch};
use super::{LEAST_FREEDOM, TypeA, found};
use crate::UncertaintyError;
use crate::linear::Linear;
use asphera_form::linear::{CHUNK, Selection, System, Triangle, Weights};
use asphera_form::{Aperture, Fit, Freedoms, PointMm};
use asphera_geometry::{BoundsMm, Numbers};

/// As [`super::type_a`] by 64 to 128 patches in place of 256; `None` where the points make too few.
///
/// Fewer patches know less: the uncertainties are half to 2.5 times those of [`super::type_a`] as a rule, of height and
/// tilts up to five times, for waves as long as the part cannot be ruled out.
///
/// `deviations_mm` are those of the fit, as [`asphera_form::deviations`] has them; points whose deviation is not finite, or that
/// lie outside the aperture, do not count. `uncertainties_mm` are those of [`asphera_form::fit_weighted`], if it had any. `O(n)`:
/// some 30 ms for a million points on two threads, 10 ms for some thousands.
pub fn glance(
    points: &[PointMm],
    deviations_mm: &[f64],
    fit: &Fit,
    aperture: &Aperture,
    uncertainties_mm: Option<&[f64]>,
) -> Result<Option<TypeA>, UncertaintyError> {
    if deviations_mm.len() != points.len() {
        let found = deviations_mm.len();
        return Err(UncertaintyError::Lengths { points: points.len(), found });
    }
    let roots = Linear::roots(uncertainties_mm, points.len())?;
    let roots = roots.as_ref().map(|weights: &Weights| weights.roots.as_slice());
    let chosen = some(points.len());
    let some_points: Vec<PointMm> = chosen.iter().map(|&index| points[index]).collect();
    let some_roots =
        roots.map(|roots| chosen.iter().map(|&index| roots[index]).collect::<Vec<f64>>());
    let selection =
        Selection::new(&some_points, some_roots.as_deref(), &fit.nominal, &fit.pose, aperture);
    let p = fit.estimates.len();
    let most = largest_power_of_two(selection.points.len() / LEAST_A_PATCH)
        .min(largest_power_of_two(points.len() / MANY_A_PATCH).clamp(FEW, MOST));
    if p == 0 || most < p + LEAST_FREEDOM {
        return Ok(None);
    }
    let linear = Linear::of(selection, fit)?;
    let middles: Vec<[f64; 2]> =
        groups(&linear, most).iter().map(|group| patch(group, &linear).0.place_mm).collect();
    // Points with derivatives go to patches as all others.
    let territory = Territory::new(&linear.places_mm, &middles);
    let mut near: Vec<Vec<usize>> = vec![Vec::new(); middles.len()];
    for (place, &place_mm) in linear.places_mm.iter().enumerate() {
        if linear.weights[place] > 0.0 {
            near[territory.patch(place_mm)].push(place);
        }
    }
    let all = sums(points, deviations_mm, (fit, aperture, roots), (&territory, near.len()));
    let known = near.iter().zip(all).filter(|(near, sums)| !near.is_empty() && sums.weight > 0.0);
    let (mut patches, sums): (Vec<Patch>, Vec<Sums>) = known
        .map(|(near, sums)| {
            let (patch, _) = patch(near, &linear);
            let deviation_mm = sums.first_mm / sums.weight;
            (Patch { deviation_mm, place_mm: sums.mean_place_mm(), ..patch }, sums)
        })
        .unzip();
    gains(&mut patches, &sums, &fit.freedoms);
    if patches.len() < p + LEAST_FREEDOM {
        return Ok(None);
    }
    Ok(Some(found(fit, &patches, Independence::new(&sums, p))))
}

/// Indices of at most [`DERIVATIVES`] points spread over all, one anywhere in each of as many equal parts: steps of one
/// length would fall in with the lines of a scan.
fn some(count: usize) -> Vec<usize> {
    if count <= DERIVATIVES {
        return (0..count).collect();
    }
    let numbers = Numbers::new(0, 0, 0);
    let edge = |part: usize| part * count / DERIVATIVES;
    (0..DERIVATIVES)
        .map(|part| {
            let (from, to) = (edge(part), edge(part + 1));
            from + ((numbers.uniform(part) * (to - from) as f64) as usize).min(to - from - 1)
        })
        .collect()
}

/// Sums over all points that count, patch by patch. The same bits with any number of threads.
fn sums(
    points: &[PointMm],
    deviations_mm: &[f64],
    (fit, aperture, roots): (&Fit, &Aperture, Option<&[f64]>),
    (territory, patches): (&Territory, usize),
) -> Vec<Sums> {
    let motion = fit.pose.motion();
    let of_chunk = |(chunk, points): (usize, &[PointMm])| {
        let mut sums = vec![Sums::default(); patches];
        for (offset, &point) in points.iter().enumerate() {
            let index = chunk * CHUNK + offset;
            let deviation_mm = deviations_mm[index];
            let [x, y, _] = motion.to_part(point);
            if !deviation_mm.is_finite() || !aperture.contains(x, y) {
                continue;
            }
            let root = roots.map_or(1.0, |roots| roots[index]);
            let of_loss = fit
                .robust
                .map_or(1.0, |robust| robust.loss.weight(root * deviation_mm / robust.scale_mm));
            sums[territory.patch([x, y])].push(root * root * of_loss, deviation_mm, [x, y]);
        }
        sums
    };
    let chunks: Vec<Vec<Sums>> = points.par_chunks(CHUNK).enumerate().map(of_chunk).collect();
    let mut all = vec![Sums::default(); patches];
    for sums in &chunks {
        all.iter_mut().zip(sums).for_each(|(all, sums)| all.add(sums));
    }
    all
}

/// What a fit to the means of the patches would take off the parameters: of smooth errors the same as that to all points,
/// and without the chance in which points the derivatives were taken at.
fn gains(patches: &mut [Patch], sums: &[Sums], freedoms: &Freedoms) {
    let p = patches.first().map_or(0, |patch| patch.row.len());
    let mut triangle = Triangle::new(p + 1);
    for (patch, sums) in patches.iter().zip(sums) {
        let root = sums.weight.sqrt();
        let mut row: Vec<f64> = patch.row.iter().map(|entry| root * entry).collect();
        row.push(root * patch.deviation_mm);
        triangle.push(&row);
    }
    triangle.flush();
    let step = System::new(&triangle).solve_along(freedoms, 0.0);
    for (patch, sums) in patches.iter_mut().zip(sums) {
        patch.gain = step.undo_gram(&patch.row);
        patch.gain.iter_mut().for_each(|gain| *gain *= sums.weight);
    }
}

/// Which patch a place belongs to: a grid of cells over all places, each of the patch whose middle is nearest to its own.
struct Territory {
    low_mm: [f64; 2],
    /// Cells a mm.
    per_mm: [f64; 2],
    patch_of: Vec<usize>,
}

impl Territory {
    /// Over places that are some. `O(cells·patches)`.
    fn new(places_mm: &[[f64; 2]], middles_mm: &[[f64; 2]]) -> Territory {
        let bounds = BoundsMm::about(places_mm.iter().copied());
        let (low_mm, size_mm) =
            (bounds.low, bounds.size_mm().map(|size_mm| size_mm.max(f64::MIN_POSITIVE)));
        let per_mm = size_mm.map(|size_mm| CELLS as f64 / size_mm);
        let nearest = |cell: usize| {
            let middle = |axis: usize, index: usize| {
                low_mm[axis] + (index as f64 + 0.5) / CELLS as f64 * size_mm[axis]
            };
            let (x, y) = (middle(0, cell % CELLS), middle(1, cell / CELLS));
            let squares =
                middles_mm.iter().map(|m| (m[0] - x).powi(2) + (m[1] - y).powi(2)).enumerate();
            let first = (0, f64::INFINITY);
            squares.fold(first, |least, one| if one.1 < least.1 { one } else { least }).0
        };
        Territory { low_mm, per_mm, patch_of: (0..CELLS * CELLS).map(nearest).collect() }
    }

    /// Those outside belong to the cell at the border.
    fn patch(&self, place_mm: [f64; 2]) -> usize {
        let cell = |axis: usize| {
            let at = (place_mm[axis] - self.low_mm[axis]) * self.per_mm[axis];
            (at as usize).min(CELLS - 1)
        };
        self.patch_of[cell(1) * CELLS + cell(0)]
    }
}

/// 1 for 0 and 1.
fn largest_power_of_two(count: usize) -> usize {
    1 << count.max(1).ilog2()
}

/// Points at which derivatives are taken.
const DERIVATIVES: usize = 16_384;
/// Cells of the grid along one side: some eight a patch.
const CELLS: usize = 96;
/// Patches, a power of two.
const MOST: usize = 128;
/// So many, or fewer where there are not the points for them, before the patches hold [`MANY_A_PATCH`] points.
const FEW: usize = 64;
/// More points a patch make no difference to what a patch tells; then there may be more patches.
const MANY_A_PATCH: usize = 1024;
/// So few points tell how deviations scatter within a patch, over all patches.
const LEAST_A_PATCH: usize = 4;
