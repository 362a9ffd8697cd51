//! Where the middle of the rings lies, if not on the axis: a part is turned about one place and cut out, or measured, about
//! another.
//!
//! Rings f about a place c near the axis leave f(|p − c|) − f(|p|) ≈ −f′ c·û of what is alike about the axis, up in half of
//! the sectors and down in the others. By least squares over all means that gives c, and better about each c found. What a
//! defect adds to some means is far from that: it is cut down to what noise may add.

use nalgebra::{Matrix2, Vector2};

use super::sectors::Sectors;
use crate::defects::tail;

/// How much farther from the axis the middle of the rings lies than was assumed, in nodes; `None` where no ring tells. `left`
/// is what the profile, by nodes outwards, leaves of the sectors. Nodes before `first` do not count.
pub(super) fn off_centre(profile_mm: &[f64], left: &Sectors, first: usize) -> Option<[f64; 2]> {
    let lines: Vec<Line> = left
        .means
        .iter()
        .enumerate()
        .flat_map(|(sector, means)| {
            let (y, x) = Sectors::middle_of(sector).sin_cos();
            let nodes = first..(profile_mm.len() - 1).min(means.len());
            nodes.map(move |node| {
                let steepness = 0.5 * (profile_mm[node + 1] - profile_mm[node - 1]);
                let root = means[node].weight.sqrt();
                let lift = -root * steepness * Vector2::new(x, y);
                Line { lift, height: root * means[node].height_mm }
            })
        })
        .filter(|line| line.lift != Vector2::zeros())
        .collect();
    let normal: Matrix2<f64> = lines.iter().map(|line| line.lift * line.lift.transpose()).sum();
    let factor = normal.cholesky()?;
    let (mut found, mut most) = (Vector2::zeros(), f64::INFINITY);
    for _ in 0..ROUNDS {
        let step = |line: &Line| line.lift * line.off(&found).clamp(-most, most);
        found += factor.solve(&lines.iter().map(step).sum::<Vector2<f64>>());
        let mut sizes: Vec<f64> = lines.iter().map(|line| line.off(&found).abs()).collect();
        most = CALM * tail::scale(&mut sizes)?;
    }
    (found.x.is_finite() && found.y.is_finite()).then_some([found.x, found.y])
}

/// A mean over its standard deviation, but for a factor that all have.
struct Line {
    /// What a middle one node farther along x and y adds.
    lift: Vector2<f64>,
    height: f64,
}

impl Line {
    fn off(&self, centre: &Vector2<f64>) -> f64 {
        self.height - self.lift.dot(centre)
    }
}

/// Rounds in which what is far off is cut down.
const ROUNDS: usize = 5;
/// Standard deviations to which it is.
const CALM: f64 = 3.0;
