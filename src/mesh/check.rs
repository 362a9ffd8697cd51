//! Proof that a mesh is the Delaunay triangulation of its points, by exact arithmetic.
//!
//! Independent of how the mesh was made: it reads points and triangles alone and decides every sign
//! with this crate's own predicates, not those of the triangulation behind the mesh. For tests, and
//! for whoever doubts a result.

use std::cmp::Ordering;

use asphera_geometry::predicates::{Place, in_circle, orientation};
use asphera_geometry::{PointMm, VertexId, place};
use thiserror::Error;

/// The first thing found wrong with a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Violation {
    /// A corner is not the index of a point.
    #[error("triangle {corners:?} has a corner outside the {points} points")]
    NoSuchPoint {
        /// The triangle.
        corners: [VertexId; 3],
        /// How many points there are.
        points: usize,
    },
    /// A triangle is clockwise or has no area.
    #[error("triangle {corners:?} is not counter-clockwise")]
    NotCounterClockwise {
        /// The triangle.
        corners: [VertexId; 3],
    },
    /// Two triangles lie on the same side of an edge.
    #[error("two triangles lie on the left of the edge from {from} to {to}")]
    EdgeUsedTwice {
        /// Where the edge starts.
        from: VertexId,
        /// Where it ends.
        to: VertexId,
    },
    /// A point lies inside the circumcircle of a triangle.
    #[error("point {inside} lies inside the circumcircle of triangle {corners:?}")]
    CircleNotEmpty {
        /// The triangle.
        corners: [VertexId; 3],
        /// The point inside its circumcircle.
        inside: VertexId,
    },
    /// The boundary turns to the right.
    #[error("the boundary is not convex at vertex {vertex}")]
    NotConvex {
        /// Where it turns.
        vertex: VertexId,
    },
    /// The boundary turns to the left everywhere, but more than once around: triangles overlap.
    #[error("the boundary winds {times} times around, so triangles overlap")]
    WindsTwice {
        /// How often it winds.
        times: usize,
    },
    /// The boundary is not one closed loop.
    #[error("the boundary has {edges} edges, but its first loop has {in_loop}")]
    BoundaryNotOneLoop {
        /// Edges with a triangle on one side only.
        edges: usize,
        /// Those reached from the first.
        in_loop: usize,
    },
    /// A point belongs to no triangle, although there are triangles.
    #[error("point {vertex} belongs to no triangle")]
    Unused {
        /// The point.
        vertex: VertexId,
    },
    /// Euler's relation for a disc, vertices - edges + triangles = 1, does not hold.
    #[error("{vertices} vertices - {edges} edges + {triangles} triangles is not 1")]
    Euler {
        /// Points.
        vertices: usize,
        /// Different edges.
        edges: usize,
        /// Triangles.
        triangles: usize,
    },
    /// There is no triangle, but there are three points that span one.
    #[error("there is no triangle, but point {vertex} is off the line of the first two")]
    NoTriangle {
        /// The first point off the line.
        vertex: VertexId,
    },
}

/// Checks that `triangles` are a Delaunay triangulation of `points`, which must differ in place.
///
/// In this order: every triangle turns counter-clockwise; no two triangles lie on the same side of
/// an edge; every point is used; Euler's relation holds; the boundary is one convex loop that winds once
/// around, so that no triangles overlap (angles about the inner vertices are whole turns, and as many in
/// all as there are such vertices); and of two triangles with a common edge neither has the other's third corner inside its circumcircle, which
/// for all such pairs implies that all circumcircles are empty (B. Delaunay, 1934). Points exactly
/// on a circumcircle are no violation. Without triangles all points must lie on one line.
///
/// Coordinates must be such as [`crate::Mesh`] admits. Takes n log n time.
///
/// # Errors
///
/// The first violation found.
pub fn delaunay(
    points: &[PointMm],
    triangles: impl IntoIterator<Item = [VertexId; 3]>,
) -> Result<(), Violation> {
    let triangles: Vec<[VertexId; 3]> = triangles.into_iter().collect();
    if triangles.is_empty() {
        return on_one_line(points);
    }
    let mesh = Checked { points, triangles: &triangles };
    mesh.triangles_turn_left()?;
    mesh.points_are_used()?;
    let sides = mesh.sides();
    let (inner, boundary) = mesh.edges(&sides)?;
    let edges = inner.len() + boundary.len();
    if points.len() + triangles.len() != edges + 1 {
        let (vertices, triangles) = (points.len(), triangles.len());
        return Err(Violation::Euler { vertices, edges, triangles });
    }
    mesh.boundary_is_convex(&boundary)?;
    mesh.circles_are_empty(&inner)
}

