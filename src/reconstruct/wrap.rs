//! Wrap (H. Edelsbrunner 2003, "Surface reconstruction by wrapping finite sets in space"), by the discrete gradient of U. Bauer and
//! H. Edelsbrunner (2017, doi:10.1090/tran/6991).
//!
//! The distance from the points flows up through the Delaunay triangulation ([`flow`]). Critical simplices are where it rests.
//! The *wrap complex* of a ball holds critical simplices within its diameter and all that lies below them. The alpha complex of that ball
//! collapses to it, so both have the same Betti numbers.
//!
//! Without a ball the critical simplices near the surface are found as E. A. Ramos and B. Sadri do (2007, "Geometric and topological
//! guarantees for the WRAP reconstruction algorithm"): the way from a corner to the centre lies along the surface there, and along the
//! normal near the medial axis. Spheres wider than what a point sees do not count, as lids of open surfaces ([`crate::reach`]). Below them lies a sheet, and a walk along its outer side takes one layer.

mod flow;
mod lower;

use asphera_geometry::PointMm;
use asphera_geometry::predicates::{compare_facet_circle, compare_sphere};

use self::flow::{Flow, Owner};
use self::lower::{Lower, Simplex};
use crate::alpha::AlphaError;
use crate::centres;
use crate::cocone::outer_layer;
use crate::delaunay::Delaunay;
use crate::geometry::{cross, dot, double_area, minus, scaled};
use crate::poles::Poles;
use crate::reach::Reach;
use crate::sampling::SamplingCondition;
use crate::surface::{LeftOut, Reconstruction, of_vertices};

/// A surface by the flow of the distance from points.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrap {
    /// Facets of the complex that have space outside the complex beside them; without a ball one layer of them.
    pub surface: Reconstruction,
    /// Critical edges, facets and tetrahedra of the triangulation.
    pub critical: [usize; 3],
    /// Critical simplices that the complex lies below.
    pub chosen: usize,
    /// Vertices, edges, facets and tetrahedra of the complex.
    pub simplices: [usize; 4],
    /// Components, tunnels and cavities of the complex, coefficients in Z/2.
    pub betti: [i64; 3],
    /// The sampling condition of the theorem; `None` with a ball.
    pub sampling: Option<SamplingCondition>,
}

/// The largest sampling ratio ε for which the theorem holds, as seed 002 states it.
pub const WRAP_BOUND: f64 = 0.01;

/// Wraps points: in the complex of balls of a diameter, or in a surface.
///
/// # Errors
///
/// A diameter that is not from 0 to 1e12 mm, points that do not span space.
pub fn wrap(points_mm: &[PointMm], diameter_mm: Option<f64>) -> Result<Wrap, AlphaError> {
    if let Some(found) = diameter_mm.filter(|d| !(0.0..=asphera_geometry::RANGE_MM).contains(d)) {
        return Err(AlphaError::Diameter { found });
    }
    let delaunay = Delaunay::new(points_mm)?;
    let flow = Flow::of(&delaunay);
    let critical = critical(&flow);
    let count = |wanted: fn(&Simplex) -> bool| critical.iter().filter(|s| wanted(s)).count();
    let counts = [
        count(|simplex| matches!(simplex, Simplex::Edge(_))),
        count(|simplex| matches!(simplex, Simplex::Facet(..))),
        count(|simplex| matches!(simplex, Simplex::Cell(_))),
    ];
    let (chosen, poles): (Vec<Simplex>, Option<Poles>) = if let Some(diameter_mm) = diameter_mm {
        let is_within = |simplex: &Simplex| is_within(&flow, *simplex, diameter_mm);
        (critical.into_iter().filter(is_within).collect(), None)
    } else {
        let near = Nearness::of(&delaunay);
        let chosen = critical.into_iter().filter(|simplex| near.has(&flow, *simplex));
        (chosen.collect::<Vec<_>>(), Some(near.poles))
    };
    let count = chosen.len();
    let lower = Lower::of(&flow, chosen.into_iter());
    let facets = if poles.is_some() { outer_layer(&lower.facets) } else { border(&lower) };
    let sampling =
        poles.map(|poles| SamplingCondition::of(&delaunay.points_mm, &poles, &facets, WRAP_BOUND));
    Ok(Wrap {
        critical: counts,
        chosen: count,
        simplices: lower.counts(),
        betti: lower.betti(),
        surface: of_vertices(points_mm, &delaunay, facets, LeftOut::NoFacet),
        sampling,
    })
}

