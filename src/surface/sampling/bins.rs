//! An area by the values of a figure, in bins of an eighth of an octave: a distribution that can be added up.

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

    /// The same without the empty bins at both ends.
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

    /// An upper bound of the smallest value such that those up to it have a share of the area, by up to 1/8 too
    /// large; never above `most`, the largest value.
    pub(super) fn bound(&self, share: f64, most: Option<f64>) -> Option<f64> {
        let ([_, upper], _) = self.end_of(share)?;
        Some(most.map_or(upper, |most| upper.min(most)))
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
        assert_eq!((Bins::all().bound(0.5, None), Bins::all().about(0.5)), (None, None));
        // 21 in all: those up to 0.011 have 7, up to 0.5 10, up to 3 15.
        assert!((0.5..=0.5625).contains(&all.bound(0.4, None).unwrap()));
        assert_eq!(all.bound(0.4, Some(0.5)), Some(0.5));
        assert!((0.5..0.5625).contains(&all.about(0.4).unwrap()));
        assert_eq!(all.bound(1.0, Some(1e7)), Some(1e7));
    }

    #[test]
    fn an_even_spread_is_found_within_its_bins() {
        let mut bins = Bins::all();
        (0..100_000).for_each(|i| bins.add(1.0 + f64::from(i) * 1e-5, 1.0));
        let median = bins.about(0.5).unwrap();
        assert!((median - 1.5).abs() < 1e-4, "{median}");
    }
}
