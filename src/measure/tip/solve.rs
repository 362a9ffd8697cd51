//! Contacts of all centres: fits and contacts in turn, until no contact moves.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use asphera_form::{MeasuredFrom, Pose, Touch, Touched, Untouched};
use asphera_geometry::vector::{dot, minus, plus};
use asphera_geometry::{Point, PointMm, RANGE_MM};
use asphera_surface::Plane;
use rayon::prelude::*;

use super::{Centres, Tip, UP};
use crate::fitting::{Fitted, NoFit, fitted};
use crate::profile::{Line, fit_along};
use crate::systematic::Systematic;
use crate::{Part, Weights, origin};

/// Contacts of all centres.
pub(crate) struct Solved {
    /// The contacts, or the lowest points of the ball where there is no fit; measured frame, in order of measurement.
    pub(crate) contacts: Vec<Point>,
    /// Centres without a contact, by reason.
    pub(crate) untouched: BTreeMap<&'static str, u64>,
    pub(super) tip: Tip,
    /// The contacts, unless there is no fit.
    pub(super) found: Result<Found, NoFit>,
    pub(super) passes: u32,
    pub(super) last_move_mm: f64,
}

/// Extremes of the contacts, measured frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) contacts: u64,
    /// Smallest cosine between normal and probe, and its contact, mm.
    pub(super) steepest: (f64, PointMm),
    /// Largest curvature towards the ball, 1/mm, and its centre, mm.
    pub(super) most_hollow: (f64, PointMm),
}

/// A centre on its way to its contact, in the frame of the plane of projection.
#[derive(Clone, Copy)]
struct Ball {
    centre_mm: PointMm,
    /// The contact as far as known; the lowest point at first.
    near_mm: PointMm,
    touched: Result<Touched, Untouched>,
}

impl Centres {
    /// The contacts. The time is that of a few fits.
    pub(crate) fn solve(self, part: &Part, plane: &Plane) -> Solved {
        let Centres { tip, centres, .. } = self;
        let is_known = |point: &&Point| point.at_mm.iter().all(|at| at.abs() <= RANGE_MM);
        let known: Vec<Point> = centres.iter().filter(is_known).copied().collect();
        let mut solving = Solving::new(&known, tip, part, plane);
        let (mut passes, mut last_move_mm) = (0, f64::INFINITY);
        let mut fit = solving.fit().or_else(|error| solving.first_by_design().ok_or(error));
        while let Ok(laid) = &fit {
            last_move_mm = solving.touch(laid);
            passes += 1;
            fit = solving.fit();
            if last_move_mm <= SETTLED_MM || passes == MOST_PASSES {
                break;
            }
        }
        let found = fit.map(|_| solving.found());
        let (contacts, untouched) = match &found {
            Ok(_) => solving.contacts(&known),
            Err(_) => (solving.lowest(&known), BTreeMap::new()),
        };
        Solved { contacts, untouched, tip, found, passes, last_move_mm }
    }
}

impl Solved {
    /// The radius of the ball as an error that all contacts have together; `None` where points are no contacts.
    pub(crate) fn systematic(&self) -> Option<Systematic> {
        self.found.is_ok().then(|| Systematic::of_tip(&self.tip))
    }
}

struct Solving<'a> {
    part: &'a Part,
    plane: &'a Plane,
    tip: Tip,
    balls: Vec<Ball>,
    /// Standard uncertainties of the heights of all, mm, where they are the weights.
    heights_mm: Option<Vec<f64>>,
    /// The line of a profile, whose contacts stay on it.
    line: Option<Line>,
}

