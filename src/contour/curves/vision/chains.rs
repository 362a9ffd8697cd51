//! Chains that grow, with the statistics of their edges.

use super::angle_rad;
use crate::graphs::Sets;
use crate::triangulation::distance_mm;
use crate::{Graph, SampleId, Triangulation};

/// Samples joined to chains: at most two edges each.
pub(super) struct Chains<'a> {
    triangulation: &'a Triangulation,
    others: Vec<[Option<SampleId>; 2]>,
    /// How many edges each sample has: most questions are about that alone.
    degrees: Vec<u8>,
    sets: Sets,
    /// Of each chain, where the sample that stands for it is.
    statistics: Vec<Statistics>,
}

/// Sums over a chain.
#[derive(Clone, Copy, Default)]
struct Statistics {
    edges: f64,
    mean_mm: f64,
    /// Sum of the squared differences from the mean, mm².
    squares_mm2: f64,
    angles: f64,
    angle_sum_rad: f64,
}

impl<'a> Chains<'a> {
    pub(super) fn new(triangulation: &'a Triangulation) -> Chains<'a> {
        let count = triangulation.len();
        Chains {
            triangulation,
            others: vec![[None; 2]; count],
            degrees: vec![0; count],
            sets: Sets::new(count),
            statistics: vec![Statistics::default(); count],
        }
    }

    /// How many edges a sample has.
    pub(super) fn degree(&self, sample: SampleId) -> usize {
        usize::from(self.degrees[sample as usize])
    }

    /// The sample that an end of a chain is joined to; none of a sample alone.
    pub(super) fn other(&self, end: SampleId) -> Option<SampleId> {
        self.others[end as usize][0]
    }

    /// Mean and standard deviation (of n - 1) of the edge lengths of a sample's chain in mm.
    pub(super) fn lengths(&self, sample: SampleId) -> (f64, f64) {
        let statistics = self.statistics[self.sets.find(sample) as usize];
        let deviation_mm = match statistics.edges > 1.0 {
            true => (statistics.squares_mm2 / (statistics.edges - 1.0)).max(0.0).sqrt(),
            false => 0.0,
        };
        (statistics.mean_mm, deviation_mm)
    }

    /// The mean angle between neighbouring edges of a sample's chain in radians; π if there is none.
    pub(super) fn angle_rad(&self, sample: SampleId) -> f64 {
        let statistics = self.statistics[self.sets.find(sample) as usize];
        match statistics.angles > 0.0 {
            true => statistics.angle_sum_rad / statistics.angles,
            false => std::f64::consts::PI,
        }
    }

    /// Joins two samples with fewer than two edges each.
    pub(super) fn join(&mut self, p: SampleId, q: SampleId) {
        let [at_p, at_q] = [p, q].map(|sample| self.triangulation.place(sample));
        let mut own = Statistics::default();
        own.add_length(distance_mm(at_p, at_q));
        for (at, to) in [(p, q), (q, p)] {
            if let Some(last) = self.other(at) {
                let [at, to, last] = [at, to, last].map(|sample| self.triangulation.place(sample));
                own.angles += 1.0;
                own.angle_sum_rad += angle_rad(at, to, last);
            }
        }
        let [of_p, of_q] = [p, q].map(|sample| self.sets.of(sample));
        let mut joined = self.statistics[of_p.min(of_q) as usize];
        if self.sets.join(p, q) {
            joined.unite(&self.statistics[of_p.max(of_q) as usize]);
        }
        joined.unite(&own);
        let stands = self.sets.of(p);
        self.statistics[stands as usize] = joined;
        for (at, to) in [(p, q), (q, p)] {
            self.degrees[at as usize] += 1;
            let others = &mut self.others[at as usize];
            *(if others[0].is_none() { &mut others[0] } else { &mut others[1] }) = Some(to);
        }
    }

    /// The edges.
    pub(super) fn graph(&self) -> Graph {
        let edges = (0..).zip(&self.others);
        Graph::new(
            edges.flat_map(|(at, others)| others.iter().flatten().map(move |&other| [at, other])),
        )
    }
}

impl Statistics {
    fn add_length(&mut self, length_mm: f64) {
        *self = Statistics { edges: 1.0, mean_mm: length_mm, ..*self };
    }

    /// Those of two chains together (T. F. Chan, G. H. Golub, R. J. LeVeque, COMPSTAT 1982, 30-41).
    fn unite(&mut self, other: &Statistics) {
        let edges = self.edges + other.edges;
        if edges > 0.0 {
            let apart_mm = other.mean_mm - self.mean_mm;
            self.squares_mm2 +=
                other.squares_mm2 + apart_mm * apart_mm * (self.edges * other.edges / edges);
            self.mean_mm += apart_mm * (other.edges / edges);
        }
        self.edges = edges;
        self.angles += other.angles;
        self.angle_sum_rad += other.angle_sum_rad;
    }
}
