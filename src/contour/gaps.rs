//! Curves across a gap between two ends: a corner, or the curve whose curvature varies least.
//!
//! How wide a gap may be is for the caller to say. After the sketch completion of A. D. Parakkat, P. Memari, M.-P. Cani, *Delaunay painting:
//! perceptual image coloring from raster contours with gaps*, Computer Graphics Forum 41 (2022); the text was not at hand.

mod minimum_variation;
mod pairs;

use minimum_variation::{Course, course};
pub use pairs::{Gap, MOST_ENDS, gaps_of};

use crate::samples::PlaceMm;
use crate::triangulation::distance_mm;

/// An end of a curve at a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapEnd {
    /// Where it ends, mm.
    pub at_mm: PlaceMm,
    /// The direction in which it would go on into the gap, of any length above 0.
    pub onward: [f64; 2],
    /// Whether it is straight there, within its noise.
    pub is_straight: bool,
}

/// The curve across a gap.
#[derive(Clone, Debug, PartialEq)]
pub enum GapCurve {
    /// Both ends go on straight to a corner.
    Corner {
        /// The corner, mm.
        at_mm: PlaceMm,
    },
    /// A smooth curve with the directions of both ends.
    Smooth {
        /// Places evenly along it, its ends among them, mm.
        places_mm: Vec<PlaceMm>,
        /// Its length, mm.
        length_mm: f64,
        /// What was made least: (∫ds)⁵/|AB|²·∫(dκ/ds)²ds, without unit; 0 of an arc of a circle.
        energy: f64,
    },
}

/// Reason why no curve crosses a gap.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GapError {
    /// The ends lie in one place, or a direction has no length.
    #[error("gap from ({}, {}) to ({}, {}) mm: expected two places and a direction at each, found {found}; leave the gap open", .from_mm[0], .from_mm[1], .to_mm[0], .to_mm[1])]
    NoDirection {
        /// The first end, mm.
        from_mm: PlaceMm,
        /// The second end, mm.
        to_mm: PlaceMm,
        /// The fault.
        found: &'static str,
    },
    /// No smooth curve without a loop was found.
    #[error("gap from ({}, {}) to ({}, {}) mm: expected ends that a smooth curve can join, found directions that point away from it; leave the gap open", .from_mm[0], .from_mm[1], .to_mm[0], .to_mm[1])]
    NoCurve {
        /// The first end, mm.
        from_mm: PlaceMm,
        /// The second end, mm.
        to_mm: PlaceMm,
    },
}

impl GapEnd {
    /// The end of a chain of places that end there: its last places are fitted by a line, and by a parabola over it.
    ///
    /// It is straight if the parabola stays within twice the noise of its chord. The noise is its standard deviation in mm, and not less than the
    /// scatter of the places about the parabola. None of fewer than three places, or if they lie in one spot.
    pub fn of_places(places_mm: &[PlaceMm], sigma_mm: f64) -> Option<GapEnd> {
        let last = &places_mm[places_mm.len().saturating_sub(FITTED)..];
        let (&end, &first) = (last.last()?, last.first()?);
        let length_mm = distance_mm(first, end);
        if last.len() < 3 || length_mm == 0.0 {
            return None;
        }
        let along = [(end[0] - first[0]) / length_mm, (end[1] - first[1]) / length_mm];
        // Coordinates from the end: s backwards along the chord, t across it.
        let rows: Vec<[f64; 2]> = last
            .iter()
            .map(|place| {
                let [x, y] = [place[0] - end[0], place[1] - end[1]];
                [
                    (x * along[0] + y * along[1]) / length_mm,
                    (along[0] * y - along[1] * x) / length_mm,
                ]
            })
            .collect();
        let bend = curvature(&rows)?;
        // A parabola of second coefficient c is at most c/4 from its chord over a length of 1.
        let noise_mm = sigma_mm.max(scatter(&rows, bend) * length_mm).max(ROUNDING * length_mm);
        let is_straight = (bend / 4.0).abs() * length_mm <= 2.0 * noise_mm;
        let slope = slope_at_end(&rows, if is_straight { 0.0 } else { bend })?;
        let onward = [along[0] - slope * along[1], along[1] + slope * along[0]];
        Some(GapEnd { at_mm: end, onward, is_straight })
    }
}

