//! Steps that shorten a path whose beginning stays.

use std::collections::VecDeque;

use super::Ruler;

/// A path shortened until no step of a place gains.
///
/// Places are tried in the order of the path, and again when a neighbour changed. A place takes its best step.
pub(super) fn shortened(ruler: &Ruler, order: Vec<usize>, near: &[Vec<usize>]) -> Vec<usize> {
    let end = ruler.nodes.len();
    let nodes: Vec<usize> = [0].into_iter().chain(order).chain([end]).collect();
    let mut places = vec![0; end + 1];
    nodes.iter().enumerate().for_each(|(place, &node)| places[node] = place);
    let mut waiting: VecDeque<usize> = nodes[..end].iter().copied().collect();
    let mut waits = vec![true; end + 1];
    let mut path = Path { ruler, nodes, places };
    while let Some(node) = waiting.pop_front() {
        waits[node] = false;
        let Some(step) = path.best(node, near) else { continue };
        for changed in path.take(step).into_iter().chain([node]) {
            if changed != end && !waits[changed] {
                waits[changed] = true;
                waiting.push_back(changed);
            }
        }
    }
    path.nodes[1..end].to_vec()
}

/// Nodes in order: the beginning, all places, and an end that is as near to every place.
struct Path<'a> {
    ruler: &'a Ruler,
    nodes: Vec<usize>,
    /// Where each node stands.
    places: Vec<usize>,
}

#[derive(Clone, Copy)]
struct Step {
    gain: i64,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    /// Reverses the nodes from one place to another.
    Reverse { from: usize, to: usize },
    /// Moves the nodes from one place to another behind the node at a third, outside them.
    Shift { from: usize, to: usize, behind: usize, turned: bool },
}

impl Path<'_> {
    fn length(&self, p: usize, q: usize) -> i64 {
        let end = self.ruler.nodes.len();
        if p == end || q == end { 0 } else { self.ruler.length(p, q) }
    }

    /// The length between the nodes at two places.
    fn between(&self, i: usize, j: usize) -> i64 {
        self.length(self.nodes[i], self.nodes[j])
    }

    fn best(&self, node: usize, near: &[Vec<usize>]) -> Option<Step> {
        let mut best: Option<Step> = None;
        let mut offer = |gain: i64, kind: Kind| {
            if gain > best.map_or(0, |best| best.gain) {
                best = Some(Step { gain, kind });
            }
        };
        self.reversals(self.places[node], &near[node], &mut offer);
        for count in 1..=LONGEST_PIECE {
            self.shifts(self.places[node], count, &near[node], &mut offer);
        }
        best
    }

    /// Reversals that make a place and one near it neighbours, and those that make it the last.
    fn reversals(&self, i: usize, near: &[usize], offer: &mut impl FnMut(i64, Kind)) {
        let last = self.nodes.len() - 1;
        for &other in near {
            let j = self.places[other];
            let new = self.between(i, j);
            let (low, high) = (i.min(j), i.max(j));
            // Both with the node behind them.
            if new < self.between(i, i + 1) && high > low + 1 {
                let gain = self.between(i, i + 1) + self.between(j, j + 1)
                    - new
                    - self.between(i + 1, j + 1);
                offer(gain, Kind::Reverse { from: low + 1, to: high });
            }
            // Both with the node before them.
            if low > 0 && new < self.between(i - 1, i) && high > low + 1 {
                let gain = self.between(i - 1, i) + self.between(j - 1, j)
                    - new
                    - self.between(i - 1, j - 1);
                offer(gain, Kind::Reverse { from: low, to: high - 1 });
            }
        }
        if i > 0 && i + 2 < last {
            let gain = self.between(i - 1, i) - self.between(i - 1, last - 1);
            offer(gain, Kind::Reverse { from: i, to: last - 1 });
        }
    }

    /// Shifts of so many nodes that begin or end at a place, next to one near it.
    fn shifts(&self, i: usize, count: usize, near: &[usize], offer: &mut impl FnMut(i64, Kind)) {
        let last = self.nodes.len() - 1;
        for begins in [true, false] {
            if count == 1 && !begins {
                continue;
            }
            let Some(from) = (if begins { Some(i) } else { (i + 1).checked_sub(count) }) else {
                continue;
            };
            let to = from + count - 1;
            if from == 0 || to >= last {
                continue;
            }
            let freed = self.between(from - 1, from) + self.between(to, to + 1)
                - self.between(from - 1, to + 1);
            if freed <= 0 {
                continue;
            }
            for &other in near {
                let j = self.places[other];
                for behind in [Some(j), j.checked_sub(1)].into_iter().flatten() {
                    let is_inside = (from - 1..=to).contains(&behind);
                    if is_inside || behind + 1 > last {
                        continue;
                    }
                    for turned in [false, true] {
                        let [first, final_] = if turned { [to, from] } else { [from, to] };
                        let added = self.between(behind, first) + self.between(final_, behind + 1)
                            - self.between(behind, behind + 1);
                        offer(freed - added, Kind::Shift { from, to, behind, turned });
                    }
                }
            }
        }
    }

    /// Takes a step; the nodes that have new neighbours.
    fn take(&mut self, step: Step) -> Vec<usize> {
        let (low, high, inner) = match step.kind {
            Kind::Reverse { from, to } => {
                self.nodes[from..=to].reverse();
                (from, to, None)
            }
            Kind::Shift { from, to, behind, turned } => {
                if turned {
                    self.nodes[from..=to].reverse();
                }
                let count = to + 1 - from;
                if behind > to {
                    self.nodes[from..=behind].rotate_left(count);
                    (from, behind, Some(behind + 1 - count))
                } else {
                    self.nodes[behind + 1..=to].rotate_right(count);
                    (behind + 1, to, Some(behind + count))
                }
            }
        };
        for place in low..=high {
            self.places[self.nodes[place]] = place;
        }
        let mut changed =
            vec![self.nodes[low - 1], self.nodes[low], self.nodes[high], self.nodes[high + 1]];
        changed.extend(
            inner.into_iter().flat_map(|at| {
                [self.nodes[at], self.nodes[at - 1], self.nodes[(at + 1).min(high)]]
            }),
        );
        changed
    }
}

/// Most places of a piece that is shifted.
const LONGEST_PIECE: usize = 3;
