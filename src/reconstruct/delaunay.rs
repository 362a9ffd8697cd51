//! The Delaunay triangulation of points in space, exact, with one rule for ties.
//!
//! Points are inserted one by one (A. Bowyer, D. F. Watson 1981): cells whose spheres enclose the point give way to cells with it.
//! Beyond each facet of the convex hull lies a cell with a corner at infinity, so that outside is not a special case. The order
//! of insertion is along a Hilbert curve in rounds that double ([`order`]). It decides the time alone: of places on one sphere
//! the last by x, y, z counts as outside ([`asphera_geometry::predicates::sphere_encloses`]), so the triangulation is unique.

mod check;
mod insert;
mod order;
mod start;

use asphera_geometry::PointMm;
use thiserror::Error;

pub use self::check::{Unsound, check_delaunay};
use self::insert::Inserter;
use crate::surface::{LeftOut, Numbered, admitted};

/// The Delaunay triangulation of points in space.
#[derive(Clone, Debug)]
pub struct Delaunay {
    /// Vertices in the order of insertion.
    pub(crate) points_mm: Vec<PointMm>,
    /// Their numbers as they came.
    pub(crate) ids: Vec<u32>,
    /// Points that are no vertices, and why.
    pub(crate) left_out: Vec<(u32, LeftOut)>,
    /// Corners of the cells: tetrahedra first, then cells with [`INFINITE`] as last corner.
    pub(crate) corners: Vec<[u32; 4]>,
    /// The cell across the facet opposite each corner.
    pub(crate) neighbours: Vec<[u32; 4]>,
    /// How many cells are tetrahedra.
    pub(crate) tetrahedra: usize,
}

/// Whether places, each there once, span space.
///
/// # Errors
///
/// Why they do not.
pub(crate) fn check_span(places: &[Numbered]) -> Result<(), NoDelaunay> {
    if places.len() > MOST_DELAUNAY_POINTS {
        return Err(NoDelaunay::TooMany { found: places.len() });
    }
    if places.len() < 4 {
        return Err(NoDelaunay::TooFew { found: places.len() });
    }
    start::bring_forward(&mut places.to_vec())
}

/// The corner at infinity.
pub(crate) const INFINITE: u32 = u32::MAX;

/// The largest number of points that a Delaunay triangulation takes.
pub const MOST_DELAUNAY_POINTS: usize = 12_000_000;

/// Why points have no Delaunay triangulation in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NoDelaunay {
    /// More points than memory is meant for.
    #[error("expected at most {MOST_DELAUNAY_POINTS} points, found {found}; reduce them first")]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// Fewer than four different places.
    #[error("expected at least 4 different finite places, found {found}; give more points")]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// All places on a line.
    #[error(
        "all {places} places lie exactly on a line; expected places that span space; check the columns of the file"
    )]
    OnALine {
        /// How many there are.
        places: usize,
    },
    /// All places in a plane.
    #[error(
        "all {places} places lie exactly in a plane; expected places that span space; use --method local"
    )]
    InAPlane {
        /// How many there are.
        places: usize,
    },
}

impl Delaunay {
    /// Triangulates points: exact, n·log n time for scans of surfaces, some 300 bytes a point.
    ///
    /// The tetrahedra depend on the places alone, not on their order. Points with coordinates that are not finite or beyond
    /// 1e12 mm and points in the place of an earlier one are no vertices.
    ///
    /// # Errors
    ///
    /// Too many points, or places that do not span space.
    pub fn new(points_mm: &[PointMm]) -> Result<Delaunay, NoDelaunay> {
        if points_mm.len() > MOST_DELAUNAY_POINTS {
            return Err(NoDelaunay::TooMany { found: points_mm.len() });
        }
        let (mut places, left_out) = admitted(points_mm);
        if places.len() < 4 {
            return Err(NoDelaunay::TooFew { found: places.len() });
        }
        order::arrange(&mut places);
        start::bring_forward(&mut places)?;
        let ids = places.iter().map(|&(_, id)| id).collect();
        let points_mm: Vec<PointMm> = places.into_iter().map(|(place, _)| place).collect();
        let mut inserter = Inserter::new(&points_mm);
        for vertex in 4..points_mm.len() as u32 {
            inserter.insert(vertex);
        }
        let (corners, neighbours, tetrahedra) = inserter.finish();
        Ok(Delaunay { points_mm, ids, left_out, corners, neighbours, tetrahedra })
    }

    /// Tetrahedra by the numbers of the points as they came, corners and list in ascending order.
    pub fn tetrahedra(&self) -> Vec<[u32; 4]> {
        let mut all: Vec<[u32; 4]> = self.corners[..self.tetrahedra]
            .iter()
            .map(|corners| {
                let mut numbers = corners.map(|corner| self.ids[corner as usize]);
                numbers.sort_unstable();
                numbers
            })
            .collect();
        all.sort_unstable();
        all
    }

    /// Points that are vertices.
    pub fn vertices(&self) -> usize {
        self.points_mm.len()
    }

    /// Points that are no vertices, and why.
    pub fn left_out(&self) -> &[(u32, LeftOut)] {
        &self.left_out
    }

    /// Whether a cell has a corner at infinity.
    #[inline]
    pub(crate) fn is_outside(&self, cell: u32) -> bool {
        cell as usize >= self.tetrahedra
    }

    #[inline]
    pub(crate) fn place(&self, vertex: u32) -> PointMm {
        self.points_mm[vertex as usize]
    }

    /// The places of the corners of a tetrahedron.
    #[inline]
    pub(crate) fn places(&self, cell: u32) -> [PointMm; 4] {
        self.corners[cell as usize].map(|corner| self.place(corner))
    }

    /// The corner of a cell that is opposite its neighbour `other`.
    #[inline]
    pub(crate) fn slot_toward(&self, cell: u32, other: u32) -> usize {
        let across = &self.neighbours[cell as usize];
        across.iter().position(|&neighbour| neighbour == other).unwrap_or(3)
    }

    /// Every finite facet once: a tetrahedron and the corner that the facet is opposite to.
    pub(crate) fn facets(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        (0..self.tetrahedra as u32).flat_map(move |cell| {
            (0..4).filter_map(move |slot| {
                let other = self.neighbours[cell as usize][slot];
                (cell < other).then_some((cell, slot))
            })
        })
    }

    /// Vertices of a facet, counter-clockwise seen from the corner that it is opposite to.
    #[inline]
    pub(crate) fn facet(&self, cell: u32, slot: usize) -> [u32; 3] {
        let corners = &self.corners[cell as usize];
        FACES[slot].map(|at| corners[at])
    }
}

/// Corners of the facet opposite each corner, counter-clockwise seen from that corner.
///
/// Seen from its last corner the first three of a cell turn clockwise.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
