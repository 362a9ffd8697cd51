//! Parts from their beginning to their end, as strips are closed.

use std::collections::{BTreeMap, BTreeSet};

use asphera_geometry::PointMm;

use super::strip::Strip;

/// Number of a part, in the order in which parts begin. Of merged parts the lowest stays.
pub type PartId = u32;

/// A change of the parts where a strip is closed.
#[derive(Clone, Debug, PartialEq)]
pub struct RunningEvent {
    /// The part.
    pub part: PartId,
    /// The strip in which it happened.
    pub strip: i64,
    /// Where: the mean of the places of the node, mm.
    pub at_mm: PointMm,
    /// The change.
    pub change: Change,
}

/// What happened to a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// It began.
    Begun,
    /// One branch became so many.
    Split {
        /// Branches behind it.
        branches: usize,
    },
    /// So many branches became one. Where all of them were of this part, a hole was closed.
    Joined {
        /// Branches before it.
        branches: usize,
    },
    /// Other parts turned out to be this one.
    Merged {
        /// Their numbers, ascending.
        absorbed: Vec<PartId>,
    },
    /// It ended: nothing more can belong to it.
    Ended,
}

/// A part that ended.
#[derive(Clone, Debug, PartialEq)]
pub struct RunningPart {
    /// Its number.
    pub id: PartId,
    /// Its points.
    pub points: u64,
    /// Its places: equal points share one.
    pub places: u64,
    /// The box along the axes: least and largest coordinates in mm.
    pub box_mm: [PointMm; 2],
    /// The mean of its places in mm.
    pub centre_mm: PointMm,
    /// First and last strip.
    pub strips: [i64; 2],
    /// Nodes of the graph.
    pub nodes: u64,
    /// Loops of the graph: arcs less nodes and one more.
    pub loops: u64,
    /// Whether the scan ended in it or before the next strip, so that it may have been cut off.
    pub is_open: bool,
    /// Its points with their rows, by row; none where they are not wanted.
    pub rows: Vec<(u64, PointMm)>,
}

#[derive(Clone, Debug)]
struct Open {
    part: RunningPart,
    arcs: u64,
    /// Sums over places of what is left of the first one, mm.
    first_mm: PointMm,
    sum_mm: PointMm,
}

/// Parts that have not ended.
#[derive(Clone, Debug, Default)]
pub(super) struct OpenParts {
    next: PartId,
    open: BTreeMap<PartId, Open>,
    /// The part of each node of the last closed strip.
    of_node: Vec<PartId>,
    events: Vec<RunningEvent>,
    ended: Vec<RunningPart>,
}

impl OpenParts {
    pub(super) fn len(&self) -> usize {
        self.open.len()
    }

    pub(super) fn take_events(&mut self) -> Vec<RunningEvent> {
        std::mem::take(&mut self.events)
    }

    pub(super) fn take_ended(&mut self) -> Vec<RunningPart> {
        std::mem::take(&mut self.ended)
    }

    /// Goes on to a strip. `below` is the number of the first node of the strip before it, if that is the one below.
    pub(super) fn advance(&mut self, strip: &Strip, below: Option<u64>, keeps_points: bool) {
        let closed = &strip.closed;
        let lower = std::mem::take(&mut self.of_node);
        let mut before: Vec<Vec<usize>> = vec![Vec::new(); closed.nodes.len()];
        let mut behind: Vec<usize> = vec![0; lower.len()];
        for ([a, b], _) in &closed.arcs {
            let (a, b) = ((a - below.unwrap_or(0)) as usize, (b - closed.first_node) as usize);
            before[b].push(a);
            behind[a] += 1;
        }
        self.split(strip, &lower, &before, &behind);
        let mut now: BTreeMap<PartId, PartId> = lower.iter().map(|&id| (id, id)).collect();
        for (node, from) in before.iter().enumerate() {
            let id = self.join(strip, node, from, &lower, &mut now);
            self.of_node.push(id);
        }
        // A merge after a node took its part changes that of the node, too.
        self.of_node.iter_mut().for_each(|id| *id = now.get(id).copied().unwrap_or(*id));
        for ((node, &id), from) in closed.nodes.iter().zip(&self.of_node).zip(&before) {
            if let Some(open) = self.open.get_mut(&id) {
                open.add(node, from.len() as u64, closed.strip);
            }
        }
        if keeps_points {
            let points = strip.points.rows.iter().zip(&strip.points.at_mm);
            for ((&row, &at_mm), node) in points.zip(strip.nodes_of_points()) {
                if let Some(open) = self.open.get_mut(&self.of_node[node as usize]) {
                    open.part.rows.push((row, at_mm));
                }
            }
        }
        let here: BTreeSet<PartId> = self.of_node.iter().copied().collect();
        let gone: Vec<PartId> = self.open.keys().copied().filter(|id| !here.contains(id)).collect();
        gone.into_iter().for_each(|id| self.end(id, false));
    }

