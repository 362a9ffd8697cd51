//! Insertion of a point: finding its cell, the cavity of cells that give way, and the cells that fill it.

use asphera_geometry::predicates::{certain_sphere, orientation_in_space, sphere_in_box_encloses};
use asphera_geometry::{BoxMm, PointMm};

use super::{FACES, INFINITE};

/// A triangulation that grows.
///
/// Invariant: cells with an infinite corner have it last. Replacing the infinite corner by a place outside, or any corner by a
/// place on its side, leaves the orientation `Greater`.
pub(super) struct Inserter<'a> {
    points_mm: &'a [PointMm],
    /// See [`certain_sphere`].
    certain: f64,
    corners: Vec<[u32; 4]>,
    neighbours: Vec<[u32; 4]>,
    /// Twice the vertex for which a cell was in the cavity, one more if it was seen outside it.
    stamps: Vec<u32>,
    /// Cells without use.
    free: Vec<u32>,
    /// A cell of the last point.
    recent: u32,
    cavity: Vec<u32>,
    border: Vec<Border>,
    edges: Edges,
}

/// A facet of the cavity: the cell inside, the corner opposite, and the new cell there.
#[derive(Clone, Copy)]
struct Border {
    inside: u32,
    slot: usize,
    new: u32,
}

/// The corners of a border by small numbers, and which new cell has an edge in each sense: a table in the cache, where turning
/// about the edges would go through cells anywhere in memory.
struct Edges {
    /// By a hash of their vertices: corners, the number of the border that they are of, and their small numbers.
    slots: [(u32, u32, u8); 2 * MOST_CORNERS],
    borders: u32,
    /// The facets of the border by small numbers.
    facets: Vec<[u8; 3]>,
    across: Box<[[u32; MOST_CORNERS]; MOST_CORNERS]>,
}

impl Edges {
    fn new() -> Edges {
        Edges {
            slots: [(0, 0, 0); 2 * MOST_CORNERS],
            borders: 0,
            facets: Vec::new(),
            across: Box::new([[0; MOST_CORNERS]; MOST_CORNERS]),
        }
    }

    /// Numbers the corners of a border; false where there are too many.
    fn number(&mut self, border: impl Iterator<Item = [u32; 3]>) -> bool {
        self.borders += 1;
        self.facets.clear();
        let mut count = 0;
        for facet in border {
            let mut at = [0; 3];
            for (at, vertex) in at.iter_mut().zip(facet) {
                let mut slot = (vertex.wrapping_mul(0x9e37_79b1) >> (32 - SLOT_BITS)) as usize;
                *at = loop {
                    let (seen, border, number) = self.slots[slot];
                    if border != self.borders {
                        if count == MOST_CORNERS {
                            return false;
                        }
                        self.slots[slot] = (vertex, self.borders, count as u8);
                        count += 1;
                        break count as u8 - 1;
                    }
                    if seen == vertex {
                        break number;
                    }
                    slot = (slot + 1) % (2 * MOST_CORNERS);
                };
            }
            self.facets.push(at);
        }
        true
    }
}

/// Most corners of a border whose cells are joined by their edges.
const MOST_CORNERS: usize = 1 << (SLOT_BITS - 1);
const SLOT_BITS: u32 = 7;

impl<'a> Inserter<'a> {
    /// The first four points, whose orientation must be `Greater`.
    pub(super) fn new(points_mm: &'a [PointMm]) -> Self {
        // Seven cells a point is the mean of points at random in space.
        let room = 7 * points_mm.len() + 16;
        let mut inserter = Inserter {
            points_mm,
            certain: certain_sphere(BoxMm::about(points_mm.iter().copied()).size_mm()),
            corners: Vec::with_capacity(room),
            neighbours: Vec::with_capacity(room),
            stamps: Vec::with_capacity(room),
            free: Vec::new(),
            recent: 0,
            cavity: Vec::new(),
            border: Vec::new(),
            edges: Edges::new(),
        };
        inserter.add([0, 1, 2, 3], [1, 2, 3, 4]);
        for slot in 0..4 {
            let mut corners = [0, 1, 2, 3];
            corners[slot] = INFINITE;
            // One exchange turns the cell outwards.
            if slot == 3 {
                corners.swap(0, 1);
            } else {
                corners.swap(slot, 3);
            }
            let across = corners.map(|corner| if corner == INFINITE { 0 } else { corner + 1 });
            inserter.add(corners, across);
        }
        inserter
    }

