//! Sculpture (J.-D. Boissonnat 1984, doi:10.1145/357346.357349): tetrahedra are carved from the convex hull until all points are on its
//! surface.
//!
//! Carved are tetrahedra with one open facet, whose opposite corner is still inside, and with two, whose opposite edge is. So the
//! surface stays a sphere, and no point is lost. The one whose sphere stands out farthest over an open facet goes first.

use std::collections::BinaryHeap;

use asphera_geometry::PointMm;

use crate::centres;
use crate::delaunay::{Delaunay, NoDelaunay};
use crate::geometry::{dot, double_area, minus, unit};
use crate::rings::Turn;
use crate::surface::{LeftOut, Reconstruction, of_vertices};

/// Reconstructs a closed surface without handles by sculpture. There is no theorem about it.
///
/// # Errors
///
/// Points that do not span space.
pub fn sculpture(points_mm: &[PointMm]) -> Result<Reconstruction, NoDelaunay> {
    let delaunay = Delaunay::new(points_mm)?;
    let mut block = Block::new(&delaunay);
    while block.inner > 0
        && let Some(Stroke { cell, .. }) = block.strokes.pop()
    {
        if block.may_go(cell) {
            block.carve(cell);
        }
    }
    let border = delaunay.facets().filter(|&(cell, slot)| {
        let other = delaunay.neighbours[cell as usize][slot];
        block.is_carved[cell as usize] != block.is_carved[other as usize]
    });
    let facets = border.map(|(cell, slot)| delaunay.facet(cell, slot)).collect();
    Ok(of_vertices(points_mm, &delaunay, facets, LeftOut::NoFacet))
}

/// What is left of the hull.
struct Block<'a> {
    delaunay: &'a Delaunay,
    centres: Vec<PointMm>,
    is_carved: Vec<bool>,
    /// Whether a vertex is on the surface.
    is_open: Vec<bool>,
    /// Vertices that are not.
    inner: usize,
    strokes: BinaryHeap<Stroke>,
}

/// A tetrahedron that may be carved, and how far its sphere stands out, mm.
struct Stroke {
    out_mm: f64,
    cell: u32,
}

impl Ord for Stroke {
    fn cmp(&self, other: &Stroke) -> std::cmp::Ordering {
        self.out_mm.total_cmp(&other.out_mm).then(other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Stroke {
    fn partial_cmp(&self, other: &Stroke) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Stroke {
    fn eq(&self, other: &Stroke) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Stroke {}

impl<'a> Block<'a> {
    fn new(delaunay: &'a Delaunay) -> Block<'a> {
        let cells = delaunay.corners.len();
        let mut block = Block {
            delaunay,
            centres: centres::of(delaunay),
            is_carved: (0..cells).map(|cell| cell >= delaunay.tetrahedra).collect(),
            is_open: vec![false; delaunay.points_mm.len()],
            inner: delaunay.points_mm.len(),
            strokes: BinaryHeap::new(),
        };
        for cell in delaunay.tetrahedra..cells {
            for slot in 0..3 {
                block.open(delaunay.corners[cell][slot]);
            }
            block.offer(delaunay.neighbours[cell][3]);
        }
        block
    }

    fn open(&mut self, vertex: u32) {
        let is_open = &mut self.is_open[vertex as usize];
        self.inner -= usize::from(!*is_open);
        *is_open = true;
    }

    fn open_slots(&self, cell: u32) -> impl Iterator<Item = usize> {
        let across = self.delaunay.neighbours[cell as usize];
        let is_open = across.map(|other| self.is_carved[other as usize]);
        (0..4).filter(move |&slot| is_open[slot])
    }

    fn offer(&mut self, cell: u32) {
        if self.is_carved[cell as usize] || !self.may_go(cell) {
            return;
        }
        let out_mm = self.open_slots(cell).map(|slot| self.stands_out_mm(cell, slot));
        let out_mm = out_mm.fold(0.0, f64::max);
        self.strokes.push(Stroke { out_mm, cell });
    }

    /// How far the sphere of a cell stands out over the facet opposite a corner.
    fn stands_out_mm(&self, cell: u32, slot: usize) -> f64 {
        let facet = self.delaunay.facet(cell, slot).map(|corner| self.delaunay.place(corner));
        let way = minus(self.centres[cell as usize], facet[0]);
        let radius = dot(way, way).sqrt();
        // Counter-clockwise seen from the corner: the normal points inwards.
        unit(double_area(facet)).map_or(0.0, |inward| radius - dot(way, inward))
    }

    /// Whether a tetrahedron may be carved: the surface stays a sphere and all points on it stay there.
    fn may_go(&self, cell: u32) -> bool {
        if self.is_carved[cell as usize] {
            return false;
        }
        let mut open = self.open_slots(cell);
        let corners = &self.delaunay.corners[cell as usize];
        match (open.next(), open.next(), open.next()) {
            (Some(slot), None, _) => !self.is_open[corners[slot] as usize],
            (Some(one), Some(other), None) => !self.is_edge_open(cell, one, other),
            _ => false,
        }
    }

    /// Whether the edge between two corners is on the surface.
    fn is_edge_open(&self, cell: u32, one: usize, other: usize) -> bool {
        let mut rest = (0..4).filter(|&slot| slot != one && slot != other);
        let (Some(behind), Some(ahead)) = (rest.next(), rest.next()) else { return true };
        let start = Turn { cell, behind, ahead };
        let mut turn = start;
        loop {
            if self.is_carved[turn.cell as usize] {
                return true;
            }
            turn = turn.next(self.delaunay);
            if turn == start {
                return false;
            }
        }
    }

    fn carve(&mut self, cell: u32) {
        self.is_carved[cell as usize] = true;
        for corner in self.delaunay.corners[cell as usize] {
            self.open(corner);
        }
        for next in self.delaunay.neighbours[cell as usize] {
            self.offer(next);
        }
    }
}
