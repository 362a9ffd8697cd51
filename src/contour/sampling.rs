//! How well samples show the curve that was found of them: ε, ρ, uniformity, and the condition of a method.

mod axis;
mod condition;

use rayon::prelude::*;

pub use self::axis::medial_axis_mm;
pub use self::condition::{Condition, Failure, Quantity, Verdict};
use crate::polylines::{Polylines, middle};
use crate::triangulation::distance_mm;
use crate::{Graph, PlaceMm, SampleId, Samples, Triangulation};

/// Sampling of a curve by the samples that it was found of, judged by the medial axis of the curve itself.
///
/// The medial axis is that of the samples: the Voronoi edges of all Delaunay edges but those of the curve
/// ([`medial_axis_mm`]). Its distances are right to 10⁻⁶ of them. Between two samples the curve is taken for an arc. So a feature that no sample shows is not seen, and
/// noise makes a curve look as rough as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveSampling {
    edges: Vec<EdgeSampling>,
    steps: Vec<Step>,
    ends_mm: Vec<PlaceMm>,
    least_lfs_mm: f64,
}

/// The sampling of the piece of curve between two samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeSampling {
    /// The place half way on the arc between the samples.
    pub at_mm: PlaceMm,
    /// The distance of that place to the samples over its local feature size.
    ///
    /// On a straight piece no place between has a larger ratio while this one is below 1, for the local feature size changes by no more
    /// than the way gone.
    pub epsilon: f64,
    /// The same distance over the reach: the least local feature size on the piece.
    pub rho: f64,
    /// The reach in mm; infinite where no medial axis is near.
    pub reach_mm: f64,
    /// Distance of the samples in mm.
    pub length_mm: f64,
}

/// Two pieces that follow each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The sample between them, mm.
    pub at_mm: PlaceMm,
    /// The longer edge over the shorter one.
    pub ratio: f64,
}

impl CurveSampling {
    /// The sampling of a curve found of samples; n·log n time.
    ///
    /// Samples without an edge do not belong to the curve, so the medial axis is made without them.
    pub fn new(triangulation: &Triangulation, curve: &Graph) -> CurveSampling {
        let samples = triangulation.samples();
        let count = samples.len();
        let axis = Polylines::of_sides(axis_without_alone(triangulation, curve)).nearly();
        let others = neighbours(curve, count);
        let bend = |sample: SampleId| match others[sample as usize][..] {
            [p, q] => Some((p, curvature(samples, [p, sample, q]))),
            _ => None,
        };
        let edges: Vec<EdgeSampling> = curve
            .edges()
            .par_iter()
            .map(|&[p, q]| {
                // Curvatures along the way from p to q: at each end it is that of the way that comes along the edge or leaves it.
                let bends = [(p, q, -1.0), (q, p, 1.0)].map(|(at, along, sign)| {
                    bend(at)
                        .map(|(from, bend)| if from == along { sign * bend } else { -sign * bend })
                });
                let ends = [p, q].map(|end| samples.places()[end as usize]);
                edge_sampling(&axis, ends, limited(bends))
            })
            .collect();
        let least_lfs_mm = edges.iter().map(|edge| edge.reach_mm).fold(f64::INFINITY, f64::min);
        let steps = (0..).zip(&others).filter_map(|(sample, others)| match others[..] {
            [p, q] => Some(step(samples, [p, sample, q])),
            _ => None,
        });
        CurveSampling {
            edges,
            steps: steps.collect(),
            ends_mm: places_of(samples, curve.ends(count)),
            least_lfs_mm,
        }
    }

    /// The pieces between samples, in the order of the edges of the curve.
    pub fn edges(&self) -> &[EdgeSampling] {
        &self.edges
    }

    /// The samples with two edges, and the ratio of the edges there.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The samples where the curve ends.
    pub fn ends_mm(&self) -> &[PlaceMm] {
        &self.ends_mm
    }

    /// The largest ε, and its piece; none without edges.
    pub fn epsilon(&self) -> Option<EdgeSampling> {
        largest(&self.edges, |edge| edge.epsilon)
    }

    /// The largest ρ, and its piece; none without edges.
    pub fn rho(&self) -> Option<EdgeSampling> {
        largest(&self.edges, |edge| edge.rho)
    }

    /// The largest ratio of edges that follow each other (u); none if no sample has two.
    pub fn uniformity(&self) -> Option<Step> {
        largest(&self.steps, |step| step.ratio)
    }

    /// The least local feature size on the curve in mm; infinite of a straight line.
    pub fn least_lfs_mm(&self) -> f64 {
        self.least_lfs_mm
    }

    /// Whether the samples meet a condition, and where they do not.
    pub fn against(&self, condition: &Condition) -> Verdict {
        condition.judge(self)
    }
}

