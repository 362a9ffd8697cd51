//! A known curve as places very close together, with normals and local feature sizes.

use std::cell::Cell;

use asphera_geometry::{BoundsMm, WeightedTree};
use rayon::prelude::*;

use super::step::{Spacing, samples_of};
use super::{BezierLine, SampledLine};
use crate::PlaceMm;
use crate::bezier::{at, slope};
use crate::polylines::Polylines;
use crate::triangulation::distance_mm;

/// A known curve.
///
/// The local feature size is the distance to the medial axis: the centres of the largest discs that touch the curve and hold none of it.
/// Such a disc is found by shrinking one that touches a place until nothing is within (J. Ma, S. W. Bae, S. Choi, The Visual Computer 28
/// (2012) 7-19). Beside a corner it is zero; there it counts as 1/200 of the diagonal of the box round the curve, which is our choice.
#[derive(Clone, Debug)]
pub struct TrueCurve {
    lines: Vec<FineLine>,
    diagonal_mm: f64,
    bounds_mm: [PlaceMm; 2],
}

/// A line of it.
#[derive(Clone, Debug, Default)]
pub(super) struct FineLine {
    pub(super) places: Vec<PlaceMm>,
    pub(super) normals: Vec<[f64; 2]>,
    pub(super) lfs_mm: Vec<f64>,
    pub(super) is_corner: Vec<bool>,
    pub(super) closed: bool,
}

impl TrueCurve {
    /// The curve of Bézier lines, fine enough for samples of a spacing. Lines without length are left out.
    pub fn of_beziers(lines: &[BezierLine], spacing: &Spacing) -> TrueCurve {
        let has_length = |line: &&BezierLine| line.pieces.iter().map(hull_mm).sum::<f64>() > 0.0;
        let lines: Vec<BezierLine> = lines.iter().filter(has_length).cloned().collect();
        let lines = &lines[..];
        let length_mm: f64 = lines.iter().flat_map(|line| &line.pieces).map(hull_mm).sum();
        let (even_mm, least_mm) = (length_mm / FIRST_PLACES, length_mm / MOST_PLACES);
        let mut marks: Vec<Vec<Mark>> =
            lines.iter().map(|line| divided(line, &whole(line), |_| even_mm)).collect();
        let mut fine = FineLine::all(lines, &marks);
        let mut sizes = Sizes::new(&fine);
        sizes.fill(&mut fine);
        // The smaller local feature size of the two beside a gap sets how fine it is divided.
        let refined = |marks: &[Vec<Mark>], fine: &[FineLine], step_mm: &dyn Fn(f64) -> f64| {
            let lines = lines.iter().zip(marks).zip(fine);
            let lines = lines.map(|((line, marks), fine)| {
                let lfs = |index: usize| fine.lfs_mm.get(index).copied().unwrap_or(f64::INFINITY);
                divided(line, marks, |index| {
                    step_mm(lfs(index).min(lfs(index + 1))).clamp(least_mm, even_mm)
                })
            });
            lines.collect::<Vec<Vec<Mark>>>()
        };
        marks = refined(&marks, &fine, &|lfs_mm| AXIS_STEP * lfs_mm);
        fine = FineLine::all(lines, &marks);
        sizes = Sizes::new(&fine);
        sizes.fill(&mut fine);
        marks = refined(&marks, &fine, &|lfs_mm| STEP * spacing.finest_mm(lfs_mm));
        fine = FineLine::all(lines, &marks);
        sizes.fill(&mut fine);
        sizes.of(fine)
    }

    /// The curve through places in order, that lie close together: borders of images. Each line says whether it is closed.
    pub fn of_places(lines: &[(Vec<PlaceMm>, bool)]) -> TrueCurve {
        let fine = lines.iter().filter(|(places, _)| places.len() > 2).map(|(places, closed)| {
            let count = places.len();
            let normal = |index: usize| {
                let before = if index > 0 || *closed { (index + count - 1) % count } else { 0 };
                let after = if index + 1 < count || *closed { (index + 1) % count } else { index };
                unit_normal(places[before], places[after])
            };
            FineLine {
                places: places.clone(),
                normals: (0..count).map(normal).collect(),
                lfs_mm: Vec::new(),
                is_corner: vec![false; count],
                closed: *closed,
            }
        });
        let mut fine: Vec<FineLine> = fine.collect();
        let sizes = Sizes::new(&fine);
        sizes.fill(&mut fine);
        sizes.of(fine)
    }

