//! Steep sides of triangles: where two neighbouring samples say that the surface stands upright.
//!
//! The slope of a triangle is taken as that of its steepest side, height over way in the plane. That
//! is what two samples say without interpolation, and it holds for thin triangles as well, whose
//! plane may stand upright over three samples of a gentle surface that lie nearly on one line. The
//! plane of a triangle without an obtuse angle is steeper than its steepest side by at most a factor
//! of 2/√3 in the tangent.
//!
//! Among scattered samples some pairs are much nearer than the rest, and noise alone makes the way
//! between them steep. A side therefore counts only if it also rises by [`RISE_SPACINGS`] of the
//! spacing there.

use std::ops::Range;

use asphera_geometry::{PointMm, VertexId};
use rayon::prelude::*;

/// How many spacings a steep side must rise.
///
/// The spacing of scattered samples, as measured here, is some 0.7 of the square root of the area a
/// sample has, so a side must rise by that square root. Noise of a tenth of it (standard deviation)
/// has to move two neighbours apart by seven times the deviation of their difference to do so; a
/// true slope at the default limit of 75° rises by 3.7 of it.
const RISE_SPACINGS: f64 = 1.5;

/// A triangle is clearly flat if the square of its gradient is less than this share of the limit's.
const CLEARLY: f64 = 0.5;
/// The smallest area, as a share of the squares of two sides, that rounding leaves some ten digits of.
const THIN: f64 = 1e-6;
/// Triangles of a chunk, of which one thread takes care.
const CHUNK: usize = 1 << 14;

/// When a side is steep.
#[derive(Clone, Copy)]
pub(crate) struct Steepness {
    pub(crate) tangent: f64,
    /// Smallest rise in mm.
    pub(crate) step_mm: f64,
}

impl Steepness {
    /// Whether the side from `p` to `q` is steep enough, the spacing left aside.
    pub(crate) fn holds(&self, p: PointMm, q: PointMm) -> bool {
        let rise_mm = (q[2] - p[2]).abs();
        // The first test decides nearly always on an optical surface, and costs no square root.
        let way_squared = (q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2);
        rise_mm * rise_mm >= self.tangent * self.tangent * way_squared && rise_mm >= self.step_mm
    }
}

