//! The graph method: a surface through landmarks, found in a graph of neighbours.
//!
//! "Graph-based 2-manifold reconstruction"; sections, equations and tables named here are that paper's. Geometry ends with the
//! graph: steps 2 to 6 count hops and contacts. The steps are
//!
//! 1. [`links`]: an edge to each of the κ nearest;
//! 2. [`landmarks`]: a maximal set of points at least k hops apart;
//! 3. [`cells`]: every point belongs to the nearest landmark in hops;
//! 4. [`contacts`]: landmarks whose cells touch at more than `a` points are joined (the combinatorial Delaunay map);
//! 5. [`faces`]: cycles of 3, 4, ... edges, an edge in at most two;
//! 6. [`triangles`]: longer faces cut by their short diagonals;
//! 7. [`put_back`], where asked for: all other points become vertices, by lengths and angles.
//!
//! Ties of distances fall by coordinates and those of hops by the order of the landmarks. So the surface depends on the places
//! alone.

mod cells;
mod contacts;
mod faces;
mod landmarks;
mod links;
mod live;
mod mapped;
mod put_back;
mod tiles;
mod triangles;

use asphera_geometry::PointMm;
use thiserror::Error;

pub use self::contacts::Contact;
pub use self::landmarks::LandmarkOrder;
use self::links::Links;
pub use self::live::LiveGraph;
use self::mapped::Mapped;
pub use self::tiles::{
    MOST_TILED_POINTS, TileError, TileShelf, TileShelfFailure, TiledGraph, TiledSurface,
};
use crate::local::MOST_POINTS;
use crate::neighbours::Neighbours;
use crate::surface::{LeftOut, Reconstruction, admitted, finished};

/// Numbers that the graph method goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GraphChoices {
    /// k: landmarks are at least so many hops apart; 1 to [`MOST_HOPS`].
    pub hops: u8,
    /// a: cells that touch at more points than this are joined.
    pub threshold: u32,
    /// Which points become landmarks first.
    pub order: LandmarkOrder,
    /// Which cycles of the map are faces.
    pub faces: FaceRule,
}

/// Which cycles of 4 edges or more are faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceRule {
    /// Those around which the cells meet within: pairs that meet, but share no edge, cut the cycle into triangles. Beyond the
    /// paper: a hole of the points stays open.
    #[default]
    Filled,
    /// All, as in the paper. The rim of a hole with at most ten landmarks becomes a lid.
    Any,
}

impl Default for GraphChoices {
    /// k = 5 and a = 7, the paper's.
    fn default() -> GraphChoices {
        GraphChoices { hops: 5, threshold: 7, order: LandmarkOrder::Sweep, faces: FaceRule::Filled }
    }
}

impl GraphChoices {
    fn check(&self) -> Result<(), GraphError> {
        let is_allowed = (1..=MOST_HOPS).contains(&self.hops);
        is_allowed.then_some(()).ok_or(GraphError::Hops { found: self.hops })
    }
}

/// Refuses a κ that is out of range.
fn check_neighbours(neighbours: usize) -> Result<(), GraphError> {
    let is_allowed = (1..=MOST_NEIGHBOURS).contains(&neighbours);
    is_allowed.then_some(()).ok_or(GraphError::Neighbours { found: neighbours })
}

/// Points and the graph of their neighbours.
pub struct PointGraph<'a> {
    points_mm: &'a [PointMm],
    tree: Neighbours,
    links: Links,
    left_out: Vec<(u32, LeftOut)>,
}

/// What the graph method found.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphSurface {
    /// The triangles through landmarks, and every other point with the reason.
    pub reconstruction: Reconstruction,
    /// The map that the triangles were cut of.
    pub map: GraphMap,
    /// Why there are no facets; `None` where there are.
    pub no_surface: Option<NoSurface>,
}

/// The combinatorial Delaunay map and its faces, by the numbers of points.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphMap {
    /// In the order in which they were chosen.
    pub landmarks: Vec<u32>,
    /// The cell of each point; `None` of those without place and of duplicates.
    pub cells: Vec<Option<Cell>>,
    /// All pairs of cells that touch, in the order of their landmarks.
    pub contacts: Vec<Contact>,
    /// Contacts at more points than the threshold: the edges of the map.
    pub edges: usize,
    /// Landmarks with an edge.
    pub vertices: usize,
    /// Parts that no edge joins.
    pub components: usize,
    /// Cycles of landmarks, the short ones first.
    pub faces: Vec<Vec<u32>>,
}

/// The cell that a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its landmark.
    pub landmark: u32,
    /// Hops from the point to the landmark.
    pub hops: u8,
}

impl GraphMap {
    /// Vertices − edges + faces, equation 4.1.
    pub fn euler(&self) -> i64 {
        self.vertices as i64 - self.edges as i64 + self.faces.len() as i64
    }

    /// Handles of all parts together by equation 4.2, here for any number of parts.
    ///
    /// A half means that the map is no closed surface; a whole number does not prove that it is one.
    pub fn genus(&self) -> f64 {
        (2 * self.components as i64 - self.euler()) as f64 / 2.0
    }

    /// How many faces are triangles.
    pub fn triangles(&self) -> usize {
        self.faces.iter().filter(|face| face.len() == 3).count()
    }
}

