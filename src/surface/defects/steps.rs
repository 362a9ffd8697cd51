//! Steps: lines along which the level of the surface jumps.
//!
//! 1. *Jumps.* About every cell a plane with a jump along a line through the cell is fitted to the
//!    means of the residuals of the 37 cells about it, for eight directions of the line. Cells that
//!    the line cuts take no part. A residual is smooth but for defects and steps, whatever the
//!    reference made of a step, so the jump survives in it.
//! 2. *Lines.* Of the significant jumps those stay that are the largest across their line; they are
//!    joined along it.
//! 3. *Flanks.* The flank of a pit or scratch jumps too, but the opposite flank jumps back not
//!    farther than the largest width of a defect; a step's second level goes on. So a line is none of
//!    a step if it is shorter than that width, or if its folded profile, over a cubic, is better told
//!    by a level that returns than by one that does not.
//! 4. *Height and place* by segments of the line: a quadric, cubic across the line, with a jump
//!    through the single samples, the place being the one that leaves the least squares. The jump is as soft as its
//!    profile is (`steps/flank.rs`).
//!
//! Steps that come within four cells of the border, or each other, are not seen there; a line goes on
//! straight where it ends.

mod flank;
mod segments;

use asphera_geometry::{PointMm, VertexId};

use self::flank::Flank;
use self::segments::Segments;
use super::cells::Cells;
use super::line::{Line, side};
use super::reference::Reference;
use super::tail;

/// A step, its line and what the jump is.
pub(super) struct Step {
    pub(super) line: Line,
    /// How much higher the left side is, in mm along the normal.
    pub(super) height_mm: f64,
    pub(super) uncertainty_mm: f64,
    pub(super) length_mm: f64,
    /// How many samples the height was measured from.
    pub(super) samples: u64,
    /// Whether it leads to where there are no samples.
    pub(super) on_border: bool,
}

/// What the search goes by.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) largest_mm: f64,
    pub(super) spacing_mm: f64,
    /// Noise of single samples by cell.
    pub(super) sigma_mm: &'a [f64],
    pub(super) false_expected: f64,
}

/// Directions of a line.
const DIRECTIONS: usize = 8;
/// Squared radius of the template in cells.
const RADIUS_SQUARED: i64 = 10;
/// Cells nearer to the line are cut by it.
const CUT: f64 = 0.75;
/// Reach of the template.
const REACH: i64 = 3;
/// How many cells apart two crests of one line may be.
const GAP: i64 = 4;
/// Cells a line needs.
const CELLS_MIN: usize = 6;
/// Cosine of the angle up to which two jumps are of one line.
const ALIKE: f64 = 0.7;
/// Half width in cells of the band in which a segment is fitted.
const BAND: f64 = 5.0;
/// Half width in cells of the band in which it is decided whether a jump is a step's.
const WIDE: f64 = 12.0;
/// Samples nearer to a line than this many spacings are not used for its height.
const NEAR_SPACINGS: f64 = 1.5;
/// How far in cells a line goes on where it ends.
const END: f64 = 6.0;

#[derive(Clone, Copy)]
struct Jump {
    significance: f64,
    /// Unit vector uphill.
    uphill: [f64; 2],
}

pub(super) fn find(
    points: &[PointMm],
    cells: &Cells,
    reference: &Reference,
    search: &Search<'_>,
) -> Vec<Step> {
    let jumps = jumps(cells, reference, search);
    let kept: Vec<bool> = (0..cells.len()).map(|cell| is_crest(cells, &jumps, cell)).collect();
    let lines = join(cells, &jumps, &kept);
    let mut steps: Vec<Step> = lines
        .into_iter()
        .filter(|line| line.len() >= CELLS_MIN)
        .filter_map(|line| measure(points, cells, reference, search, &jumps, &line))
        .collect();
    steps.sort_by(|a, b| {
        (b.height_mm.abs() / b.uncertainty_mm).total_cmp(&(a.height_mm.abs() / a.uncertainty_mm))
    });
    steps
}

