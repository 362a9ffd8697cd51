//! What heights are about.

use std::fmt;

use super::surface::Nodes;

/// What heights are about. As an F-operation: what is removed before the filters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Datum {
    /// The zero of the heights given: the form was removed before, or the filter left them so.
    #[default]
    AsGiven,
    /// Their area-weighted mean.
    Mean,
    /// The plane of least squares of the heights, weighted by area.
    MeanPlane,
}

impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Datum::AsGiven => "heights as given",
            Datum::Mean => "heights about their mean",
            Datum::MeanPlane => "heights about their mean plane",
        })
    }
}

/// z = height + gradient·(place − centre).
pub(super) struct MeanPlane {
    centre_mm: [f64; 2],
    height_nm: f64,
    gradient: [f64; 2],
}

impl MeanPlane {
    /// What `datum` removes from nodes. Nodes on a line determine only the slope along it; across it there
    /// is none.
    pub(super) fn new(nodes: &Nodes, datum: Datum) -> MeanPlane {
        let flat = MeanPlane { centre_mm: [0.0; 2], height_nm: 0.0, gradient: [0.0; 2] };
        if datum == Datum::AsGiven {
            return flat;
        }
        // About the first height, so that a large offset costs no digits.
        let first = nodes.heights_nm[0];
        let height_nm = first + nodes.mean(|i| nodes.heights_nm[i] - first);
        if datum == Datum::Mean {
            return MeanPlane { height_nm, ..flat };
        }
        let start = nodes.places_mm[0];
        let centre_mm =
            [0, 1].map(|axis| start[axis] + nodes.mean(|i| nodes.places_mm[i][axis] - start[axis]));
        let offset = |i: usize, axis: usize| nodes.places_mm[i][axis] - centre_mm[axis];
        let reach = (0..nodes.places_mm.len()).map(|i| offset(i, 0).abs().max(offset(i, 1).abs()));
        let reach = reach.fold(0.0, f64::max);
        if reach == 0.0 {
            return MeanPlane { centre_mm, height_nm, ..flat };
        }
        let moment =
            |a: usize, b: usize| nodes.mean(|i| offset(i, a) / reach * offset(i, b) / reach);
        let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
        let with = |axis: usize| {
            nodes.mean(|i| offset(i, axis) / reach * (nodes.heights_nm[i] - height_nm))
        };
        let (xz, yz) = (with(0), with(1));
        // Along the directions of largest and smallest extent the two slopes are independent.
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sin, cos) = angle.sin_cos();
        let half = (0.5 * (xx - yy)).hypot(xy);
        let extents = [0.5 * (xx + yy) + half, 0.5 * (xx + yy) - half];
        let slopes = [cos * xz + sin * yz, cos * yz - sin * xz];
        let along = slopes[0] / extents[0];
        let across =
            if extents[1] > LEAST_EXTENT * extents[0] { slopes[1] / extents[1] } else { 0.0 };
        let gradient = [(cos * along - sin * across) / reach, (sin * along + cos * across) / reach];
        MeanPlane { centre_mm, height_nm, gradient }
    }

    pub(super) fn height_nm(&self, place: [f64; 2]) -> f64 {
        self.height_nm
            + self.gradient[0] * (place[0] - self.centre_mm[0])
            + self.gradient[1] * (place[1] - self.centre_mm[1])
    }
}

/// Mean square extent across a line, as a share of that along it, below which rounding makes it.
const LEAST_EXTENT: f64 = 1e-13;
