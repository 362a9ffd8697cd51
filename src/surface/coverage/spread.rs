//! The distribution of a figure over an area.
//!
//! Quantiles of many values are found without sorting or moving them: values that are not negative are
//! ordered as their bits are, so a histogram over ranges of bits tells in which range a share of the area
//! ends; the few values there are sorted, and a range with too many is cut again. Histograms are summed
//! over fixed chunks in their order: the result does not depend on how many threads there are.

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

/// The spread of values, not negative, with their areas; those without area or that are NaN do not count.
/// None if there are none.
pub(super) fn spread(values: &[f64], areas: &[f64]) -> Option<Spread> {
    let weighted = Weighted { values, areas };
    let (range, total) = weighted.extent()?;
    let histogram = weighted.histogram(range);
    let quantile = |share: f64| weighted.end_of(&histogram, share * total);
    Some(Spread { median: quantile(0.5), p99: quantile(0.99), max: f64::from_bits(range.high) })
}

/// Values with their areas.
#[derive(Clone, Copy)]
struct Weighted<'a> {
    values: &'a [f64],
    areas: &'a [f64],
}

/// Bits of values, both ends included.
#[derive(Clone, Copy)]
struct Range {
    low: u64,
    high: u64,
}

/// The area and the number of the values in each part of a range.
struct Histogram {
    range: Range,
    /// A part has 2 to this many different values.
    shift: u32,
    areas: Vec<f64>,
    counts: Vec<u32>,
}

impl<'a> Weighted<'a> {
    /// The smallest and the largest value, and the area of all.
    fn extent(&self) -> Option<(Range, f64)> {
        let extents: Vec<Option<(Range, f64)>> = self.over_chunks(|chunk| {
            chunk
                .entries()
                .map(|(bits, area)| (Range { low: bits, high: bits }, area))
                .reduce(joined)
        });
        extents.into_iter().flatten().reduce(joined)
    }

    fn histogram(&self, range: Range) -> Histogram {
        let bits = u64::BITS - (range.high - range.low).leading_zeros();
        let shift = bits.saturating_sub(PARTS_BITS);
        let parts: Vec<(Vec<f64>, Vec<u32>)> = self.over_chunks(|chunk| {
            let (mut areas, mut counts) = (vec![0.0; PARTS], vec![0; PARTS]);
            for (bits, area) in chunk.entries().filter(|&(bits, _)| range.contains(bits)) {
                let part = ((bits - range.low) >> shift) as usize;
                areas[part] += area;
                counts[part] += 1;
            }
            (areas, counts)
        });
        let mut whole = Histogram { range, shift, areas: vec![0.0; PARTS], counts: vec![0; PARTS] };
        for (areas, counts) in parts {
            whole.areas.iter_mut().zip(areas).for_each(|(sum, area)| *sum += area);
            whole.counts.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        whole
    }

    /// The smallest value such that those up to it have at least an area of `wanted`; the largest, if
    /// rounding leaves none.
    fn end_of(&self, histogram: &Histogram, mut wanted: f64) -> f64 {
        let (mut part, mut below) = (0, 0.0);
        for (index, (&area, &count)) in histogram.areas.iter().zip(&histogram.counts).enumerate() {
            if count > 0 {
                part = index;
                if below + area >= wanted {
                    break;
                }
                below += area;
            }
        }
        // Rounding may find no end: then the last part was counted as below itself.
        below = below.min(wanted);
        wanted -= below;
        let low = histogram.range.low + ((part as u64) << histogram.shift);
        let range =
            Range { low, high: histogram.range.high.min(low + ((1 << histogram.shift) - 1)) };
        if range.low == range.high {
            return f64::from_bits(range.low);
        }
        if histogram.counts[part] > FEW {
            return self.end_of(&self.histogram(range), wanted);
        }
        let found: Vec<Vec<(u64, f64)>> = self.over_chunks(|chunk| {
            chunk.entries().filter(|&(bits, _)| range.contains(bits)).collect()
        });
        let mut entries: Vec<(u64, f64)> = found.into_iter().flatten().collect();
        entries.sort_by_key(|&(bits, _)| bits);
        let mut held = 0.0;
        let end = entries.iter().find(|(_, area)| {
            held += area;
            held >= wanted
        });
        let (bits, _) = end.or(entries.last()).copied().unwrap_or((range.high, 0.0));
        f64::from_bits(bits)
    }

    /// The bits of the values that count, with their areas.
    fn entries(self) -> impl Iterator<Item = (u64, f64)> + use<'a> {
        let counts = |&(value, &area): &(&f64, &f64)| area > 0.0 && !value.is_nan();
        // Adding zero makes negative zero positive.
        let bits = |(value, &area): (&f64, &f64)| ((value + 0.0).to_bits(), area);
        self.values.iter().zip(self.areas).filter(counts).map(bits)
    }

    /// What `take` makes of each chunk, in their order.
    fn over_chunks<T: Send>(&self, take: impl Fn(Weighted<'_>) -> T + Sync) -> Vec<T> {
        self.values
            .par_chunks(CHUNK)
            .zip(self.areas.par_chunks(CHUNK))
            .map(|(values, areas)| take(Weighted { values, areas }))
            .collect()
    }
}

impl Range {
    fn contains(&self, bits: u64) -> bool {
        (self.low..=self.high).contains(&bits)
    }
}

fn joined((left, left_area): (Range, f64), (right, right_area): (Range, f64)) -> (Range, f64) {
    let range = Range { low: left.low.min(right.low), high: left.high.max(right.high) };
    (range, left_area + right_area)
}

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
