//! The signed deviation of points from a nominal outline.

use asphera_geometry::side::share_along;

use crate::PlaceMm;
use crate::bezier::{at, bend, direction, slope};
use crate::polylines::{Polylines, middle};
use crate::sampler::BezierLine;
use crate::triangulation::distance_mm;

/// A nominal outline: lines of Bézier curves.
pub struct NominalOutline {
    pieces: Vec<[PlaceMm; 4]>,
    /// The sides that stand for the pieces, [`PARTS`] a piece.
    sides: Polylines,
    corners: Vec<[PlaceMm; 2]>,
    /// Whether what lies left of each piece is inside; none of a line that is not closed.
    is_left_inside: Vec<Option<bool>>,
    /// The pieces before and behind each; none at the ends of a line.
    neighbours: Vec<[Option<usize>; 2]>,
}

/// Deviations of points from an outline as it lies: nothing is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineDeviation {
    /// The deviation of every point in mm: outside above 0 and inside below, a hole counting as outside; of an outline that is not closed,
    /// left of its way above 0. A point beyond an end of such a line lies on neither side, and has none.
    pub deviations_mm: Vec<Option<f64>>,
    /// The place on the outline nearest to each.
    pub feet_mm: Vec<PlaceMm>,
}

impl NominalOutline {
    /// The outline of lines; none without a piece.
    pub fn new(lines: &[BezierLine]) -> Option<NominalOutline> {
        let pieces: Vec<[PlaceMm; 4]> = lines.iter().flat_map(|line| line.pieces.clone()).collect();
        let share = |part: usize| part as f64 / PARTS as f64;
        let corners: Vec<[PlaceMm; 2]> = pieces
            .iter()
            .flat_map(|piece| {
                (0..PARTS).map(|part| [at(piece, share(part)), at(piece, share(part + 1))])
            })
            .collect();
        if pieces.is_empty() {
            return None;
        }
        let mut outline = NominalOutline {
            sides: Polylines::of_sides(corners.clone()),
            is_left_inside: Vec::new(),
            neighbours: Vec::new(),
            pieces,
            corners,
        };
        let mut first = 0;
        for line in lines {
            let count = line.pieces.len();
            let is_left_inside = line.closed.then(|| outline.is_left_inside(first, count));
            outline.is_left_inside.extend((0..count).map(|_| is_left_inside));
            let (last, is_round) = ((first + count).saturating_sub(1), is_round(line));
            outline.neighbours.extend((first..first + count).map(|piece| {
                let before = if piece > first { Some(piece - 1) } else { is_round.then_some(last) };
                let behind = if piece < last { Some(piece + 1) } else { is_round.then_some(first) };
                [before, behind]
            }));
            first += count;
        }
        Some(outline)
    }

    /// Whether the left of a closed line is inside: of its longest side.
    fn is_left_inside(&self, first: usize, count: usize) -> bool {
        let sides = &self.corners[PARTS * first..PARTS * (first + count)];
        let length = |[p, q]: &[PlaceMm; 2]| distance_mm(*p, *q);
        let longest = sides.iter().copied().max_by(|a, b| length(a).total_cmp(&length(b)));
        longest.is_some_and(|[p, q]| {
            let [x, y] = middle(p, q);
            self.is_inside([x - 1e-3 * (q[1] - p[1]), y + 1e-3 * (q[0] - p[0])])
        })
    }

    /// The deviations of points; the feet lie on the Bézier curves themselves. Time of a point: log m, and m where its foot is a corner, m the
    /// pieces.
    pub fn deviations(&self, points_mm: &[PlaceMm]) -> OutlineDeviation {
        let (feet_mm, deviations_mm) = points_mm.iter().map(|&place| self.deviation(place)).unzip();
        OutlineDeviation { deviations_mm, feet_mm }
    }

    fn deviation(&self, place: PlaceMm) -> (PlaceMm, Option<f64>) {
        let Some((side, _)) = self.sides.nearest(place) else { return (place, None) };
        let (piece, part) = (side as usize / PARTS, side as usize % PARTS);
        let start = {
            let along = share_along(self.corners[side as usize], place);
            (part as f64 + along) / PARTS as f64
        };
        let (foot, t) = foot(&self.pieces[piece], place, start);
        let distance = distance_mm(foot, place);
        let is_corner = t == 0.0 || t == 1.0;
        let is_above = match self.is_left_inside[piece] {
            // At a corner the sides of both pieces would have to be asked.
            Some(_) if is_corner => !self.is_inside(place),
            Some(is_left_inside) => self.is_left(piece, t, place) != Some(is_left_inside),
            None => match self.is_left(piece, t, place) {
                Some(is_left) => is_left,
                None => return (foot, None),
            },
        };
        (foot, Some(if is_above { distance } else { -distance }))
    }

