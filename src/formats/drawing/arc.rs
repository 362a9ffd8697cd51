//! Arcs as cubic Bézier curves.

use std::f64::consts::{PI, TAU};

use super::PlaceMm;

/// An arc of an ellipse: centre, half axes, the turn of its first axis, and where it begins, in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) centre: PlaceMm,
    pub(super) radii: [f64; 2],
    pub(super) turn: f64,
    pub(super) from: f64,
    /// How far it goes, counter-clockwise above 0 in the frame of the coordinates.
    pub(super) sweep: f64,
}

/// The widest angle of one piece: a Bézier curve then leaves its circle by 1e-9 of the radius at most.
const WIDEST: f64 = PI / 16.0;

impl Arc {
    /// The pieces of the arc.
    pub(super) fn pieces(&self) -> Vec<[PlaceMm; 4]> {
        let count = (self.sweep.abs() / WIDEST).ceil().clamp(1.0, 64.0);
        let step = self.sweep / count;
        // The length of the handles with which the middle of a piece lies on the circle.
        let handle = 4.0 / 3.0 * (step / 4.0).tan();
        let (turn_sin, turn_cos) = self.turn.sin_cos();
        let [rx, ry] = self.radii;
        let placed = |[x, y]: [f64; 2]| {
            let [x, y] = [rx * x, ry * y];
            [
                self.centre[0] + turn_cos * x - turn_sin * y,
                self.centre[1] + turn_sin * x + turn_cos * y,
            ]
        };
        (0..count as usize)
            .map(|index| {
                // The same at the end of a piece as at the beginning of the next.
                let angle = |index: usize| self.from + step * index as f64;
                let (s0, c0) = angle(index).sin_cos();
                let (s1, c1) = angle(index + 1).sin_cos();
                [
                    [c0, s0],
                    [c0 - handle * s0, s0 + handle * c0],
                    [c1 + handle * s1, s1 - handle * c1],
                    [c1, s1],
                ]
                .map(placed)
            })
            .collect()
    }

    /// The arc of SVG from one place to another (SVG 1.1, appendix F.6); `None` where it is a straight line.
    pub(super) fn between(
        from: PlaceMm,
        to: PlaceMm,
        radii: [f64; 2],
        turn: f64,
        [is_large, is_sweep]: [bool; 2],
    ) -> Option<Arc> {
        let [mut rx, mut ry] = radii.map(f64::abs);
        if rx == 0.0 || ry == 0.0 || from == to {
            return None;
        }
        let (sin, cos) = turn.sin_cos();
        let [dx, dy] = [0.5 * (from[0] - to[0]), 0.5 * (from[1] - to[1])];
        let [x, y] = [cos * dx + sin * dy, -sin * dx + cos * dy];
        let needed = (x / rx).powi(2) + (y / ry).powi(2);
        if needed > 1.0 {
            (rx, ry) = (rx * needed.sqrt(), ry * needed.sqrt());
        }
        let length = (rx * y).powi(2) + (ry * x).powi(2);
        let left = ((rx * ry).powi(2) - length).max(0.0) / length;
        let sign = if is_large == is_sweep { -1.0 } else { 1.0 };
        let [cx, cy] = [sign * left.sqrt() * rx * y / ry, -sign * left.sqrt() * ry * x / rx];
        let centre = [
            cos * cx - sin * cy + 0.5 * (from[0] + to[0]),
            sin * cx + cos * cy + 0.5 * (from[1] + to[1]),
        ];
        let angle = |px: f64, py: f64| ((py - cy) / ry).atan2((px - cx) / rx);
        let begin = angle(x, y);
        let mut sweep = angle(-x, -y) - begin;
        if is_sweep && sweep < 0.0 {
            sweep += TAU;
        }
        if !is_sweep && sweep > 0.0 {
            sweep -= TAU;
        }
        Some(Arc { centre, radii: [rx, ry], turn, from: begin, sweep })
    }
}
