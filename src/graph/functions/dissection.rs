//! Fronts of places: an order in which the Laplacian is eliminated with little fill.
//!
//! The k-d tree of the cloud cuts it in halves again and again. Of each cut the places of one side that have neighbours on the other
//! come after both halves (nested dissection, A. George, SIAM Journal on Numerical Analysis 10 (1973) 345-363,
//! doi:10.1137/0710032). On a surface a cut is short, so fill grows little faster than the places.

use std::ops::Range;

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

impl Dissection {
    /// The order for the links of a Laplacian among places of a tree.
    pub(super) fn new<const D: usize>(links: &Laplacian, nodes: &[Node<D>]) -> Dissection {
        let node_of = node_of_each_place(links, nodes);
        let mut dissection = Dissection {
            fronts: Vec::new(),
            order: Vec::with_capacity(links.len()),
            position: vec![0; links.len()],
            entries: 0,
        };
        dissection.add(links, (nodes, &node_of), 0);
        for front in &mut dissection.fronts {
            let position = |place: &mut u32| *place = dissection.position[*place as usize];
            front.border.iter_mut().for_each(position);
            front.border.sort_unstable();
            dissection.entries += front.pivots * front.rows();
        }
        for at in 0..dissection.fronts.len() {
            for below in dissection.fronts[at].below.clone() {
                let own = &dissection.fronts[at];
                let border = dissection.fronts[below].border.iter();
                let above = border.map(|&position| own.row(position) as u32).collect();
                dissection.fronts[below].above = above;
            }
        }
        dissection
    }

    /// Adds the fronts of a node and of those below it; gives the number of its own.
    fn add<const D: usize>(
        &mut self,
        links: &Laplacian,
        (nodes, node_of): (&[Node<D>], &[u32]),
        at: usize,
    ) -> usize {
        let node = &nodes[at];
        let begun = [self.fronts.len(), self.order.len()];
        let below = match halves(node, at) {
            Some(halves) => halves.map(|half| self.add(links, (nodes, node_of), half)).into(),
            None => Vec::new(),
        };
        let first = self.order.len();
        for place in (node.first..node.end).filter(|&place| node_of[place as usize] == at as u32) {
            self.position[place as usize] = self.order.len() as u32;
            self.order.push(place);
        }
        let end = self.order.len();
        // Places that are yet to come have no position, so places stand for them; their nodes are above this one.
        let mut border: Vec<u32> = Vec::new();
        for &place in &self.order[first..end] {
            border.extend(links.neighbours(place as usize).map(|(other, _)| other as u32));
        }
        let is_later = |place: u32| is_above(nodes, node_of[place as usize] as usize, at);
        border.retain(|&place| is_later(place));
        for &front in &below {
            border.extend(self.fronts[front].border.iter().filter(|&&place| is_later(place)));
        }
        border.sort_unstable();
        border.dedup();
        self.fronts.push(Front {
            first,
            pivots: end - first,
            border,
            above: Vec::new(),
            fronts: self.fronts.len() + 1 - begun[0],
            places: end - begun[1],
            below,
        });
        self.fronts.len() - 1
    }
}

/// The node at which each place is eliminated: the highest one whose cut it lies at, or the lowest one.
fn node_of_each_place<const D: usize>(links: &Laplacian, nodes: &[Node<D>]) -> Vec<u32> {
    let mut node_of = vec![NONE; links.len()];
    let mut open = vec![0];
    while let Some(at) = open.pop() {
        let node = &nodes[at];
        let Some([left, right]) = halves(node, at) else {
            let own = &mut node_of[node.first as usize..node.end as usize];
            own.iter_mut().filter(|node| **node == NONE).for_each(|node| *node = at as u32);
            continue;
        };
        let [left_places, right_places] = [left, right].map(|at| nodes[at].first..nodes[at].end);
        let at_cut = |own: &Range<u32>, others: &Range<u32>| -> Vec<u32> {
            let is_across =
                |other: usize| node_of[other] == NONE && others.contains(&(other as u32));
            let is_at_cut = |&place: &u32| {
                node_of[place as usize] == NONE
                    && links.neighbours(place as usize).any(|(other, _)| is_across(other))
            };
            own.clone().filter(is_at_cut).collect()
        };
        let sides = [at_cut(&left_places, &right_places), at_cut(&right_places, &left_places)];
        let smaller = usize::from(sides[1].len() < sides[0].len());
        sides[smaller].iter().for_each(|&place| node_of[place as usize] = at as u32);
        open.extend([left, right]);
    }
    node_of
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