    /// The curve with every place moved to the mean of those up to `reach` steps before and after it, three times over: takes the steps of
    /// pixels away. Open lines keep their ends.
    #[must_use]
    pub fn smoothed(&self, reach: usize) -> TrueCurve {
        let mut lines = self.lines_mm();
        for (places, closed) in &mut lines {
            for _ in 0..3 {
                *places = averaged(places, *closed, reach);
            }
        }
        TrueCurve::of_places(&lines)
    }

    /// The samples of the curve that are as far apart as a spacing lets them be, line by line.
    pub fn sampled(&self, spacing: &Spacing) -> Vec<SampledLine> {
        self.lines.iter().map(|line| samples_of(line, spacing)).collect()
    }

    /// All places of the curve as samples, line by line.
    pub fn every_place(&self) -> Vec<SampledLine> {
        let line = |line: &FineLine| SampledLine {
            places_mm: line.places.clone(),
            normals: line.normals.clone(),
            lfs_mm: line.lfs_mm.clone(),
            closed: line.closed,
        };
        self.lines.iter().map(line).collect()
    }

    /// The curve itself as places close together, by line, and whether each is closed.
    pub fn lines_mm(&self) -> Vec<(Vec<PlaceMm>, bool)> {
        self.lines.iter().map(|line| (line.places.clone(), line.closed)).collect()
    }

    /// The least local feature size in mm.
    pub fn least_lfs_mm(&self) -> f64 {
        let sizes = self.lines.iter().flat_map(|line| &line.lfs_mm);
        sizes.copied().fold(f64::INFINITY, f64::min)
    }

    /// The diagonal of the box round the curve in mm.
    pub fn diagonal_mm(&self) -> f64 {
        self.diagonal_mm
    }

    /// The corners of the box round the curve in mm.
    pub fn bounds_mm(&self) -> [PlaceMm; 2] {
        self.bounds_mm
    }
}

/// What the local feature size depends on.
struct Sizes {
    axis: Polylines,
    corners: WeightedTree,
    bounds_mm: [PlaceMm; 2],
    diagonal_mm: f64,
}

impl Sizes {
    fn new(lines: &[FineLine]) -> Sizes {
        let all: Vec<PlaceMm> = lines.iter().flat_map(|line| line.places.iter().copied()).collect();
        let bounds_mm = bounds(&all);
        let diagonal_mm = distance_mm(bounds_mm[0], bounds_mm[1]);
        let tree = WeightedTree::new(all.iter().map(|&[x, y]| ([x, y, 0.0], 0.0)));
        let axis = Polylines::of_sides(axis(lines, &all, &tree, diagonal_mm)).nearly();
        let corners = lines.iter().flat_map(|line| line.places.iter().zip(&line.is_corner));
        let corners = corners.filter(|(_, is_corner)| **is_corner);
        let corners = WeightedTree::new(corners.map(|(&[x, y], _)| ([x, y, 0.0], 0.0)));
        Sizes { axis, corners, bounds_mm, diagonal_mm }
    }

    fn at(&self, place: PlaceMm) -> f64 {
        let floor_mm = CORNER * self.diagonal_mm;
        let lfs_mm = self.axis.distance_mm(place).unwrap_or(f64::INFINITY);
        let to_corner_mm = self.corners.least([place[0], place[1], 0.0]);
        let is_beside = to_corner_mm.is_some_and(|to_mm| to_mm < 2.0 * floor_mm);
        if is_beside { lfs_mm.max(floor_mm) } else { lfs_mm }
    }

    fn fill(&self, lines: &mut [FineLine]) {
        for line in lines {
            line.lfs_mm = line.places.par_iter().map(|&place| self.at(place)).collect();
        }
    }

    fn of(self, lines: Vec<FineLine>) -> TrueCurve {
        TrueCurve { lines, diagonal_mm: self.diagonal_mm, bounds_mm: self.bounds_mm }
    }
}

/// Every place of a line as the mean of those up to `reach` steps before and after it.
fn averaged(places: &[PlaceMm], closed: bool, reach: usize) -> Vec<PlaceMm> {
    let count = places.len();
    let mean = |index: usize| {
        let reach = match closed {
            true => reach.min((count - 1) / 2),
            false => reach.min(index).min(count - 1 - index),
        };
        let sum = (0..=2 * reach).fold([0.0; 2], |sum: PlaceMm, step| {
            let [x, y] = places[(index + count + step - reach) % count];
            [sum[0] + x, sum[1] + y]
        });
        sum.map(|value| value / (2 * reach + 1) as f64)
    };
    (0..count).map(mean).collect()
}

