//! An area by the values of a figure, in bins of an eighth of an octave: a distribution that can be added up.

use asphera_geometry::nearness::{Entry, Nearness, quantile};

/// Areas by value. Bins before the first and after the last that are kept are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Bins {
    first: usize,
    areas: Vec<f64>,
}

impl Bins {
    /// All bins, to be added to.
    pub(super) fn all() -> Bins {
        Bins { first: 0, areas: vec![0.0; BINS] }
    }

    /// Empties all bins; they are those of [`Bins::all`].
    pub(super) fn clear(&mut self) {
        self.areas.fill(0.0);
    }

    /// Adds to one of all bins. A value is at least 0.
    #[inline(always)]
    pub(super) fn add(&mut self, value: f64, area: f64) {
        self.areas[bin(value)] += area;
    }

    /// Adds the area of a triangle to all bins, by the figure of its places: distance over `unit_mm`, which is
    /// positive.
    pub(super) fn add_places(&mut self, nearness: &Nearness, unit_mm: f64) {
        let last = bin(nearness.gap_mm / unit_mm);
        let mut left_mm2 = nearness.area_mm2;
        for bin in (1..=last).rev().take(BINS_OF_PLACES) {
            let below_mm2 = nearness.within(upper_bound(bin - 1) * unit_mm).area_mm2.min(left_mm2);
            self.areas[bin] += left_mm2 - below_mm2;
            left_mm2 = below_mm2;
        }
        self.areas[last.saturating_sub(BINS_OF_PLACES)] += left_mm2;
    }

    /// Bins without the empty ones at both ends.
    pub(super) fn trimmed(&self) -> Bins {
        let is_held = |area: &f64| *area != 0.0;
        let Some(first) = self.areas.iter().position(is_held) else { return Bins::default() };
        let last = self.areas.iter().rposition(is_held).unwrap_or(first);
        Bins { first: self.first + first, areas: self.areas[first..=last].to_vec() }
    }

    /// Adds all areas of others to these, which are all bins.
    pub(super) fn merge(&mut self, other: &Bins) {
        let bins = self.areas[other.first..].iter_mut();
        bins.zip(&other.areas).for_each(|(sum, area)| *sum += area);
    }

    /// The value up to which there is a share of the area: bounds of the bin it lies in, and how far in that the
    /// share ends, 0 to 1. `None` if there is no area.
    fn end_of(&self, share: f64) -> Option<([f64; 2], f64)> {
        let wanted = share * self.areas.iter().sum::<f64>();
        let mut below = 0.0;
        for (index, &area) in self.areas.iter().enumerate() {
            if area > 0.0 && below + area >= wanted {
                let bin = self.first + index;
                let low = if bin == 0 { 0.0 } else { upper_bound(bin - 1) };
                return Some(([low, upper_bound(bin)], ((wanted - below) / area).clamp(0.0, 1.0)));
            }
            below += area;
        }
        None
    }

    /// An upper bound of the figure up to which a share of the area has places, where these values are those of the
    /// farthest places of triangles, and those of `others` are of places: by up to 1/8 too large where the triangles are halves
    /// of squares. Never above `most`, the largest value.
    pub(super) fn bound_of_places(
        &self,
        others: &Bins,
        share: f64,
        most: Option<f64>,
    ) -> Option<f64> {
        // In the first bin is what is next to nothing, what is in the last has no end.
        let unit_mm = |bin: usize, part: f64| match bin {
            0 => f64::INFINITY,
            _ if bin == BINS - 1 => 0.0,
            _ => {
                let (low, high) = (upper_bound(bin - 1), upper_bound(bin));
                (low + part * (high - low)).recip()
            }
        };
        let triangles = self.held().map(|(bin, weight)| Entry {
            nearness: HALF_A_SQUARE,
            unit_mm: unit_mm(bin, 1.0),
            weight,
        });
        let places = others.held().flat_map(|(bin, weight)| {
            PARTS.map(|part| Entry {
                nearness: ALL_AS_FAR,
                unit_mm: unit_mm(bin, part),
                weight: weight / PARTS.len() as f64,
            })
        });
        let all: Vec<Entry> = triangles.chain(places).collect();
        let found = quantile(&all, share)?;
        Some(most.map_or(found, |most| found.min(most)))
    }

    /// The bins that are not empty, with their areas.
    fn held(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let bins = (self.first..).zip(self.areas.iter().copied());
        bins.filter(|(_, area)| *area > 0.0)
    }

    /// About that value: as if the area were spread evenly over its bin, so off by less than 1/8.
    pub(super) fn about(&self, share: f64) -> Option<f64> {
        let ([low, upper], part) = self.end_of(share)?;
        Some(if upper.is_finite() { low + part * (upper - low) } else { low })
    }
}

