//! Samples and figures of merit of the comparison of methods, for curves and for regions: no data needed.

mod drawn;
mod regions;

use std::f64::consts::TAU;

use asphera_geometry::Numbers;

pub use self::drawn::{Drawing, DrawingError};
pub use self::regions::{Distribution, RegionScore, RegionTrial, Shape};
use crate::sampler::{BezierLine, Disturbance, Spacing, TrueCurve};
use crate::{
    Choice, Deviation, FoundCurve, Graph, Method, MethodError, Parameters, PlaceMm, Samples,
    Triangulation, agreement,
};

/// What is hard about samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Smooth curves sampled as sparsely as ε = 0.3 lets them be: spacing differs along the curve.
    NonUniform,
    /// Noise of 0.3 % of the box on dense samples.
    UniformNoise,
    /// Noise of a tenth of the local feature size on samples of ε = 0.1.
    NonUniformNoise,
    /// Outliers, 5 % of dense samples.
    Outliers,
    /// Closed curves sampled at ρ = 1.2, beyond what is proven: the outcome should still be closed.
    Manifold,
    /// Curves that cross themselves.
    NonManifold,
    /// Polygons with sharp corners.
    Sharp,
    /// Open curves.
    Open,
    /// Several closed curves.
    Multiple,
}

/// Figures of a method on one set of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Root mean square distance of the lines to the curve and back, over the diagonal of the box round it; infinite of no line.
    pub rms: f64,
    /// Harmonic mean of precision and recall of the edges.
    pub f: f64,
    /// Share of the samples with two edges.
    pub two_edges: f64,
}

/// One set of samples with its truth.
pub struct Trial {
    /// The samples.
    pub triangulation: Triangulation,
    truth: Graph,
    lines_mm: Vec<(Vec<PlaceMm>, bool)>,
    diagonal_mm: f64,
}

impl Category {
    /// All of them.
    pub const ALL: [Category; 9] = [
        Category::NonUniform,
        Category::UniformNoise,
        Category::NonUniformNoise,
        Category::Outliers,
        Category::Manifold,
        Category::NonManifold,
        Category::Sharp,
        Category::Open,
        Category::Multiple,
    ];

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Category::NonUniform => "non-uniform",
            Category::UniformNoise => "uniform-noise",
            Category::NonUniformNoise => "non-uniform-noise",
            Category::Outliers => "outliers",
            Category::Manifold => "manifold",
            Category::NonManifold => "non-manifold",
            Category::Sharp => "sharp",
            Category::Open => "open",
            Category::Multiple => "multiple",
        }
    }

    /// The best two methods of the ECCV 2022 tutorial "Outline and Shape Reconstruction in 2D", best first, by their names here or there.
    pub fn published_best(&self) -> [&'static str; 2] {
        match self {
            Category::NonUniform => ["hnn-crust", "peel"],
            Category::UniformNoise => ["discur", "vicur"],
            Category::NonUniformNoise => ["stretch-denoise", "connect2d"],
            Category::Outliers => ["hnn-crust", "crust"],
            Category::Manifold => ["connect2d", "crawl"],
            Category::NonManifold => ["crust", "lenz"],
            Category::Sharp => ["gathan-g", "connect2d"],
            Category::Open => ["vicur", "hnn-crust"],
            Category::Multiple => ["peel", "hnn-crust"],
        }
    }

    /// A set of samples; the same seed and number give the same.
    pub fn trial(&self, seed: u64, number: u32) -> Trial {
        let numbers = Numbers::new(seed, number, 16);
        let lines = self.lines(&numbers);
        self.sampled(|spacing| TrueCurve::of_beziers(&lines, spacing), 2e-4, (seed, number))
    }

    /// Samples of a curve that is as fine as it is asked for; dense ones have the chord.
    fn sampled(
        &self,
        curve: impl Fn(&Spacing) -> TrueCurve,
        chord_mm: f64,
        (seed, number): (u64, u32),
    ) -> Trial {
        let by = |epsilon: Option<f64>, rho: Option<f64>| Spacing { epsilon, rho, chord_mm: None };
        let dense = Spacing { chord_mm: Some(chord_mm), ..Spacing::default() };
        let spacing = match self {
            Category::UniformNoise | Category::Outliers => dense,
            Category::NonUniformNoise => by(Some(0.1), None),
            Category::Manifold => by(None, Some(1.2)),
            Category::Sharp => by(Some(0.5), None),
            _ => by(Some(0.3), None),
        };
        let still =
            Disturbance { seed: seed.wrapping_add(u64::from(number)), ..Disturbance::default() };
        let disturbance = match self {
            Category::UniformNoise => Disturbance { of_box: 0.003, ..still },
            Category::NonUniformNoise => Disturbance { of_lfs: 0.1, ..still },
            Category::Outliers => Disturbance { outliers_percent: 5.0, ..still },
            _ => still,
        };
        let curve = curve(&spacing);
        let points = disturbance.apply(&curve, &curve.sampled(&spacing));
        // Made here: finite and few.
        let samples =
            Samples::new(&points.points_mm).unwrap_or_else(|_| unreachable!("finite places"));
        let edges = points.edges.iter().map(|edge| edge.map(|row| samples.of_row(row as usize)));
        Trial {
            truth: Graph::new(edges),
            triangulation: Triangulation::new(samples),
            lines_mm: curve.lines_mm(),
            diagonal_mm: curve.diagonal_mm(),
        }
    }

    fn lines(&self, numbers: &Numbers) -> Vec<BezierLine> {
        let between =
            |index: usize, low: f64, high: f64| low + (high - low) * numbers.uniform(index);
        let spline = |first: usize, middle: PlaceMm, size: f64, closed: bool| {
            let count = 9;
            let corners = (0..count).map(|index| {
                let (sin, cos) = (TAU * index as f64 / count as f64).sin_cos();
                let radius = size * between(first + index, 0.5, 1.0);
                [middle[0] + radius * cos, middle[1] + radius * sin]
            });
            smooth(&corners.collect::<Vec<_>>(), closed)
        };
        match self {
            Category::Sharp => {
                let count = 5 + (between(0, 0.0, 4.0) as usize);
                let corners = (0..2 * count).map(|index| {
                    let (sin, cos) = (TAU * index as f64 / (2 * count) as f64).sin_cos();
                    let inner = between(index + 1, 0.4, 0.6);
                    let radius = 10.0 * if index % 2 == 0 { 1.0 } else { inner };
                    [radius * cos, radius * sin]
                });
                vec![BezierLine::through(&corners.collect::<Vec<_>>(), true)]
            }
            Category::Open => vec![spline(0, [0.0; 2], 10.0, false)],
            Category::Multiple => (0..4)
                .map(|index| {
                    let place = [22.0 * f64::from(index % 2), 22.0 * f64::from(index / 2)];
                    spline(20 * index as usize, place, 10.0, true)
                })
                .collect(),
            Category::NonManifold => {
                // A figure of eight, stretched and turned at random.
                let stretch = between(0, 0.5, 1.0);
                let corners = (0..32).map(|index| {
                    let angle = TAU * f64::from(index) / 32.0;
                    [10.0 * angle.sin(), 10.0 * stretch * (2.0 * angle).sin() + 0.1]
                });
                vec![smooth(&corners.collect::<Vec<_>>(), true)]
            }
            _ => vec![spline(0, [0.0; 2], 10.0, true)],
        }
    }
}

