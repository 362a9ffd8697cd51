//! Gaps at the rim of an aperture, from all samples.
//!
//! Where the circumcentre of a triangle lies in the aperture, the distance there is that to its corners: no sample is
//! nearer, and no place of the triangle is farther. Where it lies beyond the border, places of the triangle that are
//! inside may be nearer to a sample that is none of its corners, often one outside the aperture. So for such a triangle
//! the samples about it count too: as long as one is nearer to the farthest place than was thought, it is added to those
//! that part the triangle among them, and the farthest place is sought anew. Each step is an upper bound of the gap, and
//! the last one is the gap.
//!
//! Only few triangles need that: those not within the target by their corners, and those whose gap or ε would be the largest.

use asphera_geometry::predicates::Place;
use asphera_geometry::{Gap, PointMm, Triangle, VertexId, WeightedTree, place};
use rayon::prelude::*;

use super::border::Border;
use super::clipped_gap::Pieces;

/// Whether samples that are no corners of a triangle may bring its gap in the aperture down.
pub(super) fn is_doubtful(triangle: &Triangle, border: &Border) -> bool {
    !border.holds(circumcentre(triangle))
}

/// Whether the angle over the longest side is above 90° by more than rounding.
#[inline]
pub(super) fn is_blunt(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.corners_mm();
    let (mut at_c, mut squared) = (0.0, 0.0);
    for axis in 0..3 {
        at_c += (a[axis] - c[axis]) * (b[axis] - c[axis]);
        squared += (a[axis] - b[axis]).powi(2);
    }
    at_c < -RIGHT * squared
}

/// The place over which the centre of the circle through the corners lies.
fn circumcentre(triangle: &Triangle) -> Place {
    let [a, b, c] = triangle.corners_mm();
    let minus =
        |p: PointMm, q: PointMm| -> PointMm { std::array::from_fn(|axis| p[axis] - q[axis]) };
    let dot = |u: PointMm, v: PointMm| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let (ab, ac, bc) = (minus(b, a), minus(c, a), minus(c, b));
    let of_b = dot(ac, ac) * -dot(bc, ab);
    let of_c = dot(ab, ab) * dot(ac, bc);
    let total = dot(bc, bc) * dot(ac, ab) + of_b + of_c;
    [0, 1].map(|axis| a[axis] + (of_b * ab[axis] + of_c * ac[axis]) / total)
}

/// A mesh in an aperture.
pub(super) struct Surface<'a> {
    pub(super) points: &'a [PointMm],
    pub(super) triangles: &'a [[VertexId; 3]],
    /// Without one every place of a triangle counts.
    pub(super) border: Option<&'a Border>,
}

impl Surface<'_> {
    /// The gaps of some triangles from all samples, where those from their corners are told with their index. Takes a
    /// look at each point, and one at each triangle where a sample counts that is no corner of its triangle.
    pub(super) fn gaps(&self, chosen: &[(usize, Gap)]) -> Vec<Gap> {
        let mut nearby = self.points_about(chosen);
        let (gaps, used) = self.gaps_among(&nearby, chosen);
        // Points that were taken out of the mesh are no samples. There are hardly ever any.
        if self.are_corners(&used).into_iter().all(|is_corner| is_corner) {
            return gaps;
        }
        let mut are_corners = self.are_corners(&nearby).into_iter();
        nearby.retain(|_| are_corners.next() == Some(true));
        self.gaps_among(&nearby, chosen).0
    }

    /// The points that may be nearer to places of the triangles than their corners, by ascending number.
    fn points_about(&self, chosen: &[(usize, Gap)]) -> Vec<VertexId> {
        let boxes = chosen.iter().map(|&(index, gap)| {
            let corners = self.triangles[index].map(|corner| place(self.points[corner as usize]));
            [0, 1].map(|axis| {
                let [p, q, r] = corners.map(|corner| corner[axis]);
                [p.min(q).min(r) - gap.mm, p.max(q).max(r) + gap.mm]
            })
        });
        let squares = Squares::about(&boxes.collect::<Vec<_>>());
        let numbered = self.points.par_iter().with_min_len(CHUNK).enumerate();
        let about = numbered.filter(|(_, point)| squares.hold(place(**point)));
        about.map(|(index, _)| index as VertexId).collect()
    }

    /// Whether points are corners of triangles.
    fn are_corners(&self, points: &[VertexId]) -> Vec<bool> {
        if points.is_empty() {
            return Vec::new();
        }
        let mut is_met = vec![false; self.points.len()];
        points.iter().for_each(|&point| is_met[point as usize] = true);
        let corners: Vec<VertexId> = self
            .triangles
            .par_iter()
            .with_min_len(CHUNK)
            .flat_map_iter(|corners| corners.iter().copied().filter(|&it| is_met[it as usize]))
            .collect();
        points.iter().for_each(|&point| is_met[point as usize] = false);
        corners.into_iter().for_each(|corner| is_met[corner as usize] = true);
        points.iter().map(|&point| is_met[point as usize]).collect()
    }

    /// The gaps where no other points than these are samples, and which of them matter.
    fn gaps_among(
        &self,
        samples: &[VertexId],
        chosen: &[(usize, Gap)],
    ) -> (Vec<Gap>, Vec<VertexId>) {
        let places: Vec<PointMm> =
            samples.iter().map(|&sample| self.points[sample as usize]).collect();
        let tree = WeightedTree::of_points(&places);
        let found: Vec<(Gap, Vec<u32>)> = chosen
            .par_iter()
            .with_min_len(A_FEW)
            .map(|&(index, gap)| {
                let triangle = Triangle::new(self.points, self.triangles[index]);
                gap_among(&places, &tree, (&triangle, gap), self.border)
            })
            .collect();
        let used = found.iter().flat_map(|(_, used)| used);
        let used = used.map(|&index| samples[index as usize]).collect();
        (found.into_iter().map(|(gap, _)| gap).collect(), used)
    }
}

