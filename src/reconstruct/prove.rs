//! Proof of a triangle mesh in space: what it is as a surface, decided exactly.
//!
//! The proof knows nothing of how the mesh was made: it reads points and triangles alone. Edges, umbrellas, orientation,
//! components, borders and Betti numbers are counted; crossings of triangles are decided by exact signs.

pub(crate) mod boxes;
mod crossings;
mod edges;
mod homology;
mod loops;
mod umbrellas;

use asphera_geometry::{PointMm, RANGE_MM};
use rayon::prelude::*;
use thiserror::Error;

pub(crate) use self::crossings::cross_any;
use self::edges::Edges;
pub use self::loops::BorderLoop;
use self::umbrellas::Umbrellas;
use crate::geometry::{cross, dot, double_area, minus};

/// What a triangle mesh is as a surface. The same mesh gives the same proof, whatever the threads.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// Corners of triangles; points that no triangle uses are left out.
    pub vertices: usize,
    /// Edges of triangles, each counted once.
    pub edges: usize,
    /// Triangles.
    pub facets: usize,
    /// Edges of one triangle only.
    pub border_edges: usize,
    /// Edges of three triangles or more.
    pub nonmanifold_edges: Findings<[u32; 2]>,
    /// Vertices whose triangles make more than one fan or ring.
    pub singular_vertices: Findings<u32>,
    /// Pairs of triangles that meet elsewhere than in a common corner or edge, by their numbers.
    pub self_intersections: Findings<[u32; 2]>,
    /// Triangles without area, by their numbers. They are left out of the search for crossings.
    pub degenerate_facets: Findings<u32>,
    /// Parts that share no vertex.
    pub components: usize,
    /// No edge has one triangle only, and there is a triangle.
    pub is_closed: bool,
    /// Every edge has one or two triangles, every vertex one fan or ring.
    pub is_manifold: bool,
    /// The triangles can be turned so that neighbours agree.
    pub is_orientable: bool,
    /// Neighbours agree as the triangles are listed.
    pub is_oriented: bool,
    /// Vertices − edges + facets.
    pub euler: i64,
    /// Handles of all components together; `None` of what is no orientable manifold.
    pub genus: Option<i64>,
    /// Components, tunnels and cavities with coefficients in Z/2. `None` where more than 4,096 patches meet along
    /// non-manifold edges.
    pub betti: Option<[i64; 3]>,
    /// The loops of border edges, the one of the smallest vertex first.
    pub border_loops: Vec<BorderLoop>,
    /// Area of all triangles in mm².
    pub area_mm2: f64,
    /// Volume in mm³ inside a closed mesh whose neighbours agree: positive where triangles turn counter-clockwise seen from
    /// outside. `None` of others.
    pub volume_mm3: Option<f64>,
}

/// Things found: how many, and the first of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Findings<T> {
    /// How many there are.
    pub count: usize,
    /// The first [`LISTED`] of them, in ascending order.
    pub first: Vec<T>,
}

impl<T: Ord> Findings<T> {
    pub(crate) fn of(mut all: Vec<T>) -> Findings<T> {
        all.sort_unstable();
        let count = all.len();
        all.truncate(LISTED);
        Findings { count, first: all }
    }
}

/// Why a mesh cannot be looked at.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProofError {
    /// A corner is not the number of a point.
    #[error(
        "triangle {facet}: expected corners below {points}, found {corner}; give the points that the triangles refer to"
    )]
    NoSuchPoint {
        /// Number of the triangle, from 0.
        facet: usize,
        /// The corner.
        corner: u32,
        /// How many points there are.
        points: usize,
    },
    /// A coordinate is no length in mm that exact signs can be computed of.
    #[error(
        "point {point}: expected coordinates from -1e12 to 1e12 mm, found {value}; leave the point out"
    )]
    Coordinate {
        /// Number of the point, from 0.
        point: u32,
        /// The coordinate.
        value: f64,
    },
    /// More triangles than can be numbered.
    #[error("expected at most {MOST_FACETS} triangles, found {found}; prove parts of the mesh")]
    TooMany {
        /// How many there are.
        found: usize,
    },
}

/// The largest number of triangles that [`prove`] takes.
pub const MOST_FACETS: usize = 16_000_000;
/// How many findings of a kind are listed.
pub const LISTED: usize = 16;

