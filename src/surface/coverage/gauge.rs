//! Every triangle against the target: its gap, its ε, and whether it is surface or a bridge.

use super::target::Target;
use crate::rim::refined_gaps;
use crate::triangle::{Gap, Triangle};
use crate::{PointMm, VertexId};

/// What a triangle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// Its gap is within the target.
    Covered,
    /// Its gap is not, or the target cannot be told there; but at one of its corners samples are
    /// about as far apart as here.
    Undersampled,
    /// Its gap is not within the target, and far above those at all of its corners: it bridges what
    /// nobody scanned.
    Bridge,
}

/// A triangle against the target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gauged {
    pub(super) gap: Gap,
    /// The smallest local feature size at its corners and at the place of its gap.
    pub(super) lfs_mm: Option<f64>,
    pub(super) standing: Standing,
}

impl Gauged {
    pub(super) fn epsilon(&self) -> Option<f64> {
        self.lfs_mm.map(|lfs_mm| self.gap.mm / lfs_mm)
    }
}

/// The local feature size as a caller tells it, or none if it is no positive number.
pub(super) fn sound_lfs(lfs_mm: Option<f64>) -> Option<f64> {
    lfs_mm.filter(|&lfs_mm| lfs_mm > 0.0)
}

/// Gauges all triangles; those of `left_out`, ascending indices, are bridges whatever their gap.
/// Linear time.
pub(super) fn gauge(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    left_out: &[usize],
    target: &Target,
    lfs_mm: &impl Fn(f64, f64) -> Option<f64>,
) -> Vec<Gauged> {
    let lfs_mm = |x, y| sound_lfs(lfs_mm(x, y));
    let at_points: Vec<Option<f64>> = points.iter().map(|&[x, y, _]| lfs_mm(x, y)).collect();
    let mut refined = refined_gaps(points, triangles).into_iter().peekable();
    // For each vertex the smallest gap of a triangle there: how far apart samples are about it. A
    // bridge has a large gap, but of the triangles at a sample on the rim of a hole some are surface.
    let mut about_mm = vec![f64::INFINITY; points.len()];
    let mut gauged: Vec<Gauged> = Vec::with_capacity(triangles.len());
    for (index, &corners) in triangles.iter().enumerate() {
        let gap = match refined.next_if(|&(thin, _)| thin == index) {
            Some((_, gap)) => gap,
            None => Triangle::new(points, corners).gap(),
        };
        let [a, b, c] = corners.map(|corner| at_points[corner as usize]);
        let lfs_mm = smaller(smaller(a, b), smaller(c, lfs_mm(gap.at_mm[0], gap.at_mm[1])));
        let covered =
            target.gap_mm(lfs_mm).is_some_and(|limit_mm| gap.mm <= limit_mm * (1.0 + ROUNDING));
        let standing = if covered { Standing::Covered } else { Standing::Undersampled };
        for corner in corners {
            let about_mm = &mut about_mm[corner as usize];
            *about_mm = about_mm.min(gap.mm);
        }
        gauged.push(Gauged { gap, lfs_mm, standing });
    }
    let mut left_out = left_out.iter().peekable();
    for (index, (gauged, corners)) in gauged.iter_mut().zip(triangles).enumerate() {
        if left_out.next_if(|&&other| other == index).is_some() {
            gauged.standing = Standing::Bridge;
        } else if gauged.standing == Standing::Undersampled {
            let about_mm =
                corners.iter().map(|&corner| about_mm[corner as usize]).fold(0.0, f64::max);
            if gauged.gap.mm > BRIDGE * about_mm {
                gauged.standing = Standing::Bridge;
            }
        }
    }
    gauged
}

fn smaller(left: Option<f64>, right: Option<f64>) -> Option<f64> {
    Some(left?.min(right?))
}

/// A gap above its limit by so small a share is within: a raster at the target's spacing meets it.
const ROUNDING: f64 = 1e-9;

/// A triangle bridges if its gap is more than so many times the smallest gap at each of its corners.
/// On a raster that is a hole of about five spacings across; scattered samples rarely have it.
const BRIDGE: f64 = 3.0;