    /// Ends all parts: nothing lies in the next strip. `is_open` says whether the scan ended there.
    pub(super) fn end_all(&mut self, is_open: bool) {
        self.of_node.clear();
        let all: Vec<PartId> = self.open.keys().copied().collect();
        all.into_iter().for_each(|id| self.end(id, is_open));
    }

    fn end(&mut self, id: PartId, is_open: bool) {
        let Some(Open { mut part, arcs, first_mm, sum_mm }) = self.open.remove(&id) else { return };
        part.centre_mm =
            std::array::from_fn(|axis| first_mm[axis] + sum_mm[axis] / part.places as f64);
        part.loops = (arcs + 1).saturating_sub(part.nodes);
        part.is_open = is_open;
        part.rows.sort_unstable_by_key(|&(row, _)| row);
        let (strip, at_mm) = (part.strips[1], part.centre_mm);
        self.events.push(RunningEvent { part: id, strip, at_mm, change: Change::Ended });
        self.ended.push(part);
    }

    /// Says where one node of the strip below leads to several. A part of several such nodes says so for each.
    fn split(&mut self, strip: &Strip, lower: &[PartId], before: &[Vec<usize>], behind: &[usize]) {
        for (node, &branches) in behind.iter().enumerate().filter(|(_, branches)| **branches > 1) {
            let first = before.iter().position(|from| from.contains(&node));
            let at_mm = first.map_or([0.0; 3], |first| strip.closed.nodes[first].centroid_mm);
            let change = Change::Split { branches };
            self.events.push(RunningEvent {
                part: lower[node],
                strip: strip.closed.strip,
                at_mm,
                change,
            });
        }
    }

    /// The part of a node: a new one, that of the nodes below, or what several of these become.
    fn join(
        &mut self,
        strip: &Strip,
        node: usize,
        from: &[usize],
        lower: &[PartId],
        now: &mut BTreeMap<PartId, PartId>,
    ) -> PartId {
        let at_mm = strip.closed.nodes[node].centroid_mm;
        let number = strip.closed.strip;
        let event = |part, change| RunningEvent { part, strip: number, at_mm, change };
        let ids: BTreeSet<PartId> = from.iter().map(|&below| now[&lower[below]]).collect();
        let Some(&id) = ids.first() else {
            let id = self.next;
            self.next += 1;
            self.open.insert(id, Open::new(id, number));
            self.events.push(event(id, Change::Begun));
            return id;
        };
        let absorbed: Vec<PartId> = ids.iter().copied().skip(1).collect();
        if from.len() > absorbed.len() + 1 {
            self.events.push(event(id, Change::Joined { branches: from.len() }));
        }
        if !absorbed.is_empty() {
            for other in &absorbed {
                if let (Some(gone), Some(open)) = (self.open.remove(other), self.open.get_mut(&id))
                {
                    open.absorb(gone);
                }
                now.insert(*other, id);
                now.values_mut().filter(|part| *part == other).for_each(|part| *part = id);
            }
            self.events.push(event(id, Change::Merged { absorbed }));
        }
        id
    }
}

impl Open {
    fn new(id: PartId, strip: i64) -> Open {
        let part = RunningPart {
            id,
            points: 0,
            places: 0,
            box_mm: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
            centre_mm: [0.0; 3],
            strips: [strip; 2],
            nodes: 0,
            loops: 0,
            is_open: false,
            rows: Vec::new(),
        };
        Open { part, arcs: 0, first_mm: [0.0; 3], sum_mm: [0.0; 3] }
    }

    fn add(&mut self, node: &super::RunningNode, arcs: u64, strip: i64) {
        if self.part.nodes == 0 {
            self.first_mm = node.centroid_mm;
        }
        self.part.nodes += 1;
        self.part.points += node.points;
        self.part.places += node.places;
        self.part.strips[1] = strip;
        self.arcs += arcs;
        for axis in 0..3 {
            self.sum_mm[axis] +=
                node.places as f64 * (node.centroid_mm[axis] - self.first_mm[axis]);
        }
        self.widen(node.box_mm);
    }

    fn widen(&mut self, [low, high]: [PointMm; 2]) {
        let own = &mut self.part.box_mm;
        for axis in 0..3 {
            own[0][axis] = own[0][axis].min(low[axis]);
            own[1][axis] = own[1][axis].max(high[axis]);
        }
    }

    fn absorb(&mut self, other: Open) {
        let Open { part, arcs, first_mm, sum_mm } = other;
        for axis in 0..3 {
            let aside = first_mm[axis] - self.first_mm[axis];
            self.sum_mm[axis] += sum_mm[axis] + part.places as f64 * aside;
        }
        self.arcs += arcs;
        self.part.nodes += part.nodes;
        self.part.points += part.points;
        self.part.places += part.places;
        self.part.strips[0] = self.part.strips[0].min(part.strips[0]);
        self.part.rows.extend(part.rows);
        self.widen(part.box_mm);
    }
}
