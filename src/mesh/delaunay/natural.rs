//! Natural neighbour coordinates of a place.
//!
//! R. Sibson, A vector identity for the Dirichlet tessellation, Math. Proc. Cambridge Phil. Soc. 87
//! (1980) 151-155, doi:10.1017/S0305004100056589; A brief description of natural neighbour
//! interpolation, in: V. Barnett (ed.), Interpreting Multivariate Data (1981) 21-36. Were the place
//! a vertex, its Voronoi cell would be taken from those of its neighbours, and what it takes from
//! each is that neighbour's weight. As D. F. Watson computes it (Contouring: A Guide to the
//! Analysis and Display of Spatial Data (1992)), from the triangles that would go: their
//! circumcentres, and those of the triangles that would come, are the corners of the parts. Here
//! each part is taken as one polygon, so that no triangle of the place with an inner edge occurs,
//! which has no circumcentre when the place lies on that edge:
//!
//! ```text
//!       g0 ─── o0             g  circumcentres of the place, the neighbour, and the one before
//!       │        \               or after it about the place
//!       │         o1          o  circumcentres of the neighbour's triangles that would go
//!       │        /
//!       g1 ─── o2                the side from g1 to g0 halves the way from place to neighbour
//! ```

use asphera_geometry::predicates::Place;
use asphera_geometry::{VertexId, from_smallest};

use super::cells::{Cells, Slot};
use super::editor::Editor;
use super::places::Places;

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// The natural neighbours of a place located in the triangle `home`, no vertex, and their
    /// weights, not negative and with the sum one, counter-clockwise from the smallest number on.
    ///
    /// None if the place lies on the hull, where the parts have no end, or so near that their size
    /// is not told by doubles.
    pub(super) fn natural(&mut self, place: Place, home: Slot) -> Option<Vec<(VertexId, f64)>> {
        self.carve(place, home);
        if self.work.doomed.iter().any(|&slot| self.cells.is_ghost(slot)) {
            return None;
        }
        let border = &mut self.work.border;
        let smallest = (0..border.len()).min_by_key(|&index| border[index].1)?;
        border.rotate_left(smallest);
        let border = &self.work.border;
        let from_place = |vertex: VertexId| minus(self.at(vertex), place);
        let new_centres: Vec<Place> = (0..border.len())
            .map(|i| {
                let (start, end) = (border[i].1, border[(i + 1) % border.len()].1);
                centre(from_place(start), from_place(end))
            })
            .collect();
        let mut weights = Vec::with_capacity(border.len());
        for (i, &(outside, neighbour)) in border.iter().enumerate() {
            let before = (i + border.len() - 1) % border.len();
            // All corners from the first on, lest differences of large numbers make up a small
            // part.
            let first = new_centres[i];
            let mut last = [0.0; 2];
            let mut twice_area = 0.0;
            let mut pass = |corner: Place| {
                let corner = minus(corner, first);
                twice_area += cross(last, corner);
                last = corner;
            };
            let mut side = self.cells.across(outside);
            loop {
                pass(self.old_centre(side.slot(), place));
                let next = self.cells.across(side.prev());
                if next == border[before].0 {
                    break;
                }
                side = next;
            }
            pass(new_centres[before]);
            weights.push((neighbour, twice_area));
        }
        normalized(weights)
    }

    /// The circumcentre of a triangle, seen from a place.
    fn old_centre(&self, slot: Slot, place: Place) -> Place {
        // How the corners are turned in their cell depends on how the mesh grew.
        let [a, b, c] = from_smallest(self.cells.corners(slot)).map(|corner| self.at(corner));
        let [x, y] = centre(minus(b, a), minus(c, a));
        let [ax, ay] = minus(a, place);
        [ax + x, ay + y]
    }
}

/// The circumcentre of the origin, `p` and `q`, which turn left.
fn centre(p: Place, q: Place) -> Place {
    let squared = |p: Place| p[0] * p[0] + p[1] * p[1];
    let (pp, qq, twice) = (squared(p), squared(q), 2.0 * cross(p, q));
    [(pp * q[1] - qq * p[1]) / twice, (qq * p[0] - pp * q[0]) / twice]
}

/// Areas as weights; none if they tell nothing.
fn normalized(areas: Vec<(VertexId, f64)>) -> Option<Vec<(VertexId, f64)>> {
    // Rounding may make a small one negative.
    let sum: f64 = areas.iter().map(|&(_, area)| area.max(0.0)).sum();
    let told = sum > 0.0 && sum.is_finite() && areas.iter().all(|(_, area)| area.is_finite());
    let positive = areas.into_iter().filter(|&(_, area)| area > 0.0);
    told.then(|| positive.map(|(vertex, area)| (vertex, area / sum)).collect())
}

fn minus(p: Place, q: Place) -> Place {
    [p[0] - q[0], p[1] - q[1]]
}

fn cross(p: Place, q: Place) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}
