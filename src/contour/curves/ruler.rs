//! Lengths as whole numbers: sums and differences of them are exact.

use crate::samples::PlaceMm;
use crate::triangulation::distance_mm;

/// A scale of whole numbers. The unit is a power of two of a millimetre, so scaled places have scaled lengths.
pub(super) struct Ruler {
    units_per_mm: f64,
}

impl Ruler {
    /// The ruler for places: the larger side of the box round them has from 2⁴¹ to 2⁴² units.
    pub(super) fn new(places: &[PlaceMm]) -> Ruler {
        let side = |axis: usize| {
            let values = places.iter().map(|place| place[axis]);
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        let extent_mm = side(0).max(side(1));
        // Places lie at least 10⁻³⁰⁰ mm apart or in one spot: the logarithm of one spot is not asked for.
        let exponent = if extent_mm > 0.0 { extent_mm.log2().floor() } else { 0.0 };
        Ruler { units_per_mm: (UNITS - exponent).exp2() }
    }

    /// Distance of two places in units.
    pub(super) fn length(&self, p: PlaceMm, q: PlaceMm) -> i64 {
        (distance_mm(p, q) * self.units_per_mm).round() as i64
    }
}

/// Binary logarithm of the units of the extent.
const UNITS: f64 = 41.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_scale_with_their_places() {
        let places = [[0.0, 0.0], [3.0, 4.0], [-1.5, 7.25], [0.1, 0.3]];
        let scaled = places.map(|place| place.map(|value| value * 2_f64.powi(-40)));
        let [ruler, other] = [Ruler::new(&places), Ruler::new(&scaled)];
        for (p, from) in places.iter().zip(&scaled) {
            for (q, to) in places.iter().zip(&scaled) {
                assert_eq!(ruler.length(*p, *q), other.length(*from, *to));
            }
        }
        assert_eq!(ruler.length(places[0], places[1]), 5 << 39);
        assert_eq!(Ruler::new(&places[..1]).length(places[0], places[0]), 0);
    }
}
