//! A triangle mesh that takes further vertices, and flips edges, without a change of its topology.
//!
//! Facets need not be turned alike, so that one-sided surfaces are meshes too.

/// Facets, and what lies over each of their edges.
pub(super) struct Mesh {
    pub(super) corners: Vec<[u32; 3]>,
    /// The facet over the edge opposite each corner, or [`BORDER`] or [`WALL`].
    across: Vec<[u32; 3]>,
    /// A facet at each vertex; [`NONE`] of points that are no vertex.
    facet_at: Vec<u32>,
    /// Vertices whose facets make more than one fan or ring.
    is_pinched: Vec<bool>,
}

/// No facet: the edge is a border.
pub(super) const BORDER: u32 = u32::MAX;
/// No facet that may change with this one: three or more meet here.
const WALL: u32 = u32::MAX - 1;
const NONE: u32 = u32::MAX;

impl Mesh {
    /// The mesh of facets with corners among so many points.
    pub(super) fn new(points: usize, corners: Vec<[u32; 3]>) -> Mesh {
        let mut sides: Vec<(u32, u32, usize)> = Vec::with_capacity(3 * corners.len());
        let mut facet_at = vec![NONE; points];
        let mut facets_at = vec![0_u32; points];
        for (facet, own) in corners.iter().enumerate() {
            for corner in 0..3 {
                let [one, other] = [own[(corner + 1) % 3], own[(corner + 2) % 3]];
                sides.push((one.min(other), one.max(other), 3 * facet + corner));
                facet_at[own[corner] as usize] = facet as u32;
                facets_at[own[corner] as usize] += 1;
            }
        }
        sides.sort_unstable();
        let mut across = vec![[BORDER; 3]; corners.len()];
        for group in sides.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            for &(.., slot) in group {
                across[slot / 3][slot % 3] = match group {
                    [_] => BORDER,
                    [one, other] => ((one.2 + other.2 - slot) / 3) as u32,
                    _ => WALL,
                };
            }
        }
        let mut mesh = Mesh { corners, across, facet_at, is_pinched: vec![false; points] };
        let mut fan = Vec::new();
        for vertex in 0..points as u32 {
            mesh.fan(vertex, &mut fan);
            mesh.is_pinched[vertex as usize] = fan.len() as u32 != facets_at[vertex as usize];
        }
        mesh
    }

    pub(super) fn is_vertex(&self, point: u32) -> bool {
        self.facet_at[point as usize] != NONE
    }

    /// The facet over the edge opposite a corner.
    pub(super) fn over(&self, facet: u32, corner: usize) -> Option<u32> {
        let other = self.across[facet as usize][corner];
        (other < WALL).then_some(other)
    }

    pub(super) fn is_border(&self, facet: u32, corner: usize) -> bool {
        self.across[facet as usize][corner] == BORDER
    }

    /// Which corner of a facet a vertex is.
    pub(super) fn corner(&self, facet: u32, vertex: u32) -> Option<usize> {
        self.corners[facet as usize].iter().position(|&corner| corner == vertex)
    }

    /// The corners of a facet, this one first.
    pub(super) fn from(&self, facet: u32, corner: usize) -> [u32; 3] {
        let mut corners = self.corners[facet as usize];
        corners.rotate_left(corner);
        corners
    }

    /// The corner of a facet that is not an end of an edge.
    pub(super) fn opposite(&self, facet: u32, ends: [u32; 2]) -> usize {
        let corners = self.corners[facet as usize];
        corners.iter().position(|corner| !ends.contains(corner)).unwrap_or(0)
    }

    /// The vertex of a facet over an edge.
    pub(super) fn apex(&self, facet: u32, ends: [u32; 2]) -> u32 {
        self.corners[facet as usize][self.opposite(facet, ends)]
    }

    /// Facets that follow each other about a vertex: all of them where it is not pinched.
    pub(super) fn fan(&self, vertex: u32, found: &mut Vec<u32>) {
        found.clear();
        let start = self.facet_at[vertex as usize];
        if start == NONE {
            return;
        }
        found.push(start);
        let Some(own) = self.corner(start, vertex) else { return };
        let [_, one, other] = self.from(start, own);
        for first in [one, other] {
            let (mut facet, mut spoke) = (start, first);
            while let Some(next) = self.over(facet, self.opposite(facet, [vertex, spoke])) {
                if next == start {
                    return;
                }
                found.push(next);
                (facet, spoke) = (next, self.apex(next, [vertex, spoke]));
            }
        }
    }

    /// Whether an edge joins two vertices, or may do so unnoticed: where both are pinched.
    pub(super) fn may_be_joined(&self, one: u32, other: u32, fan: &mut Vec<u32>) -> bool {
        let [from, to] = if self.is_pinched[one as usize] { [other, one] } else { [one, other] };
        self.fan(from, fan);
        self.is_pinched[from as usize] || fan.iter().any(|&facet| self.corner(facet, to).is_some())
    }

    /// Corners of the facets in so many rings about some, with these but for those that are `gone`.
    pub(super) fn around(&self, some: &[u32], gone: &[u32], rings: usize) -> Vec<[u32; 3]> {
        let mut found = some.to_vec();
        let (mut vertices, mut fan) = (Vec::new(), Vec::new());
        for _ in 0..rings {
            vertices.clear();
            vertices.extend(found.iter().flat_map(|&facet| self.corners[facet as usize]));
            vertices.sort_unstable();
            vertices.dedup();
            for &vertex in &vertices {
                self.fan(vertex, &mut fan);
                found.extend(&fan);
            }
            found.sort_unstable();
            found.dedup();
        }
        found.retain(|facet| !gone.contains(facet));
        found.into_iter().map(|facet| self.corners[facet as usize]).collect()
    }

    /// Cuts a facet into three at a new vertex. Gives the facets of the vertex.
    ///
    /// ```text
    ///         c
    ///       / | \
    ///      /  p  \
    ///     / ⁄   \ \
    ///    a ------- b
    /// ```
    pub(super) fn split_facet(&mut self, facet: u32, vertex: u32) -> [u32; 3] {
        let [a, b, c] = self.corners[facet as usize];
        let [bc, ca, ab] = self.across[facet as usize];
        let [second, third] = [0, 1].map(|more| (self.corners.len() + more) as u32);
        self.corners[facet as usize] = [a, b, vertex];
        self.across[facet as usize] = [second, third, ab];
        self.corners.extend([[b, c, vertex], [c, a, vertex]]);
        self.across.extend([[third, facet, bc], [facet, second, ca]]);
        self.relink(bc, [b, c], second);
        self.relink(ca, [c, a], third);
        for (vertex, facet) in [(a, facet), (b, facet), (c, second), (vertex, facet)] {
            self.facet_at[vertex as usize] = facet;
        }
        [facet, second, third]
    }

    /// Cuts the edge opposite a corner at a new vertex, and with it the facets on its sides. Gives the facets of the vertex.
    pub(super) fn split_edge(&mut self, facet: u32, corner: usize, vertex: u32) -> Vec<u32> {
        let [_, a, b] = self.from(facet, corner);
        let other = self.over(facet, corner);
        let halves = self.halve(facet, [a, b], vertex);
        let Some(other) = other else { return halves.to_vec() };
        let beyond = self.halve(other, [a, b], vertex);
        for (one, other, end) in [(halves[0], beyond[0], a), (halves[1], beyond[1], b)] {
            self.relink(one, [vertex, end], other);
            self.relink(other, [vertex, end], one);
        }
        [halves, beyond].concat()
    }

    /// Cuts a facet into two at a new vertex on an edge: the halves at the first end and at the second.
    fn halve(&mut self, facet: u32, [a, b]: [u32; 2], vertex: u32) -> [u32; 2] {
        let far = self.opposite(facet, [a, b]);
        let c = self.corners[facet as usize][far];
        let across = self.across[facet as usize];
        let over = |from: usize| across[from];
        let [at_a, at_b] = [self.opposite(facet, [b, c]), self.opposite(facet, [a, c])];
        let (bc, ca, ab) = (over(at_a), over(at_b), over(far));
        let second = self.corners.len() as u32;
        self.corners[facet as usize] = [c, a, vertex];
        self.across[facet as usize] = [ab, second, ca];
        self.corners.push([c, vertex, b]);
        self.across.push([ab, bc, facet]);
        self.relink(bc, [b, c], second);
        for (vertex, facet) in [(a, facet), (b, second), (c, facet), (vertex, facet)] {
            self.facet_at[vertex as usize] = facet;
        }
        [facet, second]
    }

    /// Adds a facet over the border opposite a corner, with a new vertex. The border goes round it.
    pub(super) fn add_ear(&mut self, facet: u32, corner: usize, vertex: u32) -> u32 {
        let [_, a, b] = self.from(facet, corner);
        let ear = self.corners.len() as u32;
        self.corners.push([vertex, b, a]);
        self.across.push([facet, BORDER, BORDER]);
        self.across[facet as usize][corner] = ear;
        self.facet_at[vertex as usize] = ear;
        ear
    }

    /// Replaces the edge opposite a corner by the other diagonal of its two facets, which both have it as an edge then.
    ///
    /// ```text
    ///        p                 p
    ///      /   \             / | \
    ///     a --- b    ─▶     a  |  b
    ///      \   /             \ | /
    ///        d                 d
    /// ```
    pub(super) fn flip(&mut self, facet: u32, corner: usize) -> Option<[u32; 2]> {
        let other = self.over(facet, corner)?;
        let [p, a, b] = self.from(facet, corner);
        let d = self.apex(other, [a, b]);
        let pb = self.across[facet as usize][(corner + 1) % 3];
        let pa = self.across[facet as usize][(corner + 2) % 3];
        let [bd, ad] = [[b, d], [a, d]].map(|ends| {
            let corner = self.opposite(other, ends);
            self.across[other as usize][corner]
        });
        self.corners[facet as usize] = [p, a, d];
        self.across[facet as usize] = [ad, other, pa];
        self.corners[other as usize] = [p, d, b];
        self.across[other as usize] = [bd, pb, facet];
        self.relink(ad, [a, d], facet);
        self.relink(pb, [p, b], other);
        for (vertex, facet) in [(p, facet), (a, facet), (d, facet), (b, other)] {
            self.facet_at[vertex as usize] = facet;
        }
        Some([facet, other])
    }

    /// Notes with a facet, if there is one, which facet lies over an edge of it.
    fn relink(&mut self, facet: u32, ends: [u32; 2], to: u32) {
        if facet < WALL {
            let corner = self.opposite(facet, ends);
            self.across[facet as usize][corner] = to;
        }
    }
}
