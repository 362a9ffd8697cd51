//! Kept points with the mean of what was measured about them.

use super::fitted::Fitted;
use crate::PointMm;
use crate::nearest::WeightedTree;

/// The averages of kept points.
#[derive(Clone, Debug, PartialEq)]
pub struct Averaged {
    /// One for each kept point, in the same order.
    pub points: Vec<AveragedPoint>,
    /// How many were averaged; the others stay as measured.
    pub averaged: u64,
}

/// A kept point with the mean of its surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AveragedPoint {
    /// The place of the kept point, and its averaged height, in mm.
    pub point_mm: PointMm,
    /// Standard uncertainty of the height from independent noise, in mm: σ where nothing was
    /// averaged.
    pub u_mm: f64,
    /// The most by which averaging may have shifted the height, in mm; zero where nothing was
    /// averaged. `None` where a quadric was fitted: what it leaves depends on how the bending
    /// changes, which the local feature size does not bound.
    pub bias_bound_mm: Option<f64>,
    /// How many measurements went into it.
    pub measurements: u64,
}

/// Gives each of the `kept` points the height of a surface fitted by least squares to all `points`
/// nearest to it, read at its own place. `sigma_mm` is the standard deviation of a height, `lfs_mm`
/// the local feature size at a point.
///
/// The mean of heights alone would be wrong by the slope times the distance to the mean place; a
/// plane takes that out. What a plane leaves is the bending. Its value at the place is a sum of
/// heights with weights wᵢ, whose first moments vanish, so on a surface that bends by no more than
/// 1/lfs it is off by at most Σ|wᵢ|·rᵢ²/(2·lfs) ≤ √Σwᵢ²·√Σrᵢ⁴/(2·lfs), times (1 + slope²)^{3/2} as
/// heights are not taken along the normal. That bound is stated. Where it is above a third of the
/// plane's uncertainty, or the local feature size is not known, a quadric is fitted instead: it
/// takes the bending out, at about twice the uncertainty. Where points do not determine what is
/// needed, the point stays as it was measured.
///
/// Points that are not finite must have been left out. Noise that is not independent from point to
/// point, such as vibration, is reduced less than `u_mm` says. Takes n·log k time for k kept
/// points.
///
/// # Panics
///
/// At 2³² kept points.
pub fn average(
    points: &[PointMm],
    kept: &[PointMm],
    sigma_mm: f64,
    lfs_mm: impl Fn(PointMm) -> Option<f64>,
) -> Averaged {
    let owned = owned(points, kept);
    let mut averaged = 0;
    let mut offsets_mm = Vec::new();
    let points = kept
        .iter()
        .enumerate()
        .map(|(number, &at)| {
            offsets_mm.clear();
            let own = &owned.points[owned.starts[number]..owned.starts[number + 1]];
            offsets_mm.extend(own.iter().map(|&index| {
                let point = points[index as usize];
                [point[0] - at[0], point[1] - at[1], point[2] - at[2]]
            }));
            let mean = mean_at(at, &offsets_mm, sigma_mm, lfs_mm(at));
            averaged += u64::from(mean.is_some());
            mean.unwrap_or(AveragedPoint {
                point_mm: at,
                u_mm: sigma_mm,
                bias_bound_mm: Some(0.0),
                measurements: 1,
            })
        })
        .collect();
    Averaged { points, averaged }
}

/// Which points are nearest to each kept one.
struct Owned {
    points: Vec<u32>,
    /// Where those of each kept point start, and the end of the last.
    starts: Vec<usize>,
}

fn owned(points: &[PointMm], kept: &[PointMm]) -> Owned {
    let tree = WeightedTree::of_points(kept);
    let owners: Vec<Option<u32>> =
        points.iter().map(|&point| tree.nearest(point, |_| true).map(|(owner, _)| owner)).collect();
    let mut starts = vec![0; kept.len() + 1];
    for owner in owners.iter().flatten() {
        starts[*owner as usize + 1] += 1;
    }
    for number in 0..kept.len() {
        starts[number + 1] += starts[number];
    }
    let mut next = starts.clone();
    let mut sorted = vec![0; starts[kept.len()]];
    for (index, owner) in (0..).zip(&owners) {
        if let Some(owner) = owner {
            let place = &mut next[*owner as usize];
            sorted[*place] = index;
            *place += 1;
        }
    }
    Owned { points: sorted, starts }
}

/// The mean at a place of what was measured about it; `None` where that does not determine a
/// surface.
fn mean_at(
    at: PointMm,
    offsets_mm: &[[f64; 3]],
    sigma_mm: f64,
    lfs_mm: Option<f64>,
) -> Option<AveragedPoint> {
    let plane = Fitted::<3>::to(offsets_mm)?;
    let fourth_mm4: f64 = offsets_mm.iter().map(|&[u, v, _]| (u * u + v * v).powi(2)).sum();
    let [along_x, along_y] = plane.slopes();
    let stretch = (1.0 + along_x * along_x + along_y * along_y).powf(1.5);
    let bending_mm2 = 0.5 * stretch * plane.height_factor() * fourth_mm4.sqrt();
    let bias_mm = lfs_mm.map(|lfs_mm| bending_mm2 / lfs_mm);
    let read = |height_mm: f64, factor: f64, bias_bound_mm| AveragedPoint {
        point_mm: [at[0], at[1], at[2] + height_mm],
        u_mm: sigma_mm * factor,
        bias_bound_mm,
        measurements: offsets_mm.len() as u64,
    };
    let flat = read(plane.height_mm(), plane.height_factor(), bias_mm);
    if bias_mm.is_some_and(|bias_mm| 3.0 * bias_mm <= flat.u_mm) {
        return Some(flat);
    }
    let quadric = Fitted::<6>::to(offsets_mm).filter(|_| offsets_mm.len() >= QUADRIC_POINTS)?;
    Some(read(quadric.height_mm(), quadric.height_factor(), None))
}

/// A quadric has six terms; with fewer points than this its value is hardly better than a single
/// height.
const QUADRIC_POINTS: usize = 10;
