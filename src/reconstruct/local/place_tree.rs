//! Places of points, indexed while they arrive: a binary tree of boxes that are halved.
//!
//! A leaf holds at most [`LEAF`] points; a full one is halved in the middle of its cell, across the wider side of its points. The
//! depth so depends on the spread of the points over their spacing, not on the order in which they come. A point outside doubles the
//! root. Points of a batch are numbered leaf by leaf, so that neighbours are near in memory. Every node knows the box of its
//! points, and how far the points in it see: who sees a new place is found without asking all.

mod plan;
mod queries;
mod sights;

use std::cmp::Ordering;

use asphera_geometry::{BoxMm, PointMm};

use self::plan::{Plan, halved};
pub(super) use self::queries::Ball;
use self::sights::SIGHTS;
pub(crate) use self::sights::Sight;
use crate::geometry::joined;
use crate::neighbours::{Near, by_coordinates};
use crate::surface::Numbered;

/// The tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlaceTree {
    points_mm: Vec<PointMm>,
    /// Numbers of the points as they came.
    pub(crate) ids: Vec<u32>,
    leaf_of: Vec<u32>,
    /// The first is the root, where there is a point.
    nodes: Vec<Node>,
    blocks: Vec<[u32; LEAF]>,
    cell: Option<Cell>,
    /// For each point the squares of its sights, mm².
    sights: Vec<[f32; SIGHTS]>,
}

/// A node. Its cell follows from the way to it.
#[derive(Clone, Debug)]
struct Node {
    /// The box of its points.
    bounds: BoxMm,
    /// The largest squares of sights of its points, mm².
    sights: [f32; SIGHTS],
    parent: u32,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    Leaf { block: u32, len: u32 },
    Split { low: u32, high: u32, axis: u8, at_mm: f64 },
}

/// A half-open box: from the low corner to below the high one.
type Cell = BoxMm;

/// The new points of a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewInLeaf {
    pub(crate) from: u32,
    pub(crate) to: u32,
}

impl NewInLeaf {
    pub(crate) fn len(&self) -> u32 {
        self.to - self.from
    }
}

/// New points, by numbers of the tree.
#[derive(Default)]
pub(crate) struct Inserted {
    pub(crate) leaves: Vec<NewInLeaf>,
    /// Points at the place of an earlier one, by their own numbers.
    pub(crate) duplicates: Vec<u32>,
}

impl PlaceTree {
    pub(crate) fn len(&self) -> usize {
        self.points_mm.len()
    }

    /// The nearest first; of equal distances the smaller coordinates.
    #[inline]
    pub(crate) fn order(&self, a: &Near, b: &Near) -> Ordering {
        // Squares are not negative: they are in the order of their bits.
        a.0.to_bits().cmp(&b.0.to_bits()).then_with(|| {
            by_coordinates(self.points_mm[a.1 as usize], self.points_mm[b.1 as usize])
        })
    }

    /// Takes points that count as places. Of points in one place the smallest number stays.
    pub(crate) fn insert(&mut self, batch: &mut [Numbered]) -> Inserted {
        let mut inserted = Inserted::default();
        if batch.is_empty() {
            return inserted;
        }
        let bounds = BoxMm::about(batch.iter().map(|&(place, _)| place));
        let cell = self.grown_to(&bounds);
        self.points_mm.reserve(batch.len());
        self.ids.reserve(batch.len());
        self.leaf_of.reserve(batch.len());
        self.sights.reserve(batch.len());
        // Leaves are more than half full, on the average.
        self.blocks.reserve(batch.len() / LEAF * 2);
        self.nodes.reserve(batch.len() / LEAF * 4);
        let is_first = self.points_mm.is_empty();
        let plan = is_first.then(|| self.plan(Some(ROOT), cell, batch)).flatten();
        self.descend((ROOT, plan.as_deref()), cell, batch, &mut inserted);
        inserted
    }

    /// Gives back the memory of all but places and numbers.
    pub(super) fn forget_nodes(&mut self) {
        let points_mm = std::mem::take(&mut self.points_mm);
        let ids = std::mem::take(&mut self.ids);
        *self = PlaceTree { points_mm, ids, ..PlaceTree::default() };
    }