/// The gap in the aperture of a triangle, which by its corners is `gap`, and which samples of the tree matter.
fn gap_among(
    places: &[PointMm],
    tree: &WeightedTree,
    (triangle, gap): (&Triangle, Gap),
    border: Option<&Border>,
) -> (Gap, Vec<u32>) {
    let pieces = Pieces::of(triangle);
    let mut parted: Option<Parted<'_>> = None;
    let mut used = Vec::new();
    let mut farthest = gap;
    for _ in 0..MOST_SAMPLES {
        let Some((index, mm)) = tree.nearest(farthest.at_mm, |_| true) else { break };
        if mm >= farthest.mm * (1.0 - ROUNDING) {
            break;
        }
        let parted = parted.get_or_insert_with(|| Parted::new(&pieces, triangle, border));
        used.push(index);
        parted.add(places[index as usize]);
        let Some(found) = parted.farthest() else { break };
        farthest = found;
    }
    (if farthest.mm < gap.mm { farthest } else { gap }, used)
}

/// A triangle parted among samples: each has the places that it is nearest to.
///
/// Such a part is a convex polygon, over which the distance is convex: it is largest at a corner of what the border leaves
/// of that.
struct Parted<'a> {
    pieces: &'a Pieces,
    border: Option<&'a Border>,
    /// Of the border, near the triangle.
    sides: Vec<u32>,
    parts: Vec<Part>,
}

struct Part {
    sample: PointMm,
    polygon: Vec<PointMm>,
    /// Its farthest place in the aperture.
    farthest: Option<Gap>,
}

