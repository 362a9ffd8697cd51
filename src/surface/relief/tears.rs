//! Torn rings: where the neighbours of a sample lie on two levels by turns.
//!
//! The samples about a vertex, its ring in the mesh, are split by height at the widest gap between
//! them. Where the surface steps up or down, whatever the course of the step, the ring passes from
//! one level to the other and back. Where two sheets lie one above the other, their samples mix in
//! the projection, and the ring passes several times, or the vertex is alone on its level:
//!
//! ```text
//!        step                 fold                  spike
//!     ▲   ▲   ▽            ▲   ▽   ▲              ▽   ▽   ▽
//!       ▲   ▽                ▲   ▽                  ▲   ▽
//!     ▲   ▲   ▽            ▽   ▲   ▽              ▽   ▽   ▽
//! ```
//!
//! A vertex is *torn* if its ring changes level more than twice, and *alone* if all neighbours lie on
//! the other level. If every sample is on one of two levels at random, with the share q on one of
//! them, a vertex with six neighbours is torn with probability 9q²p⁴ + 14q³p³ + 9q⁴p², p = 1-q:
//! that is how many of the 64 rings change level at least four times. It is alone there with
//! probability p⁶. A torn vertex may still belong to a line that stands off; but between two
//! sheets torn vertices of both are neighbours. Those are *entangled*. So are samples that stand
//! one above the other but for rounding.
//!
//! A few wrong readings are alone, and sheets are entangled unless one is rare. Counted over 40,000
//! scattered samples, there were as many entangled as alone vertices at q = 0.18, half as many at
//! q = 0.14, a fifth at q = 0.1; if the samples off the first level have all kinds of heights, as
//! many at q = 0.23 and half as many at q = 0.18.

use asphera_geometry::{PointMm, VertexId};

use super::steep::Spokes;

/// What the rings of the vertices with spokes say.
pub(crate) struct Tears {
    /// For each slot: the highest height in mm of the lower level, if its ring has two levels.
    floor_mm: Vec<Option<f64>>,
    alone: Vec<bool>,
    entangled: Vec<bool>,
}

impl Tears {
    /// `rise_mm` for each slot: the smallest gap between two levels.
    pub(crate) fn find(points: &[PointMm], spokes: &Spokes, rise_mm: &[f64]) -> Tears {
        let floor_mm: Vec<Option<f64>> = (0..spokes.len())
            .map(|slot| {
                let vertices = spokes.neighbours(slot).iter().chain([&spokes.vertices[slot]]);
                let heights = vertices.map(|&vertex| points[vertex as usize][2]).collect();
                widest_gap(heights).filter(|gap| gap.mm >= rise_mm[slot]).map(|gap| gap.floor_mm)
            })
            .collect();
        let mut tears = Tears { floor_mm, alone: Vec::new(), entangled: Vec::new() };
        let torn: Vec<bool> =
            (0..spokes.len()).map(|slot| tears.is_torn(points, spokes, slot)).collect();
        tears.alone = (0..spokes.len()).map(|slot| tears.is_alone(points, spokes, slot)).collect();
        tears.entangled = (0..spokes.len())
            .map(|slot| {
                let mut others = spokes
                    .neighbours(slot)
                    .iter()
                    .filter(|&&vertex| tears.on_other_level(points, spokes, slot, vertex));
                torn[slot] && others.any(|&vertex| spokes.slot(vertex).is_some_and(|at| torn[at]))
                    || is_stacked(points, spokes, slot, rise_mm[slot])
            })
            .collect();
        tears
    }

    /// Whether the vertex is torn and so is a neighbour on the other level, or a neighbour stands
    /// right above or below it.
    pub(crate) fn entangled(&self, slot: usize) -> bool {
        self.entangled[slot]
    }

    /// Whether all neighbours of the vertex are on the other level.
    pub(crate) fn alone(&self, slot: usize) -> bool {
        self.alone[slot]
    }

    /// Whether the ring of `slot` has two levels and `neighbour` is not on that of its vertex.
    pub(crate) fn on_other_level(
        &self,
        points: &[PointMm],
        spokes: &Spokes,
        slot: usize,
        neighbour: VertexId,
    ) -> bool {
        self.floor_mm[slot].is_some_and(|floor_mm| {
            let low = |vertex: VertexId| points[vertex as usize][2] <= floor_mm;
            low(neighbour) != low(spokes.vertices[slot])
        })
    }

    fn is_torn(&self, points: &[PointMm], spokes: &Spokes, slot: usize) -> bool {
        let other = |vertex: VertexId| self.on_other_level(points, spokes, slot, vertex);
        let ring = spokes.opposite(slot).iter();
        ring.filter(|&&[from, to]| other(from) != other(to)).count() > 2
    }

    fn is_alone(&self, points: &[PointMm], spokes: &Spokes, slot: usize) -> bool {
        let mut neighbours = spokes.neighbours(slot).iter();
        neighbours.all(|&neighbour| self.on_other_level(points, spokes, slot, neighbour))
    }
}

/// Whether a neighbour stands above or below the vertex by at least `rise_mm`, at a way in the plane
/// of less than [`STACKED_SHARE`] of the median to all neighbours.
fn is_stacked(points: &[PointMm], spokes: &Spokes, slot: usize, rise_mm: f64) -> bool {
    let from = points[spokes.vertices[slot] as usize];
    let way_mm = |vertex: VertexId| {
        let to = points[vertex as usize];
        (to[0] - from[0]).hypot(to[1] - from[1])
    };
    let mut ways_mm: Vec<f64> = spokes.neighbours(slot).iter().map(|&to| way_mm(to)).collect();
    let middle = ways_mm.len() / 2;
    let limit_mm = STACKED_SHARE * *ways_mm.select_nth_unstable_by(middle, f64::total_cmp).1;
    spokes.neighbours(slot).iter().any(|&vertex| {
        way_mm(vertex) < limit_mm && (points[vertex as usize][2] - from[2]).abs() >= rise_mm
    })
}

struct Gap {
    mm: f64,
    /// Its lower end.
    floor_mm: f64,
}

/// The widest gap between consecutive heights; the lowest of several.
fn widest_gap(mut heights_mm: Vec<f64>) -> Option<Gap> {
    heights_mm.sort_unstable_by(f64::total_cmp);
    let gaps = heights_mm.windows(2).map(|pair| Gap { mm: pair[1] - pair[0], floor_mm: pair[0] });
    gaps.reduce(|widest, gap| if gap.mm > widest.mm { gap } else { widest })
}

/// Two samples stand one above the other if they are nearer in the plane than this share of the way
/// to other neighbours.
///
/// Wide enough for coordinates that went through a rotation, and too narrow for the rim of a
/// hemisphere: at the foot of n rows from pole to rim two rows are apart by some 1/(6n) of the way
/// along the row.
const STACKED_SHARE: f64 = 1e-6;
