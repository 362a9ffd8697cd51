//! FitConnect: circles fitted to more and more samples say what lies beside what.

pub(super) mod fit;
mod local;

use self::local::{Local, Side};
use super::MovedCurve;
use crate::triangulation::distance_mm;
use crate::{Graph, PlaceMm, SampleId, Triangulation};

/// The curve of noisy samples without a parameter: each sample gets as many neighbours as its noise asks for.
///
/// A circle is fitted to a sample and its k nearest, k from 2 up. It orders them to the left and to the right. The sample *conforms* if
/// both sides have samples and the outermost two lie farther from each other than from it, all on the circle. Two samples that conform
/// and hold each other are joined, the farthest first; what lies between them in both is left out. A sample with two edges is done. The others
/// get one neighbour more and are fitted again, up to 40, those with the nearest neighbours first; a fit that does not conform is not taken.
/// At last a sample without edges joins two ends seen less than 60° apart, if the edges cross none: a corner.
///
/// The outermost sample of an open curve has samples on one side only and stays out.
///
/// Each sample with an edge is moved along its normal, to the mean of where that meets its own circle and the circles that hold it.
/// S. Ohrhallinger, M. Wimmer, *FitConnect: connecting noisy 2D samples by fitted neighbourhoods*, Computer Graphics Forum 38 (2019) 126-137,
/// after a description of its public program; the bound of 40 and the order are ours. No condition is proven. In doubles. n·k² time and
/// n·log n.
pub fn fit_connect(triangulation: &Triangulation) -> MovedCurve {
    Joined::of(triangulation).moved()
}

/// The edges of [`fit_connect`], and whether each sample was left out because it lies between two that are joined.
pub(super) fn connected(triangulation: &Triangulation) -> (Graph, Vec<bool>) {
    let joined = Joined::of(triangulation);
    (joined.graph(), joined.is_out)
}

/// Samples with their fits and their edges.
struct Joined<'a> {
    triangulation: &'a Triangulation,
    locals: Vec<Local>,
    edges: Vec<[Option<SampleId>; 2]>,
    is_out: Vec<bool>,
    /// All samples, those with the nearest neighbour first.
    order: Vec<SampleId>,
}

