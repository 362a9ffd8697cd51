//! Heights that stand for none: numbers that programs write for a missing height, and heights far from all others.

use super::Unit;

/// Numbers that programs write where nothing was measured: of GIS and of instruments, the ends of 16-bit samples, Surfer's blank,
/// the ends of single precision.
const MARKS: [f64; 15] = [
    -999.0,
    -9999.0,
    -99_999.0,
    -999_999.0,
    999.0,
    9999.0,
    99_999.0,
    999_999.0,
    -32_768.0,
    -32_767.0,
    32_767.0,
    1.701_41e38,
    1e30,
    f32::MAX as f64,
    f32::MIN as f64,
];

/// Marks among heights.
#[derive(Debug, Default, PartialEq)]
pub(super) struct NoData {
    /// The marks in mm, as they stand among the heights.
    marks_mm: Vec<f64>,
    /// What is to be said of them.
    pub(super) cautions: Vec<String>,
}

impl NoData {
    /// Marks among heights of a column in `unit`; NaN is passed over. None where they are kept.
    ///
    /// A number of [`MARKS`] is one where it lies apart from all other heights: by twice their range, or, where it comes again,
    /// by a quarter of it. Takes time in proportion to the heights.
    pub(super) fn of(
        heights_mm: impl Iterator<Item = f64>,
        unit: Unit,
        keeps_marks: bool,
    ) -> NoData {
        if keeps_marks {
            return NoData::default();
        }
        let scaled_mm = MARKS.map(|mark| unit.scaled(mark));
        let mut counts = [0_u64; MARKS.len()];
        let (mut low_mm, mut high_mm, mut others) = (f64::INFINITY, f64::NEG_INFINITY, 0_u64);
        for mm in heights_mm.filter(|mm| mm.is_finite()) {
            if let Some(index) = scaled_mm.iter().position(|mark_mm| *mark_mm == mm) {
                counts[index] += 1;
            } else {
                (low_mm, high_mm) = (low_mm.min(mm), high_mm.max(mm));
                others += 1;
            }
        }
        let mut found = NoData::default();
        if others < FEWEST_OTHERS {
            return found;
        }
        let range_mm = high_mm - low_mm;
        for (index, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let apart_mm = (low_mm - scaled_mm[index]).max(scaled_mm[index] - high_mm);
            let needed_mm = if count > 1 { AGAIN * range_mm } else { ONCE * range_mm };
            if apart_mm > 0.0 && apart_mm >= needed_mm {
                found.marks_mm.push(scaled_mm[index]);
                let (mark, heights) = (MARKS[index], if count == 1 { "height" } else { "heights" });
                found.cautions.push(format!(
                    "{count} {heights} of {mark} {unit} left out: a usual mark for no data, far from all other heights \
                     (`--keep-marks` takes it as a height)"
                ));
            }
        }
        found
    }

    /// Whether a height is a mark.
    pub(super) fn is_mark(&self, height_mm: f64) -> bool {
        self.marks_mm.contains(&height_mm)
    }
}

/// A caution on heights that no surface as wide as these points has: few, and far from all others.
pub(super) fn outliers<P: Iterator<Item = [f64; 3]>>(points_mm: impl Fn() -> P) -> Option<String> {
    let len = points_mm().count();
    if len < FEWEST_POINTS {
        return None;
    }
    let extent_mm = |axis: usize| {
        let ends = points_mm().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(at[axis]), high.max(at[axis])]
        });
        ends[1] - ends[0]
    };
    // A sample, taken evenly, tells where nearly all heights lie.
    let mut sample_mm: Vec<f64> =
        points_mm().step_by(len.div_ceil(SAMPLE)).map(|at| at[2]).collect();
    sample_mm.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| sample_mm[(share * (sample_mm.len() - 1) as f64).round() as usize];
    let middle_mm = at(0.5);
    let reach_mm = FAR * extent_mm(0).max(extent_mm(1)).max(at(0.95) - at(0.05));
    let mut far = points_mm().filter(|point| (point[2] - middle_mm).abs() > reach_mm);
    let [x, y, z] = far.next().filter(|_| reach_mm > 0.0)?;
    let count = 1 + far.count();
    let is_few = count as f64 <= FEW * len as f64 || count == 1;
    is_few.then(|| {
        let heights = if count == 1 { "1 height lies" } else { &format!("{count} heights lie") };
        format!(
            "{heights} more than {} mm from the others, as z {} mm at x {} mm, y {} mm: if that stands for no data, \
             take it out of the file",
            in_few(reach_mm),
            in_few(z),
            in_few(x),
            in_few(y)
        )
    })
}

