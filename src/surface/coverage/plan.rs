//! What to measure next, as places to go to, and how long it takes.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use asphera_geometry::predicates::Place;
use thiserror::Error;

use super::clip::{cross, minus};
use super::patches::Patch;
use super::polygon::Polygon;

/// A place to be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// The region it belongs to: 1 is the first of [`super::Coverage::patches`].
    pub patch: usize,
    /// x and y in mm in the frame of the points.
    pub at_mm: [f64; 2],
}

/// What a scan has done and has left to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Area that is not covered yet, in mm².
    pub area_left_mm2: f64,
    /// Points wanted per mm² there; none if not known.
    pub points_per_mm2: Option<f64>,
    /// Points of the scan plan that are not measured yet; none without a plan.
    pub points_left: Option<f64>,
    /// Points measured per second.
    pub rate_hz: f64,
}

/// How long a scan will still take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Completion {
    /// Seconds until all is covered; none if nothing is being measured or it is not known how many
    /// points are wanted.
    pub by_coverage_s: Option<f64>,
    /// Seconds until the plan is done; none if nothing is being measured or there is no plan.
    pub by_plan_s: Option<f64>,
}

/// Why there is no plan.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum PlanError {
    /// No spacing is known for a region, and none was given for such.
    #[error("region {patch} has no spacing of its own, and none was given for such regions")]
    Spacing {
        /// Its number, from 1 on.
        patch: usize,
    },
    /// More places than were allowed.
    #[error("what is left needs more than {limit} places")]
    TooMany {
        /// How many were allowed.
        limit: usize,
    },
    /// A figure that is negative or not finite, or a spacing that is zero.
    #[error(
        "{name} is {value}, expected a finite number that is not negative, nor zero for a spacing"
    )]
    Figure {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Places to measure in each region, region by region in their order.
///
/// The places of a region lie on lines along its longer axis (of inertia; along x if none is longer),
/// one line there and the next one back. Lines, and places along them, are 0.95 times the
/// spacing apart that the region needs, seen in the plane, or a little less; half as far or a full
/// step from the samples around it, and right at the border of the aperture, where there are none. A
/// region without a spacing of its own takes `otherwise_mm`.
///
/// # Errors
///
/// When there is no spacing for a region, `otherwise_mm` is not a positive number, or more than
/// `limit` places are needed.
pub fn waypoints(
    patches: &[Patch],
    otherwise_mm: Option<f64>,
    limit: usize,
) -> Result<Vec<Waypoint>, PlanError> {
    if let Some(value) = otherwise_mm.filter(|mm| !(mm.is_finite() && *mm > 0.0)) {
        return Err(PlanError::Figure { name: "spacing in mm", value });
    }
    let mut found = Vec::new();
    for (index, patch) in patches.iter().enumerate() {
        let number = index + 1;
        let spacing_mm = patch
            .spacing_in_plane_mm()
            .or(otherwise_mm)
            .ok_or(PlanError::Spacing { patch: number })?;
        let step_mm = MARGIN * spacing_mm;
        for polygon in &patch.polygons {
            sweep(polygon, step_mm, limit, |at_mm| found.push(Waypoint { patch: number, at_mm }))
                .map_err(|TooMany| PlanError::TooMany { limit })?;
            if found.len() > limit {
                return Err(PlanError::TooMany { limit });
            }
        }
    }
    Ok(found)
}

/// Writes places as comma-separated values, one a line, under the names `patch,x_mm,y_mm`. Numbers
/// have as many digits as tell them apart.
///
/// # Errors
///
/// When `out` cannot be written to.
pub fn write_waypoints(out: &mut impl fmt::Write, waypoints: &[Waypoint]) -> fmt::Result {
    writeln!(out, "patch,x_mm,y_mm")?;
    for Waypoint { patch, at_mm: [x, y] } in waypoints {
        writeln!(out, "{patch},{x},{y}")?;
    }
    Ok(())
}

/// How long a scan will still take: by what is left to cover and by what is left of its plan.
///
/// # Errors
///
/// When a figure is negative or not finite.
pub fn completion(progress: &Progress) -> Result<Completion, PlanError> {
    let figures = [
        ("area left in mm²", Some(progress.area_left_mm2)),
        ("points per mm²", progress.points_per_mm2),
        ("points left", progress.points_left),
        ("rate in Hz", Some(progress.rate_hz)),
    ];
    for (name, value) in figures {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
            return Err(PlanError::Figure { name, value });
        }
    }
    let seconds = |points: f64| {
        let seconds = points / progress.rate_hz;
        seconds.is_finite().then_some(seconds)
    };
    let by_density = progress.points_per_mm2.map(|density| progress.area_left_mm2 * density);
    Ok(Completion {
        by_coverage_s: by_density.and_then(seconds),
        by_plan_s: progress.points_left.and_then(seconds),
    })
}