/// The most significant jump at each cell, if it is significant.
fn jumps(cells: &Cells, reference: &Reference, search: &Search<'_>) -> Vec<Option<Jump>> {
    let means: Vec<f64> = (0..cells.len())
        .map(|cell| {
            let residuals = &reference.residuals_mm[cells.range(cell)];
            residuals.iter().sum::<f64>() / residuals.len() as f64 / reference.secants[cell]
        })
        .collect();
    let templates = templates();
    let offsets = offsets();
    let mut sizes = vec![Vec::new(); DIRECTIONS];
    let mut every: Vec<Option<[f64; DIRECTIONS]>> = vec![None; cells.len()];
    let mut about = Vec::with_capacity(offsets.len());
    for (cell, every) in every.iter_mut().enumerate() {
        let [column, row] = cells.places[cell].map(i64::from);
        about.clear();
        about.extend(offsets.iter().map_while(|&[i, j]| {
            let other = cells.at(column + i, row + j)?;
            means[other].is_finite().then(|| [means[other], cells.moments[other].count.recip()])
        }));
        if about.len() < offsets.len() {
            continue;
        }
        let mut significances = [0.0; DIRECTIONS];
        for ((significance, sizes), weights) in
            significances.iter_mut().zip(&mut sizes).zip(&templates)
        {
            let (mut height_mm, mut variance) = (0.0, 0.0);
            for (weight, [mean, part]) in weights.iter().zip(&about) {
                height_mm += weight * mean;
                variance += weight * weight * part;
            }
            *significance = height_mm / (search.sigma_mm[cell] * variance.sqrt());
            sizes.push(significance.abs());
        }
        *every = Some(significances);
    }
    let tests = (DIRECTIONS * sizes[0].len()) as f64;
    let limit = tail::two_sided((search.false_expected / tests).min(0.1));
    // Lines of a scan may have levels of their own: jumps along them are then larger than others.
    let scales: Vec<f64> = sizes
        .iter_mut()
        .map(|sizes| tail::scale(sizes).filter(|scale| scale.is_finite()).unwrap_or(1.0).max(1.0))
        .collect();
    let largest = |significances: [f64; DIRECTIONS]| {
        let all = (0..DIRECTIONS).map(|direction| (direction, significances[direction]));
        let scaled = all.map(|(direction, size)| (direction, size / scales[direction]));
        let (direction, size) = scaled.reduce(|p, q| if q.1.abs() > p.1.abs() { q } else { p })?;
        let uphill = normal(direction).map(|part| size.signum() * part);
        (size.abs() > limit).then_some(Jump { significance: size.abs(), uphill })
    };
    every.into_iter().map(|every| every.and_then(largest)).collect()
}

fn normal(direction: usize) -> [f64; 2] {
    let (sin, cos) = (std::f64::consts::PI * direction as f64 / DIRECTIONS as f64).sin_cos();
    [cos, sin]
}

fn offsets() -> Vec<[i64; 2]> {
    let all = -REACH..=REACH;
    all.clone()
        .flat_map(|j| all.clone().map(move |i| [i, j]))
        .filter(|[i, j]| i * i + j * j <= RADIUS_SQUARED)
        .collect()
}

/// For each direction the weights with which the cells about one give the jump.
fn templates() -> Vec<Vec<f64>> {
    (0..DIRECTIONS)
        .map(|direction| {
            let [cos, sin] = normal(direction);
            let rows: Vec<Option<[f64; 3]>> = offsets()
                .iter()
                .map(|&[i, j]| {
                    let (i, j) = (i as f64, j as f64);
                    let across = i * cos + j * sin;
                    (across.abs() >= CUT)
                        .then(|| [across, j * cos - i * sin, 0.5 * across.signum()])
                })
                .collect();
            // Cells lie symmetrically about the middle, so a constant does not mix with the jump; what
            // slopes across and along the line have of it is taken out.
            let sum =
                |a: usize, b: usize| rows.iter().flatten().map(|row| row[a] * row[b]).sum::<f64>();
            let mixed = sum(0, 1) / sum(0, 0);
            let along = sum(1, 1) - mixed * sum(0, 1);
            let second = (sum(1, 2) - mixed * sum(0, 2)) / along;
            let first = sum(0, 2) / sum(0, 0) - second * mixed;
            let pure = |[across, way, side]: [f64; 3]| side - first * across - second * way;
            let squares: f64 = rows.iter().flatten().map(|&row| pure(row).powi(2)).sum();
            rows.iter().map(|row| row.map_or(0.0, |row| pure(row) / squares)).collect()
        })
        .collect()
}

