//! Paths against formulas of their length, their points and their time, and the laws they keep.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use std::f64::consts::{PI, TAU};

use asphera_plan::{
    Aperture, Axis, Limits, MOST_POINTS, Machine, Path, Piece, PlanError, Schedule, Spacing, Way,
    lay, schedule,
};
use proptest::prelude::*;

const DISC: Aperture = Aperture::Circle { radius_mm: 10.0 };

fn axis(half: f64, speed: f64, acceleration: f64) -> Axis {
    Axis::about_zero(half, speed, acceleration)
}

/// Stages that reach the scan speed at once and follow every bend.
fn strong() -> Limits {
    let stage = axis(100.0, 1e3, 1e9);
    Limits {
        machine: Machine::Cartesian { x: stage, y: stage },
        scan_speed_mm_s: 5.0,
        dwell_s: 0.0,
    }
}

fn polar(scan_speed_mm_s: f64) -> Limits {
    let r = Axis { low: -1.0, high: 50.0, speed: 20.0, acceleration: 100.0 };
    let c = axis(f64::INFINITY, TAU, 10.0 * TAU);
    Limits { machine: Machine::Polar { r, c }, scan_speed_mm_s, dwell_s: 0.0 }
}

fn laid(path: &Path, aperture: Aperture) -> Vec<Piece> {
    lay(path, &aperture, [0.0, 0.0]).unwrap()
}

fn run(pieces: &[Piece], mm: f64, limits: &Limits) -> Schedule {
    schedule(pieces, Spacing::AtMost { mm }, limits, None).unwrap()
}

/// The largest distance of places of the aperture from the nearest point.
fn gap_mm(found: &Schedule, aperture: Aperture) -> f64 {
    let reach = aperture.reach_mm();
    let raster =
        (0..160 * 160).map(|k| [k % 160, k / 160].map(|k| (f64::from(k) / 79.5 - 1.0) * reach));
    let near = |[x, y]: [f64; 2]| {
        let points =
            found.points.iter().map(|point| (point.at_mm[0] - x).hypot(point.at_mm[1] - y));
        points.fold(f64::INFINITY, f64::min)
    };
    raster.filter(|&place| aperture.contains(place)).map(near).fold(0.0, f64::max)
}

#[test]
fn a_spiral_has_the_length_of_its_integral() {
    let pieces = laid(&Path::Spiral { pitch_mm: 0.5, way: Way::Out }, DISC);
    let [spiral, turn] = pieces[..] else { panic!("{pieces:?}") };
    // ∫√(r² + b²) dc over 20 turns by Simpson's rule.
    let (b, end) = (0.5 / TAU, 20.0 * TAU);
    let speed = |c: f64| (b * c).hypot(b);
    let n = 200_000;
    let h = end / f64::from(n);
    let inner: f64 = (1..n).map(|k| f64::from(2 + 2 * (k % 2)) * speed(f64::from(k) * h)).sum();
    let expected = h / 3.0 * (speed(0.0) + inner + speed(end));
    assert!((spiral.length_mm() / expected - 1.0).abs() < 1e-12);
    assert!((turn.length_mm() - TAU * 10.0).abs() < 1e-12);
    let found = run(&pieces, 0.5, &strong());
    // The turn begins where the spiral ends: that place counts once.
    let count = (expected / 0.5).ceil() as usize + (TAU * 10.0 / 0.5).ceil() as usize;
    assert_eq!(found.points.len(), count);
    assert!(found.points.windows(2).all(|pair| pair[1].t_s > pair[0].t_s));
    // Points follow each other evenly along the way; the time is that of the speed.
    assert!((found.scan_s / ((expected + TAU * 10.0) / 5.0) - 1.0).abs() < 1e-6);
    assert!(found.full_speed_mm > 0.99 * found.scan_mm);
    let inwards = laid(&Path::Spiral { pitch_mm: 0.5, way: Way::In }, DISC);
    assert!((inwards[1].length_mm() / expected - 1.0).abs() < 1e-12);
    assert!(inwards[1].end().iter().all(|mm| mm.abs() < 1e-9));
}

