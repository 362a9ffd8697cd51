//! Triangles inside and outside.

use std::collections::VecDeque;

use crate::Triangulation;
use crate::triangulation::{EdgeId, TriangleId};

/// Whether each triangle lies inside. What lies beyond the hull is outside.
pub(crate) struct Inside {
    inside: Vec<bool>,
}

impl Inside {
    /// The triangles for which `is_inside` is true.
    pub(crate) fn of(is_inside: Vec<bool>) -> Inside {
        Inside { inside: is_inside }
    }

    /// All triangles that cannot be reached from beyond the hull without crossing a wall.
    pub(crate) fn within(triangulation: &Triangulation, walls: &[bool]) -> Inside {
        let levels = levels(triangulation, walls);
        Inside { inside: levels.into_iter().map(|level| level > 0).collect() }
    }

    /// All triangles for which the least number of walls on a way from beyond the hull is odd.
    pub(crate) fn by_parity(triangulation: &Triangulation, walls: &[bool]) -> Inside {
        let levels = levels(triangulation, walls);
        Inside { inside: levels.into_iter().map(|level| level % 2 == 1).collect() }
    }

    /// 1 of each triangle inside, 0 of the others.
    pub(crate) fn labels(&self) -> Vec<u32> {
        self.inside.iter().map(|&is_inside| u32::from(is_inside)).collect()
    }

    /// Whether a triangle lies inside; beyond the hull nothing does.
    pub(crate) fn holds(&self, triangle: Option<TriangleId>) -> bool {
        triangle.is_some_and(|triangle| self.inside[triangle as usize])
    }

    /// Moves a triangle to the inside or outside.
    pub(crate) fn set(&mut self, triangle: TriangleId, is_inside: bool) {
        self.inside[triangle as usize] = is_inside;
    }

    /// Fills what is outside but cannot be reached from beyond the hull through the outside.
    pub(crate) fn fill_pockets(&mut self, triangulation: &Triangulation) {
        let borders: Vec<bool> = (0..triangulation.edges().len() as EdgeId)
            .map(|edge| self.is_border(triangulation, edge))
            .collect();
        *self = Inside::within(triangulation, &borders);
    }

    /// Whether an edge parts inside from outside.
    pub(crate) fn is_border(&self, triangulation: &Triangulation, edge: EdgeId) -> bool {
        let [left, right] = triangulation.edges()[edge as usize].triangles();
        self.holds(left) != self.holds(right)
    }
}

/// The least number of walls on a way from beyond the hull to each triangle.
fn levels(triangulation: &Triangulation, walls: &[bool]) -> Vec<u32> {
    let mut levels = vec![u32::MAX; triangulation.triangles().len()];
    let mut queue: VecDeque<(TriangleId, u32)> = VecDeque::new();
    let mut offer = |queue: &mut VecDeque<_>, triangle: TriangleId, level: u32, is_wall: bool| {
        let level = level + u32::from(is_wall);
        if level < levels[triangle as usize] {
            levels[triangle as usize] = level;
            // Those without a wall between come first, so levels leave the queue in order.
            if is_wall {
                queue.push_back((triangle, level));
            } else {
                queue.push_front((triangle, level));
            }
        }
    };
    let mut hull = Vec::new();
    for (edge, is_wall) in triangulation.edges().iter().zip(walls) {
        if let [Some(triangle), None] | [None, Some(triangle)] = edge.triangles() {
            hull.push((*is_wall, triangle));
        }
    }
    hull.sort_unstable();
    for (is_wall, triangle) in hull {
        offer(&mut queue, triangle, 0, is_wall);
    }
    // The queue begins with level 0 in front of level 1, and keeps that order.
    while let Some((triangle, level)) = queue.pop_front() {
        let beyond = triangulation.across(triangle).into_iter().zip(triangulation.sides(triangle));
        for (next, side) in beyond {
            if let Some(next) = next {
                offer(&mut queue, next, level, walls[side as usize]);
            }
        }
    }
    levels
}