/// The cell some cells uphill of one.
fn uphill_of(cells: &Cells, cell: usize, uphill: [f64; 2], away: i64) -> Option<usize> {
    let place = cells.places[cell].map(i64::from);
    let [column, row] =
        [0, 1].map(|axis| place[axis] + (away as f64 * uphill[axis]).round() as i64);
    cells.at(column, row).filter(|&other| other != cell)
}

/// Whether no jump across the line of a cell's is larger.
fn is_crest(cells: &Cells, jumps: &[Option<Jump>], cell: usize) -> bool {
    let Some(jump) = jumps[cell] else { return false };
    (-REACH..=REACH).all(|away| {
        uphill_of(cells, cell, jump.uphill, away).and_then(|other| jumps[other]).is_none_or(
            |other| {
                other.significance < jump.significance
                    || (other.significance == jump.significance && away > 0)
            },
        )
    })
}

fn cosine(left: [f64; 2], right: [f64; 2]) -> f64 {
    left[0] * right[0] + left[1] * right[1]
}

/// The crests joined along their lines.
fn join(cells: &Cells, jumps: &[Option<Jump>], kept: &[bool]) -> Vec<Vec<usize>> {
    let mut seen = vec![false; cells.len()];
    let mut lines = Vec::new();
    for first in 0..cells.len() {
        if !kept[first] || seen[first] {
            continue;
        }
        seen[first] = true;
        let mut line = vec![first];
        let mut next = 0;
        while let Some(&cell) = line.get(next) {
            next += 1;
            let [column, row] = cells.places[cell].map(i64::from);
            for (i, j) in (-GAP..=GAP).flat_map(|j| (-GAP..=GAP).map(move |i| (i, j))) {
                if let Some(other) = cells.at(column + i, row + j)
                    && kept[other]
                    && !seen[other]
                    && let (Some(left), Some(right)) = (jumps[cell], jumps[other])
                    && cosine(left.uphill, right.uphill) > ALIKE
                {
                    seen[other] = true;
                    line.push(other);
                }
            }
        }
        line.sort_unstable();
        lines.push(line);
    }
    lines
}

/// Places a line of cells, and measures its jump.
fn measure(
    points: &[PointMm],
    cells: &Cells,
    reference: &Reference,
    search: &Search<'_>,
    jumps: &[Option<Jump>],
    crests: &[usize],
) -> Option<Step> {
    let segments = Segments::new(cells, jumps, crests, search.largest_mm)?;
    let samples = segments.samples(points, cells, reference);
    if !goes_on(samples.iter().flatten(), cells.side_mm, search.largest_mm) {
        return None;
    }
    let flank = Flank::of(&samples, cells.side_mm, search.spacing_mm);
    let mut knots_mm = Vec::new();
    let mut heights_mm = Vec::new();
    let (mut sum, mut weights, mut counted) = (0.0, 0.0, 0);
    for (segment, mut samples) in samples.into_iter().enumerate() {
        let Some(middle) = segments.middle_mm[segment] else { continue };
        samples.retain(|sample| sample[1].abs() <= BAND * cells.side_mm);
        let lengths_mm = [cells.side_mm, search.spacing_mm, flank.soft_mm];
        let Some(SegmentJump { offset_mm, .. }) = jump_of(&mut samples, lengths_mm) else {
            continue;
        };
        // Samples about the line may be on its wrong side, and lower the jump.
        let near_mm = if flank.soft_mm > 0.0 { 0.0 } else { NEAR_SPACINGS * search.spacing_mm };
        samples.retain(|sample| (sample[1] - offset_mm).abs() > near_mm);
        if let Some(jump) = jump_of(&mut samples, lengths_mm)
            && jump.height_mm > 0.0
        {
            knots_mm.push([segments.centre_mm(segment), middle + offset_mm]);
            heights_mm.push((jump.height_mm, jump.weight));
            sum += jump.height_mm * jump.weight;
            weights += jump.weight;
            counted += samples.len() as u64;
        }
    }
    if 2 * knots_mm.len() <= segments.count() {
        return None;
    }
    // The ends go on straight along the last segments.
    let Segments { origin_mm, along, length_mm, segment_mm, .. } = segments;
    let end_mm = 0.5 * segment_mm + END * cells.side_mm;
    let (from, to) = (knots_mm[0], knots_mm[knots_mm.len() - 1]);
    let slope = if knots_mm.len() > 1 { (to[1] - from[1]) / (to[0] - from[0]) } else { 0.0 };
    knots_mm.insert(0, [from[0] - end_mm, from[1] - slope * end_mm]);
    knots_mm.push([to[0] + end_mm, to[1] + slope * end_mm]);
    let height_mm = sum / weights;
    // From the noise, or from how the segments differ if that is more.
    let squares: f64 =
        heights_mm.iter().map(|&(height, weight)| weight * (height - height_mm).powi(2)).sum();
    let scatter = squares / (heights_mm.len() as f64 - 1.0).max(1.0);
    let sigma_mm = search.sigma_mm[crests[crests.len() / 2]];
    let uncertainty_mm =
        (sigma_mm.powi(2).max(scatter) / weights).sqrt().hypot(flank.uncertainty_mm);
    let line = Line { origin_mm, along, knots_mm, soft_mm: flank.soft_mm };
    let on_border = [line.knots_mm[0], line.knots_mm[line.knots_mm.len() - 1]]
        .map(|end| line.place_mm(end))
        .into_iter()
        .any(|end| cells.around(end).is_none());
    Some(Step { line, height_mm, uncertainty_mm, length_mm, samples: counted, on_border })
}