/// One side of a triangle.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Side {
    from: VertexId,
    to: VertexId,
    /// The third corner of the triangle, on the left.
    apex: VertexId,
}

impl Side {
    /// The same for both sides of an edge.
    fn edge(self) -> [VertexId; 2] {
        [self.from.min(self.to), self.from.max(self.to)]
    }
}

struct Checked<'a> {
    points: &'a [PointMm],
    triangles: &'a [[VertexId; 3]],
}

impl Checked<'_> {
    fn at(&self, vertex: VertexId) -> Place {
        place(self.points[vertex as usize])
    }

    fn triangles_turn_left(&self) -> Result<(), Violation> {
        let points = self.points.len();
        for &corners in self.triangles {
            if corners.iter().any(|&corner| corner as usize >= points) {
                return Err(Violation::NoSuchPoint { corners, points });
            }
            let [a, b, c] = corners.map(|corner| self.at(corner));
            if orientation(a, b, c) != Ordering::Greater {
                return Err(Violation::NotCounterClockwise { corners });
            }
        }
        Ok(())
    }

    fn points_are_used(&self) -> Result<(), Violation> {
        let mut used = vec![false; self.points.len()];
        for &corner in self.triangles.as_flattened() {
            used[corner as usize] = true;
        }
        match used.iter().position(|used| !used) {
            Some(vertex) => Err(Violation::Unused { vertex: vertex as VertexId }),
            None => Ok(()),
        }
    }

    /// All sides of all triangles, those of one edge next to each other.
    fn sides(&self) -> Vec<Side> {
        let mut sides: Vec<Side> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b, c), (b, c, a), (c, a, b)])
            .map(|(from, to, apex)| Side { from, to, apex })
            .collect();
        sides.sort_unstable_by_key(|side| (side.edge(), side.from));
        sides
    }

    /// Edges between two triangles, and edges of one triangle.
    fn edges(&self, sides: &[Side]) -> Result<(Vec<[Side; 2]>, Vec<Side>), Violation> {
        let (mut inner, mut boundary) = (Vec::new(), Vec::new());
        for edge in sides.chunk_by(|left, right| left.edge() == right.edge()) {
            match *edge {
                [side] => boundary.push(side),
                [left, right] if left.from != right.from => inner.push([left, right]),
                _ => {
                    // Of at least three sides, or two alike, two that are sorted together are alike.
                    let [from, to] = edge
                        .windows(2)
                        .find(|pair| pair[0].from == pair[1].from)
                        .map_or(edge[0].edge(), |pair| [pair[0].from, pair[0].to]);
                    return Err(Violation::EdgeUsedTwice { from, to });
                }
            }
        }
        Ok((inner, boundary))
    }

    fn boundary_is_convex(&self, boundary: &[Side]) -> Result<(), Violation> {
        let mut next: Vec<Option<VertexId>> = vec![None; self.points.len()];
        for side in boundary {
            next[side.from as usize] = Some(side.to);
        }
        let (mut in_loop, mut times) = (0, 0);
        let mut reached = boundary.first().map(|side| (side.from, side.to));
        while let Some((from, vertex)) = reached.take() {
            let Some(to) = next[vertex as usize].take() else { break };
            in_loop += 1;
            let [before, here, after] = [from, vertex, to].map(|vertex| self.at(vertex));
            let is_convex = match orientation(before, here, after) {
                Ordering::Less => false,
                // Straight on, not back.
                Ordering::Equal => leads_down(before, here) == leads_down(here, after),
                Ordering::Greater => true,
            };
            if !is_convex {
                return Err(Violation::NotConvex { vertex });
            }
            // A loop that only turns left leads down and then up again once in each turn.
            times += usize::from(leads_down(before, here) && !leads_down(here, after));
            reached = Some((vertex, to));
        }
        if in_loop != boundary.len() {
            return Err(Violation::BoundaryNotOneLoop { edges: boundary.len(), in_loop });
        }
        if times != 1 {
            return Err(Violation::WindsTwice { times });
        }
        Ok(())
    }

    fn circles_are_empty(&self, inner: &[[Side; 2]]) -> Result<(), Violation> {
        for &[left, right] in inner {
            let corners = [left.from, left.to, left.apex];
            let [a, b, c] = corners.map(|corner| self.at(corner));
            if in_circle(a, b, c, self.at(right.apex)) == Ordering::Greater {
                return Err(Violation::CircleNotEmpty { corners, inside: right.apex });
            }
        }
        Ok(())
    }
}

