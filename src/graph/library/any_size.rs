//! Shapes whatever their size: entries are scaled to a part before they are laid onto it.

use super::align::{Laid, Motion};
use super::sheet::Vector;
use super::{CLEAR, Fit, LibraryEntry, MOST_PLACES, Recognition, STEPS, Side, fitted, recognised};

/// Which entry a part is, whatever its size: a part of twice the size of an entry is that entry too, at the scale 2. Arguments and
/// answers as of [`recognise`](super::recognise). Surfaces of one shape in two sizes are equal entries, and no answer.
///
/// The radii of the outlines give the scale. Another one within a twenty-fifth of it is taken where the entry differs less by it.
/// Some tenths of a second for every side of an entry.
pub fn recognise_any_size(
    points: &[[f64; 3]],
    library: &[LibraryEntry],
    within_mm: Option<f64>,
) -> Recognition {
    recognised(points, library, within_mm, &fitted_any_size)
}

/// The best scale and motion of a side; `None` where one of both has no size.
fn fitted_any_size(laid: &Laid<'_>, side: &Side) -> Option<Fit> {
    let radii_mm = [laid.part.frame.radius_mm, side.sheet.frame.radius_mm];
    let ratio = radii_mm[0] / radii_mm[1];
    if !(ratio.is_finite() && ratio > 0.0) {
        return None;
    }
    let scaled = side.scaled(ratio);
    let first = Fit { scale: ratio, ..fitted(laid, &scaled)? };
    if first.difference_mm > HOPELESS * radii_mm[0] {
        return Some(first);
    }
    let middle = side.sheet.frame.middle_mm;
    let place = first.motion.place(middle.map(|mm| ratio * mm));
    let at = |change: f64| {
        let scale = ratio * change.exp();
        let sheet = side.sheet.scaled(scale);
        let motion = Motion { shift_mm: [0.0; 3], ..first.motion };
        let turned: Vector = motion.place(sheet.frame.middle_mm);
        let shift_mm = std::array::from_fn(|axis| place[axis] - turned[axis]);
        let motion = Motion { shift_mm, ..motion };
        let motion = laid.refined(&sheet, motion, STEPS, MOST_PLACES);
        let difference_mm = laid.difference_mm(&sheet, &motion, MOST_PLACES);
        Fit { difference_mm, motion, scale }
    };
    let best = least(at, |fit| fit.difference_mm);
    // The size of a flat is known by its outline alone: about as good scales are no better.
    let is_better = best.difference_mm < (1.0 - CLEAR) * first.difference_mm;
    Some(if is_better { best } else { first })
}

/// The least of a function between ±[`REACH`] by golden sections (J. Kiefer, Proceedings of the American Mathematical Society 4
/// (1953) 502-506).
fn least<T>(at: impl Fn(f64) -> T, value: impl Fn(&T) -> f64) -> T {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (-REACH, REACH);
    let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
    let [a, b] = inner(low, high);
    let (mut left, mut right) = (at(a), at(b));
    for _ in 0..SECTIONS {
        if value(&left) <= value(&right) {
            high = inner(low, high)[1];
            right = left;
            left = at(inner(low, high)[0]);
        } else {
            low = inner(low, high)[0];
            left = right;
            right = at(inner(low, high)[1]);
        }
    }
    if value(&left) <= value(&right) { left } else { right }
}

/// The natural logarithm by which a scale may differ from the ratio of radii.
const REACH: f64 = 0.04;

/// Sections: they leave 1/3000 of the scale.
const SECTIONS: usize = 11;

/// A difference beyond this share of the radius, which no change of the scale makes good.
const HOPELESS: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_close_in_on_the_least_value() {
        for lowest in [-0.039_f64, -0.01, 0.0, 0.027] {
            let found = least(|at| at, |at| (at - lowest).abs());
            assert!((found - lowest).abs() < 4e-4, "{found} {lowest}");
        }
    }
}