fn place(points: &[PointMm], vertex: VertexId) -> [f64; 2] {
    let [x, y, _] = points[vertex as usize];
    [x, y]
}

/// Whether the level beyond a line stays: whether the profile of samples (way, offset, height), folded
/// along the line, is better told by a step than by a groove or ridge up to a width.
fn goes_on<'a>(samples: impl Iterator<Item = &'a [f64; 3]>, side_mm: f64, largest_mm: f64) -> bool {
    // Bins of half a cell.
    let half = (2.0 * WIDE) as i64;
    let mut bins = vec![(0.0, 0.0); 2 * half as usize];
    for [_, offset, height] in samples {
        let bin = (2.0 * offset / side_mm).floor() as i64 + half;
        if let Some((sum, count)) = usize::try_from(bin).ok().and_then(|bin| bins.get_mut(bin)) {
            *sum += height;
            *count += 1.0;
        }
    }
    let terms = |bin: usize| {
        let x = (bin as f64 + 0.5) / half as f64 - 1.0;
        nalgebra::Vector4::new(1.0, x, x * x, x * x * x)
    };
    let mut matrix = nalgebra::Matrix4::zeros();
    let mut right = nalgebra::Vector4::zeros();
    for (bin, &(sum, count)) in bins.iter().enumerate() {
        matrix += count * terms(bin) * terms(bin).transpose();
        right += sum * terms(bin);
    }
    let Some(factor) = matrix.cholesky() else { return false };
    let solved = factor.solve(&right);
    // By how much the squares fall if the profile may rise by any height from one bin to another.
    let gain = |from: i64, until: i64| {
        let mut mixed = nalgebra::Vector4::zeros();
        let (mut moment, mut weight) = (0.0, 0.0);
        let first = (from + half).max(0) as usize;
        let end = (until + half).max(0) as usize;
        for (bin, &(sum, count)) in bins.iter().enumerate().take(end).skip(first) {
            mixed += count * terms(bin);
            moment += sum;
            weight += count;
        }
        let left = weight - mixed.dot(&factor.solve(&mixed));
        let moment = moment - mixed.dot(&solved);
        if left > 1e-6 * weight { moment * moment / left } else { 0.0 }
    };
    let widest = (2.0 * largest_mm / side_mm).ceil() as i64;
    let edges = -2 * REACH..=2 * REACH;
    let step = edges.clone().map(|edge| gain(edge, half)).fold(0.0, f64::max);
    let back = edges
        .flat_map(|edge| (1..=widest).map(move |width| (edge, width)))
        .map(|(edge, width)| gain(edge, edge + width).max(gain(edge - width, edge)))
        .fold(0.0, f64::max);
    step > back
}

