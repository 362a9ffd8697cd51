//! A zone to first order about its place: how wide it becomes when the distances of points change a little.

use super::directions::Directions;
use super::exchange::Rows;
use super::residuals::{Laid, Part, Residuals};
use super::{Criterion, ZoneFit};
use crate::fit::refine::priority;
use crate::{Parameter, PointMm};

/// The linear minimax problem over some points, at the place of the zone.
#[derive(Clone, Debug)]
pub struct LinearZone {
    /// Distances count from the middle of the zone, in half widths.
    rows: Rows,
    half_mm: f64,
}

impl LinearZone {
    /// Over the points `near`, as indices of `points`; others only help to tell what the parameters do, some `SAMPLE` of
    /// them. `None` for a zone without a width, or where a point has no distance. `O(c·p²)` for c points.
    pub fn new(
        points: &[PointMm],
        near: &[usize],
        zone: &ZoneFit,
        rank_tolerance: f64,
    ) -> Option<LinearZone> {
        let half_mm = 0.5 * zone.zone_mm;
        if half_mm <= 0.0 {
            return None;
        }
        let free: Vec<Parameter> =
            zone.least_squares.estimates.iter().map(|estimate| estimate.parameter).collect();
        let place = Laid { pose: zone.pose, nominal: zone.nominal.clone() };
        let some = points.iter().step_by((points.len() / SAMPLE).max(1)).copied();
        let all: Vec<PointMm> = some.chain(near.iter().map(|&index| points[index])).collect();
        let order = priority(&free, &zone.nominal);
        let whole = Part { points: &all, free: &free };
        let offset = zone.criterion == Criterion::Range;
        let within = (&zone.least_squares.freedoms, &order[..]);
        let directions = Directions::new(&whole, &place, within, offset, rank_tolerance)?;
        let mut entries = Vec::new();
        let close = Part { points, free: &free };
        close.rows(&place, near.iter().copied(), &mut entries)?;
        let rows = directions.turn(&entries, free.len(), zone.offset_mm, half_mm);
        Some(LinearZone { rows, half_mm })
    }

    /// The width of the zone in mm when the distance of each point is larger by its error in mm.
    pub fn width_mm(&self, errors_mm: &[f64]) -> f64 {
        let mut rows = self.rows.clone();
        let mut largest: f64 = 1.0;
        for (row, error_mm) in rows.entries.chunks_exact_mut(rows.columns + 1).zip(errors_mm) {
            row[self.rows.columns] += error_mm / self.half_mm;
            largest = largest.max(row[self.rows.columns].abs());
        }
        2.0 * self.half_mm * rows.minimax(REACH * largest).reached
    }
}

/// Points that tell what the parameters do.
const SAMPLE: usize = 512;
/// As of the search: a better place is at most two half widths away.
const REACH: f64 = 4.0;
