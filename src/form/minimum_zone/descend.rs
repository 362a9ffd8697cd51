//! The nonlinear minimax problem over a few points: linear ones in a row, each trusted only so far.
//!
//! Madsen, J. Inst. Maths Applics 16 (1975) 321. Where the answer is held by as many points as there are
//! unknowns, the usual case, the steps converge like Newton's method; no second derivatives are needed.

use super::bend;
use super::directions::Directions;
use super::exchange::{Held, Optimum, Rows};
use super::residuals::Residuals;
use super::scan::Span;

/// The narrowest zone of the working points near a start.
#[derive(Clone, Debug)]
pub(super) struct Bottom<P> {
    pub(super) place: P,
    pub(super) centre_mm: f64,
    /// Half the width of the zone.
    pub(super) half_mm: f64,
    /// To first order no place within a motion of two half widths has a smaller half width.
    pub(super) lower_mm: f64,
    pub(super) contacts: Vec<Holding>,
    /// Length of the sum of the contacts' derivatives, each with multiplier and side.
    pub(super) pull: f64,
    /// Distances computed.
    pub(super) evaluations: usize,
}

/// A point that holds the zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Holding {
    /// Index in the problem.
    pub(super) index: usize,
    pub(super) high: bool,
    pub(super) multiplier: f64,
}

/// Descends from a place at which every working point has a distance, until the half width exceeds its lower
/// bound by `tolerance_mm` or less or no step helps. `None` if a point has no distance or there is no point.
pub(super) fn descend<R: Residuals>(
    problem: &R,
    directions: &Directions,
    working: &[usize],
    start: &R::Place,
    tolerance_mm: f64,
) -> Option<Bottom<R::Place>> {
    let mut at = Linear::new(problem, directions, working, start)?;
    let mut evaluations = working.len();
    let mut reach_mm = REACH * at.half_mm;
    for left in (0..STEPS).rev() {
        if at.half_mm <= tolerance_mm {
            return Some(at.touching(evaluations));
        }
        let rows = directions.turn(&at.rows, problem.parameters(), at.centre_mm, at.half_mm);
        let optimum = rows.minimax(reach_mm / at.half_mm);
        let predicted_mm = at.half_mm * (1.0 - optimum.reached);
        let lower_mm = at.lower_mm(&rows, &optimum);
        let settled = at.half_mm - lower_mm <= tolerance_mm;
        let stuck = left == 0 || predicted_mm <= 0.0 || reach_mm <= LEAST_REACH * at.half_mm;
        if stuck && !settled {
            // Within a short reach the box holds almost everything: a wide one tells more.
            let wide = rows.minimax(REACH);
            let wide_mm = at.lower_mm(&rows, &wide);
            return Some(if wide_mm > lower_mm {
                at.bottom(working, &wide, wide_mm, evaluations)
            } else {
                at.bottom(working, &optimum, lower_mm, evaluations)
            });
        }
        let trial = Trial { problem, directions, working, at: &at, rows: &rows };
        let next = if settled {
            // The last step is free of charge.
            trial.moved(&at, &optimum.y, &mut evaluations)
        } else {
            trial.go(&optimum, predicted_mm, reach_mm, &mut evaluations)
        };
        let gained_mm = at.half_mm - half_mm(&next);
        let longest = optimum.y.iter().fold(0.0, |longest: f64, y| longest.max(y.abs()));
        let longest_mm = longest * at.half_mm;
        if let Some(next) = next
            && gained_mm > 0.0
        {
            at = next;
        }
        if settled {
            return Some(at.bottom(working, &optimum, lower_mm, evaluations));
        }
        if gained_mm < POOR * predicted_mm {
            reach_mm = SHORTER * longest_mm.min(reach_mm);
        } else if gained_mm > GOOD * predicted_mm && longest_mm >= 0.99 * reach_mm {
            reach_mm *= LONGER;
        }
    }
    None
}

/// A step from a place, with the rows there.
struct Trial<'a, R: Residuals> {
    problem: &'a R,
    directions: &'a Directions,
    working: &'a [usize],
    at: &'a Linear<R::Place>,
    rows: &'a Rows,
}

