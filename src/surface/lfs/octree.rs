//! Oriented points in cubes within cubes: the search structure of the medial balls.
//!
//! Each cube stands for the points in it by the first of them that came. So the cubes of one size
//! are a thinned set, and a search may stop at the size it needs: what a large ball touches is seen
//! as well by one point in 20 as by all. That also bounds the search about the centre of a sphere,
//! from where all points are equally near and a search for the nearest of all would visit each.
//! Points may be added at any time. A cube knows the newest point in it, so that a search may be
//! confined to what came since.

use asphera_geometry::PointMm;

/// The tree. It holds no coordinates; the caller passes the same points each time.
#[derive(Clone, Debug)]
pub(super) struct Octree {
    nodes: Vec<Node>,
    root: u32,
    low_mm: PointMm,
    side_mm: f64,
    /// Cubes of this side hold one point; what else falls there is left out.
    smallest_mm: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    point: u32,
    newest: u32,
    children: [u32; 8],
}

/// A cube.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cube {
    node: u32,
    /// The first point that came to it.
    pub(super) point: u32,
    /// The last one.
    pub(super) newest: u32,
    pub(super) low_mm: PointMm,
    pub(super) side_mm: f64,
}

impl Cube {
    /// How far the farthest corner is from a place in mm.
    pub(super) fn farthest_mm(&self, at_mm: PointMm) -> f64 {
        let ways = [0, 1, 2].map(|axis| {
            let over = at_mm[axis] - self.low_mm[axis];
            over.max(self.side_mm - over)
        });
        super::vector::norm(ways)
    }

    /// How far a place is from the cube in mm; zero in it.
    pub(super) fn distance_mm(&self, at_mm: PointMm) -> f64 {
        let beside = [0, 1, 2].map(|axis| {
            let over = at_mm[axis] - self.low_mm[axis];
            (-over).max(over - self.side_mm).max(0.0)
        });
        super::vector::norm(beside)
    }
}

const NONE: u32 = u32::MAX;

impl Octree {
    pub(super) fn new(smallest_mm: f64) -> Octree {
        Octree {
            nodes: Vec::new(),
            root: NONE,
            low_mm: [0.0; 3],
            side_mm: smallest_mm,
            smallest_mm,
        }
    }

    /// The side of the smallest cubes in mm.
    pub(super) fn smallest_mm(&self) -> f64 {
        self.smallest_mm
    }

    /// What rounding may do to a coordinate of a cube or a point in it, in mm.
    pub(super) fn rounding_mm(&self) -> f64 {
        let largest_mm = self
            .low_mm
            .iter()
            .fold(0.0_f64, |most, low| most.max(low.abs()).max((low + self.side_mm).abs()));
        16.0 * f64::EPSILON * largest_mm
    }

    /// The cube of all points; `None` without points.
    pub(super) fn root(&self) -> Option<Cube> {
        (self.root != NONE).then(|| self.cube(self.root, self.low_mm, self.side_mm))
    }

    /// The up to eight cubes with points in a cube; none in one with a single point.
    pub(super) fn children(&self, of: Cube) -> impl Iterator<Item = Cube> + '_ {
        let side_mm = 0.5 * of.side_mm;
        let children = self.nodes[of.node as usize].children;
        (0..8).filter(move |&octant| children[octant] != NONE).map(move |octant| {
            self.cube(children[octant], corner(of.low_mm, side_mm, octant), side_mm)
        })
    }

    /// Adds point `new`, the last of `points`; `false` if its smallest cube is taken, and the tree
    /// is as before. Time in proportion to the depth: the logarithm of extent over smallest side.
    pub(super) fn insert(&mut self, points: &[PointMm], new: u32) -> bool {
        let at = points[new as usize];
        if self.root == NONE {
            self.root = self.leaf(new);
            self.side_mm = self.smallest_mm;
            self.low_mm = at.map(|coordinate| coordinate - 0.5 * self.side_mm);
            return true;
        }
        self.widen(at);
        let (mut node, mut low_mm, mut side_mm) = (self.root, self.low_mm, self.side_mm);
        let mut path = Vec::with_capacity(48);
        loop {
            path.push(node);
            let children = self.nodes[node as usize].children;
            if children == [NONE; 8] {
                if side_mm <= self.smallest_mm {
                    return false;
                }
                let first = self.nodes[node as usize].point;
                let octant = octant(low_mm, 0.5 * side_mm, points[first as usize]);
                let moved = self.leaf(first);
                self.nodes[node as usize].children[octant] = moved;
            }
            side_mm *= 0.5;
            let octant = octant(low_mm, side_mm, at);
            let child = self.nodes[node as usize].children[octant];
            low_mm = corner(low_mm, side_mm, octant);
            if child == NONE {
                let leaf = self.leaf(new);
                self.nodes[node as usize].children[octant] = leaf;
                break;
            }
            node = child;
        }
        for node in path {
            self.nodes[node as usize].newest = new;
        }
        true
    }

    /// Doubles the cube of all points until it holds a place.
    fn widen(&mut self, at: PointMm) {
        let inside = |low: f64, side: f64, at: f64| at >= low && at < low + side;
        while !(0..3).all(|axis| inside(self.low_mm[axis], self.side_mm, at[axis])) {
            let mut octant = 0;
            for (axis, low_mm) in self.low_mm.iter_mut().enumerate() {
                if at[axis] < *low_mm {
                    *low_mm -= self.side_mm;
                    octant |= 1 << axis;
                }
            }
            self.side_mm *= 2.0;
            let old = self.root;
            let Node { point, newest, .. } = self.nodes[old as usize];
            let mut children = [NONE; 8];
            children[octant] = old;
            self.root = self.nodes.len() as u32;
            self.nodes.push(Node { point, newest, children });
        }
    }

    fn leaf(&mut self, point: u32) -> u32 {
        self.nodes.push(Node { point, newest: point, children: [NONE; 8] });
        self.nodes.len() as u32 - 1
    }

    fn cube(&self, node: u32, low_mm: PointMm, side_mm: f64) -> Cube {
        let Node { point, newest, .. } = self.nodes[node as usize];
        Cube { node, point, newest, low_mm, side_mm }
    }
}

/// The octant of a place: bit i is set if it lies in the upper half along axis i.
fn octant(low_mm: PointMm, half_mm: f64, at: PointMm) -> usize {
    (0..3).filter(|&axis| at[axis] >= low_mm[axis] + half_mm).map(|axis| 1 << axis).sum()
}

/// The lowest corner of an octant.
fn corner(low_mm: PointMm, half_mm: f64, octant: usize) -> PointMm {
    let mut corner = low_mm;
    for (axis, coordinate) in corner.iter_mut().enumerate() {
        if octant >> axis & 1 == 1 {
            *coordinate += half_mm;
        }
    }
    corner
}
