//! Interpolation of heights, or of any values given at the vertices, between them.

use asphera_geometry::predicates::Place;
use asphera_geometry::{VertexId, place};

use super::Mesh;
use super::locate::admit_place;
use crate::Location;

impl Mesh {
    /// The height of the mesh in mm at the place (`x_mm`, `y_mm`): on its triangles, or, while all
    /// vertices lie on one line, on the edges between them. None outside. Takes as long as
    /// [`Mesh::locate`].
    pub fn interpolate_linear(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.interpolate_linear_of(x_mm, y_mm, |vertex| self.points[vertex as usize][2])
    }

    /// A value at the place that runs linearly over each triangle, in the unit of `value`, which is
    /// asked for it at up to three vertices. It lies between theirs; a NaN among them is passed on.
    /// None outside.
    pub fn interpolate_linear_of(
        &self,
        x_mm: f64,
        y_mm: f64,
        value: impl FnMut(VertexId) -> f64,
    ) -> Option<f64> {
        weighted(&self.linear_coordinates(x_mm, y_mm), value)
    }

    /// The corners of the triangle in which the place lies and their weights there, as in
    /// [`Mesh::natural_coordinates`]; on an edge its ends, at a vertex that alone.
    pub fn linear_coordinates(&self, x_mm: f64, y_mm: f64) -> Vec<(VertexId, f64)> {
        admit_place(x_mm, y_mm).map_or(Vec::new(), |at| self.linear(at))
    }

    /// The height in mm at the place (`x_mm`, `y_mm`) by natural neighbours: smooth but at the
    /// vertices, where it is theirs, and on the hull, where it is linear along each edge. None
    /// outside.
    ///
    /// Takes as long as [`Mesh::natural_coordinates`].
    pub fn interpolate_natural(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.interpolate_natural_of(x_mm, y_mm, |vertex| self.points[vertex as usize][2])
    }

    /// A value at the place by natural neighbours, in the unit of `value`, which is asked for it at
    /// each of them. It lies between theirs; a NaN among them is passed on. None outside.
    pub fn interpolate_natural_of(
        &self,
        x_mm: f64,
        y_mm: f64,
        value: impl FnMut(VertexId) -> f64,
    ) -> Option<f64> {
        weighted(&self.natural_coordinates(x_mm, y_mm), value)
    }

    /// The natural neighbours of the place (`x_mm`, `y_mm`) and their weights there: R. Sibson's
    /// coordinates (A brief description of natural neighbour interpolation, in: V. Barnett (ed.),
    /// Interpreting Multivariate Data (1981) 21-36). Were the place a vertex, the weight of a
    /// neighbour is the share of the new Voronoi cell that was the neighbour's before.
    ///
    /// Weights are positive and add up to one, to rounding; the places of the neighbours, so
    /// weighted, add up to the place, so that values linear in x and y are reproduced: to rounding
    /// as a rule, and among flat triangles to 1e-9 of the distance to the farthest neighbour.
    /// Counter-clockwise from the smallest number on; vertices that have no share are left out. At
    /// a vertex that alone; on an edge of the hull and on the line of a mesh without triangles the
    /// two ends, by distance; outside nothing.
    ///
    /// Where the place lies so near an edge of the hull or so flat triangles that doubles do not
    /// tell the shares, these are the weights of [`Mesh::linear_coordinates`].
    ///
    /// Takes as long as [`Mesh::locate`], and time in proportion to the neighbours.
    pub fn natural_coordinates(&self, x_mm: f64, y_mm: f64) -> Vec<(VertexId, f64)> {
        let Ok(at) = admit_place(x_mm, y_mm) else { return Vec::new() };
        let natural = match self.delaunay.locate(&self.points[..], at) {
            Location::Inside { .. } | Location::OnEdge { .. } => {
                self.delaunay.natural(&self.points[..], at)
            }
            _ => None,
        };
        natural.filter(|weights| self.balanced(at, weights)).unwrap_or_else(|| self.linear(at))
    }

    fn linear(&self, at: Place) -> Vec<(VertexId, f64)> {
        let place_of = |vertex: VertexId| place(self.points[vertex as usize]);
        let mut weights = match self.delaunay.locate(&self.points[..], at) {
            Location::At { vertex } => vec![(vertex, 1.0)],
            Location::OnEdge { edge } => {
                let share = share_along(edge.map(place_of), at);
                vec![(edge[0], 1.0 - share), (edge[1], share)]
            }
            Location::Inside { triangle } => {
                triangle.into_iter().zip(barycentric(triangle.map(place_of), at)).collect()
            }
            _ => Vec::new(),
        };
        weights.retain(|&(_, weight)| weight > 0.0);
        weights
    }

