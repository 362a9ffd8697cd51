//! The search over all points: a zone of a few, then all held against it, until none sticks out.

use super::descend::{Bottom, Holding, descend};
use super::directions::Directions;
use super::residuals::Residuals;
use super::scan::{Extremes, Span, scan, span};

/// Bounds of the search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Share of the half width by which the zone may exceed its lower bound.
    pub(super) tolerance: f64,
    /// Rounding of a distance.
    pub(super) rounding_mm: f64,
    /// Largest number of passes over all points.
    pub(super) scans: usize,
    /// Whether a zone is judged by the range of the distances, not by the largest one.
    pub(super) by_range: bool,
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Settled,
    NoDescent,
    Scans,
}

/// The narrowest zone found.
#[derive(Clone, Debug)]
pub(super) struct Found<P> {
    pub(super) place: P,
    pub(super) span: Span,
    pub(super) lower_mm: f64,
    pub(super) tolerance_mm: f64,
    pub(super) contacts: Vec<Holding>,
    pub(super) pull: f64,
    /// Points whose rows were used.
    pub(super) working: usize,
    pub(super) scans: usize,
    pub(super) evaluations: usize,
    pub(super) end: End,
}

/// Searches from `start`, where every point must have a distance; else `None`.
///
/// The zone of a part of the points is never wider than that of all. So the width over the working points
/// bounds that over all from below, and once no other point sticks out of it both agree (the cutting planes
/// of semi-infinite programming: Hettich & Kortanek, SIAM Rev. 35 (1993) 380).
pub(super) fn search<R: Residuals>(
    problem: &R,
    directions: &Directions,
    start: R::Place,
    limits: Limits,
) -> Option<Found<R::Place>> {
    let mut blocks = scan(problem, &start);
    let mut best = (start.clone(), span(&blocks)?);
    let mut working = Working::new(problem.len(), &blocks);
    let mut place = start;
    let (mut scans, mut evaluations) = (1, problem.len());
    loop {
        let width_mm = limits.half_mm(best.1);
        let tolerance_mm = (limits.tolerance * width_mm).max(limits.rounding_mm);
        let points = working.sorted();
        let bottom = descend(problem, directions, &points, &place, 0.5 * tolerance_mm)?;
        blocks = scan(problem, &bottom.place);
        (scans, evaluations) = (scans + 1, evaluations + problem.len() + bottom.evaluations);
        let now = span(&blocks);
        if let Some(now) = now
            && limits.half_mm(now) < limits.half_mm(best.1)
        {
            best = (bottom.place.clone(), now);
        }
        let added = working.add(&blocks, &bottom, 0.5 * tolerance_mm);
        let close = limits.half_mm(best.1) - bottom.lower_mm <= tolerance_mm;
        let end = if close {
            End::Settled
        } else if added == 0 {
            End::NoDescent
        } else if scans >= limits.scans {
            End::Scans
        } else {
            // Where a point has lost its foot, the way there must be gone anew and with that point.
            place = if now.is_some() { bottom.place } else { best.0.clone() };
            continue;
        };
        let Bottom { lower_mm, contacts, pull, .. } = bottom;
        let (place, span) = best;
        return Some(Found {
            place,
            span,
            lower_mm,
            tolerance_mm,
            contacts,
            pull,
            working: points.len(),
            scans,
            evaluations,
            end,
        });
    }
}

impl Limits {
    fn half_mm(self, span: Span) -> f64 {
        span.half_mm(self.by_range)
    }
}

/// The points the linear problems are made of.
struct Working {
    member: Vec<bool>,
}

impl Working {
    /// All points if they are few, else the extremes of every block and some to determine the parameters.
    fn new(count: usize, blocks: &[Extremes]) -> Working {
        let mut member = vec![count <= FEW; count];
        member.iter_mut().step_by((count / SAMPLE).max(1)).for_each(|member| *member = true);
        for block in blocks {
            for (index, _) in [block.high, block.low].into_iter().flatten() {
                member[index] = true;
            }
        }
        Working { member }
    }

    fn sorted(&self) -> Vec<usize> {
        let members = self.member.iter().enumerate();
        members.filter_map(|(index, &member)| member.then_some(index)).collect()
    }

    /// Adds of every block the points that stick out most, and one without a distance. Returns how many.
    fn add<P>(&mut self, blocks: &[Extremes], bottom: &Bottom<P>, slack_mm: f64) -> usize {
        let limit_mm = bottom.half_mm + slack_mm;
        let outside =
            |&(_, distance_mm): &(usize, f64)| (distance_mm - bottom.centre_mm).abs() > limit_mm;
        let mut added = 0;
        for block in blocks {
            let sticking = [block.high, block.low].into_iter().flatten().filter(outside);
            for index in sticking.map(|(index, _)| index).chain(block.lost) {
                added += usize::from(!self.member[index]);
                self.member[index] = true;
            }
        }
        added
    }
}

/// So many points are all taken at once.
const FEW: usize = 2048;
/// Points that stand for all others where these are more.
const SAMPLE: usize = 512;
