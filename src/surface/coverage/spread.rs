//! The distribution of a figure over an area.
//!
//! Quantiles of many values are found without sorting or moving them: values that are not negative are
//! ordered as their bits are, so a histogram over ranges of bits tells in which range a share of the area
//! ends; the few values there are sorted, and a range with too many is cut again. Several figures are looked at
//! in one pass. Histograms are summed over fixed chunks in their order: the result does not depend on how many
//! threads there are.

use std::array;

use rayon::prelude::*;

/// How a figure is distributed over an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Half of the area has at most this.
    pub median: f64,
    /// 99 % of the area has at most this.
    pub p99: f64,
    /// The largest value.
    pub max: f64,
}

/// Values, not negative, with their areas. Those that are NaN, without area or not chosen do not count.
#[derive(Clone, Copy)]
pub(super) struct Weighted<'a> {
    pub(super) values: &'a [f64],
    pub(super) areas: &'a [f64],
    /// Which of them count; none: all.
    pub(super) chosen: Option<&'a [bool]>,
    /// It holds all that count.
    pub(super) range: Range,
}

/// From one value to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    low: f64,
    high: f64,
}

impl Default for Range {
    /// Of no value.
    fn default() -> Range {
        Range { low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
}

impl Range {
    /// Takes in a value, unless it is NaN.
    #[inline(always)]
    pub(super) fn note(&mut self, value: f64) {
        self.low = if value < self.low { value } else { self.low };
        self.high = if value > self.high { value } else { self.high };
    }

    /// Whether a value lies above all there are.
    #[inline(always)]
    pub(super) fn is_below(&self, value: f64) -> bool {
        value > self.high
    }

    pub(super) fn join(&mut self, other: Range) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }
}

/// The quantiles of each figure: of half of its area and of 99 %. `None` where nothing counts.
pub(super) fn quantiles<const N: usize>(of: [Weighted<'_>; N]) -> [Option<[f64; 2]>; N] {
    let histograms = histograms(of);
    let mut searches = Vec::with_capacity(SHARES.len() * N);
    let known: [bool; N] = array::from_fn(|which| {
        let Some(histogram) = &histograms[which] else { return false };
        let total: f64 = histogram.areas.iter().sum();
        let narrowed = |share| Search::narrowed(of[which], histogram, share * total);
        searches.extend(SHARES.map(narrowed));
        total > 0.0
    });
    let mut ends = gathered(&searches).into_iter();
    known.map(|known| {
        let found = [ends.next()?, ends.next()?];
        known.then_some(found)
    })
}

/// Where a share of the area ends.
#[derive(Clone, Copy)]
struct Search<'a> {
    of: Weighted<'a>,
    range: Bits,
    /// The area in mm² up to the value wanted, from the beginning of the range.
    wanted: f64,
}

impl<'a> Search<'a> {
    /// The smallest value such that those up to it have at least an area of `wanted`, or the largest if
    /// rounding leaves none, among the few values in the range that remains.
    fn narrowed(of: Weighted<'a>, histogram: &Histogram, wanted: f64) -> Search<'a> {
        let (range, wanted, count) = histogram.part_with(wanted);
        let search = Search { of, range, wanted };
        if count <= FEW || range.low == range.high {
            return search;
        }
        let [histogram] = histograms_over([of], [Some(range)]);
        histogram.map_or(search, |histogram| Search::narrowed(of, &histogram, wanted))
    }

    /// The value among all entries of the range.
    fn end(&self, mut entries: Vec<(u64, f64)>) -> f64 {
        entries.sort_by_key(|&(bits, _)| bits);
        let mut held = 0.0;
        let end = entries.iter().find(|(_, area)| {
            held += area;
            held >= self.wanted
        });
        let (bits, _) = end.or(entries.last()).copied().unwrap_or((self.range.high, 0.0));
        f64::from_bits(bits)
    }
}

/// Where each search ends.
fn gathered(searches: &[Search<'_>]) -> Vec<f64> {
    let is_open = |search: &&Search<'_>| search.range.low < search.range.high;
    let open: Vec<&Search<'_>> = searches.iter().filter(is_open).collect();
    let count = open.first().map_or(0, |search| search.of.values.len());
    let parts: Vec<Vec<Vec<(u64, f64)>>> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let entries = |search: &&Search<'_>| {
                let mut found = Vec::new();
                search.of.for_each_of(chunk, search.range, |bits, area| found.push((bits, area)));
                found
            };
            open.iter().map(entries).collect()
        })
        .collect();
    let mut entries: Vec<Vec<(u64, f64)>> = vec![Vec::new(); open.len()];
    for part in parts {
        entries.iter_mut().zip(part).for_each(|(all, found)| all.extend(found));
    }
    let mut entries = entries.into_iter();
    let end = |search: &Search<'_>| match is_open(&search) {
        true => search.end(entries.next().unwrap_or_default()),
        false => f64::from_bits(search.range.low),
    };
    searches.iter().map(end).collect()
}

