//! Lower sets of critical simplices: all that the flow brings to them, as a complex.

use asphera_geometry::Sets;

use super::flow::{Flow, Owner, ends};
use crate::rings::FacetSet;

/// A complex of simplices of a Delaunay triangulation. Every vertex belongs to it.
pub(super) struct Lower<'a> {
    flow: &'a Flow<'a>,
    pub(super) has_cell: Vec<bool>,
    pub(super) facets: FacetSet<'a>,
    has_edge: Vec<bool>,
    doubtful: Vec<Simplex>,
}

/// A critical simplex, or a part of a complex.
#[derive(Clone, Copy, Debug)]
pub(super) enum Simplex {
    /// The number of an edge.
    Edge(usize),
    /// A cell and the corner opposite.
    Facet(u32, usize),
    /// A tetrahedron.
    Cell(u32),
}

impl<'a> Lower<'a> {
    /// The smallest complex that holds simplices, their faces, and the owners of all that it holds.
    pub(super) fn of(flow: &'a Flow<'a>, simplices: impl Iterator<Item = Simplex>) -> Lower<'a> {
        let mut lower = Lower {
            flow,
            has_cell: vec![false; flow.delaunay.corners.len()],
            facets: FacetSet::empty(flow.delaunay),
            has_edge: vec![false; flow.edges.len()],
            doubtful: simplices.collect(),
        };
        while let Some(simplex) = lower.doubtful.pop() {
            match simplex {
                Simplex::Cell(cell) => lower.add_cell(cell),
                Simplex::Facet(cell, slot) => lower.add_facet(cell, slot),
                Simplex::Edge(edge) => lower.add_edge(edge),
            }
        }
        lower
    }

    fn add_owner(&mut self, owner: Owner) {
        match owner {
            Owner::Itself => {}
            Owner::Facet(cell, slot) => self.doubtful.push(Simplex::Facet(cell, slot.into())),
            Owner::Cell(cell) => self.doubtful.push(Simplex::Cell(cell)),
        }
    }

    fn add_cell(&mut self, cell: u32) {
        if !self.has_cell[cell as usize] {
            self.has_cell[cell as usize] = true;
            self.doubtful.extend((0..4).map(|slot| Simplex::Facet(cell, slot)));
        }
    }

    fn add_facet(&mut self, cell: u32, slot: usize) {
        if self.facets.has(cell, slot) {
            return;
        }
        self.facets.insert(cell, slot);
        let [a, b, c] = self.flow.delaunay.facet(cell, slot);
        for (one, other) in [(a, b), (b, c), (c, a)] {
            let edge = self.flow.edge_number(ends(one, other));
            self.doubtful.extend(edge.map(Simplex::Edge));
        }
        self.add_owner(self.flow.facet_owner(cell, slot));
    }

    fn add_edge(&mut self, edge: usize) {
        if !self.has_edge[edge] {
            self.has_edge[edge] = true;
            self.add_owner(self.flow.edge_owner(edge));
        }
    }

    /// Vertices, edges, facets and tetrahedra.
    pub(super) fn counts(&self) -> [usize; 4] {
        let count = |bits: &[bool]| bits.iter().filter(|&&is_in| is_in).count();
        let vertices = self.flow.delaunay.points_mm.len();
        [vertices, count(&self.has_edge), self.facets.all().count(), count(&self.has_cell)]
    }

    /// Components, tunnels and cavities with coefficients in Z/2.
    ///
    /// Cavities are the parts of space outside the complex, less one (Alexander duality); tunnels follow from the Euler number.
    pub(super) fn betti(&self) -> [i64; 3] {
        let delaunay = self.flow.delaunay;
        let mut parts = Sets::new(delaunay.points_mm.len());
        let mut components = delaunay.points_mm.len() as i64;
        for (&[one, other], _) in
            self.flow.edges.iter().zip(&self.has_edge).filter(|&(_, &is_in)| is_in)
        {
            components -= i64::from(parts.join(one as usize, other as usize));
        }
        // All cells beyond the hull are one.
        let numbered = |cell: u32| (cell as usize).min(delaunay.tetrahedra);
        let mut rooms = Sets::new(delaunay.tetrahedra + 1);
        let taken = self.has_cell.iter().filter(|&&is_in| is_in).count();
        let mut outside = (delaunay.tetrahedra + 1 - taken) as i64;
        for (cell, slot) in delaunay.facets() {
            let other = delaunay.neighbours[cell as usize][slot];
            let is_free = |cell: u32| !self.has_cell[cell as usize];
            if !self.facets.has(cell, slot) && is_free(cell) && is_free(other) {
                outside -= i64::from(rooms.join(numbered(cell), numbered(other)));
            }
        }
        let [vertices, edges, facets, cells] = self.counts().map(|count| count as i64);
        let cavities = outside - 1;
        let tunnels = components + cavities - (vertices - edges + facets - cells);
        [components, tunnels, cavities]
    }
}
