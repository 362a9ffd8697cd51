//! Which vertices are neighbours on the surface: joined by an edge of it that bridges no gap.

use asphera_geometry::{PointMm, VertexId};
use thiserror::Error;

/// The neighbours of every vertex along the edges of a set of triangles.
///
/// This is the true neighbourhood of a vertex: what is near in space but on another sheet, across a
/// hole or beyond a gap of the scan is none of it.
#[derive(Clone, Debug)]
pub struct Adjacency {
    /// Where the neighbours of each vertex start in `ends`, and after the last vertex their number.
    starts: Vec<usize>,
    ends: Vec<VertexId>,
    /// One for each vertex.
    border: Vec<bool>,
}

/// Why there is no [`Adjacency`].
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AdjacencyError {
    /// The reach is not a length.
    #[error("reach {reach_mm} mm is not above 0")]
    Reach {
        /// The reach in mm.
        reach_mm: f64,
    },
    /// A triangle has a corner that is no point.
    #[error("triangle {triangle} has the corner {corner}, but there are {points} points")]
    Corner {
        /// Index of the triangle.
        triangle: usize,
        /// Its corner.
        corner: VertexId,
        /// How many points there are.
        points: usize,
    },
}

impl Adjacency {
    /// The edges of `triangles`, whose corners are indices into `points`, up to a length of
    /// `reach_mm` in space.
    ///
    /// A Delaunay mesh fills the convex hull: its edges also bridge holes, hollows of the outline and
    /// what was not measured. Such edges must not make neighbours. Either only those triangles are
    /// passed that are surface ([`crate::Survey::good`]), or a reach, several times the sample
    /// distance, forbids longer edges; or both. No reach: every edge counts.
    ///
    /// Linear time; 24 bytes a point, while it is built 48 more.
    pub fn new(
        points: &[PointMm],
        triangles: &[[VertexId; 3]],
        reach_mm: Option<f64>,
    ) -> Result<Adjacency, AdjacencyError> {
        let reach_mm = reach_mm.unwrap_or(f64::INFINITY);
        if reach_mm.is_nan() || reach_mm <= 0.0 {
            return Err(AdjacencyError::Reach { reach_mm });
        }
        let both_ends = both_ends(points.len(), triangles)?;
        Ok(both_ends.merged(points, reach_mm))
    }

    /// How many vertices there are, those without neighbours included.
    pub fn len(&self) -> usize {
        self.border.len()
    }

    /// Whether there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.border.is_empty()
    }

    /// The neighbours of a vertex in the order of their numbers.
    ///
    /// # Panics
    ///
    /// When there is no such vertex.
    pub fn neighbours(&self, vertex: VertexId) -> &[VertexId] {
        let vertex = vertex as usize;
        &self.ends[self.starts[vertex]..self.starts[vertex + 1]]
    }

    /// Whether the triangles about a vertex do not close around it, or one of its edges is longer
    /// than the reach. A vertex without neighbours is on the border.
    ///
    /// # Panics
    ///
    /// When there is no such vertex.
    pub fn on_border(&self, vertex: VertexId) -> bool {
        self.border[vertex as usize]
    }
}

/// For every vertex the two other corners of each of its triangles.
struct BothEnds {
    starts: Vec<usize>,
    ends: Vec<VertexId>,
}

fn both_ends(points: usize, triangles: &[[VertexId; 3]]) -> Result<BothEnds, AdjacencyError> {
    let mut starts = vec![0_usize; points + 1];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &corner in corners {
            if corner as usize >= points {
                return Err(AdjacencyError::Corner { triangle, corner, points });
            }
            starts[corner as usize + 1] += 2;
        }
    }
    for vertex in 0..points {
        starts[vertex + 1] += starts[vertex];
    }
    let mut ends = vec![0; starts[points]];
    let mut next = starts.clone();
    for &[a, b, c] in triangles {
        for (corner, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
            let place = &mut next[corner as usize];
            ends[*place..*place + 2].copy_from_slice(&others);
            *place += 2;
        }
    }
    Ok(BothEnds { starts, ends })
}

impl BothEnds {
    /// Every edge once. One between two triangles was found twice; others are on the border.
    fn merged(self, points: &[PointMm], reach_mm: f64) -> Adjacency {
        let BothEnds { mut starts, mut ends } = self;
        let mut border = vec![false; points.len()];
        let mut kept = 0;
        for vertex in 0..points.len() {
            let range = starts[vertex]..starts[vertex + 1];
            starts[vertex] = kept;
            border[vertex] = range.is_empty();
            ends[range.clone()].sort_unstable();
            let mut index = range.start;
            while index < range.end {
                let end = ends[index];
                let run = ends[index..range.end].iter().take_while(|&&other| other == end).count();
                index += run;
                let too_long = distance_mm(points[vertex], points[end as usize]) > reach_mm;
                border[vertex] |= run != 2 || too_long;
                if !too_long && end as usize != vertex {
                    ends[kept] = end;
                    kept += 1;
                }
            }
        }
        starts[points.len()] = kept;
        ends.truncate(kept);
        ends.shrink_to_fit();
        Adjacency { starts, ends, border }
    }
}

fn distance_mm(p: PointMm, q: PointMm) -> f64 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    (x * x + y * y + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of four triangles about vertex 4, the last corner 10 mm away.
    const POINTS: [PointMm; 6] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -10.0, 0.0],
        [0.0, 0.0, 0.0],
        [9.0, 9.0, 9.0],
    ];
    const FAN: [[VertexId; 3]; 4] = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [0, 4, 3]];

    #[test]
    fn a_fan() {
        let adjacency = Adjacency::new(&POINTS, &FAN, None).unwrap();
        assert_eq!(adjacency.len(), 6);
        assert_eq!(adjacency.neighbours(4), [0, 1, 2, 3]);
        assert_eq!(adjacency.neighbours(0), [1, 3, 4]);
        assert_eq!(adjacency.neighbours(5), [0; 0]);
        let border: Vec<bool> = (0..6).map(|vertex| adjacency.on_border(vertex)).collect();
        assert_eq!(border, [true, true, true, true, false, true]);
    }

    #[test]
    fn the_reach_is_inclusive_and_what_it_cuts_is_border() {
        let whole = Adjacency::new(&POINTS, &FAN, Some(10.0)).unwrap();
        assert_eq!(whole.neighbours(4), [0, 1, 2, 3]);
        assert!(!whole.on_border(4));
        let cut = Adjacency::new(&POINTS, &FAN, Some(9.99)).unwrap();
        assert_eq!(cut.neighbours(4), [0, 1, 2]);
        assert_eq!(cut.neighbours(3), [0; 0]);
        assert!(cut.on_border(4));
    }

    #[test]
    fn nonsense_is_an_error() {
        for reach_mm in [0.0, -1.0, f64::NAN] {
            let found = Adjacency::new(&POINTS, &FAN, Some(reach_mm)).unwrap_err();
            assert!(matches!(found, AdjacencyError::Reach { .. }));
        }
        let found = Adjacency::new(&POINTS, &[[0, 1, 4], [0, 1, 6]], None).unwrap_err();
        assert_eq!(found, AdjacencyError::Corner { triangle: 1, corner: 6, points: 6 });
        assert_eq!(found.to_string(), "triangle 1 has the corner 6, but there are 6 points");
    }
}
