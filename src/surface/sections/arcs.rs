//! A circle's arcs, laid out by their angle from where the section starts.

use std::f64::consts::TAU;

use asphera_geometry::VertexId;
use asphera_geometry::predicates::Place;
use asphera_mesh::Mesh;

use super::circle::{Arc, Circuit, follow};
use super::disc::Disc;
use super::pieces::{Builder, Limit, SectionPoint, Source};

/// Adds the section over a circle that starts in the direction `start` from the centre, which has
/// the angle `start_rad`.
pub(super) fn lay_out<K: FnMut([VertexId; 3]) -> bool>(
    mesh: &Mesh,
    disc: &Disc,
    start: [f64; 2],
    start_rad: f64,
    builder: &mut Builder<'_, K>,
) {
    let turn = Turn { mesh, disc, start, start_rad };
    let arcs = match follow(mesh, disc, turn.place(0.0)) {
        Circuit::Nothing => return,
        Circuit::Within(corners) => {
            let from = turn.between(builder, 0.0, corners);
            turn.add(builder, from, TAU, from, corners);
            builder.end(Limit::Path);
            builder.join_ends();
            return;
        }
        Circuit::Arcs(arcs) if arcs.is_empty() => return,
        Circuit::Arcs(arcs) => arcs,
    };
    let spans = turn.spans(&arcs);
    // The first in order is the one that begins first after the start of the section, unless it is
    // one that passes the start: that one ends the section, and its second part begins it.
    let before = |index: usize| (index + arcs.len() - 1) % arcs.len();
    let mut first =
        (0..arcs.len()).min_by(|&i, &j| spans[i][0].total_cmp(&spans[j][0])).unwrap_or(0);
    // Of several so short that they begin there all, the one before which none does.
    for _ in 1..arcs.len() {
        if spans[before(first)][0] == spans[first][0] {
            first = before(first);
        }
    }
    let last = before(first);
    let over = (spans[last][1] > TAU).then(|| turn.between(builder, 0.0, arcs[last].corners));
    if let Some(from) = over {
        let arc = &arcs[last];
        let end = spans[last][1] - TAU;
        let to = builder.point(0.0, arc.to);
        turn.add(builder, from, end, to, arc.corners);
    }
    for (step, index) in (0..arcs.len()).map(|step| (step, (first + step) % arcs.len())) {
        let arc = &arcs[index];
        if !arc.follows {
            builder.end(Limit::Hull);
            builder.begin(Limit::Hull);
        } else if step == 0 && over.is_none() {
            builder.begin(Limit::Path);
        }
        let [begin, end] = spans[index];
        let from = builder.point(turn.s_mm(begin), arc.from);
        let to = match over {
            Some(start) if index == last => start,
            _ => builder.point(0.0, arc.to),
        };
        turn.add(builder, from, end.min(TAU), to, arc.corners);
    }
    // Where the last arc ends at the start, the first one tells whether the mesh does, too.
    let ends_at_start = over.is_some() || arcs[first].follows;
    builder.end(if ends_at_start { Limit::Path } else { Limit::Hull });
    if arcs.iter().all(|arc| arc.follows) {
        builder.join_ends();
    }
}

/// The circle, seen from where the section starts.
struct Turn<'a> {
    mesh: &'a Mesh,
    disc: &'a Disc,
    start: [f64; 2],
    start_rad: f64,
}