struct SegmentJump {
    offset_mm: f64,
    height_mm: f64,
    /// One over the variance of the height for samples of variance 1.
    weight: f64,
}

type Terms = nalgebra::SVector<f64, 7>;

/// The jump in a quadric, cubic in the offset, through samples (way, offset, height) that leaves the least squares, of all
/// offsets within one and a half cells. Lengths are the side of a cell, the spacing, and how soft the jump is.
fn jump_of(
    samples: &mut [[f64; 3]],
    [side_mm, spacing_mm, soft_mm]: [f64; 3],
) -> Option<SegmentJump> {
    samples.sort_unstable_by(|p, q| {
        p[1].total_cmp(&q[1]).then(p[0].total_cmp(&q[0])).then(p[2].total_cmp(&q[2]))
    });
    let terms = |&[way, offset, _]: &[f64; 3]| {
        let [t, d] = [way / (BAND * side_mm), offset / (BAND * side_mm)];
        Terms::from([1.0, t, d, t * t, t * d, d * d, d * d * d])
    };
    let all: Vec<Terms> = samples.iter().map(terms).collect();
    let mut matrix = nalgebra::SMatrix::<f64, 7, 7>::zeros();
    let mut right = Terms::zeros();
    for (terms, sample) in all.iter().zip(samples.iter()) {
        matrix += terms * terms.transpose();
        right += terms * sample[2];
    }
    let factor = matrix.cholesky()?;
    let solved = factor.solve(&right);
    let mut best: Option<(f64, SegmentJump)> = None;
    let tries = (1.5 * side_mm / (0.25 * spacing_mm)).ceil() as i64;
    for index in -tries..=tries {
        let offset_mm = index as f64 * 0.25 * spacing_mm;
        let (mut sides, mut sides_mm, mut squares) = (Terms::zeros(), 0.0, 0.0);
        for (terms, sample) in all.iter().zip(samples.iter()) {
            let side = side(sample[1] - offset_mm, soft_mm);
            sides += side * terms;
            sides_mm += side * sample[2];
            squares += side * side;
        }
        let weight = squares - sides.dot(&factor.solve(&sides));
        let moment = sides_mm - sides.dot(&solved);
        if weight < 1e-3 * samples.len() as f64 {
            continue;
        }
        let gain = moment * moment / weight;
        if best.as_ref().is_none_or(|(most, _)| gain > *most) {
            best = Some((gain, SegmentJump { offset_mm, height_mm: moment / weight, weight }));
        }
    }
    best.map(|(_, jump)| jump)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On planes there is no jump, on a jump by 1 it is 1, whatever the plane.
    #[test]
    fn templates_tell_jumps_from_planes() {
        for (direction, weights) in templates().iter().enumerate() {
            let [cos, sin] = normal(direction);
            let over = |surface: &dyn Fn(f64, f64) -> f64| -> f64 {
                let offsets = offsets();
                let places = offsets.iter().map(|&[i, j]| (i as f64, j as f64));
                weights.iter().zip(places).map(|(weight, (i, j))| weight * surface(i, j)).sum()
            };
            assert!(over(&|i, j| 3.0 + 2.0 * i - j).abs() < 1e-12, "{direction}");
            let jump = over(&|i, j| 2.0 * i + f64::from(u8::from(i * cos + j * sin > 0.0)));
            assert!((jump - 1.0).abs() < 1e-12, "{direction} {jump}");
        }
    }

    #[test]
    fn a_jump_is_placed_and_measured() {
        let mut samples: Vec<[f64; 3]> = (0..1600)
            .map(|i| [f64::from(i % 40) - 19.5, f64::from(i / 40) - 19.5])
            .map(|[t, d]| {
                let jump = if d > 1.0 { 0.25 } else { 0.0 };
                [t, d, 3.0 + 0.01 * t * d - 0.02 * d * d + jump]
            })
            .collect();
        let jump = jump_of(&mut samples, [2.5, 1.0, 0.0]).unwrap();
        assert!((jump.height_mm - 0.25).abs() < 1e-10, "{}", jump.height_mm);
        assert!((jump.offset_mm - 1.0).abs() <= 0.5, "{}", jump.offset_mm);
    }
}