    /// The cell of the root, doubled until it holds a box.
    fn grown_to(&mut self, bounds: &BoxMm) -> Cell {
        let mut cell = self.cell.unwrap_or_else(|| {
            self.nodes.push(Node::new(self.new_block(), NONE));
            self.blocks.push([NONE; LEAF]);
            first_cell(bounds)
        });
        while let Some((axis, is_low)) = outside(&cell, bounds) {
            let size = cell.high[axis] - cell.low[axis];
            let at_mm = if is_low { cell.low[axis] } else { cell.high[axis] };
            // The root stays the first node: what it was moves to the end.
            let old = self.nodes.len() as u32;
            let (own, beside) = (self.nodes[0].clone(), Node::new(self.new_block(), ROOT));
            let (bounds, sights) = (own.bounds, own.sights);
            self.blocks.push([NONE; LEAF]);
            self.nodes.extend([own, beside]);
            self.nodes[old as usize].parent = ROOT;
            self.adopt(old);
            let (low, high) = if is_low { (old + 1, old) } else { (old, old + 1) };
            let content = Content::Split { low, high, axis: axis as u8, at_mm };
            self.nodes[0] = Node { bounds, sights, parent: NONE, content };
            if is_low {
                cell.low[axis] -= size;
            } else {
                cell.high[axis] += size;
            }
        }
        self.cell = Some(cell);
        cell
    }

    fn new_block(&self) -> u32 {
        self.blocks.len() as u32
    }

    /// Tells what lies below a node that its number has changed.
    fn adopt(&mut self, node: u32) {
        match self.nodes[node as usize].content {
            Content::Split { low, high, .. } => {
                self.nodes[low as usize].parent = node;
                self.nodes[high as usize].parent = node;
            }
            Content::Leaf { block, len } => {
                for &at in &self.blocks[block as usize][..len as usize] {
                    self.leaf_of[at as usize] = node;
                }
            }
        }
    }

    /// Takes points below a node, which may have a plan; gives their box.
    fn descend(
        &mut self,
        (node, plan): (u32, Option<&Plan>),
        cell: Cell,
        batch: &mut [Numbered],
        inserted: &mut Inserted,
    ) -> BoxMm {
        if batch.is_empty() {
            return BoxMm::EMPTY;
        }
        if let Content::Leaf { len, .. } = self.nodes[node as usize].content {
            if let Some(plan) = plan {
                self.widen(node, &plan.bounds);
                self.split(node, plan.axis, plan.at_mm);
            } else {
                let whole = BoxMm::about(batch.iter().map(|&(place, _)| place));
                self.widen(node, &whole);
                let is_one_place = batch.iter().all(|&(place, _)| place == batch[0].0);
                if len as usize + if is_one_place { 1 } else { batch.len() } <= LEAF {
                    self.fill(node, batch, inserted);
                    return whole;
                }
                let Some((axis, at_mm)) = middle(&self.nodes[node as usize].bounds, &cell) else {
                    // A cell that cannot be halved holds one place, which is there.
                    inserted.duplicates.extend(batch.iter().map(|&(_, id)| id));
                    return whole;
                };
                self.split(node, axis, at_mm);
            }
        }
        let Content::Split { low, high, axis, at_mm } = self.nodes[node as usize].content else {
            return BoxMm::EMPTY;
        };
        let axis = usize::from(axis);
        let count = plan.map_or_else(|| partition(batch, axis, at_mm), |plan| plan.below);
        let (below, above) = batch.split_at_mut(count);
        let [low_cell, high_cell] = halved(&cell, axis, at_mm);
        let [low_plan, high_plan] = plan.map_or([None; 2], Plan::halves);
        let below = self.descend((low, low_plan), low_cell, below, inserted);
        let above = self.descend((high, high_plan), high_cell, above, inserted);
        let whole = joined(&below, &above);
        self.widen(node, &whole);
        whole
    }

    fn widen(&mut self, node: u32, own: &BoxMm) {
        let bounds = &mut self.nodes[node as usize].bounds;
        *bounds = joined(bounds, own);
    }

    /// Puts points into a leaf that has room for all their places.
    fn fill(&mut self, leaf: u32, batch: &mut [Numbered], inserted: &mut Inserted) {
        let Content::Leaf { block, mut len } = self.nodes[leaf as usize].content else { return };
        batch.sort_unstable_by_key(|&(_, id)| id);
        let from = self.points_mm.len() as u32;
        for &(place, id) in &*batch {
            let held = &self.blocks[block as usize][..len as usize];
            if held.iter().any(|&at| self.points_mm[at as usize] == place) {
                inserted.duplicates.push(id);
                continue;
            }
            self.blocks[block as usize][len as usize] = self.points_mm.len() as u32;
            len += 1;
            self.points_mm.push(place);
            self.ids.push(id);
            self.leaf_of.push(leaf);
            self.sights.push([BLIND; SIGHTS]);
        }
        self.nodes[leaf as usize].content = Content::Leaf { block, len };
        let to = self.points_mm.len() as u32;
        if to > from {
            inserted.leaves.push(NewInLeaf { from, to });
        }
    }

