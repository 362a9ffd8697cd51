//! The minimum zone of a nominal laid into points: the narrowest pair of surfaces that holds them all.

mod bend;
mod descend;
mod directions;
mod exchange;
mod linearised;
mod residuals;
mod scan;
mod search;
#[cfg(test)]
mod tests;

use crate::fit::model::Model;
use crate::fit::refine::{priority, rounding_mm};
use crate::fit::selection::{Membership, Selection};
use crate::fit::{extremes, fit};
use crate::{Excluded, Fit, FitError, FitSettings, Nominal, Parameter, PointMm, Pose};
use directions::Directions;
pub use linearised::LinearZone;
use residuals::{Laid, Part};
use search::{End, Found, Limits, search};

/// Which zone is made narrow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Criterion {
    /// The range of the distances, largest less smallest: the zone lies between two surfaces parallel to the
    /// nominal at any offset from it. Flatness by the minimum zone of ISO 12781-1, and the peak to valley figure
    /// at its least.
    ///
    /// On a curved surface the offset is a freedom of its own: a sphere of fixed radius may be laid into
    /// points of any other. Mind [`ZoneFit::offset_mm`], which is large on shallow parts with a wrong
    /// radius.
    #[default]
    Range,
    /// Twice the largest distance: the zone lies symmetrically about the nominal. The profile of any surface
    /// as in ISO 1101, and the Chebyshev (L∞) fit.
    Centred,
}

impl Criterion {
    /// Name of the criterion, as reports give it.
    pub fn method(self) -> &'static str {
        match self {
            Criterion::Range => "orthogonal minimum zone",
            Criterion::Centred => "orthogonal minimum zone, centred",
        }
    }
}

/// Choice of what to fit and how far to go.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneSettings {
    /// The least-squares fit the search begins with. Its free parameters are those of the search too.
    pub fit: FitSettings,
    /// Which zone.
    pub criterion: Criterion,
    /// The zone is settled once it exceeds its lower bound by this share of itself or less; never less than
    /// rounding of the coordinates makes meaningful.
    pub tolerance: f64,
    /// Largest number of passes over all points. Four to eight are usual.
    pub max_scans: usize,
}

impl Default for ZoneSettings {
    /// A least-squares fit as by default, the range, to 1e-10, 100 passes.
    fn default() -> ZoneSettings {
        ZoneSettings {
            fit: FitSettings::default(),
            criterion: Criterion::default(),
            tolerance: 1e-10,
            max_scans: 100,
        }
    }
}

/// The result of a search for the minimum zone.
#[derive(Clone, Debug, PartialEq)]
pub struct ZoneFit {
    /// [`Criterion::method`].
    pub method: &'static str,
    /// Which zone was made narrow.
    pub criterion: Criterion,
    /// Width of the zone in mm: the range of the distances of all points used or, centred, twice the largest.
    pub zone_mm: f64,
    /// Middle of the zone in mm from the nominal, along its normal; 0 if centred. Shifts of the pose come
    /// first: it is 0 to rounding where they or the radius make up for it, as for a plane.
    pub offset_mm: f64,
    /// From the part frame into the measured frame.
    pub pose: Pose,
    /// The nominal with its fitted shape.
    pub nominal: Nominal,
    /// The points that hold the zone, ascending. Empty if the zone is no wider than rounding.
    pub contacts: Vec<Contact>,
    /// How far the zone is known to be the narrowest.
    pub certificate: Certificate,
    /// Why the search ended.
    pub termination: ZoneTermination,
    /// Distances computed after the least-squares fit.
    pub evaluations: usize,
    /// Free parameters the points do not determine; they stayed at their start.
    pub indeterminate: Vec<Parameter>,
    /// Points used.
    pub used: usize,
    /// Points left out.
    pub excluded: Excluded,
    /// The fit the search began with. Its pose decides which points lie in the aperture, so that both speak of the
    /// same points.
    pub least_squares: Fit,
}

/// A point that touches the border of the zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Index among the points given.
    pub index: usize,
    /// Which border.
    pub side: Side,
    /// Its share in holding the zone, above 0; all of them add up to 1, to 10⁻⁴ or better. If the point moved inwards, the half
    /// width would fall by this share of the motion.
    pub multiplier: f64,
}

/// A border of a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The one on the +z side.
    High,
    /// The one on the −z side.
    Low,
}

/// Proof that no place near by has a narrower zone.
///
/// A pose is a local minimum to first order (the conditions of Karush, Kuhn and Tucker) if contacts with
/// multipliers λ ≥ 0, Σ λ = 1, have Σ λ·s·∂d/∂x = 0 for every unknown x, s = ±1 being the side. For any
/// such λ, Σ λ·s·(d − offset) bounds the half width from below. Whether another minimum far away is narrower
/// remains unknown, as for a least-squares fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Lower bound of the zone in mm, by the multipliers, to first order.
    pub lower_mm: f64,
    /// `zone_mm` less the bound.
    pub gap_mm: f64,
    /// Length of Σ λ·s·∂d/∂x over the directions of the parameters, each scaled to move the surface by 1 mm
    /// root mean square a unit; 0 at the exact minimum.
    pub stationarity: f64,
    /// Points held against the zone in the last pass: all that are used.
    pub scanned: usize,
    /// Points whose derivatives took part.
    pub working: usize,
    /// Passes over all points.
    pub scans: usize,
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ZoneTermination {
    /// The zone exceeds its lower bound by no more than the tolerance.
    Settled {
        /// The excess in mm.
        gap_mm: f64,
        /// The tolerance in mm.
        tolerance_mm: f64,
    },
    /// No step, however short, made the zone narrower, or very many short ones did not end. The gap says how much
    /// may be left: shape parameters that all but make up for each other leave some 10⁻⁵ of the zone.
    NoDescent {
        /// The excess over the lower bound in mm.
        gap_mm: f64,
    },
    /// The largest number of passes was made.
    MaxScans {
        /// That number.
        limit: usize,
        /// The excess over the lower bound in mm.
        gap_mm: f64,
    },
}

