//! The adaptive scan: from what is known of a part, the next batch of places, or why the scan ends.
//!
//! It is a pure loop. The caller measures a batch, looks at the part and asks again:
//!
//! 1. A fail that is certain ends the scan. So does a budget that is spent.
//! 2. Coverage and sampling that are not reached lead to the regions where points lack. A region gets the places of the lattice in the middle of
//!    those measured, so the spacing there falls by √2. Then the part is looked at again: what is fine now drops out of the regions. A
//!    region whose need differs from place to place is so never filled with its finest spacing.
//! 3. Figures that are not certain enough lead to the next level over the whole aperture, as long as that makes them more certain.

use std::collections::BTreeSet;

use crate::lattice::{HIGHEST_LEVEL, Lattice, Node};
use crate::piece::distance_mm;
use crate::{Aperture, Piece, PlanError, Polygon, Spacing, strokes};

/// What a scan is to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Share of the aperture to be sampled densely enough, 0 to 1.
    pub coverage: f64,
    /// Largest standard uncertainty of the figure that is judged; `None`: any.
    pub u_max: Option<f64>,
    /// Time in s after which no batch begins; `None`: any.
    pub budget_s: Option<f64>,
    /// Most places of a batch.
    pub batch_places: usize,
    /// No place comes nearer to others than this, in mm: noise would turn the surface between them.
    pub finest_mm: f64,
}

/// State of the verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VerdictState {
    /// No limit is given.
    #[default]
    NotAsked,
    /// Neither is certain.
    Open,
    /// Every limit holds for certain.
    PassCertain,
    /// A limit is broken whatever comes.
    FailCertain,
}

/// A region where points lack, as the sampling report lists it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WantedRegion {
    /// Where it lies, places in mm in the frame of the machine.
    pub polygons: Vec<Polygon>,
    /// The spacing in mm it needs where it needs the finest; `None`: unknown.
    pub spacing_mm: Option<f64>,
    /// Gain of coverage by measuring it, 0 to 1.
    pub gain: f64,
}

/// All that is known when a batch was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known<'a> {
    /// Regions where points lack.
    pub regions: &'a [WantedRegion],
    /// Share of the aperture that is sampled densely enough; `None`: unknown.
    pub coverage: Option<f64>,
    /// State of the verdict.
    pub verdict: VerdictState,
    /// Standard uncertainty of the figure that is judged; `None`: unknown.
    pub u: Option<f64>,
    /// Time since the scan began in s.
    pub spent_s: f64,
    /// Where the probe stands, mm.
    pub stands_mm: [f64; 2],
}

/// The next step of a scan.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// More is to be measured.
    Measure(Batch),
    /// The scan ends.
    End(Ending),
}

/// Places to measure before the part is looked at again.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Lines and stops in a short order, each with the distance of its points: for [`schedule_each`](crate::schedule_each).
    pub pieces: Vec<(Piece, Spacing)>,
    /// How many places they have.
    pub places: usize,
    /// How many regions they lie in; 0 where they lie over the whole aperture.
    pub regions: usize,
}

/// Why a scan ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Coverage, uncertainty and verdict are as wanted.
    Reached,
    /// A limit is broken whatever comes.
    FailCertain,
    /// The time is spent.
    BudgetSpent,
    /// No place is left that helps.
    NothingToGain,
}

/// An adaptive scan over an aperture.
#[derive(Clone, Debug)]
pub struct AdaptiveScan {
    goal: Goal,
    lattice: Lattice,
    aperture: Aperture,
    centre_mm: [f64; 2],
    taken: BTreeSet<Node>,
    /// Places on the border that stand for places beyond it.
    on_border: Vec<[f64; 2]>,
    /// The uncertainty before the last level over the whole aperture.
    u_before: Option<f64>,
    /// Levels that were measured over the whole aperture.
    whole_levels: u32,
}

impl AdaptiveScan {
    /// A scan that begins with a lattice of this spacing over an aperture about a centre.
    ///
    /// # Errors
    ///
    /// When the goal, the aperture or the spacing cannot be.
    pub fn new(
        goal: Goal,
        aperture: Aperture,
        centre_mm: [f64; 2],
        spacing_mm: f64,
    ) -> Result<AdaptiveScan, PlanError> {
        goal.validate()?;
        aperture.validate()?;
        let lattice = Lattice::new(centre_mm, spacing_mm)?;
        let (taken, on_border) = (BTreeSet::new(), Vec::new());
        Ok(AdaptiveScan {
            goal,
            lattice,
            aperture,
            centre_mm,
            taken,
            on_border,
            u_before: None,
            whole_levels: 0,
        })
    }

    /// The first batch: the coarse scan, level 0 of the lattice over the aperture. It ignores the limit of a batch.
    pub fn begin(&mut self, stands_mm: [f64; 2]) -> Batch {
        self.whole_levels = 1;
        let nodes = self.whole_level(0);
        self.batch(stands_mm, vec![(0, nodes)], 0)
    }

