//! What a fit that was made must be read with.

use std::fmt;

use crate::Combination;

/// Something about a fit that makes its figures doubtful or surprising.
#[derive(Clone, Debug, PartialEq)]
pub enum Caution {
    /// The points only fit the part turned upside down: its +z side lies opposite to that of the start.
    /// Deviations stay positive on the +z side of the part.
    UpsideDown {
        /// Whether [`FitSettings::side`](crate::FitSettings) allows that.
        allowed: bool,
    },
    /// The points fit the mirror image z → −z of the nominal far better than the nominal, and no motion that is
    /// free makes the one of the other: heights or radii have the wrong sign.
    Mirrored {
        /// Root mean square deviation from the nominal in mm.
        rms_mm: f64,
        /// That from the mirror image in mm.
        mirrored_rms_mm: f64,
    },
    /// Points in the aperture stand over no place of the nominal.
    BeyondDomain {
        /// Distance from the axis in mm at which the nominal ends.
        domain_mm: f64,
        /// How many points.
        beyond: usize,
        /// How far from the axis the farthest of them stands, in mm.
        farthest_mm: f64,
    },
    /// The points fit far better in another unit.
    Units(Units),
    /// The fit rests on a few points, which count far more than all others.
    FewCount {
        /// Points of equal weight that would tell as much: [`crate::Fit::effective_points`].
        effective: f64,
        /// Points used.
        used: usize,
        /// Parameters estimated.
        estimated: usize,
    },
    /// The points barely determine a combination of the estimated parameters.
    IllConditioned {
        /// Largest over smallest singular value of the scaled Jacobian.
        condition: f64,
        /// The combination.
        combination: Combination,
    },
}

/// Points that look as if they were read in another unit than theirs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// What the coordinates would have to be multiplied by: 1e-3 or 1e3, heights alone also 1e-6.
    pub factor: f64,
    /// Whether only the heights would have to be.
    pub heights_only: bool,
    /// Root mean square deviation from the fitted nominal over that from the best plane, with the points as
    /// they are; `None` if there is no fit.
    pub now: Option<f64>,
    /// Counterpart with the points so multiplied.
    pub then: f64,
}

impl fmt::Display for Units {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, other, scaled) = match self.factor {
            factor if factor > 1.0 => ("m", "µm", format!("multiplied by {factor:.0}")),
            factor if factor < 1e-4 => ("nm", "km", format!("divided by {:.0}", 1.0 / factor)),
            factor => ("µm", "m", format!("divided by {:.0}", 1.0 / factor)),
        };
        let points = if self.heights_only { "heights" } else { "points" };
        write!(
            f,
            "the {points} were read in another unit than they have: {scaled} they fit the nominal. If they were read as mm, they are in {unit}, not mm"
        )?;
        match self.heights_only {
            true => Ok(()),
            false => write!(f, ", or the nominal is in {other}"),
        }
    }
}

impl fmt::Display for Caution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Caution::UpsideDown { allowed: true } => f.write_str(
                "the part was measured from its other side: only so the points fit it. Its +z side points down here, and a positive deviation stands out to that side",
            ),
            Caution::UpsideDown { allowed: false } => f.write_str(
                "the points fit the part upside down only. If it was measured from its other side, allow that: `side = \"either\"` in the table [fit] of the nominal. Or turn the points: `--along 0,0,-1` (in a station, `[projection] along = [0, 0, -1]`). If the nominal exchanges convex and concave, `asphera nominal FILE --flip` makes the other one",
            ),
            Caution::Mirrored { rms_mm, mirrored_rms_mm } => write!(
                f,
                "with the sign of z exchanged the points fit the nominal: RMS {mirrored_rms_mm:.1e} mm, now {rms_mm:.1e} mm. If the part was measured from its other side, turn the points: `--along 0,0,-1` (in a station, \
                 `[projection] along = [0, 0, -1]`). Or make the nominal of the other side: `asphera nominal FILE --flip`"
            ),
            Caution::BeyondDomain { domain_mm, beyond, farthest_mm } if domain_mm.is_infinite() => write!(
                f,
                "{beyond} points in the aperture have no foot on the nominal; the farthest stands {farthest_mm:.6} mm from the \
                 axis: correct its coefficients"
            ),
            Caution::BeyondDomain { domain_mm, beyond, farthest_mm } => write!(
                f,
                "{beyond} points in the aperture lie beyond the nominal, which ends {domain_mm:.6} mm from its \
                 axis; the farthest stands at {farthest_mm:.6} mm: correct radius and conic, or narrow the aperture"
            ),
            Caution::Units(units) => units.fmt(f),
            Caution::FewCount { effective, used, estimated } => write!(
                f,
                "{estimated} parameters are determined by few points: {used} have a weight, but count as {effective:.1} of equal weight. Correct the smallest uncertainties, or set weights = \"none\""
            ),
            Caution::IllConditioned { condition, combination } => write!(
                f,
                "the points barely determine {combination}: condition {condition:.1e}; hold one of these, or measure \
                 more of the part"
            ),
        }
    }
}