    /// Whether a place lies left of its foot, which is at a parameter of a piece: at a corner, of the mean normal of both pieces. None beyond
    /// an end of a line.
    ///
    /// A place whose foot is a corner lies between the normals of both pieces, so it lies on the side of their mean.
    fn is_left(&self, piece: usize, t: f64, place: PlaceMm) -> Option<bool> {
        let foot = at(&self.pieces[piece], t);
        let way = [place[0] - foot[0], place[1] - foot[1]];
        let mut along = direction(&self.pieces[piece], t);
        if t == 0.0 || t == 1.0 {
            let [before, behind] = self.neighbours[piece];
            match if t == 0.0 { before } else { behind } {
                Some(other) => {
                    let [x, y] = direction(&self.pieces[other], 1.0 - t);
                    along = [along[0] + x, along[1] + y];
                }
                None => {
                    let out = if t == 0.0 { -1.0 } else { 1.0 };
                    let beyond = out * (way[0] * along[0] + way[1] * along[1]);
                    let rounding = 4.0 * f64::EPSILON * (place[0].abs() + place[1].abs());
                    if beyond > SQUARE * way[0].hypot(way[1]) + rounding {
                        return None;
                    }
                }
            }
        }
        Some(along[0] * way[1] > along[1] * way[0])
    }

    /// Whether an odd number of sides lies right of a place. Sides of open lines count, too.
    fn is_inside(&self, [x, y]: PlaceMm) -> bool {
        let crosses = |[p, q]: &&[PlaceMm; 2]| {
            (p[1] > y) != (q[1] > y) && x < p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0])
        };
        self.corners.iter().filter(crosses).count() % 2 == 1
    }
}

impl OutlineDeviation {
    /// Largest, least and root mean square in mm; none without points.
    pub fn extremes_mm(&self) -> Option<[f64; 3]> {
        let known = || self.deviations_mm.iter().copied().flatten();
        let count = known().count();
        let squares: f64 = known().map(|deviation| deviation * deviation).sum();
        (count > 0).then(|| {
            [
                known().fold(f64::NEG_INFINITY, f64::max),
                known().fold(f64::INFINITY, f64::min),
                (squares / count as f64).sqrt(),
            ]
        })
    }
}

/// Whether the last piece of a line leads to its first: a line may end where it begins without being called closed.
fn is_round(line: &BezierLine) -> bool {
    let (Some(first), Some(last)) = (line.pieces.first(), line.pieces.last()) else { return false };
    let length_mm: f64 = line.pieces.iter().map(|piece| distance_mm(piece[0], piece[3])).sum();
    line.closed || distance_mm(first[0], last[3]) <= MET * length_mm
}

/// The place of a piece nearest to another, from a parameter near it, by Newton's iteration kept within the piece.
fn foot(piece: &[PlaceMm; 4], place: PlaceMm, start: f64) -> (PlaceMm, f64) {
    let mut t = start;
    let mut best = (distance_mm(at(piece, t), place), at(piece, t), t);
    for _ in 0..8 {
        let (first, second) = (slope(piece, t), bend(piece, t));
        let on = at(piece, t);
        let way = [on[0] - place[0], on[1] - place[1]];
        let down = way[0] * first[0] + way[1] * first[1];
        let rise =
            first[0] * first[0] + first[1] * first[1] + way[0] * second[0] + way[1] * second[1];
        if rise <= 0.0 {
            break;
        }
        let next = (t - down / rise).clamp(0.0, 1.0);
        let on = at(piece, next);
        let distance = distance_mm(on, place);
        if distance < best.0 {
            best = (distance, on, next);
        }
        if (next - t).abs() < 1e-15 {
            break;
        }
        t = next;
    }
    (best.1, best.2)
}

/// Cosine of the angle from which on a place lies beyond an end, and not across it.
const SQUARE: f64 = 1e-9;

/// Ends that are nearer than this share of their line are one.
const MET: f64 = 1e-9;

/// Sides that stand for a piece.
const PARTS: usize = 64;
