//! Rows of numbers as points: of the lines of a text, or of an array.

use super::dialect::Field;
use super::head::Role;
use super::layout::{By, Layout, MATRIX};
use super::no_data::{NoData, outliers};
use super::{Shown, Unit, malformed, too_large, unclear, unreadable};
use crate::{Cloud, Format, MAX_POINTS, ReadError, Source, Topography};

/// The rows read so far.
pub(super) struct Rows {
    cloud: Cloud,
    /// Whether nothing but their number says what the columns are: three.
    is_plain: bool,
    /// Whether the first column is 0, 1, 2, … or 1, 2, 3, …
    counts_lines: bool,
    /// Of slopes: which way x goes, by the last step.
    sense: f64,
}

impl Rows {
    pub(super) fn new(layout: &Layout, width: usize) -> Rows {
        let is_plain = layout.named_by == By::Default && width == 3;
        Rows { cloud: Cloud::default(), is_plain, counts_lines: is_plain, sense: 0.0 }
    }

    /// How many points were taken, gaps left out.
    pub(super) fn points(&self) -> usize {
        self.cloud.points_mm.len()
    }

    /// Takes a row: `text` gives what stands in a column, and `number` what that means.
    pub(super) fn row<T: Shown + Copy>(
        &mut self,
        line: usize,
        layout: &Layout,
        text: impl Fn(usize) -> T,
        mut number: impl FnMut(T) -> Field,
    ) -> Result<(), ReadError> {
        let cloud = &mut self.cloud;
        let count = (cloud.points_mm.len() + cloud.missing) as u64;
        if count >= MAX_POINTS {
            return Err(too_large(line, count + 1));
        }
        let (mut place, mut z, mut gaps) = ([Some(0.0); 2], None, 0);
        for slot in &layout.slots {
            let text = text(slot.column);
            let value = match number(text) {
                Field::Number(value) => {
                    let scaled = Some(slot.unit.scaled(value)).filter(|scaled| scaled.is_finite());
                    Some(scaled.ok_or_else(|| unreadable(line, slot, &text))?)
                }
                Field::Missing => None,
                // The uncertainty of a height that nobody weighs by may be anything.
                Field::Unreadable if slot.role == Role::Uncertainty => None,
                Field::Unreadable => return Err(unreadable(line, slot, &text)),
            };
            match slot.role {
                Role::X => place[0] = value,
                Role::Y => place[1] = value,
                Role::Z | Role::Slope => z = value,
                Role::Uncertainty => cloud.uncertainties_mm.push(value.unwrap_or(f64::NAN)),
            }
            gaps += usize::from(value.is_none() && slot.role != Role::Uncertainty);
        }
        let has_uncertainty = layout.slots.iter().any(|slot| slot.role == Role::Uncertainty);
        let asked = layout.slots.len() - usize::from(has_uncertainty);
        let ([Some(x), Some(y)], Some(z)) = (place, z) else {
            // A place without a height is a gap, and so is a line without either.
            if z.is_none() && (gaps == 1 || gaps == asked) {
                if layout.has_slopes() {
                    let expected = "a slope, for heights are not integrated over a gap";
                    return Err(malformed(line, 0, expected, "none".into()));
                }
                cloud.missing += 1;
                if has_uncertainty {
                    cloud.uncertainties_mm.pop();
                }
                return Ok(());
            }
            let slot = layout.slots.iter().find(|slot| {
                slot.role != Role::Uncertainty
                    && matches!(number(text(slot.column)), Field::Missing)
            });
            let slot = slot.unwrap_or(&layout.slots[0]);
            return Err(unreadable(line, slot, &text(slot.column)));
        };
        let at = cloud.points_mm.len() as f64;
        self.counts_lines &=
            cloud.points_mm.first().map_or(x == 0.0 || x == 1.0, |first| x == first[0] + at);
        if !layout.has_slopes() {
            cloud.points_mm.push([x, y, z]);
            return Ok(());
        }
        if let Some([last_mm, ..]) = cloud.points_mm.last() {
            let step_mm = x - last_mm;
            if step_mm == 0.0 || step_mm * self.sense < 0.0 {
                let found = format!("x {x} after {last_mm}, mm");
                return Err(malformed(line, 0, "slopes in order of x, to be integrated", found));
            }
            self.sense = step_mm;
        }
        cloud.slopes.push(z);
        cloud.points_mm.push([x, y, 0.0]);
        Ok(())
    }