/// A place of a Bézier line: the piece and how far along it.
type Mark = (usize, f64);

impl FineLine {
    fn all(lines: &[BezierLine], marks: &[Vec<Mark>]) -> Vec<FineLine> {
        lines.iter().zip(marks).map(|(line, marks)| FineLine::of(line, marks)).collect()
    }

    fn of(line: &BezierLine, marks: &[Mark]) -> FineLine {
        let mut fine = FineLine { closed: line.closed, ..FineLine::default() };
        // Of a closed line the end is the beginning.
        let marks = if line.closed { &marks[..marks.len().saturating_sub(1)] } else { marks };
        for &(piece, share) in marks {
            fine.places.push(at(&line.pieces[piece], share));
            fine.normals.push(normal(&line.pieces[piece], share));
            fine.is_corner.push(share == 0.0 && is_corner(line, piece));
        }
        fine
    }
}

/// The beginnings of all pieces, and the end of the last.
fn whole(line: &BezierLine) -> Vec<Mark> {
    let mut marks: Vec<Mark> = (0..line.pieces.len()).map(|piece| (piece, 0.0)).collect();
    if let Some(last) = line.pieces.len().checked_sub(1) {
        marks.push((last, 1.0));
    }
    marks
}

/// Marks with others between, so that no two are farther apart than `step_mm` tells for the gap after a mark.
fn divided(line: &BezierLine, marks: &[Mark], step_mm: impl Fn(usize) -> f64) -> Vec<Mark> {
    let mut fine = Vec::new();
    for (index, pair) in marks.windows(2).enumerate() {
        let [(piece, from), (next, to)] = [pair[0], pair[1]];
        let to = if next == piece { to } else { 1.0 };
        let bezier = &line.pieces[piece];
        let part =
            [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|share| at(bezier, from + share * (to - from)));
        let count = (hull_mm(&part) / step_mm(index)).ceil().clamp(1.0, MOST_PLACES);
        let count = count as usize;
        fine.extend(
            (0..count).map(|step| (piece, from + (to - from) * step as f64 / count as f64)),
        );
    }
    fine.extend(marks.last());
    fine
}

/// The length of the way through four places in mm.
fn hull_mm(places: &[PlaceMm; 4]) -> f64 {
    places.windows(2).map(|pair| distance_mm(pair[0], pair[1])).sum()
}

/// The unit normal of a Bézier curve, left of the way. Where the curve stands still, that of its control points.
fn normal(piece: &[PlaceMm; 4], t: f64) -> [f64; 2] {
    let [a, b, c, d] = piece;
    let [x, y] = slope(piece, t);
    if x.hypot(y) > 1e-9 * hull_mm(piece) {
        return unit_normal([0.0; 2], [x, y]);
    }
    let [from, to] =
        if t < 0.5 { [a, if c == a { d } else { c }] } else { [if b == d { a } else { b }, d] };
    unit_normal(*from, *to)
}

fn unit_normal(from: PlaceMm, to: PlaceMm) -> [f64; 2] {
    let length = distance_mm(from, to);
    match length > 0.0 {
        true => [(from[1] - to[1]) / length, (to[0] - from[0]) / length],
        false => [0.0, 0.0],
    }
}