/// Bits of values, both ends included.
#[derive(Clone, Copy)]
struct Bits {
    low: u64,
    high: u64,
}

/// The area and the number of the values in each part of a range.
struct Histogram {
    range: Bits,
    /// A part has 2 to this many different values.
    shift: u32,
    areas: Vec<f64>,
    counts: Vec<u32>,
}

impl Histogram {
    fn over(range: Bits) -> Histogram {
        let bits = u64::BITS - (range.high - range.low).leading_zeros();
        let shift = bits.saturating_sub(PARTS_BITS);
        Histogram { range, shift, areas: vec![0.0; PARTS], counts: vec![0; PARTS] }
    }

    /// The part where an area of `wanted` ends, what of it is left there, and how many values the part has.
    fn part_with(&self, wanted: f64) -> (Bits, f64, u32) {
        let (mut part, mut below) = (0, 0.0);
        for (index, (&area, &count)) in self.areas.iter().zip(&self.counts).enumerate() {
            if count > 0 {
                part = index;
                if below + area >= wanted {
                    break;
                }
                below += area;
            }
        }
        let low = self.range.low + ((part as u64) << self.shift);
        let high = self.range.high.min(low + ((1 << self.shift) - 1));
        // Rounding may find no end: then the last part was counted as below itself.
        (Bits { low, high }, wanted - below.min(wanted), self.counts[part])
    }
}

/// The histograms over all values; `None` where none counts.
fn histograms<const N: usize>(of: [Weighted<'_>; N]) -> [Option<Histogram>; N] {
    histograms_over(of, of.map(|of| of.bits()))
}

fn histograms_over<const N: usize>(
    of: [Weighted<'_>; N],
    ranges: [Option<Bits>; N],
) -> [Option<Histogram>; N] {
    let count = of.first().map_or(0, |of| of.values.len());
    let parts: Vec<[Option<Histogram>; N]> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            array::from_fn(|which| {
                let mut histogram = Histogram::over(ranges[which]?);
                let Histogram { range, shift, areas, counts } = &mut histogram;
                of[which].for_each_of(chunk, *range, |bits, area| {
                    let part = ((bits - range.low) >> *shift) as usize;
                    areas[part] += area;
                    counts[part] += 1;
                });
                Some(histogram)
            })
        })
        .collect();
    let mut whole = ranges.map(|range| Some(Histogram::over(range?)));
    for part in parts {
        for (whole, part) in whole.iter_mut().flatten().zip(part.into_iter().flatten()) {
            whole.areas.iter_mut().zip(part.areas).for_each(|(sum, area)| *sum += area);
            whole.counts.iter_mut().zip(part.counts).for_each(|(sum, count)| *sum += count);
        }
    }
    whole
}

impl Weighted<'_> {
    /// The bits of its range; `None` if nothing counts.
    fn bits(&self) -> Option<Bits> {
        let Range { low, high } = self.range;
        // Adding zero makes negative zero positive.
        (low <= high).then(|| Bits { low: (low + 0.0).to_bits(), high: (high + 0.0).to_bits() })
    }

    /// Calls `take` for what counts of a chunk and lies in a range.
    #[inline(always)]
    fn for_each_of(&self, chunk: usize, range: Bits, mut take: impl FnMut(u64, f64)) {
        let from = chunk * CHUNK;
        let until = self.values.len().min(from + CHUNK);
        let width = range.high - range.low;
        let chosen = self.chosen.map(|chosen| &chosen[from..until]);
        let rows = self.values[from..until].iter().zip(&self.areas[from..until]);
        for (row, (&value, &area)) in rows.enumerate() {
            // NaN has bits above all numbers.
            let bits = (value + 0.0).to_bits();
            if bits.wrapping_sub(range.low) <= width
                && area > 0.0
                && chosen.is_none_or(|chosen| chosen[row])
            {
                take(bits, area);
            }
        }
    }
}