    /// The next batch after the last one was measured, or why the scan ends.
    pub fn next_step(&mut self, known: &Known<'_>) -> Step {
        if known.verdict == VerdictState::FailCertain {
            return Step::End(Ending::FailCertain);
        }
        let is_sampled = known.coverage.is_some_and(|coverage| coverage >= self.goal.coverage);
        let is_certain = self.goal.is_certain(known);
        if is_sampled && is_certain {
            return Step::End(Ending::Reached);
        }
        if self.goal.budget_s.is_some_and(|budget_s| known.spent_s >= budget_s) {
            return Step::End(Ending::BudgetSpent);
        }
        if is_sampled {
            return self.densify(known);
        }
        loop {
            let (levels, regions) = self.wanted(known.regions);
            if levels.is_empty() {
                return Step::End(Ending::NothingToGain);
            }
            // Places on the border may all stand beside others; then finer ones come.
            let batch = self.batch(known.stands_mm, levels, regions);
            if batch.places > 0 {
                return Step::Measure(batch);
            }
        }
    }

    /// Places that a region lacks, by levels, the region of most gain first, and how many regions they lie in.
    fn wanted(&self, regions: &[WantedRegion]) -> (Vec<(u32, Vec<Node>)>, usize) {
        let mut order: Vec<&WantedRegion> = regions.iter().collect();
        order.sort_by(|p, q| q.gain.total_cmp(&p.gain));
        let mut levels: Vec<(u32, Vec<Node>)> = Vec::new();
        let mut chosen: BTreeSet<Node> = BTreeSet::new();
        let mut count = 0;
        for region in order {
            let before = chosen.len();
            for level in 0..=HIGHEST_LEVEL {
                if self.is_too_fine(level, region) || chosen.len() >= self.goal.batch_places {
                    break;
                }
                let room = self.goal.batch_places - chosen.len();
                let Ready { nodes, goes_on } = self.ready(level, region, room);
                let new: Vec<Node> =
                    nodes.into_iter().filter(|&node| chosen.insert(node)).collect();
                if !new.is_empty() {
                    levels.push((level, new));
                }
                if !goes_on {
                    break;
                }
            }
            count += usize::from(chosen.len() > before);
        }
        (levels, count)
    }

    /// Whether places of a level would stand nearer than a region needs, or than is of use.
    fn is_too_fine(&self, level: u32, region: &WantedRegion) -> bool {
        let spacing_mm = self.lattice.spacing_mm(level);
        let finer_mm = 2.0 * spacing_mm;
        spacing_mm < self.goal.finest_mm || region.spacing_mm.is_some_and(|mm| finer_mm < mm)
    }

    /// Places of a level in a region that are not measured and whose neighbours of lower levels are, as far as these lack as well.
    fn ready(&self, level: u32, region: &WantedRegion, most: usize) -> Ready {
        let spacing_mm = self.lattice.spacing_mm(level);
        let slack_mm = SLACK * spacing_mm;
        let belongs = |node: Node| {
            let within = |place| region.polygons.iter().any(|one| one.contains(place, slack_mm));
            self.place(node, spacing_mm).is_some_and(|(place, _)| within(place))
        };
        let lacks = |node: &Node| !self.taken.contains(node) && belongs(*node);
        let (mut found, mut free, mut taken) = (Vec::new(), 0, 0);
        for polygon in &region.polygons {
            let Some([low, high]) = polygon.bounds() else { continue };
            // Beyond the border, too.
            let bounds = [low.map(|mm| mm - spacing_mm), high.map(|mm| mm + spacing_mm)];
            let count = (0..2).map(|axis| (bounds[1][axis] - bounds[0][axis]) / spacing_mm);
            if count.product::<f64>() > MOST_NODES {
                return Ready { nodes: found, goes_on: false };
            }
            for node in self.lattice.nodes(level, bounds).into_iter().filter(|&node| belongs(node))
            {
                if self.taken.contains(&node) {
                    taken += 1;
                    continue;
                }
                free += 1;
                if found.len() < most && !Lattice::parents(level, node).iter().any(lacks) {
                    found.push(node);
                }
            }
        }
        // Where no place of this level is measured, none of the next has its neighbours.
        Ready { nodes: found, goes_on: free == 0 || taken > 0 }
    }

    /// The next level over the whole aperture, if the last one made the figures more certain.
    fn densify(&mut self, known: &Known<'_>) -> Step {
        let level = self.whole_levels;
        let fell = match (self.u_before, known.u) {
            (Some(before), Some(now)) => now < WORTH * before,
            _ => true,
        };
        if !fell || level > HIGHEST_LEVEL || self.lattice.spacing_mm(level) < self.goal.finest_mm {
            return Step::End(Ending::NothingToGain);
        }
        self.u_before = known.u;
        self.whole_levels += 1;
        let nodes = self.whole_level(level);
        if nodes.is_empty() {
            return Step::End(Ending::NothingToGain);
        }
        Step::Measure(self.batch(known.stands_mm, vec![(level, nodes)], 0))
    }