#[test]
fn points_of_a_spiral_lie_on_it_by_equal_lengths() {
    let [spiral, _] = laid(&Path::Spiral { pitch_mm: 2.0, way: Way::Out }, DISC)[..] else {
        panic!()
    };
    let length = spiral.length_mm();
    // The chord of a short stretch is its length.
    for share in [0.0, 1e-6, 0.01, 0.3, 0.999] {
        let [p, q] = [share * length, share * length + 1e-4].map(|way| spiral.at(way));
        assert!(((p[0] - q[0]).hypot(p[1] - q[1]) / 1e-4 - 1.0).abs() < 1e-3, "{share}");
        let radius = p[0].hypot(p[1]);
        let turns = (radius / 2.0).fract();
        let angle = p[1].atan2(p[0]).rem_euclid(TAU) / TAU;
        let miss = (turns - angle).abs();
        assert!(radius < 1e-3 || miss.min(1.0 - miss) < 1e-9, "{share}: {turns} {angle}");
    }
}

#[test]
fn rings_and_meridians_have_even_distances() {
    let rings = laid(&Path::Rings { pitch_mm: 3.0, way: Way::Out }, DISC);
    let radii: Vec<f64> = rings.iter().map(|piece| piece.at(0.0)[0]).collect();
    assert_eq!(radii, [0.0, 2.5, 5.0, 7.5, 10.0]);
    let found = run(&rings, 1.0, &strong());
    let counts = radii.iter().map(|r| ((TAU * r).ceil() as usize).max(1)).sum::<usize>();
    assert_eq!(found.points.len(), counts);
    let ring = Aperture::Annulus { inner_mm: 4.0, outer_mm: 10.0 };
    let inwards = laid(&Path::Rings { pitch_mm: 3.0, way: Way::In }, ring);
    let radii: Vec<f64> = inwards.iter().map(|piece| piece.at(0.0)[0]).collect();
    assert_eq!(radii, [10.0, 7.0, 4.0]);
    let meridians = laid(&Path::Meridians { pitch_mm: 6.0 }, ring);
    assert_eq!(meridians.len(), 11);
    for (k, piece) in meridians.iter().enumerate() {
        let ends = [piece.at(0.0), piece.end()].map(|[x, y]| x.hypot(y));
        let expected = if k % 2 == 0 { [4.0, 10.0] } else { [10.0, 4.0] };
        assert!((0..2).all(|end| (ends[end] - expected[end]).abs() < 1e-12), "{k}");
        let [x, y] = piece.at(1.0);
        let angle = y.atan2(x).rem_euclid(TAU);
        assert!((angle - TAU * k as f64 / 11.0).abs() < 1e-12);
    }
}

#[test]
fn a_raster_covers_what_it_is_laid_over() {
    let rectangle = Aperture::Rectangle { width_mm: 12.0, height_mm: 7.0 };
    let ring = Aperture::Annulus { inner_mm: 4.0, outer_mm: 10.0 };
    for (aperture, slack) in [(rectangle, 1.0), (DISC, 1.15), (ring, 1.25)] {
        let pieces = laid(&Path::Raster { pitch_mm: 0.8, one_way: false }, aperture);
        let found = run(&pieces, 0.8, &strong());
        let gap = gap_mm(&found, aperture);
        assert!(gap <= slack * 0.8 / 2_f64.sqrt(), "{aperture:?} {gap}");
        assert!(found.points.iter().all(|point| aperture.contains(point.at_mm)));
        let density = found.points.len() as f64 * 0.64 / aperture.area_mm2();
        assert!((1.0..1.25).contains(&density), "{aperture:?} {density}");
    }
    // Turns and rays as well: their corner squares are no larger.
    let paths = [
        Path::Spiral { pitch_mm: 0.8, way: Way::Out },
        Path::Rings { pitch_mm: 0.8, way: Way::In },
        Path::Meridians { pitch_mm: 0.8 },
    ];
    for path in paths {
        let found = run(&laid(&path, DISC), 0.8, &strong());
        assert!(gap_mm(&found, DISC) <= 1.02 * 0.8 / 2_f64.sqrt(), "{path:?}");
        let found = run(&laid(&path, rectangle), 0.8, &strong());
        assert!(gap_mm(&found, rectangle) <= 1.05 * 0.8, "{path:?} over a rectangle");
    }
    let one_way = laid(&Path::Raster { pitch_mm: 0.8, one_way: true }, rectangle);
    assert!(one_way.iter().all(|piece| piece.end()[0] > piece.at(0.0)[0]));
}

