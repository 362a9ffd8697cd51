//! Fronts of places: an order in which the Laplacian is eliminated with little fill.
//!
//! The k-d tree of the cloud cuts it in halves again and again. Of each cut the places of one side that have neighbours on the other
//! come after both halves (nested dissection, A. George, SIAM Journal on Numerical Analysis 10 (1973) 345-363,
//! doi:10.1137/0710032). On a surface a cut is short, so fill grows little faster than the places.

use std::ops::Range;

use rayon::prelude::*;

use super::laplacian::Laplacian;
use crate::tree::Node;

/// Places that are eliminated together, and those that are linked with them afterwards.
pub(super) struct Front {
    /// Position of the first pivot in the order of elimination.
    pub(super) first: usize,
    /// Pivots, at positions that follow one another.
    pub(super) pivots: usize,
    /// Positions of the border, ascending.
    pub(super) border: Vec<u32>,
    /// The row of the front above for each of the border.
    pub(super) above: Vec<u32>,
    /// Fronts below and the front itself: they lie before it, one after the other.
    pub(super) fronts: usize,
    /// Pivots of all of these.
    pub(super) places: usize,
    /// The fronts below.
    pub(super) below: Vec<usize>,
}

/// All fronts, each behind those below it.
pub(super) struct Dissection {
    pub(super) fronts: Vec<Front>,
    /// The place at each position.
    pub(super) order: Vec<u32>,
    /// The position of each place.
    pub(super) position: Vec<u32>,
    /// Numbers of the factor.
    pub(super) entries: usize,
}

impl Front {
    /// The row of a position in this front: pivots first, then the border.
    pub(super) fn row(&self, position: u32) -> usize {
        match (position as usize).checked_sub(self.first) {
            Some(row) if row < self.pivots => row,
            _ => self.pivots + self.border.partition_point(|&other| other < position),
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.pivots + self.border.len()
    }
}

/// The fronts of a node and of those below it, with the places they eliminate. Numbers count from the first of them; borders hold
/// places.
#[derive(Default)]
struct Part {
    fronts: Vec<Front>,
    order: Vec<u32>,
}

impl Part {
    /// Adds a part that follows; gives the number of its last front.
    fn add(&mut self, other: Part) -> usize {
        let [fronts, places] = [self.fronts.len(), self.order.len()];
        self.order.extend(other.order);
        self.fronts.extend(other.fronts.into_iter().map(|mut front| {
            front.first += places;
            front.below.iter_mut().for_each(|below| *below += fronts);
            front
        }));
        self.fronts.len() - 1
    }
}

impl Dissection {
    /// The order for the links of a Laplacian among places of a tree.
    pub(super) fn new<const D: usize>(links: &Laplacian, nodes: &[Node<D>]) -> Dissection {
        let mut node_of = vec![NONE; links.len()];
        eliminate(links, nodes, 0, &mut node_of);
        let Part { mut fronts, order } = Cuts { links, nodes, node_of: &node_of }.part(0);
        let mut position = vec![0; links.len()];
        (0..).zip(&order).for_each(|(at, &place)| position[place as usize] = at);
        fronts.par_iter_mut().for_each(|front| {
            front.border.iter_mut().for_each(|place| *place = position[*place as usize]);
            front.border.sort_unstable();
        });
        let rows_above = |own: &Front| -> Vec<Vec<u32>> {
            let above = |&below: &usize| {
                let border = fronts[below].border.iter();
                border.map(|&position| own.row(position) as u32).collect()
            };
            own.below.iter().map(above).collect()
        };
        let above: Vec<Vec<Vec<u32>>> = fronts.par_iter().map(rows_above).collect();
        for (at, rows) in above.into_iter().enumerate() {
            for (below, rows) in fronts[at].below.clone().into_iter().zip(rows) {
                fronts[below].above = rows;
            }
        }
        let entries = fronts.iter().map(|front| front.pivots * front.rows()).sum();
        Dissection { fronts, order, position, entries }
    }
}

/// Where a tree is cut.
#[derive(Clone, Copy)]
struct Cuts<'a, const D: usize> {
    links: &'a Laplacian,
    nodes: &'a [Node<D>],
    /// The node at which each place is eliminated.
    node_of: &'a [u32],
}