/// A number in few digits, whatever its size.
fn in_few(value: f64) -> String {
    let is_plain = value == 0.0 || (1e-4..1e9).contains(&value.abs());
    if is_plain { format!("{}", (value * 1e4).round() / 1e4) } else { format!("{value:.4e}") }
}

/// Other heights that are needed to tell a mark.
const FEWEST_OTHERS: u64 = 3;
/// Ranges of the other heights between them and a mark that stands once, and one that stands again.
const ONCE: f64 = 2.0;
const AGAIN: f64 = 0.25;
/// Points that are needed to tell an outlier.
const FEWEST_POINTS: usize = 10;
/// Heights that are sorted at most, in about.
const SAMPLE: usize = 100_000;
/// Widths of the part beyond which a height is none of its surface.
const FAR: f64 = 10.0;
/// Largest share of outliers: more of them are the surface.
const FEW: f64 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;

    fn cautions(heights_mm: &[f64], unit: Unit) -> Vec<String> {
        NoData::of(heights_mm.iter().copied(), unit, false).cautions
    }

    #[test]
    fn a_usual_mark_far_from_the_heights_is_none_of_them() {
        let heights_mm: Vec<f64> = (0..100).map(|i| f64::from(i) * 1e-3).collect();
        assert_eq!(cautions(&heights_mm, Unit::Mm), Vec::<String>::new());
        for mark in MARKS {
            let with_mark = [&heights_mm[..], &[Unit::Um.scaled(mark)]].concat();
            let said = cautions(&with_mark, Unit::Um);
            assert!(said.len() == 1 && said[0].contains("1 height of"), "{mark}: {said:?}");
            let found = NoData::of(with_mark.iter().copied(), Unit::Um, false);
            assert_eq!(with_mark.iter().filter(|mm| found.is_mark(**mm)).count(), 1);
            assert!(said[0].contains("`--keep-marks`"));
            assert_eq!(NoData::of(with_mark.into_iter(), Unit::Um, true), NoData::default());
        }
        // -999 nm among heights of some micrometres is a height.
        let rough_mm: Vec<f64> = (0..100).map(|i| f64::from(i - 50) * 1e-4).collect();
        assert!(cautions(&[&rough_mm[..], &[-999e-6]].concat(), Unit::Nm).is_empty());
        assert!(cautions(&[-999.0; 20], Unit::Mm).is_empty());
        // Once it might be a pit; again it is a mark.
        let deep_mm: Vec<f64> = (0..100).map(|i| f64::from(i) * 5.0).collect();
        assert!(cautions(&[&deep_mm[..], &[-999.0]].concat(), Unit::Mm)[0].starts_with("1 height"));
        let deeper_mm: Vec<f64> = (0..100).map(|i| f64::from(i) * 7.0).collect();
        assert!(cautions(&[&deeper_mm[..], &[-999.0]].concat(), Unit::Mm).is_empty());
        assert_eq!(cautions(&[&deeper_mm[..], &[-999.0; 2]].concat(), Unit::Mm).len(), 1);
    }

    #[test]
    fn a_height_beyond_the_size_of_the_part_is_said_once() {
        let mut points_mm: Vec<[f64; 3]> = (0..1000)
            .map(|i| [f64::from(i % 40), f64::from(i / 40), f64::from(i % 7) * 1e-4])
            .collect();
        let said = |points_mm: &[[f64; 3]]| outliers(|| points_mm.iter().copied());
        assert_eq!(said(&points_mm), None);
        points_mm[17][2] = -812.5;
        let one = said(&points_mm).unwrap();
        assert!(one.contains("1 height lies") && one.contains("z -812.5 mm at x 17 mm"), "{one}");
        points_mm[18][2] = 900.0;
        assert!(said(&points_mm).unwrap().starts_with("2 heights lie"));
        // A deep bore is no outlier, nor is what many points show.
        points_mm.iter_mut().step_by(10).for_each(|point| point[2] = -812.5);
        assert_eq!(said(&points_mm), None);
    }
}
