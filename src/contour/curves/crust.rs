//! The crust.

use crate::triangulation::{distance_mm, unsorted_triangles};
use crate::{Graph, PlaceMm, Samples, Triangulation};

/// The crust: edges between samples in the Delaunay triangulation of samples and Voronoi vertices together.
///
/// Proven: of a smooth curve without ends, sampled with ε < 0.252, it is exactly the edges between samples that follow each
/// other. N. Amenta, M. Bern, D. Eppstein, Graphical Models and Image Processing 60 (1998) 125-135; condition and
/// definition are certain. The Voronoi vertices are rounded. One of a triangle that is nearly
/// a line, farther from the middle than four times the extent of the samples, is brought nearer along the bisector of the
/// longest side: it shuts out the same discs about that side. n·log n time, with a second triangulation of three times as many
/// points.
pub fn crust(triangulation: &Triangulation) -> Graph {
    let count = triangulation.len();
    if triangulation.triangles().is_empty() {
        // On a line there is no Voronoi vertex.
        return crate::graphs::delaunay(triangulation);
    }
    let mut places: Vec<PlaceMm> = triangulation.samples().places().to_vec();
    let (middle_mm, far_mm) = surroundings(&places);
    let centres = triangulation.centres_mm().iter().zip(triangulation.triangles());
    places.extend(centres.map(|(&centre_mm, &corners)| {
        if distance_mm(centre_mm, middle_mm) <= far_mm {
            centre_mm
        } else {
            beyond_longest(corners.map(|corner| triangulation.place(corner)), far_mm)
        }
    }));
    // All are in range, and at most three times as many as samples may be.
    let Ok(both) = Samples::new(&places) else { return Graph::default() };
    let mut sample_of = vec![None; both.len()];
    for sample in 0..count {
        sample_of[both.of_row(sample) as usize] = Some(sample as u32);
    }
    // Triangles alone: most edges of them end at a Voronoi vertex, and are not wanted.
    let triangles = unsorted_triangles(&both);
    let edges = triangles.into_iter().flat_map(|corners| {
        let [a, b, c] = corners.map(|corner| sample_of[corner as usize]);
        [[a, b], [b, c], [c, a]].into_iter().filter_map(|[p, q]| Some([p?, q?]))
    });
    Graph::new(edges)
}

/// The middle of the box round places in mm, and the distance from it that counts as far.
fn surroundings(places: &[PlaceMm]) -> (PlaceMm, f64) {
    let first = places[0];
    let (low, high) = places.iter().fold((first, first), |(low, high), &[x, y]| {
        ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)])
    });
    let middle_mm = [0.5 * low[0] + 0.5 * high[0], 0.5 * low[1] + 0.5 * high[1]];
    (middle_mm, FAR * distance_mm(low, high))
}

/// The place so far beyond the longest side of a triangle that turns counter-clockwise, on that side's bisector.
fn beyond_longest([a, b, c]: [PlaceMm; 3], far_mm: f64) -> PlaceMm {
    let sides = [[a, b], [b, c], [c, a]];
    let length_mm = |&[p, q]: &[PlaceMm; 2]| distance_mm(p, q);
    let [p, q] = sides.into_iter().fold(sides[0], |longest, side| {
        if length_mm(&side) > length_mm(&longest) { side } else { longest }
    });
    let share = far_mm / distance_mm(p, q);
    // The triangle lies on the left of its sides.
    [0.5 * (p[0] + q[0]) + share * (q[1] - p[1]), 0.5 * (p[1] + q[1]) + share * (p[0] - q[0])]
}

/// Extents of the samples beyond which Voronoi vertices are brought nearer. Farther ones would leave the mesh's table of places
/// one cell for all samples, and every search a walk along the curve.
const FAR: f64 = 4.0;
