//! A mesh in space: what it is as a surface, and how far it can be trusted.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A mesh in space of the points of a part that no plane shows whole, and its proof.
///
/// Counts and signs are decided exactly, from points and facets alone. In a snapshot all of it is as of
/// [`ReconstructionFigures::as_of_points`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReconstructionFigures {
    /// How it was made: `local`.
    pub method: String,
    /// Why the points were meshed in space: asked for, or where the surface folds.
    pub reason: String,
    /// Triangles.
    pub facets: u64,
    /// Points that no facet uses, by reason.
    pub left_out: BTreeMap<String, u64>,
    /// Parts that share no vertex.
    pub components: u64,
    /// Whether no edge has one facet only.
    pub closed: bool,
    /// Whether every edge has one or two facets, and every vertex one fan or ring.
    pub manifold: bool,
    /// Whether the facets have two sides.
    pub orientable: bool,
    /// Handles of all parts together; absent of what is no orientable manifold.
    pub genus: Option<i64>,
    /// Components, tunnels and cavities over Z/2; absent where too many patches meet to count them.
    pub betti: Option<[i64; 3]>,
    /// The loops of its border, the longest first, at most [`ReconstructionFigures::LISTED`].
    pub border_loops: Vec<BorderFigures>,
    /// How many more loops there are.
    #[serde(default)]
    pub border_loops_more: u64,
    /// Edges of three facets or more.
    pub nonmanifold_edges: u64,
    /// Vertices whose facets make more than one fan or ring.
    pub singular_vertices: u64,
    /// Pairs of facets that cross.
    pub self_intersections: u64,
    /// Facets without area.
    #[serde(default)]
    pub degenerate_facets: u64,
    /// Area of all facets in mm².
    pub area_mm2: f64,
    /// Volume inside in mm³; absent where the mesh is not closed.
    pub volume_mm3: Option<f64>,
    /// The largest ε of a facet: gap over local feature size, from the source that the sampling names; absent where that is not
    /// known.
    pub epsilon_max: Option<f64>,
    /// The ε up to which a theorem says that the mesh is right; absent of a method without one.
    pub epsilon_bound: Option<f64>,
    /// Promise of the method for these points, in words.
    pub guarantee: String,
    /// How many good points it is made of.
    pub as_of_points: u64,
}

impl ReconstructionFigures {
    /// So many loops of the border are listed.
    pub const LISTED: usize = 32;
}

/// A loop of the border of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BorderFigures {
    /// How many edges it has.
    pub edges: u64,
    /// Its length in mm.
    pub length_mm: f64,
    /// The middle of its corners, on the surface where that is known, mm.
    pub at_mm: [f64; 3],
    /// Area of the opening in mm²: on the fitted sphere or cylinder, else as seen along `approach`; absent where it is not known.
    pub area_mm2: Option<f64>,
    /// Unit vector out of the material there: from where a probe comes. Absent where the mesh has no two sides.
    pub approach: Option<[f64; 3]>,
    /// Whether the surface should go on there; not of the rim of a part that ends.
    pub is_gap: bool,
}
