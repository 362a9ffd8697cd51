//! Places of a square lattice that is refined where it must be.
//!
//! Level 0 has a spacing s. Each level adds the middles of the squares of the level before, so the spacing of level k is s/2^(k/2): the squares
//! of odd levels stand on a corner. Every level doubles the places, and none is measured twice.

use crate::PlanError;
use crate::error::positive;

/// A lattice about an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    origin_mm: [f64; 2],
    spacing_mm: f64,
}

/// A place of a lattice by whole numbers: multiples of the finest step.
pub(crate) type Node = [i64; 2];

impl Lattice {
    /// A lattice whose level 0 has this spacing in mm.
    ///
    /// # Errors
    ///
    /// When the spacing is no positive number or the origin not finite.
    pub fn new(origin_mm: [f64; 2], spacing_mm: f64) -> Result<Lattice, PlanError> {
        positive("spacing", spacing_mm, "give the spacing of the first scan in mm")?;
        if !origin_mm.iter().all(|mm| mm.is_finite()) {
            let found = format!("{origin_mm:?} mm");
            return Err(PlanError::new("origin", "two numbers", found, "give the origin in mm"));
        }
        Ok(Lattice { origin_mm, spacing_mm })
    }

    /// The spacing in mm once all places of a level are measured.
    pub fn spacing_mm(&self, level: u32) -> f64 {
        self.spacing_mm * (-0.5 * f64::from(level)).exp2()
    }

    /// The distance in mm of places of one level in a line along x.
    pub(crate) fn row_step_mm(&self, level: u32) -> f64 {
        if level == 0 { self.spacing_mm } else { 2.0 * self.step_mm(level) }
    }

    pub(crate) fn place_mm(&self, [i, j]: Node) -> [f64; 2] {
        let unit = self.spacing_mm / UNITS as f64;
        [self.origin_mm[0] + unit * i as f64, self.origin_mm[1] + unit * j as f64]
    }

    /// Places of one level within a box.
    pub(crate) fn nodes(&self, level: u32, [low, high]: [[f64; 2]; 2]) -> Vec<Node> {
        let step_mm = self.step_mm(level);
        let unit = units(level);
        let first = |axis: usize| ((low[axis] - self.origin_mm[axis]) / step_mm).ceil() as i64;
        let last = |axis: usize| ((high[axis] - self.origin_mm[axis]) / step_mm).floor() as i64;
        let mut nodes = Vec::new();
        for j in first(1)..=last(1) {
            for i in first(0)..=last(0) {
                if belongs(level, i, j) {
                    nodes.push([i * unit, j * unit]);
                }
            }
        }
        nodes
    }

    /// The four places of lower levels in whose middle a place stands; none of level 0.
    pub(crate) fn parents(level: u32, [i, j]: Node) -> Vec<Node> {
        let unit = units(level);
        match level {
            0 => Vec::new(),
            _ if level % 2 == 1 => [[-1, -1], [1, -1], [-1, 1], [1, 1]]
                .map(|[a, b]| [i + a * unit, j + b * unit])
                .to_vec(),
            _ => [[-1, 0], [1, 0], [0, -1], [0, 1]]
                .map(|[a, b]| [i + a * unit, j + b * unit])
                .to_vec(),
        }
    }

    /// The step of the coordinates of a level in mm.
    fn step_mm(&self, level: u32) -> f64 {
        self.spacing_mm / f64::from(1_u32 << level.div_ceil(2))
    }
}

/// Whether the level adds a place of its steps.
fn belongs(level: u32, i: i64, j: i64) -> bool {
    match level {
        0 => true,
        _ if level % 2 == 1 => i.rem_euclid(2) == 1 && j.rem_euclid(2) == 1,
        _ => (i + j).rem_euclid(2) == 1,
    }
}

/// Finest steps in a step of a level.
fn units(level: u32) -> i64 {
    UNITS >> level.div_ceil(2)
}

/// Finest steps in the spacing of level 0.
const UNITS: i64 = 1 << (HIGHEST_LEVEL / 2);

/// The finest level.
pub(crate) const HIGHEST_LEVEL: u32 = 40;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn levels_fill_finer_lattices_and_share_no_place() {
        let lattice = Lattice::new([0.25, -1.0], 2.0).unwrap();
        let within = [[-8.0, -8.0], [8.0, 8.0]];
        let mut all = BTreeSet::new();
        for level in 0..6 {
            let nodes = lattice.nodes(level, within);
            assert!(nodes.iter().all(|&node| all.insert(node)), "level {level} repeats a place");
            for &node in &nodes {
                // Parents stand as far away as the spacing of the level, and have lower levels.
                for parent in Lattice::parents(level, node) {
                    let [p, q] = [node, parent].map(|node| lattice.place_mm(node));
                    let mm = (p[0] - q[0]).hypot(p[1] - q[1]);
                    assert!((mm / lattice.spacing_mm(level) - 1.0).abs() < 1e-12);
                    let out = q.iter().any(|mm| mm.abs() > 8.0);
                    assert!(out || all.contains(&parent));
                }
            }
            // So many places fill the box at this spacing.
            let expected = 256.0 / lattice.spacing_mm(level).powi(2);
            assert!((all.len() as f64 / expected - 1.0).abs() < 0.2, "{level}: {}", all.len());
        }
    }
}