impl<R: Residuals> Trial<'_, R> {
    /// Where the step of the linear problem leads. If the zone there is not what the rows promised, more steps
    /// follow from there, each by rows of its own, and the narrowest zone counts: on the way along a bent valley
    /// the zone may at first be wider (the watchdog of Chamberlain et al., Math. Programming Study 16 (1982)
    /// 1). If that does not help either, or the rows alone have no answer within reach, the bend itself is looked
    /// at.
    fn go(
        &self,
        optimum: &Optimum,
        predicted_mm: f64,
        reach_mm: f64,
        evaluations: &mut usize,
    ) -> Option<Linear<R::Place>> {
        let good_mm = self.at.half_mm - GOOD * predicted_mm;
        let poor_mm = self.at.half_mm - POOR * predicted_mm;
        let mut best = self.moved(self.at, &optimum.y, evaluations);
        let mut last = best.clone();
        for _ in 0..RELAXED {
            let Some(from) = &last else { break };
            if from.half_mm <= good_mm || from.half_mm == 0.0 {
                break;
            }
            let rows = self.directions.turn(
                &from.rows,
                self.problem.parameters(),
                from.centre_mm,
                from.half_mm,
            );
            let y = rows.minimax(reach_mm / from.half_mm).y;
            last = self.moved(from, &y, evaluations);
            if half_mm(&last) < half_mm(&best) {
                best = last.clone();
            }
        }
        if (half_mm(&best) > poor_mm || optimum.pull > HELD_BY_BOX)
            && let Some(bent) = self.bent(optimum)
        {
            let other = self.moved(self.at, &bent, evaluations);
            if half_mm(&other) < half_mm(&best) {
                return other;
            }
        }
        best
    }

    fn bent(&self, optimum: &Optimum) -> Option<Vec<f64>> {
        let indices: Vec<usize> = optimum.held.iter().map(|held| self.working[held.row]).collect();
        let contacts = bend::Contacts { held: &optimum.held, indices: &indices };
        let Linear { place, half_mm, .. } = self.at;
        bend::step(self.problem, self.directions, place, self.rows, contacts, *half_mm)
    }

    /// `y` in half widths of `from`.
    fn moved(
        &self,
        from: &Linear<R::Place>,
        y: &[f64],
        evaluations: &mut usize,
    ) -> Option<Linear<R::Place>> {
        *evaluations += self.working.len();
        let y_mm: Vec<f64> = y.iter().map(|y| y * from.half_mm).collect();
        let step = self.directions.step(&y_mm, self.problem.parameters());
        let place = self.problem.moved(&from.place, &step)?;
        Linear::new(self.problem, self.directions, self.working, &place)
    }
}

/// Infinite where a point lost its distance.
fn half_mm<P>(at: &Option<Linear<P>>) -> f64 {
    at.as_ref().map_or(f64::INFINITY, |at| at.half_mm)
}

/// A place and the rows of the working points there.
#[derive(Clone)]
struct Linear<P> {
    place: P,
    rows: Vec<f64>,
    centre_mm: f64,
    half_mm: f64,
}

impl<P: Clone + Sync> Linear<P> {
    fn new<R: Residuals<Place = P>>(
        problem: &R,
        directions: &Directions,
        working: &[usize],
        place: &P,
    ) -> Option<Linear<P>> {
        let mut rows = Vec::with_capacity(working.len() * (problem.parameters() + 1));
        problem.rows(place, working.iter().copied(), &mut rows)?;
        let distances = rows.chunks_exact(problem.parameters() + 1);
        let span = Span::of(distances.map(|row| row[problem.parameters()]));
        let (centre_mm, half_mm) =
            (span.centre_mm(directions.floating), span.half_mm(directions.floating));
        half_mm.is_finite().then(|| Linear { place: place.clone(), rows, centre_mm, half_mm })
    }

    /// What weak duality says: Σ λ_i·s_i·(d_i − c), less what the sum of the derivatives could add within
    /// two half widths. Any better place lies within that motion, since no point moves by more.
    fn lower_mm(&self, rows: &Rows, optimum: &Optimum) -> f64 {
        let (mut sum, mut all) = (0.0, 0.0);
        for held in &optimum.held {
            sum += held.multiplier * held.side() * rows.start(held.row);
            all += held.multiplier;
        }
        if all > 0.0 { self.half_mm * (sum - 2.0 * optimum.pull) / all } else { 0.0 }
    }

    /// All points lie on one surface of the family, to within the tolerance.
    fn touching(self, evaluations: usize) -> Bottom<P> {
        Bottom {
            place: self.place,
            centre_mm: self.centre_mm,
            half_mm: self.half_mm,
            lower_mm: 0.0,
            contacts: Vec::new(),
            pull: 0.0,
            evaluations,
        }
    }

    fn bottom(
        self,
        working: &[usize],
        optimum: &Optimum,
        lower_mm: f64,
        evaluations: usize,
    ) -> Bottom<P> {
        let contact = |held: &Held| Holding {
            index: working[held.row],
            high: held.high,
            multiplier: held.multiplier,
        };
        Bottom {
            contacts: optimum.held.iter().map(contact).collect(),
            pull: optimum.pull,
            place: self.place,
            centre_mm: self.centre_mm,
            half_mm: self.half_mm,
            lower_mm: lower_mm.max(0.0),
            evaluations,
        }
    }
}

/// Steps are trusted within so many half widths at first: a better place is at most two away.
const REACH: f64 = 4.0;
/// Shares of the predicted gain: below the first a step was too long, above the second it may grow.
const POOR: f64 = 0.25;
const GOOD: f64 = 0.75;
const SHORTER: f64 = 0.25;
const LONGER: f64 = 2.0;
/// A share of the half width so small that shorter steps are rounding.
const LEAST_REACH: f64 = 1e-12;
/// A pull above this is none of rounding.
const HELD_BY_BOX: f64 = 1e-10;
/// Steps that follow one that did not help.
const RELAXED: usize = 5;
/// Newton's convergence needs three or four; along a bent valley many are needed.
const STEPS: usize = 200;