#[test]
fn times_are_those_of_trapezoids() {
    let stage = axis(100.0, 10.0, 50.0);
    let machine = Machine::Cartesian { x: stage, y: stage };
    let limits = Limits { machine, scan_speed_mm_s: 5.0, dwell_s: 0.0 };
    let aperture = Aperture::Rectangle { width_mm: 10.0, height_mm: 2.0 };
    let pieces = laid(&Path::Raster { pitch_mm: 1.0, one_way: false }, aperture);
    let found = run(&pieces, 0.5, &limits);
    // Three lines of 10/5 + 5/50 s, two steps of 1 mm: 2·√(1/50) s, as 10 mm/s are not reached.
    assert!((found.scan_s - 3.0 * 2.1).abs() < 1e-12);
    assert!((found.move_s - 2.0 * 2.0 * (1.0_f64 / 50.0).sqrt()).abs() < 1e-12);
    assert!((found.total_s - found.scan_s - found.move_s).abs() < 1e-12);
    assert!((found.full_speed_mm - 3.0 * 9.5).abs() < 1e-9);
    assert!(found.points.windows(2).all(|pair| pair[1].t_s > pair[0].t_s));
    // One way: it comes back 10 mm, at 10 mm/s.
    let one_way = laid(&Path::Raster { pitch_mm: 1.0, one_way: true }, aperture);
    assert!((run(&one_way, 0.5, &limits).move_s - 2.0 * 1.2).abs() < 1e-12);
    // Places at which it stands: 3 mm and 4 mm apart, the longer run counts.
    let listed = laid(&Path::Points(vec![[0.0, 0.0], [3.0, 4.0]]), aperture);
    let waits = Limits { dwell_s: 0.5, ..limits };
    let found = schedule(&listed, Spacing::AtMost { mm: 1.0 }, &waits, Some([0.0, -4.0])).unwrap();
    assert!((found.total_s - (2.0 * 0.6 + 1.0)).abs() < 1e-12, "{}", found.total_s);
    assert!((found.points[1].t_s - found.total_s).abs() < 1e-12);
    assert!((found.move_mm - 9.0).abs() < 1e-12);
}

#[test]
fn axes_limit_the_speed_on_circles() {
    // Two stages of 50 mm/s² hold √(50·10) mm/s on a circle of 10 mm; a scan speed beyond that is not reached.
    let stage = axis(100.0, 1e3, 50.0);
    let machine = Machine::Cartesian { x: stage, y: stage };
    let limits = Limits { machine, scan_speed_mm_s: 1e3, dwell_s: 0.0 };
    let turn = |turns: f64| Piece::Arc {
        centre_mm: [0.0; 2],
        radius_mm: 10.0,
        from_rad: 0.0,
        to_rad: turns * TAU,
    };
    let seconds = |turns: f64| run(&[turn(turns)], 0.5, &limits).total_s;
    let a_turn = seconds(3.0) - seconds(2.0);
    let even = TAU * 10.0 / 500.0_f64.sqrt();
    assert!(a_turn < even * 1.01 && a_turn > 0.8 * even, "{a_turn} {even}");
    // A table of one turn a second holds 2π·r mm/s, in closed form.
    let found = run(&[turn(1.0)], 0.5, &polar(1e3));
    assert!((found.total_s - (1.0 + TAU / (10.0 * TAU))).abs() < 1e-9, "{}", found.total_s);
    // The spiral on a table: near the axis the table limits, farther out the probe.
    let pieces = laid(&Path::Spiral { pitch_mm: 1.0, way: Way::Out }, DISC);
    let found = run(&pieces, 0.5, &polar(5.0));
    assert!(found.full_speed_mm > 0.9 * found.scan_mm && found.full_speed_mm < found.scan_mm);
    let last = found.points[found.points.len() - 1].axes;
    assert!((last[0] - 10.0).abs() < 1e-9 && last[1] > 10.9 * TAU, "{last:?}");
}