impl<const D: usize> Cuts<'_, D> {
    /// The fronts of a node and of those below it. Halves do not depend on each other.
    fn part(&self, at: usize) -> Part {
        let node = &self.nodes[at];
        let (mut part, below) = match halves(node, at) {
            Some([left, right]) => {
                let (mut part, right) = rayon::join(|| self.part(left), || self.part(right));
                let below = vec![part.fronts.len() - 1, part.add(right)];
                (part, below)
            }
            None => (Part::default(), Vec::new()),
        };
        let first = part.order.len();
        let is_own = |&place: &u32| self.node_of[place as usize] == at as u32;
        part.order.extend((node.first..node.end).filter(is_own));
        // Places that are yet to come have no position, so places stand for them; their nodes are above this one.
        let mut border: Vec<u32> = Vec::new();
        for &place in &part.order[first..] {
            border.extend(self.links.neighbours(place as usize).map(|(other, _)| other as u32));
        }
        for &front in &below {
            border.extend_from_slice(&part.fronts[front].border);
        }
        let is_later = |place: u32| is_above(self.nodes, self.node_of[place as usize] as usize, at);
        border.retain(|&place| is_later(place));
        border.sort_unstable();
        border.dedup();
        let places = part.order.len();
        part.fronts.push(Front {
            first,
            pivots: places - first,
            border,
            above: Vec::new(),
            fronts: part.fronts.len() + 1,
            places,
            below,
        });
        part
    }
}

/// Writes the node at which each place is eliminated: the highest one whose cut it lies at, or the lowest one. `node_of` are the places
/// of the node.
fn eliminate<const D: usize>(links: &Laplacian, nodes: &[Node<D>], at: usize, node_of: &mut [u32]) {
    let node = &nodes[at];
    let Some([left, right]) = halves(node, at) else {
        node_of.iter_mut().filter(|node| **node == NONE).for_each(|node| *node = at as u32);
        return;
    };
    let [left_places, right_places] = [left, right].map(|at| nodes[at].first..nodes[at].end);
    let is_open = |place: u32| node_of[(place - node.first) as usize] == NONE;
    let at_cut = |own: &Range<u32>, others: &Range<u32>| -> Vec<u32> {
        let is_across = |other: u32| others.contains(&other) && is_open(other);
        let is_at_cut = |&place: &u32| {
            is_open(place)
                && links.neighbours(place as usize).any(|(other, _)| is_across(other as u32))
        };
        own.clone().filter(is_at_cut).collect()
    };
    let sides = [at_cut(&left_places, &right_places), at_cut(&right_places, &left_places)];
    let smaller = usize::from(sides[1].len() < sides[0].len());
    for &place in &sides[smaller] {
        node_of[(place - node.first) as usize] = at as u32;
    }
    let (left_of, right_of) = node_of.split_at_mut((left_places.end - node.first) as usize);
    rayon::join(
        || eliminate(links, nodes, left, left_of),
        || eliminate(links, nodes, right, right_of),
    );
}

/// The halves of a node that is cut.
fn halves<const D: usize>(node: &Node<D>, at: usize) -> Option<[usize; 2]> {
    (node.right != 0 && node.len() > UNCUT).then(|| [at + 1, at + node.right as usize])
}

/// Whether a node is above another one.
fn is_above<const D: usize>(nodes: &[Node<D>], above: usize, at: usize) -> bool {
    let (upper, lower) = (&nodes[above], &nodes[at]);
    above < at && upper.first <= lower.first && lower.end <= upper.end
}

const NONE: u32 = u32::MAX;

/// Places of a node that is cut no further, at most.
const UNCUT: usize = 60;