/// Distance of places over the spacing needed: so places that are off by 2 % of the spacing still
/// make triangles whose gap is within the target.
const MARGIN: f64 = 0.95;

struct TooMany;

/// A side of a polygon, seen along (u) and across (v) the lines.
struct Side {
    ends: [Place; 2],
    open: bool,
}

/// Takes places on lines through the polygon.
fn sweep(
    polygon: &Polygon,
    step_mm: f64,
    limit: usize,
    mut take: impl FnMut(Place),
) -> Result<(), TooMany> {
    let (sin, cos) = longer_axis_rad(polygon).sin_cos();
    // Turned about a place of its own, so that nothing is lost far from the origin.
    let from = polygon.outline.places_mm[0];
    let turned = |place: Place| {
        let [x, y] = minus(place, from);
        [cos * x + sin * y, cos * y - sin * x]
    };
    let sides: Vec<Side> =
        polygon.sides().map(|(p, q, open)| Side { ends: [turned(p), turned(q)], open }).collect();
    let ends = || sides.iter().flat_map(|side| side.ends.map(|end| (end[1], side.open)));
    let low = ends().map(|(v, _)| v).fold(f64::INFINITY, f64::min);
    let high = ends().map(|(v, _)| v).fold(f64::NEG_INFINITY, f64::max);
    let open_at = |level: f64| ends().any(|(v, open)| open && v == level);
    let levels = steps([low, high], [open_at(low), open_at(high)], step_mm, limit)?;
    let mut taken = 0;
    let mut crossings: Vec<(f64, bool)> = Vec::new();
    let mut line: Vec<Place> = Vec::new();
    for (row, v) in levels.into_iter().enumerate() {
        crossings.clear();
        for Side { ends: [p, q], open } in &sides {
            if (p[1] > v) != (q[1] > v) {
                crossings.push((p[0] + (v - p[1]) / (q[1] - p[1]) * (q[0] - p[0]), *open));
            }
        }
        crossings.sort_by(|left, right| left.0.total_cmp(&right.0));
        line.clear();
        for pair in crossings.chunks_exact(2) {
            let [(begin, begin_open), (end, end_open)] = [pair[0], pair[1]];
            let along = steps([begin, end], [begin_open, end_open], step_mm, limit)?;
            line.extend(along.into_iter().map(|u| [u, v]));
        }
        if row % 2 == 1 {
            line.reverse();
        }
        taken += line.len();
        if taken > limit {
            return Err(TooMany);
        }
        for &[u, v] in &line {
            take([from[0] + cos * u - sin * v, from[1] + sin * u + cos * v]);
        }
    }
    Ok(())
}