impl Solving<'_> {
    fn new<'a>(known: &[Point], tip: Tip, part: &'a Part, plane: &'a Plane) -> Solving<'a> {
        let balls: Vec<Ball> = known
            .iter()
            .map(|point| {
                let centre_mm = plane.to_plane(point.at_mm);
                let near_mm = plus(centre_mm, -tip.radius_mm, UP);
                Ball { centre_mm, near_mm, touched: Err(Untouched::BeyondNominal) }
            })
            .collect();
        let centres_mm: Vec<PointMm> = balls.iter().map(|ball| ball.centre_mm).collect();
        let is_weighted = part.criterion.weights == Weights::Uncertainty;
        let heights_mm: Option<Vec<f64>> = known.iter().map(|point| point.u_z_mm).collect();
        Solving {
            part,
            plane,
            tip,
            balls,
            heights_mm: heights_mm.filter(|_| is_weighted),
            line: Line::through(&centres_mm),
        }
    }

    /// The fit of the contacts as they are; of the lowest points before the first pass.
    fn fit(&self) -> Result<Fitted, NoFit> {
        let is_first = self.balls.iter().all(|ball| ball.touched.is_err());
        let counts = |ball: &Ball| is_first || ball.touched.is_ok();
        let places_mm: Vec<PointMm> =
            self.balls.iter().filter(|ball| counts(ball)).map(|ball| ball.near_mm).collect();
        self.fit_of(&places_mm, is_first)
    }

    /// The first fit by contacts with the design, as it lies at the start or, where the part may have been measured from its other
    /// side, upside down. It serves where the lowest points are too far from the shape of the design for a fit. `None` where there is
    /// none either; then the balls stay at their lowest points.
    fn first_by_design(&mut self) -> Option<Fitted> {
        if self.part.reference.is_some() {
            return None;
        }
        let lowest_mm: Vec<PointMm> = self.balls.iter().map(|ball| ball.near_mm).collect();
        let start = origin::start_of(self.part, &lowest_mm);
        let turned = Pose { rx_rad: start.rx_rad + PI, ..start };
        let may_turn = self.part.side == MeasuredFrom::Either;
        for pose in [Some(start), may_turn.then_some(turned)].into_iter().flatten() {
            let touch = Touch::new(&self.part.nominal, &pose, self.tip.radius_mm, UP);
            for ball in &mut self.balls {
                ball.near_mm = touch.contact_at_any_height(ball.centre_mm);
            }
            if let Ok(found) = self.fit() {
                return Some(found);
            }
        }
        self.balls.iter_mut().zip(lowest_mm).for_each(|(ball, at_mm)| ball.near_mm = at_mm);
        None
    }

    /// The fit of these places, one a ball that touches, or one a ball.
    fn fit_of(&self, places_mm: &[PointMm], of_all: bool) -> Result<Fitted, NoFit> {
        let heights_mm: Option<Vec<f64>> = self.heights_mm.as_ref().map(|heights_mm| {
            let of = self.balls.iter().zip(heights_mm);
            of.filter(|(ball, _)| of_all || ball.touched.is_ok()).map(|(_, u_mm)| *u_mm).collect()
        });
        match &self.line {
            Some(line) => fit_along(line, places_mm, self.part, self.plane, heights_mm.as_deref()),
            None => fitted(places_mm, self.part, self.plane, heights_mm.as_deref()),
        }
    }

    /// Lays every ball on the fitted nominal; gives the farthest way of a contact, mm.
    fn touch(&mut self, laid: &Fitted) -> f64 {
        let touch = Touch::new(&laid.fit.nominal, &laid.fit.pose, self.tip.radius_mm, UP);
        let across = self.line.as_ref().map(Line::across);
        let moves = self.balls.par_iter_mut().with_min_len(1024).map(|ball| {
            ball.touched = match across {
                Some(across) => touch.contact_in_plane(ball.centre_mm, ball.near_mm, across),
                None => touch.contact(ball.centre_mm, ball.near_mm),
            };
            let Ok(touched) = ball.touched else { return 0.0 };
            let way = minus(touched.at_mm, ball.near_mm);
            ball.near_mm = touched.at_mm;
            dot(way, way).sqrt()
        });
        moves.reduce(|| 0.0, f64::max)
    }

    /// Contacts in the measured frame, and counts of balls without one.
    fn contacts(&self, known: &[Point]) -> (Vec<Point>, BTreeMap<&'static str, u64>) {
        let mut untouched = BTreeMap::new();
        let mut contacts = Vec::with_capacity(self.balls.len());
        for (ball, point) in self.balls.iter().zip(known) {
            match ball.touched {
                Ok(touched) => {
                    let at_mm = self.plane.from_plane(touched.at_mm);
                    contacts.push(Point { at_mm, ..*point });
                }
                Err(why) => *untouched.entry(reason(why)).or_default() += 1,
            }
        }
        (contacts, untouched)
    }

    /// The lowest points of the balls, measured frame.
    fn lowest(&self, known: &[Point]) -> Vec<Point> {
        let normal = self.plane.normal();
        let lower = |point: &Point| plus(point.at_mm, -self.tip.radius_mm, normal);
        known.iter().map(|point| Point { at_mm: lower(point), ..*point }).collect()
    }

    fn found(&self) -> Found {
        let touching =
            self.balls.iter().filter_map(|ball| Some((ball, ball.touched.as_ref().ok()?)));
        let (mut steepest, mut most_hollow) = ((1.0, [0.0; 3]), (f64::NEG_INFINITY, [0.0; 3]));
        for (ball, touched) in touching {
            let cosine = dot(touched.normal, UP);
            if cosine <= steepest.0 {
                steepest = (cosine, touched.at_mm);
            }
            if touched.hollow_per_mm > most_hollow.0 {
                most_hollow = (touched.hollow_per_mm, ball.centre_mm);
            }
        }
        // One that does not fit is more hollow than any that does.
        let too_hollow = |ball: &&Ball| ball.touched == Err(Untouched::TooHollow);
        if let Some(ball) = self.balls.iter().find(too_hollow) {
            most_hollow = (f64::INFINITY, ball.centre_mm);
        }
        let measured = |(value, at_mm): (f64, PointMm)| (value, self.plane.from_plane(at_mm));
        let contacts = self.balls.iter().filter(|ball| ball.touched.is_ok()).count() as u64;
        Found { contacts, steepest: measured(steepest), most_hollow: measured(most_hollow) }
    }
}

/// The flag of a centre without a contact.
fn reason(why: Untouched) -> &'static str {
    match why {
        Untouched::BeyondNominal => "tip_beyond_nominal",
        Untouched::Upright => "tip_on_wall",
        Untouched::TooHollow => TOO_HOLLOW,
    }
}

/// The flag of a centre where the ball does not fit.
pub(super) const TOO_HOLLOW: &str = "tip_does_not_fit";
/// A contact that moves less has settled: the deviation there changes by far less.
const SETTLED_MM: f64 = 1e-9;
/// Passes at most. Two or three are usual.
const MOST_PASSES: u32 = 20;