fn critical(flow: &Flow<'_>) -> Vec<Simplex> {
    let delaunay = flow.delaunay;
    let edges = (0..flow.edges.len())
        .filter(|&edge| flow.edge_owner(edge) == Owner::Itself)
        .map(Simplex::Edge);
    let facets = (delaunay.facets())
        .filter(|&(cell, slot)| flow.is_critical_facet(cell, slot))
        .map(|(cell, slot)| Simplex::Facet(cell, slot));
    let cells = (0..delaunay.tetrahedra as u32)
        .filter(|&cell| flow.is_critical_cell(cell))
        .map(Simplex::Cell);
    edges.chain(facets).chain(cells).collect()
}

/// Whether the smallest sphere of a critical simplex has at most a diameter.
fn is_within(flow: &Flow<'_>, simplex: Simplex, diameter_mm: f64) -> bool {
    let delaunay = flow.delaunay;
    match simplex {
        Simplex::Edge(edge) => {
            let [one, other] = flow.edges[edge].map(|end| delaunay.place(end));
            let way = minus(one, other);
            dot(way, way) <= diameter_mm * diameter_mm
        }
        Simplex::Facet(cell, slot) => {
            let places = delaunay.facet(cell, slot).map(|corner| delaunay.place(corner));
            compare_facet_circle(places, diameter_mm).is_le()
        }
        Simplex::Cell(cell) => compare_sphere(delaunay.places(cell), diameter_mm).is_le(),
    }
}

/// What tells critical simplices near the surface from others.
struct Nearness<'a> {
    delaunay: &'a Delaunay,
    centres: Vec<PointMm>,
    poles: Poles,
    reach: Reach,
}

impl<'a> Nearness<'a> {
    fn of(delaunay: &'a Delaunay) -> Nearness<'a> {
        let centres = centres::of(delaunay);
        let poles = Poles::of(delaunay, &centres);
        Nearness { delaunay, centres, poles, reach: Reach::of(delaunay) }
    }

    fn has(&self, flow: &Flow<'_>, simplex: Simplex) -> bool {
        let delaunay = self.delaunay;
        match simplex {
            Simplex::Edge(edge) => {
                let ends = flow.edges[edge];
                let [one, other] = ends.map(|end| delaunay.place(end));
                self.lies_along(&ends, [0, 1, 2].map(|axis| 0.5 * (one[axis] + other[axis])))
            }
            Simplex::Facet(cell, slot) => {
                let corners = delaunay.facet(cell, slot);
                self.lies_along(&corners, circle_centre(corners.map(|at| delaunay.place(at))))
            }
            Simplex::Cell(cell) => {
                self.lies_along(&delaunay.corners[cell as usize], self.centres[cell as usize])
            }
        }
    }

    /// Whether the way to a centre lies along the surface for one corner at least, and is within reach of one.
    fn lies_along(&self, corners: &[u32], centre: PointMm) -> bool {
        let way = |corner: u32| minus(centre, self.delaunay.place(corner));
        let is_along = |&corner: &u32| {
            let way = way(corner);
            self.poles.normals[corner as usize].is_some_and(|normal| {
                let across = dot(way, normal);
                across * across <= ACROSS * dot(way, way)
            })
        };
        let is_within = |&corner: &u32| {
            let way = way(corner);
            self.reach.holds(corner, dot(way, way).sqrt())
        };
        corners.iter().any(is_along) && corners.iter().any(is_within)
    }
}

/// The centre of the circle through three places.
fn circle_centre([a, b, c]: [PointMm; 3]) -> PointMm {
    let [u, v] = [minus(a, c), minus(b, c)];
    let normal = double_area([a, b, c]);
    let lifted = minus(scaled(v, dot(u, u)), scaled(u, dot(v, v)));
    let way = scaled(cross(lifted, normal), 0.5 / dot(normal, normal));
    [0, 1, 2].map(|axis| c[axis] + way[axis])
}

/// Facets of a complex with space outside the complex on a side.
fn border(lower: &Lower<'_>) -> Vec<[u32; 3]> {
    let delaunay = lower.facets.delaunay;
    let has_space = |&(cell, slot): &(u32, usize)| {
        let other = delaunay.neighbours[cell as usize][slot];
        !(lower.has_cell[cell as usize] && lower.has_cell[other as usize])
    };
    lower.facets.all().filter(has_space).map(|(cell, slot)| delaunay.facet(cell, slot)).collect()
}

/// The square of the cosine of 57°: ways nearer to the normal lead to the medial axis.
const ACROSS: f64 = 0.3;