/// The bin of a value: eight to an octave, the first for all below 2⁻⁴⁰ and the last for all from 2¹⁶ on.
#[inline(always)]
fn bin(value: f64) -> usize {
    let eighths = (value.to_bits() >> (52 - BINS_PER_OCTAVE.ilog2())) as usize;
    (eighths + 1).saturating_sub(SMALLEST_IN_BINS).min(BINS - 1)
}

/// The upper bound of a bin.
fn upper_bound(bin: usize) -> f64 {
    if bin == BINS - 1 {
        return f64::INFINITY;
    }
    f64::from_bits(((SMALLEST_IN_BINS + bin) as u64) << (52 - BINS_PER_OCTAVE.ilog2()))
}

/// Half of a square whose half diagonal is 1, and so is its area.
const HALF_A_SQUARE: Nearness = Nearness {
    halves_mm: [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2, 1.0],
    bluntness: 1.0,
    gap_mm: 1.0,
    area_mm2: 1.0,
};

/// An area whose places all are 1 away.
const ALL_AS_FAR: Nearness =
    Nearness { halves_mm: [0.0; 3], bluntness: 1.0, gap_mm: 1.0, area_mm2: 1.0 };

/// Places of a bin are spread evenly over so many parts of it.
const PARTS: [f64; 8] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

/// Places nearer than the bins of so many, two octaves, are put into the next one.
const BINS_OF_PLACES: usize = 16;

const BINS_PER_OCTAVE: usize = 8;
/// From 2⁻⁴⁰, the area in mm² of a facet 1 nm wide, to 2¹⁶; and what is below and above.
const BINS: usize = 56 * BINS_PER_OCTAVE + 2;
/// Bits of 2⁻⁴⁰ down to the eighths of an octave.
const SMALLEST_IN_BINS: usize = (1023 - 40) * BINS_PER_OCTAVE;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_bound_what_is_in_them() {
        for value in [
            0.0,
            1e-13,
            9.5e-7,
            1e-6,
            0.001,
            0.05,
            0.0625,
            0.999,
            1.0,
            15.9,
            16.0,
            65_535.9,
            65_536.0,
            1e9,
            f64::INFINITY,
        ] {
            let bin = bin(value);
            assert!(value <= upper_bound(bin), "{value} in {bin}");
            assert!(
                bin == 0 || bin == BINS - 1 || upper_bound(bin) <= value * 1.125,
                "{value} in {bin}"
            );
            assert!(bin == 0 || value >= upper_bound(bin - 1), "{value} in {bin}");
        }
    }

    #[test]
    fn trimmed_bins_add_up_to_all() {
        let values = [0.0, 0.01, 0.5, 0.011, 3.0, 1e7];
        let mut all = Bins::all();
        let mut sum = Bins::all();
        for (index, &value) in values.iter().enumerate() {
            all.add(value, 1.0 + index as f64);
            let mut one = Bins::all();
            one.add(value, 1.0 + index as f64);
            assert_eq!(one.trimmed().areas.len(), 1);
            sum.merge(&one.trimmed());
        }
        assert_eq!(sum, all);
        assert_eq!(Bins::all().trimmed(), Bins::default());
        let none = Bins::all();
        assert_eq!((none.bound_of_places(&none, 0.5, None), none.about(0.5)), (None, None));
        // 21 in all: those up to 0.011 have 7, up to 0.5 10, up to 3 15.
        assert!((0.5..0.5625).contains(&all.about(0.4).unwrap()));
        assert_eq!(all.bound_of_places(&none, 1.0, Some(1e7)), Some(1e7));
    }

    #[test]
    fn places_of_squares_lie_as_they_do_in_one() {
        let none = Bins::all();
        // Two squares of half diagonals 1 and 2: the discs of radius t about the corners of each.
        let mut bins = Bins::all();
        bins.add(1.0, 1.0);
        bins.add(2.0, 4.0);
        // Nothing is bounded by these discs below 1/√2.
        let upper = upper_bound(bin(1.0));
        let median = bins.bound_of_places(&none, 0.1, None).unwrap();
        let expected = (0.5 / (0.5 * std::f64::consts::PI * 2.0)).sqrt() * upper;
        assert!((median / expected - 1.0).abs() < 1e-6, "{median}, not {expected}");
        assert_eq!(bins.bound_of_places(&none, 0.99, Some(1.5)), Some(1.5));
    }

    #[test]
    fn an_even_spread_is_found_within_its_bins() {
        let mut bins = Bins::all();
        (0..100_000).for_each(|i| bins.add(1.0 + f64::from(i) * 1e-5, 1.0));
        let median = bins.about(0.5).unwrap();
        assert!((median - 1.5).abs() < 1e-4, "{median}");
    }
}