impl Steepness {
    /// Whether one of the sides may be steep. No side is steeper than the plane of the triangle, whose gradient
    /// squared is (x² + y²)/z² of its normal x, y, z.
    #[inline(always)]
    fn may_hold(&self, p: PointMm, q: PointMm, r: PointMm) -> bool {
        let [ux, uy, uz] = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
        let [vx, vy, vz] = [r[0] - p[0], r[1] - p[1], r[2] - p[2]];
        let (x, y, z) = (uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
        // What rounding may do to a triangle as thin as a line is left to the sides themselves, and so is NaN.
        let clearly_flat = x * x + y * y < CLEARLY * self.tangent * self.tangent * z * z
            && z > THIN * (ux * ux + uy * uy + vx * vx + vy * vy);
        !clearly_flat
    }
}

/// The triangles with a steep side, and what surrounds their corners.
pub(crate) struct Steep {
    steepness: Steepness,
    /// Indices of the triangles with at least one steep side, ascending.
    pub(crate) triangles: Vec<u32>,
    /// The triangles about each of their corners.
    pub(crate) spokes: Spokes,
    /// For each vertex of `spokes`: the smallest rise in mm that counts there.
    pub(crate) rise_mm: Vec<f64>,
}

/// The steep triangles, or `None` if there are none. Linear time but for a sort about each corner.
///
/// # Panics
///
/// When a corner is not the index of a point, or there are more than 2³² triangles.
pub(crate) fn steep(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    steepness: Steepness,
) -> Option<Steep> {
    let candidates = candidates(points, triangles, steepness);
    if candidates.is_empty() {
        return None;
    }
    let near = Spokes::about(points.len(), triangles, &candidates);
    let second_mm = second_shortest_mm(points, triangles);
    let rise_mm: Vec<f64> = (0..near.len())
        .map(|slot| {
            let spacing_mm = near.spacing_mm(slot, &second_mm);
            (RISE_SPACINGS * spacing_mm).max(steepness.step_mm)
        })
        .collect();
    let candidates = Steep { steepness, triangles: candidates, spokes: near, rise_mm };
    let steep: Vec<u32> = candidates
        .triangles
        .iter()
        .copied()
        .filter(|&index| {
            let mut sides = sides(triangles[index as usize]).into_iter();
            sides.any(|side| candidates.steep_side(points, side).is_some())
        })
        .collect();
    if steep.is_empty() {
        return None;
    }
    let spokes = Spokes::about(points.len(), triangles, &steep);
    let slots = spokes.vertices.iter().filter_map(|&vertex| candidates.spokes.slot(vertex));
    let rise_mm = slots.map(|slot| candidates.rise_mm[slot]).collect();
    Some(Steep { steepness, triangles: steep, spokes, rise_mm })
}

/// Indices of the triangles with a side that is steep, the spacing left aside, ascending.
fn candidates(points: &[PointMm], triangles: &[[VertexId; 3]], steepness: Steepness) -> Vec<u32> {
    assert!(u32::try_from(triangles.len()).is_ok(), "triangles are numbered with 32 bits");
    let of_chunk = |(chunk, triangles): (usize, &[[VertexId; 3]])| {
        let mut found = Vec::new();
        for (row, &[a, b, c]) in triangles.iter().enumerate() {
            let (p, q, r) = (points[a as usize], points[b as usize], points[c as usize]);
            if steepness.may_hold(p, q, r)
                && [(p, q), (q, r), (r, p)].into_iter().any(|(p, q)| steepness.holds(p, q))
            {
                found.push((chunk * CHUNK + row) as u32);
            }
        }
        found
    };
    triangles.par_chunks(CHUNK).enumerate().flat_map_iter(of_chunk).collect()
}

impl Steep {
    /// The ends of a side with spokes at both of them, if it is steep.
    pub(crate) fn steep_side(
        &self,
        points: &[PointMm],
        side: [VertexId; 2],
    ) -> Option<[PointMm; 2]> {
        let [p, q] = side.map(|end| points[end as usize]);
        let rise_mm = (q[2] - p[2]).abs();
        let counts = |end| self.spokes.slot(end).is_some_and(|slot| rise_mm >= self.rise_mm[slot]);
        (self.steepness.holds(p, q) && side.into_iter().all(counts)).then_some([p, q])
    }
}

/// The triangles with their indices.
pub(crate) fn numbered(
    triangles: &[[VertexId; 3]],
) -> impl Iterator<Item = (u32, [VertexId; 3])> + '_ {
    triangles.iter().enumerate().map(|(index, &corners)| {
        (u32::try_from(index).expect("a mesh numbered with u32 has fewer triangles"), corners)
    })
}