/// Whether a side leads down, or straight against the first axis.
fn leads_down(from: Place, to: Place) -> bool {
    [to[1], to[0]] < [from[1], from[0]]
}

fn on_one_line(points: &[PointMm]) -> Result<(), Violation> {
    let [first, second, rest @ ..] = points else { return Ok(()) };
    let (from, to) = (place(*first), place(*second));
    match rest.iter().position(|&point| orientation(from, to, place(point)) != Ordering::Equal) {
        Some(index) => Err(Violation::NoTriangle { vertex: index as VertexId + 2 }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points, triangles, and what is to be found.
    type Case<'a> = (&'a [PointMm], &'a [[VertexId; 3]], Result<(), Violation>);

    const SQUARE: [PointMm; 4] =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.5, 0.0]];

    #[test]
    fn finds_each_violation() {
        let mut concave = SQUARE;
        concave[2] = [0.5, 0.5, 0.0];
        let mut islands = SQUARE.to_vec();
        islands.extend([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]]);
        // Two turns about the middle point, in steps of 80 degrees.
        let twice: Vec<PointMm> = std::iter::once([0.0, 0.0, 0.0])
            .chain((0..9).map(|step| {
                let (sin, cos) = (80.0 * f64::from(step)).to_radians().sin_cos();
                [cos, sin, 0.0]
            }))
            .collect();
        let fan: Vec<[VertexId; 3]> = (1..10).map(|step| [0, step, step % 9 + 1]).collect();
        let cases: [Case; 11] = [
            (&twice, &fan, Err(Violation::WindsTwice { times: 2 })),
            (&SQUARE, &[[0, 1, 2], [0, 2, 3]], Ok(())),
            (
                &SQUARE,
                &[[0, 1, 3], [1, 2, 3]],
                Err(Violation::CircleNotEmpty { corners: [1, 3, 0], inside: 2 }),
            ),
            (
                &SQUARE,
                &[[0, 1, 4], [0, 2, 3]],
                Err(Violation::NoSuchPoint { corners: [0, 1, 4], points: 4 }),
            ),
            (
                &SQUARE,
                &[[0, 2, 1], [0, 2, 3]],
                Err(Violation::NotCounterClockwise { corners: [0, 2, 1] }),
            ),
            (&SQUARE, &[[0, 1, 2], [0, 1, 3]], Err(Violation::EdgeUsedTwice { from: 0, to: 1 })),
            (&SQUARE, &[[0, 1, 2]], Err(Violation::Unused { vertex: 3 })),
            (&concave, &[[0, 1, 2], [0, 2, 3]], Err(Violation::NotConvex { vertex: 2 })),
            (&SQUARE, &[], Err(Violation::NoTriangle { vertex: 2 })),
            (&SQUARE[..2], &[], Ok(())),
            (
                &islands,
                &[[0, 1, 2], [0, 2, 3], [4, 5, 6]],
                Err(Violation::Euler { vertices: 7, edges: 8, triangles: 3 }),
            ),
        ];
        for (points, triangles, expected) in cases {
            assert_eq!(delaunay(points, triangles.iter().copied()), expected);
        }
    }
}