impl Turn<'_> {
    /// The angles at which each arc begins and ends, from the start of the section on: from 0 to
    /// below a turn, and up to a turn more.
    fn spans(&self, arcs: &[Arc]) -> Vec<[f64; 2]> {
        let mut spans: Vec<[f64; 2]> = Vec::with_capacity(arcs.len());
        let mut sum = 0.0;
        for arc in arcs {
            let [begin, end] = [arc.from, arc.to].map(|source| self.angle(source));
            let mut length = (end - begin).rem_euclid(TAU);
            if length > 0.75 * TAU && !arc.may_be_long {
                length = 0.0;
            }
            sum += length;
            spans.push([begin, begin + length]);
        }
        // All arcs together make a turn at most. If they seem to make more, a vanishing one was
        // taken for a whole turn.
        while sum > 1.5 * TAU
            && let Some(span) =
                spans.iter_mut().max_by(|p, q| (p[1] - p[0]).total_cmp(&(q[1] - q[0])))
        {
            sum -= span[1] - span[0];
            span[1] = span[0];
        }
        for span in &mut spans {
            if (span[1] - TAU).abs() < SAME_ANGLE {
                span[1] = TAU;
            }
        }
        spans
    }

    /// The angle of a point of the circle, from 0 to below a turn.
    fn angle(&self, source: Source) -> f64 {
        let [x, y, _] = source.at_mm(self.mesh.points());
        let [x, y] = [x - self.disc.centre[0], y - self.disc.centre[1]];
        let [cos, sin] = self.start;
        let angle = (cos * y - sin * x).atan2(cos * x + sin * y).rem_euclid(TAU);
        if (SAME_ANGLE..=TAU - SAME_ANGLE).contains(&angle) { angle } else { 0.0 }
    }

    /// The place on the circle at an angle from the start.
    fn place(&self, angle: f64) -> Place {
        let [cos, sin] = if angle == 0.0 {
            self.start
        } else {
            let (sin, cos) = (self.start_rad + angle).sin_cos();
            [cos, sin]
        };
        let radius = self.disc.radius_mm;
        [self.disc.centre[0] + radius * cos, self.disc.centre[1] + radius * sin]
    }

    fn s_mm(&self, angle: f64) -> f64 {
        self.disc.radius_mm * angle
    }

    /// The point at an angle, in a triangle.
    fn between<K: FnMut([VertexId; 3]) -> bool>(
        &self,
        builder: &Builder<'_, K>,
        angle: f64,
        corners: [VertexId; 3],
    ) -> SectionPoint {
        let [x, y] = self.place(angle);
        // The triangle beyond an edge may be meant, but for rounding, and beyond the hull is none.
        let found = Source::of_weights(&self.mesh.linear_coordinates(x, y));
        let nearest =
            || Source::Triangle { corners, weights: self.nearest_weights(corners, [x, y]) };
        let mut point = builder.point(self.s_mm(angle), found.unwrap_or_else(nearest));
        [point.at_mm[0], point.at_mm[1]] = [x, y];
        point
    }

    /// The weights of a triangle's corners at a place that lies outside by no more than rounding.
    fn nearest_weights(&self, corners: [VertexId; 3], [x, y]: Place) -> [f64; 3] {
        let [a, b, c] = corners.map(|corner| {
            let [at_x, at_y, _] = self.mesh.points()[corner as usize];
            [at_x - x, at_y - y]
        });
        let areas = [(b, c), (c, a), (a, b)].map(|(p, q)| (p[0] * q[1] - p[1] * q[0]).max(0.0));
        let total: f64 = areas.iter().sum();
        if total > 0.0 { areas.map(|area| area / total) } else { [1.0, 0.0, 0.0] }
    }

    /// Adds an arc up to an angle, with points in between where it is long.
    fn add<K: FnMut([VertexId; 3]) -> bool>(
        &self,
        builder: &mut Builder<'_, K>,
        from: SectionPoint,
        end: f64,
        mut to: SectionPoint,
        corners: [VertexId; 3],
    ) {
        let kept = builder.keeps([Some(corners), None]);
        to.s_mm = self.s_mm(end);
        let begin = from.s_mm / self.disc.radius_mm;
        let steps = ((end - begin) / LONGEST_STEP).ceil().max(1.0) as u32;
        let mut points: Vec<SectionPoint> = (1..steps)
            .filter(|_| kept)
            .map(|step| {
                let share = f64::from(step) / f64::from(steps);
                self.between(builder, begin + share * (end - begin), corners)
            })
            .collect();
        points.push(to);
        builder.chord(from, &points, kept);
    }
}

/// Between two points of a section over a circle there is no more than a degree: the chord then
/// lies within 4e-5 of the radius of the arc.
const LONGEST_STEP: f64 = TAU / 360.0;

/// Points so near the start that rounding may have put them before or after it lie there.
const SAME_ANGLE: f64 = 1e-12;