/// Why the graph method found no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NoSurface {
    /// Fewer than four different places.
    #[error("expected at least 4 points at different places for a surface")]
    FewPoints,
    /// Fewer than four landmarks: the points reach no further than a few hops.
    #[error(
        "fewer than 4 landmarks, for the points reach no further than a few hops: take fewer hops or neighbours"
    )]
    FewLandmarks,
    /// The map has no cycles: points along a line, or cells that touch at too few points.
    #[error("no cycle of landmarks: the points lie along a line, or the threshold is too high")]
    NoFaces,
}

/// A step of the method, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The tree of places.
    Tree,
    /// Nearest neighbours and their graph.
    Neighbours,
    /// The stable set.
    Landmarks,
    /// The graph Voronoi diagram.
    Cells,
    /// The combinatorial Delaunay map.
    Map,
    /// Cycles of the map.
    Faces,
    /// Faces cut into triangles, and turned.
    Triangles,
    /// Points that landmarks stand for, put back as vertices; where that is asked for.
    PutBack,
}

/// Why the graph method cannot begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum GraphError {
    /// More points than memory is meant for.
    #[error("expected at most {MOST_POINTS} points, found {found}; reduce them first")]
    TooManyPoints {
        /// How many there are.
        found: usize,
    },
    /// κ out of range.
    #[error("expected 1 to {MOST_NEIGHBOURS} neighbours, found {found}; the paper takes 15")]
    Neighbours {
        /// What was asked for.
        found: usize,
    },
    /// k out of range.
    #[error("expected landmarks 1 to {MOST_HOPS} hops apart, found {found}; the paper takes 5")]
    Hops {
        /// What was asked for.
        found: u8,
    },
}

/// The largest number of neighbours in a graph.
pub const MOST_NEIGHBOURS: usize = 64;
/// The largest number of hops between landmarks.
pub const MOST_HOPS: u8 = 100;

impl<'a> PointGraph<'a> {
    /// The graph with an edge from every place to its `neighbours` nearest. n·log n time.
    ///
    /// `enters` is given each stage as it begins.
    ///
    /// # Errors
    ///
    /// More than [`MOST_POINTS`] points, no neighbours or more than [`MOST_NEIGHBOURS`].
    pub fn new(
        points_mm: &'a [PointMm],
        neighbours: usize,
        enters: &mut dyn FnMut(Stage),
    ) -> Result<PointGraph<'a>, GraphError> {
        if points_mm.len() > MOST_POINTS {
            return Err(GraphError::TooManyPoints { found: points_mm.len() });
        }
        check_neighbours(neighbours)?;
        enters(Stage::Tree);
        let (places, left_out) = admitted(points_mm);
        let tree = Neighbours::of(places);
        enters(Stage::Neighbours);
        let links = Links::of(&tree, neighbours);
        Ok(PointGraph { points_mm, tree, links, left_out })
    }

    /// The surface that the graph has. Linear time but for sorting.
    ///
    /// `enters` is given each stage as it begins.
    ///
    /// # Errors
    ///
    /// No hops or more than [`MOST_HOPS`].
    pub fn surface(
        &self,
        choices: &GraphChoices,
        enters: &mut dyn FnMut(Stage),
    ) -> Result<GraphSurface, GraphError> {
        choices.check()?;
        enters(Stage::Landmarks);
        let landmarks =
            landmarks::landmarks(&self.links, &self.tree.points_mm, choices.hops, choices.order);
        enters(Stage::Cells);
        let owners = cells::owners(&self.links, &landmarks);
        enters(Stage::Map);
        let contacts = contacts::contacts(&self.links, &owners);
        let meetings = || {
            let is_asked = choices.faces == FaceRule::Filled;
            is_asked.then(|| contacts::meetings(&self.links, &owners))
        };
        let places: Vec<PointMm> =
            landmarks.points.iter().map(|&at| self.tree.points_mm[at as usize]).collect();
        let ids: Vec<u32> = landmarks.points.iter().map(|&at| self.tree.ids[at as usize]).collect();
        let mut mapped = Mapped::of(&places, contacts, choices.threshold, meetings, enters);
        let facets = finished(self.points_mm, &ids, std::mem::take(&mut mapped.triangles));
        let mut cells = vec![None; self.points_mm.len()];
        for (at, &id) in self.tree.ids.iter().enumerate() {
            let landmark = ids[owners[at] as usize];
            cells[id as usize] = Some(Cell { landmark, hops: landmarks.hops[at] });
        }
        let map = mapped.map(ids, cells);
        let no_surface =
            facets.is_empty().then(|| NoSurface::of(self.tree.len(), map.landmarks.len()));
        let left_out = left_out(&facets, &map, &self.left_out);
        Ok(GraphSurface { reconstruction: Reconstruction { facets, left_out }, map, no_surface })
    }
}

/// Points that no facet uses, and why; `others` are those without a place of their own.
fn left_out(facets: &[[u32; 3]], map: &GraphMap, others: &[(u32, LeftOut)]) -> Vec<(u32, LeftOut)> {
    let mut reasons: Vec<Option<LeftOut>> =
        map.cells.iter().map(|cell| cell.map(|_| LeftOut::Pruned)).collect();
    for &landmark in &map.landmarks {
        reasons[landmark as usize] = Some(LeftOut::NoFace);
    }
    for &corner in facets.as_flattened() {
        reasons[corner as usize] = None;
    }
    let unused = (0..).zip(reasons).filter_map(|(point, reason)| Some((point, reason?)));
    let mut left_out: Vec<(u32, LeftOut)> = unused.chain(others.iter().copied()).collect();
    left_out.sort_unstable();
    left_out
}