    /// Whether the neighbours of a place, weighted, add up to it, as good as is asked for.
    fn balanced(&self, at: Place, weights: &[(VertexId, f64)]) -> bool {
        let (mut sum, mut reach) = ([0.0; 2], 0.0_f64);
        for &(vertex, weight) in weights {
            let to = place(self.points[vertex as usize]);
            let [x, y] = [to[0] - at[0], to[1] - at[1]];
            sum = [sum[0] + weight * x, sum[1] + weight * y];
            reach = reach.max(x.hypot(y));
        }
        sum[0].hypot(sum[1]) <= UNBALANCED * reach
    }
}

/// How far the weighted neighbours may miss the place, of the distance to the farthest.
const UNBALANCED: f64 = 1e-9;

/// The sum of the values by their weights; none without any.
fn weighted(weights: &[(VertexId, f64)], mut value: impl FnMut(VertexId) -> f64) -> Option<f64> {
    let (&(vertex, _), others) = weights.split_first()?;
    // What all have in common is not rounded again.
    let first = value(vertex);
    let rest: f64 = others.iter().map(|&(vertex, weight)| weight * (value(vertex) - first)).sum();
    Some(first + rest)
}

/// How far along an edge, from 0 to 1, a place on it lies.
fn share_along([from, to]: [Place; 2], at: Place) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let axis = usize::from(along[1].abs() > along[0].abs());
    ((at[axis] - from[axis]) / along[axis]).clamp(0.0, 1.0)
}

/// The weights of the corners of a triangle at a place inside.
///
/// However flat the triangle is, the corners so weighted add up to the place, to rounding: the
/// weight of the corner opposite the longest side is told by heights above it, and may be as wrong
/// as those are small; whatever it is, the others follow from the distances along that side.
fn barycentric(corners: [Place; 3], at: Place) -> [f64; 3] {
    let side = |i: usize| minus(corners[(i + 2) % 3], corners[(i + 1) % 3]);
    let longest = |&i: &usize, &j: &usize| dot(side(i), side(i)).total_cmp(&dot(side(j), side(j)));
    let apex = (0..3).max_by(longest).unwrap_or(0);
    // Measured from the nearer end, so that a place beside it keeps the small weights of the others.
    let squared = |i: usize| dot(minus(at, corners[i]), minus(at, corners[i]));
    let (from, to) = ((apex + 1) % 3, (apex + 2) % 3);
    let (from, to) = if squared(to) < squared(from) { (to, from) } else { (from, to) };
    let along = minus(corners[to], corners[from]);
    let [to_apex, to_place] = [corners[apex], at].map(|place| minus(place, corners[from]));
    let height = cross(along, to_place) / cross(along, to_apex);
    let mut of_apex = if height.is_finite() { height.clamp(0.0, 1.0) } else { 0.0 };
    let along_side = |way: Place| dot(along, way) / dot(along, along);
    let of_end = |of_apex: f64| along_side(to_place) - of_apex * along_side(to_apex);
    if !(-FLAT..=1.0 - of_apex + FLAT).contains(&of_end(of_apex)) {
        // So wrong that the weight of an end would be negative: cut off, it would move the sum off the place.
        let [of_place, beneath] =
            [to_place, to_apex].map(|way| along_side(way).clamp(0.0, 1.0) + 0.0);
        let most = (of_place / beneath).min((1.0 - of_place) / (1.0 - beneath));
        of_apex = of_apex.min(most);
    }
    let of_to = of_end(of_apex);
    let mut weights = [0.0; 3];
    weights[apex] = of_apex;
    weights[to] = of_to.clamp(0.0, 1.0 - of_apex);
    weights[from] = 1.0 - of_apex - weights[to];
    weights
}

/// What rounding may make of a weight of zero in a triangle that is not flat.
const FLAT: f64 = 1e-12;

fn minus(p: Place, q: Place) -> Place {
    [p[0] - q[0], p[1] - q[1]]
}

fn dot(p: Place, q: Place) -> f64 {
    p[0] * q[0] + p[1] * q[1]
}

fn cross(p: Place, q: Place) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}