    fn add(&mut self, corners: [u32; 4], neighbours: [u32; 4]) -> u32 {
        if let Some(cell) = self.free.pop() {
            self.corners[cell as usize] = corners;
            self.neighbours[cell as usize] = neighbours;
            self.stamps[cell as usize] = 0;
            return cell;
        }
        self.corners.push(corners);
        self.neighbours.push(neighbours);
        self.stamps.push(0);
        self.corners.len() as u32 - 1
    }

    #[inline(always)]
    fn place(&self, vertex: u32) -> PointMm {
        self.points_mm[vertex as usize]
    }

    /// Inserts a vertex whose place no other has.
    pub(super) fn insert(&mut self, vertex: u32) {
        let first = self.locate(self.place(vertex));
        self.dig(first, vertex);
        self.fill(vertex);
    }

    /// A cell that gives way to a place: the tetrahedron that holds it, or a cell beyond the hull.
    fn locate(&self, place: PointMm) -> u32 {
        let mut cell = self.recent;
        if self.corners[cell as usize][3] == INFINITE {
            cell = self.neighbours[cell as usize][3];
        }
        let mut from = INFINITE;
        'walk: loop {
            let corners = self.corners[cell as usize];
            if corners[3] == INFINITE {
                return cell;
            }
            let places = corners.map(|corner| self.place(corner));
            for slot in 0..4 {
                let next = self.neighbours[cell as usize][slot];
                if next == from {
                    continue;
                }
                let mut replaced = places;
                replaced[slot] = place;
                let [a, b, c, d] = replaced;
                if orientation_in_space(a, b, c, d).is_lt() {
                    from = cell;
                    cell = next;
                    continue 'walk;
                }
            }
            return cell;
        }
    }

    /// Finds the cavity: the cells around `first` that give way to the vertex.
    fn dig(&mut self, first: u32, vertex: u32) {
        let (inside, outside) = (2 * vertex, 2 * vertex + 1);
        self.cavity.clear();
        self.border.clear();
        self.cavity.push(first);
        self.stamps[first as usize] = inside;
        let mut at = 0;
        while let Some(&cell) = self.cavity.get(at) {
            at += 1;
            for slot in 0..4 {
                let next = self.neighbours[cell as usize][slot];
                let stamp = self.stamps[next as usize];
                if stamp == inside {
                    continue;
                }
                if stamp != outside && self.gives_way(next, vertex) {
                    self.stamps[next as usize] = inside;
                    self.cavity.push(next);
                } else {
                    self.stamps[next as usize] = outside;
                    self.border.push(Border { inside: cell, slot, new: INFINITE });
                }
            }
        }
    }

    /// Whether a cell that has not been asked gives way to a vertex.
    fn gives_way(&self, cell: u32, vertex: u32) -> bool {
        let place = self.place(vertex);
        let corners = self.corners[cell as usize];
        if corners[3] == INFINITE {
            let [a, b, c] = [0, 1, 2].map(|slot| self.place(corners[slot]));
            let side = orientation_in_space(a, b, c, place);
            if side.is_ne() {
                return side.is_gt();
            }
            // In the plane of a hull facet the sphere behind it has the circle of the facet.
            let behind = self.neighbours[cell as usize][3];
            return match self.stamps[behind as usize] {
                stamp if stamp == 2 * vertex => true,
                stamp if stamp == 2 * vertex + 1 => false,
                _ => self.gives_way(behind, vertex),
            };
        }
        sphere_in_box_encloses(self.certain, corners.map(|corner| self.place(corner)), place)
    }

    /// Fills the cavity with cells from its border to the vertex.
    fn fill(&mut self, vertex: u32) {
        let mut border = std::mem::take(&mut self.border);
        for facet in &mut border {
            let Border { inside, slot, .. } = *facet;
            let mut corners = self.corners[inside as usize];
            corners[slot] = vertex;
            let beyond = self.neighbours[inside as usize][slot];
            let mut neighbours = [INFINITE; 4];
            neighbours[slot] = beyond;
            facet.new = self.add(corners, neighbours);
            let back = self.neighbours[beyond as usize].iter_mut().find(|back| **back == inside);
            if let Some(back) = back {
                *back = facet.new;
            }
        }
        let corners = &self.corners;
        let facets = border.iter().map(|facet| {
            let corners = &corners[facet.inside as usize];
            FACES[facet.slot].map(|at| corners[at])
        });
        if self.edges.number(facets) {
            self.join_by_edges(&border);
        } else {
            self.join_by_turning(&border, vertex);
        }
        self.recent = border.last().map_or(0, |facet| facet.new);
        self.border = border;
        self.free.extend_from_slice(&self.cavity);
    }

    /// Joins the new cells across the edges of the border, each of which two of its facets have, in either sense.
    fn join_by_edges(&mut self, border: &[Border]) {
        let Edges { facets, across, .. } = &mut self.edges;
        let edge =
            |at: &[u8; 3], turn: usize| [at[(turn + 1) % 3], at[(turn + 2) % 3]].map(usize::from);
        for (facet, at) in border.iter().zip(&*facets) {
            for turn in 0..3 {
                let [from, to] = edge(at, turn);
                across[from][to] = facet.new;
            }
        }
        for (facet, at) in border.iter().zip(&*facets) {
            for (turn, slot) in FACES[facet.slot].into_iter().enumerate() {
                let [from, to] = edge(at, turn);
                self.neighbours[facet.new as usize][slot] = across[to][from];
            }
        }
    }

    /// The same for a border with more corners than the table of edges holds.
    fn join_by_turning(&mut self, border: &[Border], vertex: u32) {
        // The dead cells lead to the new ones across the border.
        for facet in border {
            self.neighbours[facet.inside as usize][facet.slot] = facet.new;
        }
        for facet in border {
            for slot in (0..4).filter(|&slot| slot != facet.slot) {
                if self.neighbours[facet.new as usize][slot] == INFINITE {
                    self.join(facet, slot, vertex);
                }
            }
        }
    }

    /// Joins a new cell across the facet opposite `slot` to the new cell there: turns about their common edge through the cavity.
    fn join(&mut self, facet: &Border, slot: usize, vertex: u32) {
        // In `cell` the edge has two corners; the others are those of `behind` and `ahead`.
        let (mut cell, mut behind, mut ahead) = (facet.inside, facet.slot, slot);
        let other = loop {
            let next = self.neighbours[cell as usize][ahead];
            if self.stamps[next as usize] != 2 * vertex {
                break next;
            }
            let pivot = self.corners[cell as usize][behind];
            // The corner of the next cell that is not in the common facet.
            let across = &self.neighbours[next as usize];
            behind = across.iter().position(|&back| back == cell).unwrap_or(0);
            ahead = self.corners[next as usize].iter().position(|&at| at == pivot).unwrap_or(0);
            cell = next;
        };
        self.neighbours[facet.new as usize][slot] = other;
        self.neighbours[other as usize][behind] = facet.new;
    }

    /// Corners and neighbours of the cells, tetrahedra first, and how many these are.
    pub(super) fn finish(self) -> (Vec<[u32; 4]>, Vec<[u32; 4]>, usize) {
        let Inserter { mut corners, mut neighbours, free, stamps, .. } = self;
        drop(stamps);
        let mut is_free = vec![false; corners.len()];
        for &cell in &free {
            is_free[cell as usize] = true;
        }
        let mut numbers = vec![INFINITE; corners.len()];
        let mut count = 0;
        let mut tetrahedra = 0;
        for outside in [false, true] {
            for cell in (0..corners.len()).filter(|&cell| !is_free[cell]) {
                if (corners[cell][3] == INFINITE) == outside {
                    numbers[cell] = count as u32;
                    count += 1;
                }
            }
            if !outside {
                tetrahedra = count;
            }
        }
        permute(&mut corners, &numbers, count);
        permute(&mut neighbours, &numbers, count);
        for neighbour in neighbours.as_flattened_mut() {
            *neighbour = numbers[*neighbour as usize];
        }
        (corners, neighbours, tetrahedra)
    }
}

/// Brings items to their new places; those without a number fall away.
fn permute(items: &mut Vec<[u32; 4]>, numbers: &[u32], count: usize) {
    let mut moved = vec![[0; 4]; count];
    for (item, &number) in items.iter().zip(numbers) {
        if number != INFINITE {
            moved[number as usize] = *item;
        }
    }
    *items = moved;
}