    fn split(&mut self, leaf: u32, axis: usize, at_mm: f64) {
        let own = self.nodes[leaf as usize].clone();
        let Content::Leaf { block, len } = own.content else { return };
        let held = self.blocks[block as usize];
        let other_block = self.new_block();
        self.blocks.push([NONE; LEAF]);
        let low = self.nodes.len() as u32;
        let mut halves = [Node::new(block, leaf), Node::new(other_block, leaf)];
        for (side, half) in halves.iter_mut().enumerate() {
            let is_high = side == 1;
            let own_block = if is_high { other_block } else { block };
            let mut count = 0;
            for &at in &held[..len as usize] {
                let place = self.points_mm[at as usize];
                if (place[axis] >= at_mm) == is_high {
                    half.bounds = joined(&half.bounds, &BoxMm { low: place, high: place });
                    self.blocks[own_block as usize][count] = at;
                    self.leaf_of[at as usize] = low + side as u32;
                    count += 1;
                }
            }
            half.sights = own.sights;
            half.content = Content::Leaf { block: own_block, len: count as u32 };
        }
        self.nodes.extend(halves);
        self.nodes[leaf as usize].content =
            Content::Split { low, high: low + 1, axis: axis as u8, at_mm };
    }
}

impl Node {
    fn new(block: u32, parent: u32) -> Node {
        let content = Content::Leaf { block, len: 0 };
        Node { bounds: BoxMm::EMPTY, sights: [BLIND; SIGHTS], parent, content }
    }
}

/// A cube that holds a box.
fn first_cell(bounds: &BoxMm) -> Cell {
    let extent = |axis: usize| bounds.high[axis] - bounds.low[axis];
    let values = bounds.low.iter().chain(&bounds.high);
    let farthest = values.fold(0.0_f64, |most, value| most.max(value.abs()));
    let least = (farthest * LEAST_OF_FARTHEST).max(f64::MIN_POSITIVE * 1e200);
    let size = (0..3).map(extent).fold(least, f64::max);
    BoxMm { low: bounds.low, high: bounds.low.map(|low| low + size) }
}

/// An axis on which a box reaches out of a cell, and whether at its low side.
fn outside(cell: &Cell, bounds: &BoxMm) -> Option<(usize, bool)> {
    (0..3).find_map(|axis| {
        let is_low = bounds.low[axis] < cell.low[axis];
        let is_high = bounds.high[axis] >= cell.high[axis];
        (is_low || is_high).then_some((axis, is_low))
    })
}

/// Where to halve a cell: across the widest side of its points that has a middle. `None` where it is one place.
fn middle(bounds: &BoxMm, cell: &Cell) -> Option<(usize, f64)> {
    let extent = |axis: usize| bounds.high[axis] - bounds.low[axis];
    (0..3)
        .map(|axis| {
            let (low, high) = (cell.low[axis], cell.high[axis]);
            (axis, low + (high - low) / 2.0)
        })
        .filter(|&(axis, at)| cell.low[axis] < at && at < cell.high[axis])
        .max_by(|a, b| extent(a.0).total_cmp(&extent(b.0)))
}

/// Puts points below a coordinate first; gives how many they are.
fn partition(batch: &mut [Numbered], axis: usize, at_mm: f64) -> usize {
    let mut count = 0;
    for index in 0..batch.len() {
        let is_below = batch[index].0[axis] < at_mm;
        batch.swap(count, index);
        count += usize::from(is_below);
    }
    count
}

const ROOT: u32 = 0;
const NONE: u32 = u32::MAX;
/// The sight of a point that sees nothing.
const BLIND: f32 = -1.0;
/// Of a square of a distance: more than its rounding.
const MARGIN: f64 = 1e-12;
/// The least side of the first cell, of the largest coordinate: doubling it must change it.
const LEAST_OF_FARTHEST: f64 = 1e-6;
/// Points in a leaf.
pub(super) const LEAF: usize = 16;
