//! The cube of eight samples: its corners, edges and faces, and the 48 symmetries.
//!
//! ```text
//!        6───────7      corner = x + 2y + 4z
//!      ╱ │     ╱ │      x-edges 0..4: y + 2z
//!    4───────5   │      y-edges 4..8: x + 2z
//!    │   2───│───3      z-edges 8..12: x + 2y
//!    │ ╱     │ ╱        faces: x = 0, x = 1, y = 0, y = 1, z = 0, z = 1
//!    0───────1
//! ```

/// The corners of every face, counter-clockwise seen from outside the cell.
pub(crate) const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The two corners of every edge, the lower one first.
pub(crate) const EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [2, 3],
    [4, 5],
    [6, 7],
    [0, 2],
    [1, 3],
    [4, 6],
    [5, 7],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// The edge between two corners.
pub(crate) const fn edge_between(a: usize, b: usize) -> usize {
    let (low, difference) = (a & b, a ^ b);
    match difference {
        1 => (low >> 1 & 1) + 2 * (low >> 2 & 1),
        2 => 4 + (low & 1) + 2 * (low >> 2 & 1),
        _ => 8 + (low & 1) + 2 * (low >> 1 & 1),
    }
}

/// Whether two edges lie on one face.
pub(crate) fn share_face(a: usize, b: usize) -> bool {
    FACES.iter().any(|face| {
        [a, b].iter().all(|&edge| EDGES[edge].iter().all(|corner| face.contains(corner)))
    })
}

/// A symmetry of the cube, as where it takes every corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Symmetry {
    corners: [usize; 8],
    /// Whether it turns right hands into left hands.
    pub(crate) is_mirror: bool,
}

impl Symmetry {
    pub(crate) fn code(&self, code: u8) -> u8 {
        (0..8).fold(0, |image, corner| image | (code >> corner & 1) << self.corners[corner])
    }

    #[cfg(test)]
    pub(crate) fn corner(&self, corner: usize) -> usize {
        self.corners[corner]
    }

    pub(crate) fn edge(&self, edge: usize) -> usize {
        let [a, b] = EDGES[edge];
        edge_between(self.corners[a], self.corners[b])
    }
}

/// The 48 symmetries: axes exchanged, then turned over.
pub(crate) fn symmetries() -> Vec<Symmetry> {
    const ORDERS: [([usize; 3], bool); 6] = [
        ([0, 1, 2], false),
        ([1, 2, 0], false),
        ([2, 0, 1], false),
        ([0, 2, 1], true),
        ([2, 1, 0], true),
        ([1, 0, 2], true),
    ];
    let mut all = Vec::with_capacity(48);
    for (order, is_odd) in ORDERS {
        for flips in 0..8_usize {
            let corners = std::array::from_fn(|corner| {
                let turned =
                    (0..3).fold(0, |image, axis| image | (corner >> axis & 1) << order[axis]);
                turned ^ flips
            });
            all.push(Symmetry { corners, is_mirror: is_odd != (flips.count_ones() % 2 == 1) });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_and_faces_belong_together() {
        for (edge, [a, b]) in EDGES.into_iter().enumerate() {
            assert_eq!(edge_between(a, b), edge);
            assert_eq!(edge_between(b, a), edge);
        }
        for face in FACES {
            // The corners of a face agree in one axis, and neighbours along it differ in one bit.
            for at in 0..4 {
                assert_eq!((face[at] ^ face[(at + 1) % 4]).count_ones(), 1);
            }
        }
        let mut used = [0; 12];
        for face in FACES {
            (0..4).for_each(|at| used[edge_between(face[at], face[(at + 1) % 4])] += 1);
        }
        assert_eq!(used, [2; 12]);
    }

    #[test]
    fn there_are_48_symmetries_half_of_them_mirrors() {
        let mut images: Vec<[usize; 8]> = symmetries().iter().map(|s| s.corners).collect();
        images.sort_unstable();
        images.dedup();
        assert_eq!(images.len(), 48);
        assert_eq!(symmetries().iter().filter(|s| s.is_mirror).count(), 24);
    }
}