/// The shares of the area of the quantiles.
const SHARES: [f64; 2] = [0.5, 0.99];

/// Values of a chunk. Sums over it are part of the result.
const CHUNK: usize = 1 << 16;

/// A range is cut into up to 2 to this many parts.
const PARTS_BITS: u32 = 12;
const PARTS: usize = 1 << PARTS_BITS;

/// So many values of a part are sorted.
const FEW: u32 = 1 << 14;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::quantile::weighted_quantile;
    use crate::regressions::beside_source;

    /// The spread of all that has an area.
    fn spread(values: &[f64], areas: &[f64]) -> Option<Spread> {
        let mut range = Range::default();
        let counting = values.iter().zip(areas).filter(|&(_, &area)| area > 0.0);
        counting.for_each(|(&value, _)| range.note(value));
        let [found] = quantiles([Weighted { values, areas, chosen: None, range }]);
        found.map(|[median, p99]| Spread { median, p99, max: range.high })
    }

    #[test]
    fn what_is_not_chosen_does_not_count_and_figures_do_not_meet() {
        let (values, areas) = ([1.0, 2.0, 3.0, f64::NAN], [1.0; 4]);
        let range = Range { low: 0.0, high: 9.0 };
        let all = Weighted { values: &values, areas: &areas, chosen: None, range };
        let some = Weighted { chosen: Some(&[true, true, false, true]), ..all };
        let none = Weighted { chosen: Some(&[false; 4]), ..all };
        let found = quantiles([some, none, all, Weighted { range: Range::default(), ..all }]);
        assert_eq!(found, [Some([1.0, 2.0]), None, Some([2.0, 3.0]), None]);
    }

    #[test]
    fn by_area() {
        let found = spread(&[3.0, 1.0, 2.0], &[1.0, 60.0, 39.0]);
        assert_eq!(found, Some(Spread { median: 1.0, p99: 2.0, max: 3.0 }));
        assert_eq!(spread(&[], &[]), None);
        assert_eq!(spread(&[1.0, f64::NAN], &[0.0, 1.0]), None);
        let found = spread(&[0.0, f64::INFINITY], &[99.5, 0.5]);
        assert_eq!(found, Some(Spread { median: 0.0, p99: 0.0, max: f64::INFINITY }));
    }

    #[test]
    fn many_values_in_a_narrow_range_are_cut_again() {
        // All within a part in a thousand, but for one that is far off.
        let values: Vec<f64> = (0..200_000)
            .map(|i| 1.0 + f64::from(i * 7_919 % 200_000) * 1e-8)
            .chain([1e9])
            .collect();
        let found = spread(&values, &vec![1.0; values.len()]).unwrap();
        assert_eq!(found.max, 1e9);
        assert_eq!(found.median, 1.0 + 100_000.0 * 1e-8);
        assert_eq!(found.p99, 1.0 + 198_000.0 * 1e-8);
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_selection(
            entries in prop::collection::vec((0_u8..20, 0_u8..9), 1..200),
        ) {
            let (values, areas): (Vec<f64>, Vec<f64>) =
                entries.iter().map(|&(value, area)| (f64::from(value), f64::from(area))).unzip();
            let mut sound: Vec<(f64, f64)> =
                values.iter().copied().zip(areas.iter().copied()).filter(|e| e.1 > 0.0).collect();
            let found = spread(&values, &areas);
            let median = weighted_quantile(&mut sound, 0.5);
            let p99 = weighted_quantile(&mut sound, 0.99);
            prop_assert_eq!(found.map(|found| found.median), median);
            prop_assert_eq!(found.map(|found| found.p99), p99);
        }
    }
}