/// Whether a line turns by more than [`TURN_DEG`] where a piece begins.
fn is_corner(line: &BezierLine, piece: usize) -> bool {
    let before = match piece {
        0 if !line.closed => return false,
        0 => line.pieces.len() - 1,
        piece => piece - 1,
    };
    let [a, b] = [normal(&line.pieces[before], 1.0), normal(&line.pieces[piece], 0.0)];
    let (sine, cosine) = (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
    sine.atan2(cosine).abs() > TURN_DEG.to_radians()
}

/// The medial axis as sides: centres of neighbouring places joined where that is certain. Centres nearly in one place count once.
fn axis(
    lines: &[FineLine],
    all: &[PlaceMm],
    tree: &WeightedTree,
    diagonal_mm: f64,
) -> Vec<[PlaceMm; 2]> {
    let mut axis = Vec::new();
    for line in lines {
        let count = line.places.len();
        for side in [1.0, -1.0] {
            let discs: Vec<Option<Disc>> = (0..count)
                .into_par_iter()
                .map(|index| {
                    let [x, y] = line.normals[index];
                    // A corner has no normal of its own.
                    if line.is_corner[index] {
                        return None;
                    }
                    let neighbours = [(index + count - 1) % count, (index + 1) % count];
                    let neighbours = neighbours.map(|index| line.places[index]);
                    let disc = Disc {
                        place: line.places[index],
                        normal: [side * x, side * y],
                        radius: 4.0 * diagonal_mm,
                    };
                    disc.shrunk(neighbours, all, tree)
                        .filter(|disc| disc.radius < 4.0 * diagonal_mm)
                })
                .collect();
            // Of a closed line the first disc follows the last.
            let again = discs.first().filter(|_| line.closed);
            let mut last: Option<(PlaceMm, f64)> = None;
            for disc in discs.iter().chain(again) {
                let found = disc.map(|disc| (disc.centre(), disc.radius));
                if let (Some((centre, radius)), Some((before, other))) = (found, last) {
                    let apart_mm = distance_mm(centre, before);
                    if apart_mm < SAME * radius {
                        continue;
                    }
                    // Both discs are empty, so a short way between their centres keeps away from the curve.
                    let is_certain = apart_mm <= 0.5 * radius.min(other);
                    axis.push(if is_certain { [before, centre] } else { [centre, centre] });
                } else if let Some((centre, _)) = found {
                    axis.push([centre, centre]);
                }
                last = found;
            }
        }
    }
    axis
}

/// A disc that touches the curve at a place, on the side of a unit normal.
#[derive(Clone, Copy)]
struct Disc {
    place: PlaceMm,
    normal: [f64; 2],
    radius: f64,
}

impl Disc {
    fn centre(&self) -> PlaceMm {
        [0, 1].map(|axis| self.place[axis] + self.radius * self.normal[axis])
    }

    /// The disc shrunk until no other place lies within, but for [`SAME`] of its radius; none where rounding leaves nothing.
    ///
    /// Smaller discs lie in larger ones, so what lies outside one need never be looked at again.
    fn shrunk(self, first: [PlaceMm; 2], all: &[PlaceMm], tree: &WeightedTree) -> Option<Disc> {
        let disc = Cell::new(self);
        let shrink = |other: PlaceMm| {
            let [x, y] = [other[0] - self.place[0], other[1] - self.place[1]];
            let ahead = x * self.normal[0] + y * self.normal[1];
            let radius = (x * x + y * y) / (2.0 * ahead);
            if ahead > 0.0 && radius > 0.0 && radius < disc.get().radius {
                disc.set(Disc { radius, ..self });
            }
        };
        first.into_iter().for_each(shrink);
        // The nearest to the centre takes most away; what is left of it is looked for box by box.
        for _ in 0..8 {
            let ([x, y], before) = (disc.get().centre(), disc.get().radius);
            let nearest = tree.nearest([x, y, 0.0], |other| all[other as usize] != self.place);
            shrink(all[nearest?.0 as usize]);
            if disc.get().radius > 0.999 * before {
                break;
            }
        }
        tree.visit(
            |bounds, _| {
                let [x, y] = disc.get().centre();
                let reach = disc.get().radius * (1.0 - SAME);
                bounds.squared_distance_mm2([x, y, 0.0]) < reach * reach
            },
            |other| {
                shrink(all[other as usize]);
                false
            },
        );
        disc.get().radius.is_finite().then_some(disc.get())
    }
}

fn bounds(places: &[PlaceMm]) -> [PlaceMm; 2] {
    BoundsMm::about(places.iter().copied()).corners().unwrap_or([[0.0; 2]; 2])
}

/// Places of the first look at a curve.
const FIRST_PLACES: f64 = 2000.0;
/// The curve is never divided finer than its length over this.
const MOST_PLACES: f64 = 200_000.0;
/// Distance of the places of the medial axis over the local feature size.
const AXIS_STEP: f64 = 0.02;
/// Distance of fine places over the least distance of samples.
const STEP: f64 = 0.01;
/// Local feature size beside a corner over the diagonal of the box.
const CORNER: f64 = 0.005;
/// Share of a radius by which discs and their centres may be off.
const SAME: f64 = 1e-4;
/// Turn that counts as a corner.
const TURN_DEG: f64 = 5.0;