impl<'a> Parted<'a> {
    /// A triangle that its corners part.
    fn new(pieces: &'a Pieces, triangle: &Triangle, border: Option<&'a Border>) -> Parted<'a> {
        let mut sides = Vec::new();
        let corners = triangle.corners_mm();
        border.inspect(|border| border.sides_near(corners.map(place), &mut sides));
        let mut parted = Parted { pieces, border, sides, parts: Vec::new() };
        corners.into_iter().for_each(|corner| parted.add(corner));
        parted
    }

    /// Adds a sample. Takes a step for each part, and a look at the border for each that gets smaller.
    fn add(&mut self, sample: PointMm) {
        let mut polygon = self.pieces.corners().to_vec();
        let mut parts = std::mem::take(&mut self.parts);
        for part in parts.iter_mut().filter(|part| part.sample != sample) {
            polygon = nearer(&polygon, &sample, &part.sample);
            let loses = |at: &PointMm| nearer_by_mm2(at, &part.sample, &sample) < 0.0;
            if part.polygon.iter().any(loses) {
                part.polygon = nearer(&part.polygon, &part.sample, &sample);
                part.farthest = self.farthest_of(&part.sample, &part.polygon);
            }
        }
        let farthest = self.farthest_of(&sample, &polygon);
        parts.push(Part { sample, polygon, farthest });
        self.parts = parts;
    }

    /// The place in the aperture that is farthest from the nearest of the samples.
    fn farthest(&self) -> Option<Gap> {
        let all = self.parts.iter().filter_map(|part| part.farthest);
        all.reduce(|farthest, of| if of.mm > farthest.mm { of } else { farthest })
    }

    /// The place of a polygon in the aperture that is farthest from a sample.
    fn farthest_of(&self, sample: &PointMm, polygon: &[PointMm]) -> Option<Gap> {
        let mut farthest: Option<Gap> = None;
        let mut note = |at_mm: PointMm| {
            let mm = (0..3).map(|axis| (at_mm[axis] - sample[axis]).powi(2)).sum::<f64>().sqrt();
            if farthest.is_none_or(|farthest| mm > farthest.mm) {
                farthest = Some(Gap { mm, at_mm });
            }
        };
        let counts =
            |at_mm: &PointMm| self.border.is_none_or(|border| border.contains(place(*at_mm)));
        polygon.iter().copied().filter(counts).for_each(&mut note);
        if let Some(border) = self.border {
            let flat: Vec<Place> = polygon.iter().copied().map(place).collect();
            for &side in &self.sides {
                if let Some(ends) = self.pieces.clipped_to(&flat, border.side(side)) {
                    ends.into_iter().for_each(&mut note);
                }
            }
        }
        farthest
    }
}

/// How much the square of the distance to another place exceeds that to one, which is linear.
fn nearer_by_mm2(at: &PointMm, one: &PointMm, other: &PointMm) -> f64 {
    let along =
        |axis: usize| (one[axis] - other[axis]) * (2.0 * at[axis] - one[axis] - other[axis]);
    (0..3).map(along).sum()
}

/// The part of a convex polygon that is nearer to one place than to another.
fn nearer(polygon: &[PointMm], one: &PointMm, other: &PointMm) -> Vec<PointMm> {
    let by_mm2 = |at: &PointMm| nearer_by_mm2(at, one, other);
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (from, to) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let [start, end] = [from, to].map(by_mm2);
        if start >= 0.0 {
            left.push(*from);
        }
        if start * end < 0.0 {
            let share = start / (start - end);
            left.push(std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])));
        }
    }
    left
}

/// Squares of the plane about boxes.
struct Squares {
    /// The ends of all of them along x and y.
    ends: [[f64; 2]; 2],
    /// Squares per mm.
    scale: Place,
    /// Row by row: whether a box is near.
    about: Vec<bool>,
}

impl Squares {
    /// Boxes are told by their ends along x and y.
    fn about(boxes: &[[[f64; 2]; 2]]) -> Squares {
        let ends = [0, 1].map(|axis| {
            let ends = boxes.iter().map(|of_box| of_box[axis]);
            let all = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
            all.unwrap_or_default()
        });
        let scale = ends.map(|[low, high]| SQUARES as f64 / (high - low));
        let mut squares = Squares { ends, scale, about: vec![false; SQUARES * SQUARES] };
        for of_box in boxes {
            let [columns, rows] = [0, 1].map(|axis| {
                let [from, to] = of_box[axis];
                squares.step(from, axis)..=squares.step(to, axis)
            });
            for row in rows {
                for column in columns.clone() {
                    squares.about[row * SQUARES + column] = true;
                }
            }
        }
        squares
    }

    #[inline(always)]
    fn hold(&self, at: Place) -> bool {
        let [[left, right], [low, high]] = self.ends;
        let [x, y] = at;
        x >= left
            && x <= right
            && y >= low
            && y <= high
            && self.about[self.step(y, 1) * SQUARES + self.step(x, 0)]
    }

    #[inline(always)]
    fn step(&self, mm: f64, axis: usize) -> usize {
        (((mm - self.ends[axis][0]) * self.scale[axis]) as usize).min(SQUARES - 1)
    }
}

/// Squares along an axis.
const SQUARES: usize = 128;

/// Points or triangles that one thread looks through.
const CHUNK: usize = 1 << 14;

/// Triangles of which one thread takes care.
const A_FEW: usize = 64;

/// More samples than ever part a triangle, but for one along the hull that reaches over many.
const MOST_SAMPLES: usize = 64;

/// An angle above 90° by so small a share of the longest side's square changes no gap by more than that share.
const RIGHT: f64 = 1e-9;

/// A sample nearer by less than that is not.
const ROUNDING: f64 = 1e-12;