impl Trial {
    /// The figures of a method with its defaults; [`Method::Auto`] is the choice by the points.
    ///
    /// # Errors
    ///
    /// As [`Method::run`].
    pub fn score(&self, method: Method) -> Result<Score, MethodError> {
        let set = &self.triangulation;
        let chosen = (method == Method::Auto).then(|| Choice::new(set).curve(set)).flatten();
        let found = match chosen {
            Some(found) => found,
            None => method.curve(set, &Parameters::new())?,
        };
        Ok(self.score_of(&found))
    }

    fn score_of(&self, found: &FoundCurve) -> Score {
        let set = &self.triangulation;
        let places = found.places_mm.as_deref().unwrap_or(set.samples().places());
        let chains = found.graph.chains(set.len()).into_iter();
        let lines: Vec<(Vec<PlaceMm>, bool)> = chains
            .map(|chain| {
                let places = chain.samples.iter().map(|&sample| places[sample as usize]);
                (places.collect(), chain.closed)
            })
            .collect();
        let rms_mm = match lines.is_empty() {
            true => None,
            false => Deviation::between_lines(&lines, &self.lines_mm).map(|it| it.rms_mm),
        };
        let agreement = agreement(&found.graph, &self.truth);
        let (p, r) = (agreement.precision, agreement.recall);
        let degrees = found.graph.degrees(set.len());
        let two = degrees.iter().filter(|degree| **degree == 2).count();
        Score {
            rms: rms_mm.map_or(f64::INFINITY, |rms_mm| rms_mm / self.diagonal_mm),
            f: if p + r > 0.0 { 2.0 * p * r / (p + r) } else { 0.0 },
            two_edges: two as f64 / degrees.len() as f64,
        }
    }
}

/// The cardinal spline through corners.
fn smooth(corners: &[PlaceMm], closed: bool) -> BezierLine {
    let count = corners.len();
    let at = |index: usize| match closed {
        true => corners[index % count],
        // Beyond an end of an open line lies the end.
        false => corners[index.saturating_sub(count).min(count - 1)],
    };
    let shift = count;
    let slope = |index: usize| {
        let [before, after] = [at(shift + index - 1), at(shift + index + 1)];
        [(after[0] - before[0]) / 6.0, (after[1] - before[1]) / 6.0]
    };
    let pieces = if closed { count } else { count - 1 };
    let piece = |index: usize| {
        let ([p, q], [s, t]) =
            ([at(shift + index), at(shift + index + 1)], [slope(index), slope(index + 1)]);
        [p, [p[0] + s[0], p[1] + s[1]], [q[0] - t[0], q[1] - t[1]], q]
    };
    BezierLine { pieces: (0..pieces).map(piece).collect(), closed }
}