    /// Places of a level over the whole aperture that are not measured.
    fn whole_level(&self, level: u32) -> Vec<Node> {
        let spacing_mm = self.lattice.spacing_mm(level);
        let reach_mm = self.aperture.reach_mm() + spacing_mm;
        let bounds = [-reach_mm, reach_mm].map(|mm| self.centre_mm.map(|centre| centre + mm));
        let nodes = self.lattice.nodes(level, bounds).into_iter();
        let is_free =
            |node: &Node| !self.taken.contains(node) && self.place(*node, spacing_mm).is_some();
        nodes.filter(is_free).collect()
    }

    /// Where a place of the lattice is measured, and whether that is on the border: for a place that lies not far beyond it.
    fn place(&self, node: Node, spacing_mm: f64) -> Option<([f64; 2], bool)> {
        let place = self.lattice.place_mm(node);
        let about = [0, 1].map(|axis| place[axis] - self.centre_mm[axis]);
        if self.aperture.contains(about) {
            return Some((place, false));
        }
        let border = self.aperture.nearest(about);
        let is_near = distance_mm(about, border) <= BEYOND * spacing_mm;
        is_near.then(|| ([0, 1].map(|axis| border[axis] + self.centre_mm[axis]), true))
    }

    fn batch(
        &mut self,
        stands_mm: [f64; 2],
        levels: Vec<(u32, Vec<Node>)>,
        regions: usize,
    ) -> Batch {
        let mut groups: Vec<(f64, Vec<[f64; 2]>)> = Vec::new();
        let mut count = 0;
        for (level, nodes) in levels {
            let spacing_mm = self.lattice.spacing_mm(level);
            let mut places = Vec::with_capacity(nodes.len());
            self.taken.extend(nodes.iter().copied());
            for &node in &nodes {
                let Some((place, on_border)) = self.place(node, spacing_mm) else { continue };
                let apart_mm = if on_border { APART } else { BESIDE } * spacing_mm;
                if self.on_border.iter().any(|&other| distance_mm(place, other) < apart_mm) {
                    continue;
                }
                if on_border {
                    if self.is_beside_taken(place, level) {
                        continue;
                    }
                    self.on_border.push(place);
                }
                places.push(place);
            }
            count += places.len();
            groups.push((self.lattice.row_step_mm(level), places));
        }
        Batch { pieces: strokes(stands_mm, &groups), places: count, regions }
    }

    /// Whether a place on the border stands beside one of the lattice, of this level or a coarser one.
    fn is_beside_taken(&self, place: [f64; 2], level: u32) -> bool {
        let apart_mm = BESIDE * self.lattice.spacing_mm(level);
        let bounds = [place.map(|mm| mm - apart_mm), place.map(|mm| mm + apart_mm)];
        let mut near = (0..=level).flat_map(|level| self.lattice.nodes(level, bounds));
        near.any(|node| {
            let other = self.lattice.place_mm(node);
            let about = [0, 1].map(|axis| other[axis] - self.centre_mm[axis]);
            self.taken.contains(&node)
                && self.aperture.contains(about)
                && distance_mm(place, other) < apart_mm
        })
    }
}

impl Goal {
    fn validate(&self) -> Result<(), PlanError> {
        let refuse = |key, expected: &str, found: String, cure: &str| {
            Err(PlanError::new(key, expected, found, cure))
        };
        if !(self.coverage > 0.0 && self.coverage <= 1.0) {
            let found = self.coverage.to_string();
            return refuse(
                "coverage",
                "above 0 and up to 1",
                found,
                "give the share to be covered",
            );
        }
        if self.batch_places == 0 {
            return refuse("batch", "at least 1 place", "0".to_owned(), "give a larger batch");
        }
        let given =
            [("budget", self.budget_s), ("u_max", self.u_max), ("finest", Some(self.finest_mm))];
        for (key, value) in given {
            if let Some(value) = value.filter(|value| !(*value >= 0.0 && value.is_finite())) {
                return refuse(key, "a number from 0", value.to_string(), "leave it out for none");
            }
        }
        Ok(())
    }

    fn is_certain(&self, known: &Known<'_>) -> bool {
        let is_known = self.u_max.is_none_or(|most| known.u.is_some_and(|u| u <= most));
        is_known && known.verdict != VerdictState::Open
    }
}

/// Places of a level that may be measured.
struct Ready {
    nodes: Vec<Node>,
    /// Whether finer levels may have such places, too.
    goes_on: bool,
}

/// Most places of a level about a region; beyond that the region is a sliver.
const MOST_NODES: f64 = 4e6;

/// Lines of regions are simplified, and a place on one belongs to the region: so far, as a share of the spacing.
const SLACK: f64 = 0.2;

/// A place beyond the border so far away, as a share of the spacing, is measured on the border instead: points must enclose the aperture.
const BEYOND: f64 = 0.6;

/// Places on the border are no nearer to each other than this share of the spacing, and others no nearer to them than this.
const APART: f64 = 0.5;
const BESIDE: f64 = 0.25;

/// A level over the whole aperture was worth its time where it left at most this share of the uncertainty.
const WORTH: f64 = 0.95;

#[cfg(test)]
mod tests;