    /// All rows as a cloud; `first` is the line of the first one. Numbers beside points that are left out are left out, too.
    pub(super) fn finish(
        self,
        first: usize,
        layout: &Layout,
        has_decimal_commas: bool,
        beside: Option<&mut Vec<f64>>,
    ) -> Result<Topography, ReadError> {
        let Rows { mut cloud, is_plain, counts_lines, .. } = self;
        if counts_lines && cloud.points_mm.len() > 2 && cloud.missing == 0 {
            let found =
                "the first of three columns without names counts the lines, as an index does";
            return Err(unclear(
                first,
                found,
                "add `--columns` with the columns of x, y, z, or of a profile x, z",
            ));
        }
        if cloud.points_mm.is_empty() && cloud.missing > 1 {
            let found =
                format!("no line has all of x, y and z; {} lack one or more", cloud.missing);
            return Err(unclear(
                first,
                found,
                "add `--columns` with the columns that hold them, of a curve in the plane x and y",
            ));
        }
        let alike = layout.slots.iter().all(|slot| slot.unit == layout.slots[0].unit);
        if is_plain && alike && is_matrix(&cloud.points_mm) {
            let found =
                "three columns without names that are alike: they may be a matrix of heights";
            return Err(unclear(first, found, format!("{MATRIX}, as 1,2,3")));
        }
        let cautions = without_marks(first, &mut cloud, layout, beside)?;
        integrate(&mut cloud);
        let taken = Some(layout.taken(has_decimal_commas, cautions));
        Ok(Topography::Cloud(cloud, Source { taken, ..Source::new(Format::Xyz) }))
    }
}

/// Takes heights that stand for none out of a cloud, and gives the doubts about the others.
fn without_marks(
    first: usize,
    cloud: &mut Cloud,
    layout: &Layout,
    beside: Option<&mut Vec<f64>>,
) -> Result<Vec<String>, ReadError> {
    let is_of_heights = |role: Role| matches!(role, Role::Z | Role::Slope);
    let unit = layout
        .slots
        .iter()
        .find(|slot| is_of_heights(slot.role))
        .map_or(Unit::Mm, |slot| slot.unit);
    if layout.has_slopes() {
        let found = NoData::of(cloud.slopes.iter().copied(), unit, layout.keeps_marks);
        return match found.cautions.is_empty() {
            true => Ok(Vec::new()),
            false => {
                let expected = "slopes without gaps, for heights are not integrated over them";
                Err(malformed(first, 0, expected, "a usual mark for no data".to_owned()))
            }
        };
    }
    let heights_mm = cloud.points_mm.iter().map(|point| point[2]);
    let found = NoData::of(heights_mm, unit, layout.keeps_marks);
    if !found.cautions.is_empty() {
        let counts: Vec<bool> =
            cloud.points_mm.iter().map(|point| !found.is_mark(point[2])).collect();
        cloud.missing += counts.iter().filter(|counts| !**counts).count();
        retain(&mut cloud.points_mm, &counts);
        retain(&mut cloud.uncertainties_mm, &counts);
        beside.into_iter().for_each(|values| retain(values, &counts));
    }
    let mut cautions = found.cautions;
    cautions.extend(outliers(|| cloud.points_mm.iter().copied()));
    Ok(cautions)
}

/// The elements of a list that count; of an empty one none.
fn retain<T>(list: &mut Vec<T>, counts: &[bool]) {
    let mut counts = counts.iter();
    list.retain(|_| counts.next().copied().unwrap_or(true));
}

/// Whether three columns are alike as those of a matrix of heights, and as x, y, z of no surface: each follows the one beside it,
/// or all lie about one height far from zero.
fn is_matrix(points_mm: &[[f64; 3]]) -> bool {
    let count = points_mm.len() as f64;
    if points_mm.len() < FEWEST_ROWS {
        return false;
    }
    let mean = |value: &dyn Fn(&[f64; 3]) -> f64| points_mm.iter().map(value).sum::<f64>() / count;
    let spread = |value: &dyn Fn(&[f64; 3]) -> f64| {
        let middle = mean(value);
        mean(&|row| (value(row) - middle).powi(2)).sqrt()
    };
    let means = [0, 1, 2].map(|column| mean(&|row| row[column]));
    let spreads = [0, 1, 2].map(|column| spread(&|row| row[column]));
    let steps = [spread(&|row| row[1] - row[0]), spread(&|row| row[2] - row[1])];
    let most = spreads.into_iter().fold(0.0, f64::max);
    let least = spreads.into_iter().fold(f64::INFINITY, f64::min);
    // Numbers near the end of the range have no spread that could be told.
    if !(most.is_finite() && least > 0.0) {
        return false;
    }
    let follows = steps.into_iter().all(|step| step <= FOLLOWS * least);
    let gap = [means[1] - means[0], means[2] - means[1], means[2] - means[0]];
    let is_about_one = most <= ALIKE * least
        && gap.into_iter().all(|gap| gap.abs() <= most)
        && means.into_iter().all(|mean| mean.abs() > FAR_FROM_ZERO * most);
    follows || is_about_one
}

/// Rows that are needed to tell a matrix.
const FEWEST_ROWS: usize = 6;
/// Largest spread of the steps between columns that follow each other, of that of a column.
const FOLLOWS: f64 = 0.1;
/// Largest ratio of the spreads of columns that are alike.
const ALIKE: f64 = 3.0;
/// Distance of heights from zero, in their spread.
const FAR_FROM_ZERO: f64 = 10.0;

/// Heights of slopes by the trapezoidal rule, in the order of the lines, from 0 at the first.
fn integrate(Cloud { points_mm, slopes, .. }: &mut Cloud) {
    for index in 1..slopes.len() {
        let step_mm = points_mm[index][0] - points_mm[index - 1][0];
        let rise_mm = 0.5 * (slopes[index - 1] + slopes[index]) * step_mm;
        points_mm[index][2] = points_mm[index - 1][2] + rise_mm;
    }
}