/// Positions of the axes between points a hundredth of a millimetre apart, differentiated twice.
#[test]
fn no_axis_exceeds_its_limits_on_the_way() {
    let pieces = laid(&Path::Spiral { pitch_mm: 2.0, way: Way::Out }, DISC);
    let stage = axis(100.0, 8.0, 30.0);
    let cartesian = Limits {
        machine: Machine::Cartesian { x: stage, y: stage },
        scan_speed_mm_s: 20.0,
        dwell_s: 0.0,
    };
    let Machine::Polar { r, c } = polar(1.0).machine else { panic!() };
    for (limits, axes) in [(cartesian, [stage, stage]), (polar(20.0), [r, c])] {
        let found = run(&pieces[..1], 0.01, &limits);
        let mut fastest = [0.0_f64; 2];
        for pair in found.points.windows(2) {
            let dt = pair[1].t_s - pair[0].t_s;
            for (k, axis) in axes.iter().enumerate() {
                let speed = (pair[1].axes[k] - pair[0].axes[k]).abs() / dt;
                assert!(speed <= axis.speed * 1.001, "{k}: {speed}");
                fastest[k] = fastest[k].max(speed / axis.speed);
            }
        }
        for three in found.points.windows(3) {
            let [before, after] = [three[1].t_s - three[0].t_s, three[2].t_s - three[1].t_s];
            for (k, axis) in axes.iter().enumerate() {
                let speeds = [
                    (three[1].axes[k] - three[0].axes[k]) / before,
                    (three[2].axes[k] - three[1].axes[k]) / after,
                ];
                let acceleration = (speeds[1] - speeds[0]).abs() / (0.5 * (before + after));
                assert!(acceleration <= axis.acceleration * 1.03, "{k}: {acceleration}");
            }
        }
        assert!(fastest.iter().any(|share| *share > 0.9), "limits are used: {fastest:?}");
    }
}

#[test]
fn triggers_come_at_every_length() {
    let line = Piece::Line { from_mm: [0.0, 0.0], to_mm: [10.0, 0.0] };
    let found = schedule(&[line], Spacing::Every { mm: 0.3 }, &strong(), None).unwrap();
    assert_eq!(found.points.len(), 34);
    assert!((found.points[33].at_mm[0] - 9.9).abs() < 1e-12);
    let turn = Piece::Arc { centre_mm: [0.0; 2], radius_mm: 1.0, from_rad: 0.0, to_rad: TAU };
    let found = schedule(&[turn], Spacing::Every { mm: PI / 2.0 }, &strong(), None).unwrap();
    assert_eq!(found.points.len(), 4);
}

#[test]
fn a_table_takes_the_shorter_way_round() {
    let stop = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Piece::Stop { at_mm: [5.0 * cos, 5.0 * sin] }
    };
    let found = run(&[stop(170.0), stop(-170.0), stop(150.0)], 1.0, &polar(5.0));
    let turned: Vec<f64> =
        found.points.iter().map(|point| point.axes[1].to_degrees().round()).collect();
    assert_eq!(turned, [170.0, 190.0, 150.0]);
    // A table with ends turns back instead.
    let Machine::Polar { r, .. } = polar(5.0).machine else { panic!() };
    let machine = Machine::Polar { r, c: axis(PI, TAU, 10.0 * TAU) };
    let found = run(&[stop(170.0), stop(-170.0)], 1.0, &Limits { machine, ..polar(5.0) });
    assert!((found.points[1].axes[1].to_degrees() + 170.0).abs() < 1e-9);
}

#[test]
fn refusals_name_key_place_and_cure() {
    let small = axis(6.0, 10.0, 50.0);
    let limits = |machine| Limits { machine, scan_speed_mm_s: 5.0, dwell_s: 0.0 };
    let cartesian = limits(Machine::Cartesian { x: axis(20.0, 10.0, 50.0), y: small });
    let refused = |path: Path, limits: &Limits| -> PlanError {
        schedule(&laid(&path, DISC), Spacing::AtMost { mm: 1.0 }, limits, None).unwrap_err()
    };
    let raster = Path::Raster { pitch_mm: 1.0, one_way: false };
    let spiral = Path::Spiral { pitch_mm: 1.0, way: Way::Out };
    let error = refused(raster.clone(), &cartesian);
    assert_eq!(error.key, "y.travel");
    assert_eq!(
        error.to_string(),
        "y.travel: expected -6 to 6 mm, found -9.500000 mm at x -3.122499, y -9.500000 mm: plan a smaller aperture, \
         move its centre, or give the travel the machine has"
    );
    assert_eq!(refused(spiral.clone(), &cartesian).key, "y.travel");
    assert_eq!(refused(raster, &polar(5.0)).key, "path");
    let Machine::Polar { r, c } = polar(5.0).machine else { panic!() };
    let short = limits(Machine::Polar { r: Axis { high: 9.0, ..r }, c });
    assert_eq!(refused(Path::Rings { pitch_mm: 1.0, way: Way::Out }, &short).key, "r.travel");
    let ends = limits(Machine::Polar { r, c: axis(PI, 1.0, 1.0) });
    assert_eq!(refused(spiral.clone(), &ends).key, "c.travel");
    let aside = lay(&spiral, &DISC, [1.0, 0.0]).unwrap();
    let error = schedule(&aside, Spacing::AtMost { mm: 1.0 }, &polar(5.0), None).unwrap_err();
    assert_eq!(error.key, "centre");
    let still = limits(Machine::Cartesian { x: axis(20.0, 0.0, 1.0), y: small });
    assert_eq!(refused(spiral.clone(), &still).key, "x.speed");
    assert_eq!(
        refused(spiral.clone(), &Limits { scan_speed_mm_s: f64::NAN, ..polar(5.0) }).key,
        "scan_speed"
    );
    assert_eq!(refused(spiral, &Limits { dwell_s: -1.0, ..polar(5.0) }).key, "dwell");
}