impl ZoneTermination {
    /// Whether the result is a minimum zone.
    pub fn is_settled(&self) -> bool {
        matches!(self, ZoneTermination::Settled { .. })
    }
}

/// Lays `nominal` into `points` of the measured frame so that the zone of the orthogonal distances is as
/// narrow as possible.
///
/// After a least-squares fit, minimax problems over some of the points are solved by linear programming and
/// all points held against the answer; those that stick out join in, until none does. No point lies outside
/// the zone, and the zone is never wider than at the least-squares pose. Fails as [`fit`] does. The same
/// points in the same order give the same bits, whatever the number of threads.
///
/// `O(n·p²)` once and `O(n)` a pass for n points and p parameters, and `O(n)` memory. Failing to settle is
/// no error: see [`ZoneFit::termination`].
pub fn minimum_zone(
    points: &[PointMm],
    nominal: &Nominal,
    settings: &ZoneSettings,
) -> Result<ZoneFit, FitError> {
    let least_squares = fit(points, nominal, &settings.fit)?;
    let (laid, pose) = (&least_squares.nominal, &least_squares.pose);
    let selection = Selection::new(points, None, laid, pose, &settings.fit.aperture);
    let used = selection.points.len();
    if used == 0 {
        // Only where the points in the aperture had not settled.
        let (low_mm, high_mm) = extremes(points);
        let finite = points.len() - selection.excluded.not_finite;
        return Err(FitError::OutsideAperture { finite, low_mm, high_mm });
    }
    let free: Vec<Parameter> = least_squares.estimates.iter().map(|e| e.parameter).collect();
    let part = Part { points: &selection.points, free: &free };
    let start = Laid { pose: least_squares.pose, nominal: least_squares.nominal.clone() };
    let by_range = settings.criterion == Criterion::Range;
    let overflow = FitError::Overflow { used };
    let order = priority(&free, &start.nominal);
    let rank = settings.fit.rank_tolerance;
    let directions =
        Directions::new(&part, &start, (&least_squares.freedoms, &order), by_range, rank)
            .ok_or(overflow.clone())?;
    let limits = Limits {
        tolerance: settings.tolerance,
        rounding_mm: rounding_mm(&selection.points),
        scans: settings.max_scans,
        by_range,
    };
    let found = search(&part, &directions, start, limits).ok_or(overflow)?;
    let mut indeterminate = least_squares.indeterminate.clone();
    indeterminate.extend(directions.indeterminate.iter().map(|&index| free[index]));
    Ok(report(found, &selection, indeterminate, least_squares, settings))
}

fn report(
    found: Found<Laid>,
    selection: &Selection,
    indeterminate: Vec<Parameter>,
    least_squares: Fit,
    settings: &ZoneSettings,
) -> ZoneFit {
    let by_range = settings.criterion == Criterion::Range;
    let zone_mm = 2.0 * found.span.half_mm(by_range);
    // Rounding may lift the bound a little above the zone.
    let gap_mm = (zone_mm - 2.0 * found.lower_mm).max(0.0);
    let used = selection.points.len();
    let given = given_indices(selection);
    let model = Model::new(&found.place.nominal, &found.place.pose, &[]);
    let offset_mm = found.span.centre_mm(by_range);
    // Of a pair of bounds that hardly matter the linear problem may have taken the one that does not touch.
    let slack_mm = 0.5 * (gap_mm + TOUCHING * zone_mm);
    let touches = |holding: &&descend::Holding| {
        let foot = model.foot(selection.points[holding.index]);
        let off_mm = foot.map_or(f64::NAN, |foot| foot.distance_mm()) - offset_mm;
        0.5 * zone_mm - off_mm.abs() <= slack_mm
    };
    let contact = |holding: &descend::Holding| Contact {
        index: given[holding.index],
        side: if holding.high { Side::High } else { Side::Low },
        multiplier: holding.multiplier,
    };
    let contacts = found.contacts.iter().filter(touches).map(contact).collect();
    ZoneFit {
        method: settings.criterion.method(),
        criterion: settings.criterion,
        zone_mm,
        offset_mm,
        pose: found.place.pose,
        nominal: found.place.nominal,
        contacts,
        certificate: Certificate {
            lower_mm: zone_mm - gap_mm,
            gap_mm,
            stationarity: found.pull,
            scanned: used,
            working: found.working,
            scans: found.scans,
        },
        termination: match found.end {
            End::Settled => {
                ZoneTermination::Settled { gap_mm, tolerance_mm: 2.0 * found.tolerance_mm }
            }
            End::NoDescent => ZoneTermination::NoDescent { gap_mm },
            End::Scans => ZoneTermination::MaxScans { limit: settings.max_scans, gap_mm },
        },
        evaluations: found.evaluations,
        indeterminate,
        used,
        excluded: selection.excluded,
        least_squares,
    }
}

/// For every used point its index among all.
fn given_indices(selection: &Selection) -> Vec<usize> {
    let memberships = selection.memberships.iter().enumerate();
    memberships.filter_map(|(i, &member)| (member == Membership::Used).then_some(i)).collect()
}

/// A point nearer to the border than this share of the zone touches it.
const TOUCHING: f64 = 1e-6;