/// The sides of a triangle, which lies on their left.
pub(crate) fn sides([a, b, c]: [VertexId; 3]) -> [[VertexId; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// For each vertex the way in the plane to its second nearest neighbour in the mesh, in mm.
///
/// The second and not the nearest: a single sample beside another says nothing about the spacing,
/// and along a line scan whose lines are far apart both neighbours on the line are near.
fn second_shortest_mm(points: &[PointMm], triangles: &[[VertexId; 3]]) -> Vec<f64> {
    let mut nearest = vec![[(f64::INFINITY, VertexId::MAX); 2]; points.len()];
    for &corners in triangles {
        for [p, q] in sides(corners) {
            let (from, to) = (points[p as usize], points[q as usize]);
            let squared = (to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2);
            for (vertex, other) in [(p, q), (q, p)] {
                let [first, second] = &mut nearest[vertex as usize];
                // An inner side is seen from both of its triangles.
                if other == first.1 || squared >= second.0 {
                    continue;
                }
                if squared < first.0 {
                    *second = *first;
                    *first = (squared, other);
                } else {
                    *second = (squared, other);
                }
            }
        }
    }
    nearest.into_iter().map(|[_, second]| second.0.sqrt()).collect()
}

/// The triangles about some of the vertices. Each such vertex has a slot, by ascending number.
pub(crate) struct Spokes {
    /// The vertex of each slot, ascending.
    pub(crate) vertices: Vec<VertexId>,
    slot_of_vertex: Vec<u32>,
    /// The opposite sides of slot i are `opposite[first[i]..first[i + 1]]`.
    first: Vec<usize>,
    opposite: Vec<[VertexId; 2]>,
}

impl Spokes {
    /// About the corners of the triangles with the indices `chosen`; all `triangles` are spokes.
    fn about(points: usize, triangles: &[[VertexId; 3]], chosen: &[u32]) -> Spokes {
        let mut slot_of_vertex = vec![VACANT; points];
        for &corner in chosen.iter().flat_map(|&index| &triangles[index as usize]) {
            slot_of_vertex[corner as usize] = 0;
        }
        let mut vertices = Vec::new();
        for (vertex, slot) in (0..).zip(&mut slot_of_vertex) {
            if *slot != VACANT {
                *slot = vertices.len() as u32;
                vertices.push(vertex);
            }
        }
        let mut first = vec![0; vertices.len() + 1];
        for &corner in triangles.as_flattened() {
            if slot_of_vertex[corner as usize] != VACANT {
                first[slot_of_vertex[corner as usize] as usize + 1] += 1;
            }
        }
        for slot in 0..vertices.len() {
            first[slot + 1] += first[slot];
        }
        let mut opposite = vec![[VACANT; 2]; first[vertices.len()]];
        let mut next = first.clone();
        for &[a, b, c] in triangles {
            for (corner, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
                let slot = slot_of_vertex[corner as usize];
                if slot != VACANT {
                    opposite[next[slot as usize]] = [from, to];
                    next[slot as usize] += 1;
                }
            }
        }
        Spokes { vertices, slot_of_vertex, first, opposite }
    }

    pub(crate) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// The slot of a vertex, if it has one.
    pub(crate) fn slot(&self, vertex: VertexId) -> Option<usize> {
        let slot = self.slot_of_vertex[vertex as usize];
        (slot != VACANT).then_some(slot as usize)
    }

    /// The sides opposite the vertex in its triangles, in no order. About an inner vertex of a mesh
    /// they make a ring, about one on the outline a chain.
    pub(crate) fn opposite(&self, slot: usize) -> &[[VertexId; 2]] {
        let range: Range<usize> = self.first[slot]..self.first[slot + 1];
        &self.opposite[range]
    }

    /// The neighbours of the vertex, each as often as a triangle has both.
    pub(crate) fn neighbours(&self, slot: usize) -> &[VertexId] {
        self.opposite(slot).as_flattened()
    }

    /// Whether the triangles about the vertex close a ring.
    pub(crate) fn is_inner(&self, slot: usize) -> bool {
        // Each neighbour is the start of as many opposite sides as it is the end of.
        let (mut from, mut to): (Vec<VertexId>, Vec<VertexId>) =
            self.opposite(slot).iter().map(|&[from, to]| (from, to)).unzip();
        from.sort_unstable();
        to.sort_unstable();
        from == to
    }

    /// The spacing about the vertex: the upper quartile of what its neighbours have for the way to
    /// their second nearest neighbour. Where a few samples huddle together, the others count.
    fn spacing_mm(&self, slot: usize, second_mm: &[f64]) -> f64 {
        let mut around: Vec<f64> =
            self.neighbours(slot).iter().map(|&vertex| second_mm[vertex as usize]).collect();
        let quartile = 3 * around.len() / 4;
        *around.select_nth_unstable_by(quartile, f64::total_cmp).1
    }
}

/// Marks a vertex without a slot.
const VACANT: u32 = u32::MAX;