#[test]
fn sizes_that_cannot_be_are_refused() {
    for mm in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            lay(&Path::Meridians { pitch_mm: mm }, &DISC, [0.0; 2]).unwrap_err().key,
            "spacing"
        );
        let circle = Aperture::Circle { radius_mm: mm };
        let error = lay(&Path::Meridians { pitch_mm: 1.0 }, &circle, [0.0; 2]).unwrap_err();
        assert_eq!(error.key, "aperture.radius_mm");
        let pieces = laid(&Path::Meridians { pitch_mm: 1.0 }, DISC);
        assert_eq!(
            schedule(&pieces, Spacing::AtMost { mm }, &strong(), None).unwrap_err().key,
            "spacing"
        );
    }
    let fine = laid(&Path::Meridians { pitch_mm: 0.01 }, DISC);
    let error = schedule(&fine, Spacing::AtMost { mm: 1e-3 }, &strong(), None).unwrap_err();
    assert!(error.to_string().contains(&MOST_POINTS.to_string()), "{error}");
    assert!(lay(&Path::Rings { pitch_mm: 1e-9, way: Way::Out }, &DISC, [0.0; 2]).is_err());
    let empty = Aperture::Annulus { inner_mm: 5.0, outer_mm: 5.0 };
    assert_eq!(empty.validate().unwrap_err().key, "aperture.inner_mm");
    let bad = Path::Points(vec![[0.0, 0.0], [f64::NAN, 1.0]]);
    assert!(lay(&bad, &DISC, [0.0; 2]).unwrap_err().to_string().contains("as place 2"));
    assert_eq!(run(&[], 1.0, &strong()), Schedule::default());
    assert!(lay(&bad, &DISC, [f64::NAN, 0.0]).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    /// All lengths, speeds and accelerations times k: the same times.
    #[test]
    fn a_scaled_path_on_a_scaled_machine_takes_the_same_time(k in 0.1_f64..50.0, kind in 0..4) {
        let path = |k: f64| match kind {
            0 => Path::Raster { pitch_mm: 1.5 * k, one_way: false },
            1 => Path::Spiral { pitch_mm: 1.5 * k, way: Way::Out },
            2 => Path::Rings { pitch_mm: 1.5 * k, way: Way::In },
            _ => Path::Meridians { pitch_mm: 1.5 * k },
        };
        let found = |k: f64| {
            let stage = axis(30.0 * k, 8.0 * k, 40.0 * k);
            let machine = Machine::Cartesian { x: stage, y: stage };
            let limits = Limits { machine, scan_speed_mm_s: 6.0 * k, dwell_s: 0.1 };
            run(&laid(&path(k), Aperture::Circle { radius_mm: 10.0 * k }), 0.7 * k, &limits)
        };
        let [one, other] = [found(1.0), found(k)];
        prop_assert_eq!(one.points.len(), other.points.len());
        // Where an axis stands still for a moment, rounding decides what it has to spare.
        prop_assert!((one.total_s / other.total_s - 1.0).abs() < 1e-6);
        for (p, q) in one.points.iter().zip(&other.points) {
            prop_assert!((p.t_s - q.t_s).abs() < 1e-6 * one.total_s);
            prop_assert!((k * p.at_mm[0] - q.at_mm[0]).abs() < 1e-6 * k);
        }
    }
}