/// Places between two ends, at most a step apart: from an end on if it is open, else from the next
/// step on, as there are samples at the end. There is always one.
fn steps(
    [low, high]: [f64; 2],
    [low_open, high_open]: [bool; 2],
    step_mm: f64,
    limit: usize,
) -> Result<Vec<f64>, TooMany> {
    let length = high - low;
    let least = if low_open || high_open { 1.0 } else { 2.0 };
    let count = (length / step_mm - ROUNDING).ceil().max(least);
    // A raster line as long as this is refused before it is made.
    if count > limit as f64 + 2.0 {
        return Err(TooMany);
    }
    let count = count as usize;
    let first = usize::from(!low_open);
    let last = count - usize::from(!high_open);
    // Right at an end a line would touch the polygon at a corner at most.
    let inset = (INSET * step_mm).min(0.25 * length);
    let place = |i: usize| {
        let at = low + length * (i as f64 / count as f64);
        at.clamp(low + inset, high - inset)
    };
    Ok((first..=last).map(place).collect())
}

/// The direction in which the polygon is longest, from -π/2 to π/2 about +x: that of the axis of the
/// smallest moment of inertia. 0 if the moments differ by less than a tenth.
fn longer_axis_rad(polygon: &Polygon) -> f64 {
    let from = polygon.outline.places_mm[0];
    let (mut area, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
    for (p, q, _) in polygon.sides() {
        let (p, q) = (minus(p, from), minus(q, from));
        let turn = cross(p, q);
        area += 0.5 * turn;
        for axis in 0..2 {
            first[axis] += turn * (p[axis] + q[axis]) / 6.0;
        }
        // ∫ab over the triangle of the origin, p and q.
        for (index, (a, b)) in [(0, 0), (0, 1), (1, 1)].into_iter().enumerate() {
            let mixed = 0.5 * (p[a] * q[b] + q[a] * p[b]);
            second[index] += turn * (p[a] * p[b] + mixed + q[a] * q[b]) / 12.0;
        }
    }
    let centre = first.map(|first| first / area);
    let xx = second[0] / area - centre[0] * centre[0];
    let xy = second[1] / area - centre[0] * centre[1];
    let yy = second[2] / area - centre[1] * centre[1];
    let difference = (xx - yy).hypot(2.0 * xy);
    if difference.is_nan() || difference < 0.1 * (xx + yy) {
        return 0.0;
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    // Along y is π/2, however xy is rounded.
    if angle <= -FRAC_PI_2 + 1e-12 { FRAC_PI_2 } else { angle }
}

/// So small a share of a step more than a whole number of them is none.
const ROUNDING: f64 = 1e-9;

/// How far inside an open end a place lies, in steps.
const INSET: f64 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coverage::{Ring, Spacing};

    fn patch(places: &[Place], open: &[bool], spacing: Spacing) -> Patch {
        let outline = Ring { places_mm: places.to_vec(), open: open.to_vec() };
        let polygon = Polygon { outline, holes: Vec::new(), area_mm2: 1.0 };
        Patch {
            area_mm2: 1.0,
            undersampled_mm2: 0.0,
            uncovered_mm2: 1.0,
            gap_max_mm: None,
            epsilon_max: None,
            spacing,
            stretch: 1.0,
            inside_mm: [0.0; 2],
            polygons: vec![polygon],
        }
    }

    fn box_of(width: f64, height: f64) -> [Place; 4] {
        [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]
    }

    #[test]
    fn lines_run_there_and_back_along_the_longer_axis() {
        let spacing = Spacing::Mm(1.0 / MARGIN);
        let inner = [false; 4];
        let places = |patch: Patch| -> Vec<Place> {
            let found = waypoints(&[patch], None, 1000).unwrap();
            found.into_iter().map(|waypoint| waypoint.at_mm).collect()
        };
        // Samples stand all around: a step from them.
        let found = places(patch(&box_of(4.0, 3.0), &inner, spacing));
        let expected = [[1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [3.0, 2.0], [2.0, 2.0], [1.0, 2.0]];
        assert_eq!(found.len(), expected.len());
        let near = |p: Place, q: Place| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9;
        assert!(found.iter().zip(expected).all(|(&p, q)| near(p, q)), "{found:?}");
        // Upright: up the first line, down the second.
        let found = places(patch(&box_of(3.0, 4.0), &inner, spacing));
        let xs: Vec<i64> = found.iter().map(|place| place[0].round() as i64).collect();
        assert!(xs == [1, 1, 1, 2, 2, 2] || xs == [2, 2, 2, 1, 1, 1], "{found:?}");
        assert!(near([found[2][0], 0.0], [found[0][0], 0.0]));
        assert!((found[2][1] - found[3][1]).abs() < 1e-9, "{found:?}");
        // The border of the aperture below: a line on it, from end to end of the samples.
        let found = places(patch(&box_of(4.0, 3.0), &[true, false, false, false], spacing));
        assert_eq!(found.len(), 9);
        assert!(found[..3].iter().all(|place| (place[1] - 0.01).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn narrow_and_slanted_regions_get_at_least_one_line() {
        let spacing = Spacing::Mm(1.0);
        let thin = patch(&box_of(10.0, 0.5), &[false; 4], spacing);
        let found = waypoints(&[thin], None, 1000).unwrap();
        assert_eq!(found.len(), 10);
        assert!(found.iter().all(|waypoint| waypoint.at_mm[1] == 0.25 && waypoint.patch == 1));
        let slanted = [[0.0, 0.0], [10.0, 10.0], [9.5, 10.5], [-0.5, 0.5]];
        let slanted = patch(&slanted, &[false; 4], spacing);
        let found = waypoints(&[slanted], None, 1000).unwrap();
        let line = |place: Place| (place[1] - place[0] - 0.5).abs() < 1e-9;
        assert!(
            found.len() == 14 && found.iter().all(|waypoint| line(waypoint.at_mm)),
            "{found:?}"
        );
    }

    #[test]
    fn what_cannot_be_planned() {
        let unknown = || [patch(&box_of(4.0, 3.0), &[false; 4], Spacing::Unknown)];
        assert_eq!(waypoints(&unknown(), None, 9), Err(PlanError::Spacing { patch: 1 }));
        assert_eq!(waypoints(&unknown(), Some(0.1), 9), Err(PlanError::TooMany { limit: 9 }));
        assert_eq!(waypoints(&unknown(), Some(1e-300), 9), Err(PlanError::TooMany { limit: 9 }));
        for value in [0.0, -1.0, f64::NAN] {
            let found = waypoints(&unknown(), Some(value), 9);
            assert!(matches!(found, Err(PlanError::Figure { .. })));
        }
        assert_eq!(waypoints(&[], None, 0), Ok(Vec::new()));
    }

    #[test]
    fn as_text() {
        let places =
            [Waypoint { patch: 1, at_mm: [0.1, -2.0] }, Waypoint { patch: 12, at_mm: [1e-7, 3.5] }];
        let mut text = String::new();
        write_waypoints(&mut text, &places).unwrap();
        assert_eq!(text, "patch,x_mm,y_mm\n1,0.1,-2\n12,0.0000001,3.5\n");
    }

    #[test]
    fn time_left() {
        let progress = Progress {
            area_left_mm2: 2.0,
            points_per_mm2: Some(10_000.0),
            points_left: Some(5_000.0),
            rate_hz: 1000.0,
        };
        let found = completion(&progress).unwrap();
        assert_eq!((found.by_coverage_s, found.by_plan_s), (Some(20.0), Some(5.0)));
        let nothing = Completion { by_coverage_s: None, by_plan_s: None };
        assert_eq!(completion(&Progress { rate_hz: 0.0, ..progress }), Ok(nothing));
        let done =
            Progress { rate_hz: 0.0, area_left_mm2: 0.0, points_left: Some(0.0), ..progress };
        assert_eq!(completion(&done), Ok(nothing));
        let unplanned = Progress { points_per_mm2: None, points_left: None, ..progress };
        assert_eq!(completion(&unplanned), Ok(nothing));
        for value in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(completion(&Progress { rate_hz: value, ..progress }).is_err());
            assert!(completion(&Progress { area_left_mm2: value, ..progress }).is_err());
            assert!(completion(&Progress { points_left: Some(value), ..progress }).is_err());
        }
    }
}