/// The first of the items with the largest value.
fn largest<T: Copy>(items: &[T], value: impl Fn(&T) -> f64) -> Option<T> {
    let mut items = items.iter();
    let first = items.next()?;
    Some(*items.fold(first, |best, item| if value(item) > value(best) { item } else { best }))
}

fn places_of(samples: &Samples, of: Vec<SampleId>) -> Vec<PlaceMm> {
    of.into_iter().map(|sample| samples.places()[sample as usize]).collect()
}

/// The other ends of the edges at every sample.
fn neighbours(curve: &Graph, samples: usize) -> Vec<Vec<SampleId>> {
    let mut others = vec![Vec::new(); samples];
    for &[p, q] in curve.edges() {
        others[p as usize].push(q);
        others[q as usize].push(p);
    }
    others
}

/// The medial axis of the samples on a curve.
fn axis_without_alone(triangulation: &Triangulation, curve: &Graph) -> Vec<[PlaceMm; 2]> {
    let samples = triangulation.samples();
    let alone = curve.alone(samples.len());
    if alone.is_empty() {
        return medial_axis_mm(triangulation, curve);
    }
    let mut is_kept = vec![true; samples.len()];
    alone.iter().for_each(|&sample| is_kept[sample as usize] = false);
    // Samples are numbered by coordinates, so those that stay keep their order.
    let mut number = 0;
    let numbers: Vec<SampleId> = is_kept
        .iter()
        .map(|&is_kept| {
            number += SampleId::from(is_kept);
            number.saturating_sub(1)
        })
        .collect();
    let kept = samples.places().iter().zip(&is_kept).filter(|(_, is_kept)| **is_kept);
    let kept: Vec<PlaceMm> = kept.map(|(&place, _)| place).collect();
    // They are admitted already.
    let Ok(kept) = Samples::new(&kept) else { return Vec::new() };
    let edges = curve.edges().iter();
    let curve = Graph::new(edges.map(|edge| edge.map(|end| numbers[end as usize])));
    medial_axis_mm(&Triangulation::new(kept), &curve)
}

/// Curvature of the circle through three samples in 1/mm, above 0 where the way turns left.
fn curvature(samples: &Samples, way: [SampleId; 3]) -> f64 {
    let [a, b, c] = way.map(|sample| samples.places()[sample as usize]);
    let turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
    2.0 * turn / (distance_mm(a, b) * distance_mm(b, c) * distance_mm(a, c))
}

/// The bend between two samples from those at them: the smaller, none where they differ in direction.
///
/// A corner bends at its sample, not in the pieces beside it.
fn limited(bends: [Option<f64>; 2]) -> f64 {
    match bends {
        [Some(a), Some(b)] if a * b > 0.0 => {
            if a.abs() < b.abs() {
                a
            } else {
                b
            }
        }
        [Some(_), Some(_)] | [None, None] => 0.0,
        [Some(bend), None] | [None, Some(bend)] => bend,
    }
}

/// The sampling of an arc of a curvature in 1/mm between two places, above 0 where it turns left.
fn edge_sampling(axis: &Polylines, [p, q]: [PlaceMm; 2], curvature: f64) -> EdgeSampling {
    let length_mm = distance_mm(p, q);
    let half_mm = 0.5 * length_mm;
    let sine = (half_mm * curvature).clamp(-1.0, 1.0);
    let rise_mm = half_mm * sine / (1.0 + (1.0 - sine * sine).sqrt());
    let [x, y] = middle(p, q);
    // An arc that turns left lies right of its chord.
    let right = [(q[1] - p[1]) / length_mm, (p[0] - q[0]) / length_mm];
    let at_mm = [x + rise_mm * right[0], y + rise_mm * right[1]];
    let to_sample_mm = distance_mm(p, at_mm);
    let lfs_mm = axis.distance_mm(at_mm).unwrap_or(f64::INFINITY);
    let reach_mm = [[p, at_mm], [at_mm, q]]
        .into_iter()
        .filter_map(|half| axis.distance_to_side_mm(half))
        .fold(lfs_mm, f64::min);
    EdgeSampling {
        at_mm,
        epsilon: to_sample_mm / lfs_mm,
        rho: to_sample_mm / reach_mm,
        reach_mm,
        length_mm,
    }
}

fn step(samples: &Samples, way: [SampleId; 3]) -> Step {
    let [a, b, c] = way.map(|sample| samples.places()[sample as usize]);
    let [before_mm, after_mm] = [distance_mm(a, b), distance_mm(b, c)];
    Step { at_mm: b, ratio: before_mm.max(after_mm) / before_mm.min(after_mm) }
}