/// The curve across a gap, from one end to the other.
///
/// It is a corner where both ends are straight, their lines meet ahead of both at less than 60°, and the corner is nearer to the gap than twice
/// its width. Otherwise it is the scale-invariant minimum variation curve (SIMVC; H. P. Moreton, C. H. Séquin, SIGGRAPH 1992, 167-176): of all curves
/// with these ends and directions that of the least
///
/// E = (∫ds)⁵/|AB|² · ∫(dκ/ds)² ds
///
/// κ is the curvature, s the length along the curve, A and B the ends. Its curvature is a polynomial of degree 10 of the length.
///
/// # Errors
///
/// Ends in one place, a direction without length, or directions that no such curve joins.
pub fn gap_curve(from: GapEnd, to: GapEnd) -> Result<GapCurve, GapError> {
    let (from_mm, to_mm) = (from.at_mm, to.at_mm);
    let chord = [to_mm[0] - from_mm[0], to_mm[1] - from_mm[1]];
    let width_mm = distance_mm(from_mm, to_mm);
    let has_length = |[x, y]: [f64; 2]| x.is_finite() && y.is_finite() && (x != 0.0 || y != 0.0);
    let no_direction = |found| GapError::NoDirection { from_mm, to_mm, found };
    if !has_length(chord) {
        return Err(no_direction("one place"));
    }
    if !has_length(from.onward) || !has_length(to.onward) {
        return Err(no_direction("a direction without length"));
    }
    if let Some(at_mm) = corner(from, to, width_mm) {
        return Ok(GapCurve::Corner { at_mm });
    }
    // Angles to the chord: of the curve where it begins, and where it ends.
    let turn = |[x, y]: [f64; 2]| (chord[0] * y - chord[1] * x).atan2(chord[0] * x + chord[1] * y);
    let angles = [turn(from.onward), turn([-to.onward[0], -to.onward[1]])];
    let found = course(angles).ok_or(GapError::NoCurve { from_mm, to_mm })?;
    let Course { places, length, energy } = found;
    let place = |[x, y]: [f64; 2]| {
        [from_mm[0] + x * chord[0] - y * chord[1], from_mm[1] + x * chord[1] + y * chord[0]]
    };
    let mut places_mm: Vec<PlaceMm> = places.into_iter().map(place).collect();
    if let Some(last) = places_mm.last_mut() {
        *last = to_mm;
    }
    Ok(GapCurve::Smooth { places_mm, length_mm: length * width_mm, energy })
}

/// The corner in which straight ends meet, if it is sharp and near.
fn corner(from: GapEnd, to: GapEnd, width_mm: f64) -> Option<PlaceMm> {
    if !from.is_straight || !to.is_straight {
        return None;
    }
    let [ux, uy] = from.onward;
    let [vx, vy] = to.onward;
    let [x, y] = [to.at_mm[0] - from.at_mm[0], to.at_mm[1] - from.at_mm[1]];
    let cross = ux * vy - uy * vx;
    let [first, second] = [(x * vy - y * vx) / cross, (x * uy - y * ux) / cross];
    // The angle at the corner is that between the ways onward.
    let is_sharp = cross.abs().atan2(ux * vx + uy * vy) < std::f64::consts::FRAC_PI_3;
    if !(is_sharp && first > 0.0 && second > 0.0) {
        return None;
    }
    let at_mm = [from.at_mm[0] + first * ux, from.at_mm[1] + first * uy];
    // The corner lies ahead of both ends: the foot on the gap may lie beyond it.
    let off_mm = ((at_mm[0] - from.at_mm[0]) * y - (at_mm[1] - from.at_mm[1]) * x).abs() / width_mm;
    (off_mm < 2.0 * width_mm).then_some(at_mm)
}

/// The second coefficient of the least-squares parabola through rows of s and t.
fn curvature(rows: &[[f64; 2]]) -> Option<f64> {
    let count = rows.len() as f64;
    let mean = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        rows.iter().map(|&[s, t]| of(s, t)).sum::<f64>() / count
    };
    let middle = mean(&|s, _| s);
    let [s2, s3, s4] = [2, 3, 4].map(|power| mean(&|s, _| (s - middle).powi(power)));
    let [t0, t1, t2] = [0, 1, 2].map(|power| mean(&|s, t| t * (s - middle).powi(power)));
    // Normal equations of t = a + b·(s - m) + c·((s - m)² - s2), b eliminated.
    let bend = (t2 - s2 * t0 - s3 * t1 / s2) / (s4 - s2 * s2 - s3 * s3 / s2);
    (s2 > 0.0 && bend.is_finite()).then_some(bend)
}

/// The slope at s = 0 of the least-squares curve with a given second coefficient.
fn slope_at_end(rows: &[[f64; 2]], bend: f64) -> Option<f64> {
    let count = rows.len() as f64;
    let middle = rows.iter().map(|row| row[0]).sum::<f64>() / count;
    let (mut top, mut bottom) = (0.0, 0.0);
    for &[s, t] in rows {
        top += (s - middle) * (t - bend * (s - middle) * (s - middle));
        bottom += (s - middle) * (s - middle);
    }
    let slope = top / bottom - 2.0 * bend * middle;
    slope.is_finite().then_some(slope)
}

/// Standard deviation of rows about the least-squares parabola with a given second coefficient; 0 where it goes through all.
fn scatter(rows: &[[f64; 2]], bend: f64) -> f64 {
    let count = rows.len() as f64;
    let middle = rows.iter().map(|row| row[0]).sum::<f64>() / count;
    // What is left of a line once the parabola is taken off.
    let bent = rows.iter().map(|&[s, t]| [s - middle, t - bend * (s - middle) * (s - middle)]);
    let bent: Vec<[f64; 2]> = bent.collect();
    let mean = bent.iter().map(|row| row[1]).sum::<f64>() / count;
    let (top, bottom) =
        bent.iter().fold((0.0, 0.0), |(top, bottom), [s, t]| (top + s * t, bottom + s * s));
    let squares = bent.iter().map(|[s, t]| (t - mean - top / bottom * s).powi(2)).sum::<f64>();
    if rows.len() > 3 { (squares / (count - 3.0)).sqrt() } else { 0.0 }
}

/// Share of the length at an end that rounding of its coordinates may bend it.
const ROUNDING: f64 = 1e-12;

/// So many places at an end are fitted.
const FITTED: usize = 9;