impl<'a> Joined<'a> {
    fn new(triangulation: &'a Triangulation) -> Joined<'a> {
        let count = triangulation.len();
        let mut order: Vec<SampleId> = (0..count as SampleId).collect();
        // Two samples that are each other's nearest differ in their second.
        order.sort_by_cached_key(|&sample| {
            let nearest = triangulation.nearest(sample);
            let second = triangulation.nearby(sample).nth(1).map(|other| {
                distance_mm(triangulation.place(sample), triangulation.place(other)).to_bits()
            });
            (nearest.map(|spoke| triangulation.length_class(spoke.edge)), second, sample)
        });
        Joined {
            triangulation,
            locals: (0..count as SampleId).map(Local::new).collect(),
            edges: vec![[None; 2]; count],
            is_out: vec![false; count],
            order,
        }
    }

    /// All samples joined.
    fn of(triangulation: &'a Triangulation) -> Joined<'a> {
        let mut joined = Joined::new(triangulation);
        for count in 2..=MOST_NEIGHBOURS {
            let open = joined.open();
            if open.is_empty() {
                break;
            }
            // In any order: that of the numbers asks for memory in order.
            let mut by_number = open.clone();
            by_number.sort_unstable();
            for sample in by_number {
                joined.refit(sample, count);
            }
            for &sample in &open {
                joined.join_both_sides(sample);
            }
        }
        joined.join_corners();
        joined
    }

    fn graph(&self) -> Graph {
        let edges = (0..).zip(&self.edges);
        Graph::new(edges.flat_map(|(at, ends)| ends.iter().flatten().map(move |&to| [at, to])))
    }

    /// The samples that are neither done nor out, in order.
    fn open(&self) -> Vec<SampleId> {
        let is_open = |sample: &&SampleId| {
            let sample = **sample as usize;
            !self.is_out[sample] && self.edges[sample].contains(&None)
        };
        self.order.iter().filter(is_open).copied().collect()
    }

    /// Fits a sample with so many neighbours; its edges go if the fit changes.
    fn refit(&mut self, sample: SampleId, count: usize) {
        if self.locals[sample as usize].refit(self.triangulation, count) {
            self.part(sample);
        }
    }

    /// Takes all edges of a sample away.
    fn part(&mut self, sample: SampleId) {
        for other in std::mem::take(&mut self.edges[sample as usize]).into_iter().flatten() {
            for end in &mut self.edges[other as usize] {
                if *end == Some(sample) {
                    *end = None;
                }
            }
        }
    }

    fn join_both_sides(&mut self, sample: SampleId) {
        if self.is_out[sample as usize] || !self.locals[sample as usize].conforms() {
            return;
        }
        for side in [Side::Left, Side::Right] {
            if self.edges[sample as usize][side as usize].is_none() {
                self.join_side(sample, side);
            }
        }
    }

    /// Joins a sample with the farthest one of a side that holds it and has room there.
    fn join_side(&mut self, sample: SampleId, side: Side) {
        let found = self.locals[sample as usize].side(side).iter().rev().find_map(|&other| {
            let local = &self.locals[other as usize];
            let back = local.side_of(sample)?;
            let has_room = self.edges[other as usize][back as usize].is_none();
            (has_room && local.conforms() && !self.is_out[other as usize]).then_some((other, back))
        });
        let Some((other, back)) = found else { return };
        self.edges[sample as usize][side as usize] = Some(other);
        self.edges[other as usize][back as usize] = Some(sample);
        let before = self.locals[sample as usize].before(side, other);
        let beyond = self.locals[other as usize].before(back, sample);
        for between in before.into_iter().filter(|between| beyond.contains(between)) {
            self.part(between);
            self.is_out[between as usize] = true;
        }
    }

    /// Joins ends through samples without edges where corners are.
    fn join_corners(&mut self) {
        for index in 0..self.order.len() {
            let apex = self.order[index];
            if self.is_out[apex as usize] || self.edges[apex as usize] != [None; 2] {
                continue;
            }
            let near: Vec<SampleId> = self.triangulation.nearby(apex).take(NEAR_CORNER).collect();
            let is_end = |&&end: &&SampleId| self.edges[end as usize].iter().flatten().count() == 1;
            let ends: Vec<SampleId> = near.iter().filter(is_end).take(2).copied().collect();
            let [first, second] = ends[..] else { continue };
            let [p, q, at] = [first, second, apex].map(|sample| self.triangulation.place(sample));
            let narrow = super::regular::angle_rad(at, p, q) < CORNER_RAD;
            if narrow && [first, second].into_iter().all(|end| !self.crosses([apex, end], &near)) {
                for (side, end) in [first, second].into_iter().enumerate() {
                    self.edges[apex as usize][side] = Some(end);
                    let free = self.edges[end as usize].iter_mut().find(|other| other.is_none());
                    if let Some(free) = free {
                        *free = Some(apex);
                    }
                }
            }
        }
    }

    /// Whether an edge crosses one of some samples.
    fn crosses(&self, ends: [SampleId; 2], near: &[SampleId]) -> bool {
        let [p, q] = ends.map(|end| self.triangulation.place(end));
        let left = |a: PlaceMm, b: PlaceMm, c: PlaceMm| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
        };
        near.iter().any(|&from| {
            self.edges[from as usize].iter().flatten().any(|&to| {
                let [r, s] = [from, to].map(|end| self.triangulation.place(end));
                !ends.contains(&from)
                    && !ends.contains(&to)
                    && left(p, q, r) != left(p, q, s)
                    && left(r, s, p) != left(r, s, q)
            })
        })
    }

    /// The curve through the moved samples.
    fn moved(&self) -> MovedCurve {
        let graph = self.graph();
        let mut ways: Vec<(f64, f64)> = vec![(0.0, 0.0); self.locals.len()];
        for local in self.locals.iter().filter(|local| local.conforms()) {
            for sample in local.all() {
                if self.edges[sample as usize] == [None; 2] {
                    continue;
                }
                let from = self.triangulation.place(sample);
                let normal = self.locals[sample as usize].normal();
                let meeting =
                    normal.and_then(|normal| local.meeting(self.triangulation, from, normal));
                if let Some(way) = meeting {
                    let (sum, count) = &mut ways[sample as usize];
                    (*sum, *count) = (*sum + way, *count + 1.0);
                }
            }
        }
        let mut places = self.triangulation.samples().places().to_vec();
        let mut squares = Vec::new();
        for (sample, (sum, count)) in ways.into_iter().enumerate().filter(|(_, it)| it.1 > 0.0) {
            if let Some([x, y]) = self.locals[sample].normal() {
                let way = sum / count;
                let from = places[sample];
                places[sample] = [from[0] + way * x, from[1] + way * y];
                squares.push(distance_mm(from, places[sample]).powi(2));
            }
        }
        squares.sort_by(f64::total_cmp);
        let sigma_mm = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
        MovedCurve { graph, places_mm: places, sigma_mm }
    }
}

/// A sample is fitted with so many neighbours at most.
const MOST_NEIGHBOURS: usize = 40;
/// Ends of curves among so many nearest samples make a corner,
const NEAR_CORNER: usize = 8;
/// where they are seen less than 60° apart.
const CORNER_RAD: f64 = std::f64::consts::FRAC_PI_3;