/// Proves what a triangle mesh is. n·log n time.
///
/// Coordinates below 1e-40 mm in size should be zero, as [`asphera_geometry::TINY_MM`] says.
///
/// # Errors
///
/// A corner that names no point, a coordinate of a corner that is not finite or beyond 1e12 mm, more than [`MOST_FACETS`] triangles.
pub fn prove(points_mm: &[PointMm], facets: &[[u32; 3]]) -> Result<Proof, ProofError> {
    check(points_mm, facets)?;
    let edges = Edges::of(facets);
    let umbrellas = Umbrellas::of(facets, &edges);
    let degenerate: Vec<u32> = (0..facets.len() as u32)
        .into_par_iter()
        .filter(|&facet| crossings::is_degenerate(corners(points_mm, facets[facet as usize])))
        .collect();
    let crossings = crossings::all(points_mm, facets, &degenerate);
    let border_loops = loops::of(points_mm, facets, &edges, &umbrellas);
    let vertices = umbrellas.vertices;
    let euler = vertices as i64 - edges.count as i64 + facets.len() as i64;
    let is_manifold = edges.nonmanifold.is_empty() && umbrellas.singular.is_empty();
    let is_closed = edges.border.is_empty() && !facets.is_empty();
    let components = umbrellas.components;
    // Of closed surfaces the Euler number is 2 - 2g each; every border is a disc that is missing.
    let handles = 2 * components as i64 - border_loops.len() as i64 - euler;
    let area_mm2 = ordered_sum(facets, |&facet| {
        let normal = double_area(corners(points_mm, facet));
        dot(normal, normal).sqrt() / 2.0
    });
    let encloses = is_closed && edges.nonmanifold.is_empty() && edges.is_oriented;
    let volume_mm3 = encloses.then(|| volume(points_mm, facets));
    Ok(Proof {
        vertices,
        edges: edges.count,
        facets: facets.len(),
        border_edges: edges.border.len(),
        self_intersections: Findings::of(crossings),
        degenerate_facets: Findings::of(degenerate),
        components,
        is_closed,
        is_manifold,
        is_orientable: edges.is_orientable,
        is_oriented: edges.is_oriented,
        euler,
        genus: (is_manifold && edges.is_orientable).then_some(handles / 2),
        betti: homology::betti(&edges, facets.len(), components, euler),
        nonmanifold_edges: Findings::of(edges.nonmanifold.iter().map(|edge| edge.ends).collect()),
        singular_vertices: Findings::of(umbrellas.singular),
        border_loops,
        area_mm2,
        volume_mm3,
    })
}

fn check(points_mm: &[PointMm], facets: &[[u32; 3]]) -> Result<(), ProofError> {
    if facets.len() > MOST_FACETS {
        return Err(ProofError::TooMany { found: facets.len() });
    }
    for (facet, corners) in facets.iter().enumerate() {
        for &corner in corners {
            let Some(point) = points_mm.get(corner as usize) else {
                return Err(ProofError::NoSuchPoint { facet, corner, points: points_mm.len() });
            };
            let is_length = |value: &f64| value.is_finite() && value.abs() <= RANGE_MM;
            if let Some(&value) = point.iter().find(|value| !is_length(value)) {
                return Err(ProofError::Coordinate { point: corner, value });
            }
        }
    }
    Ok(())
}

pub(crate) fn corners(points_mm: &[PointMm], facet: [u32; 3]) -> [PointMm; 3] {
    facet.map(|corner| points_mm[corner as usize])
}

/// The volume inside, by tetrahedra with the first corner as apex.
fn volume(points_mm: &[PointMm], facets: &[[u32; 3]]) -> f64 {
    let Some(first) = facets.first() else { return 0.0 };
    let apex = points_mm[first[0] as usize];
    ordered_sum(facets, |&facet| {
        let [a, b, c] = corners(points_mm, facet).map(|corner| minus(corner, apex));
        dot(a, cross(b, c)) / 6.0
    })
}

/// A sum over chunks of fixed size, so that it does not depend on the threads.
pub(crate) fn ordered_sum<T: Sync>(items: &[T], value: impl Fn(&T) -> f64 + Sync) -> f64 {
    let sums: Vec<f64> =
        items.par_chunks(4096).map(|chunk| chunk.iter().map(&value).sum::<f64>()).collect();
    sums.into_iter().sum()
}
