//! The scanner over a stage that does what it is ordered, in virtual time.

use std::time::Duration;

use asphera_link::{
    AxisMove, Flags, Motion, MotionEvent, MotionFailure, MotionTrouble, Nanos, Reading, Values,
};
use asphera_plan::{
    Aperture, Axis, Ending, Goal, Limits, Machine, Path, Piece, Spacing, Trapezoid, lay,
};

use super::*;

const STAGE: (usize, usize) = (1, 0);
const STREAMS: [(usize, usize); 2] = [(0, 0), STAGE];

fn plan(adaptive: bool) -> ScanPlan {
    let aperture = Aperture::Rectangle { width_mm: 4.0, height_mm: 2.0 };
    let axis = Axis { low: -10.0, high: 10.0, speed: 20.0, acceleration: 200.0 };
    let pieces = lay(&Path::Raster { pitch_mm: 1.0, one_way: false }, &aperture, [0.0; 2]).unwrap();
    // y runs the other way and counts from 25 mm.
    let named = |name: &str, channel, scale, offset| ScanAxis {
        name: name.to_owned(),
        stream: 1,
        channel,
        scale,
        offset,
        tolerance: 0.05,
    };
    ScanPlan {
        axes: [named("x", 0, 1.0, 0.0), named("y", 1, -1.0, 25.0)],
        limits: Limits {
            machine: Machine::Cartesian { x: axis, y: axis },
            scan_speed_mm_s: 5.0,
            dwell_s: 0.05,
        },
        pieces: pieces.into_iter().map(|piece| (piece, Spacing::AtMost { mm: 0.5 })).collect(),
        dwell: Duration::from_millis(50),
        point_spacing_mm: 0.1,
        home_within: None,
        watchdog: Duration::from_millis(500),
        time_limit: None,
        points_max: None,
        adaptive: adaptive.then_some(AdaptivePlan {
            goal: Goal {
                coverage: 0.99,
                u_max: None,
                budget_s: None,
                batch_places: 100,
                finest_mm: 0.1,
            },
            aperture,
            centre_mm: [0.0; 2],
            spacing_mm: 1.0,
        }),
    }
}

/// Run under way: its begin, from, to, and how it goes.
type Running = (Nanos, f64, f64, Trapezoid);

/// A stage of two axes that obeys, and a gauge, read every 10 ms.
struct World {
    scanner: PlanScanner,
    now: Nanos,
    /// Position, and the run under way.
    axes: [(f64, Option<Running>); 2],
    ordered: Vec<(Nanos, Motion)>,
    points: Vec<[f64; 2]>,
    is_silent: bool,
    is_deaf: bool,
}

impl World {
    fn new(plan: ScanPlan) -> World {
        World {
            scanner: PlanScanner::new(plan, &STREAMS),
            now: Nanos::from_millis(1000),
            axes: [(0.0, None), (25.0, None)],
            ordered: Vec::new(),
            points: Vec::new(),
            is_silent: false,
            is_deaf: false,
        }
    }

    fn armed(plan: ScanPlan) -> World {
        let mut world = World::new(plan);
        world.run(100);
        world.scanner.arm(world.now).unwrap();
        world
    }

    fn text(&self) -> String {
        let figures = self.scanner.figures(self.now);
        format!("{}: {}", figures.state, figures.text)
    }

    fn is_moving(&self) -> bool {
        self.axes.iter().any(|(_, run)| run.is_some())
    }

    fn run(&mut self, ms: u64) {
        for _ in 0..ms / 10 {
            self.step();
        }
    }

    fn run_until(&mut self, is_enough: impl Fn(&World) -> bool) {
        for _ in 0..100_000 {
            if is_enough(self) {
                return;
            }
            self.step();
        }
        panic!("{}", self.text());
    }

    fn step(&mut self) {
        self.now = self.now + Duration::from_millis(10);
        while self.scanner.poll_timeout().is_some_and(|due| due <= self.now) {
            self.scanner.timeout(self.now);
            self.obey();
        }
        let was_moving = self.is_moving();
        for (at, run) in &mut self.axes {
            let Some((begin, from, to, pace)) = *run else { continue };
            let t_s = self.now.since(begin).as_secs_f64();
            if t_s >= pace.duration_s() {
                (*at, *run) = (to, None);
                continue;
            }
            // The way at a time, by halving.
            let (mut low, mut high) = (0.0, (to - from).abs());
            for _ in 0..60 {
                let way = 0.5 * (low + high);
                if pace.time_at_s(way) < t_s { low = way } else { high = way }
            }
            *at = from + (to - from).signum() * low;
        }
        let now = self.now;
        let reading = |values: &[f64]| {
            let values: Values = values.iter().map(|&value| Some(value)).collect();
            Reading { host: now, device_time_ns: None, count: None, values, flags: Flags::empty() }
        };
        let places = [self.axes[0].0, self.axes[1].0];
        if !self.is_silent {
            self.scanner.reading(self.now, 0, &reading(&[0.1]));
            self.scanner.reading(self.now, 1, &reading(&places));
        }
        if was_moving && !self.is_moving() && !self.is_deaf {
            self.scanner.motion(self.now, &MotionEvent::Arrived);
        }
        self.scanner.advance(self.now, true);
        self.obey();
        let position_mm = [places[0], 25.0 - places[1], 0.1];
        let mut point = Point {
            count: None,
            host: self.now,
            position_mm,
            flags: Flags::empty(),
            u_mm: [0.0; 3],
        };
        self.scanner.judge(&mut point);
        if point.is_good() {
            self.points.push([position_mm[0], position_mm[1]]);
        }
    }

    fn obey(&mut self) {
        while let Some(Order { device, motion }) = self.scanner.poll_order() {
            assert_eq!(device, STAGE);
            match &motion {
                Motion::Halt => self.axes.iter_mut().for_each(|(_, run)| *run = None),
                Motion::Run => panic!("a stage has no program"),
                // Home is 1 mm from 0 on x, half a second away.
                Motion::Home => {
                    let pace = Trapezoid::new(1.0, 5.0, 50.0);
                    self.axes[0] = (0.0, Some((self.now, 0.0, 1.0, pace)));
                }
                Motion::Move(moves) => {
                    for AxisMove { axis, to, speed, acceleration } in moves {
                        let (at, run) = &mut self.axes[usize::from(axis == "y")];
                        let pace = Trapezoid::new((to - *at).abs(), *speed, acceleration.unwrap());
                        *run = Some((self.now, *at, *to, pace));
                    }
                }
            }
            self.ordered.push((self.now, motion));
        }
    }

    fn halts(&self) -> usize {
        self.ordered.iter().filter(|(_, motion)| *motion == Motion::Halt).count()
    }
}

#[test]
fn nothing_moves_before_the_scan_is_armed() {
    let mut world = World::new(plan(false));
    world.run(60_000);
    assert!(world.ordered.is_empty() && world.points.is_empty());
    assert_eq!(world.text(), "disarmed: nothing moves until the scan is armed");
}

/// Three lines of 4 mm there and back, at 5 mm/s with 200 mm/s²: 0.825 s each, and the ways between.
#[test]
fn a_plan_is_driven_line_by_line_and_its_points_lie_on_it() {
    let mut world = World::armed(plan(false));
    world.run_until(|world| world.scanner.is_ended());
    assert_eq!(world.text(), "ended: the plan is measured");
    let first = |at: usize| match &world.ordered[at].1 {
        Motion::Move(moves) => moves.clone(),
        other => panic!("{other:?} is no move"),
    };
    // To -2, -1: y of the machine is 25 less the position of the axis.
    let begin: Vec<(String, f64)> = first(0).into_iter().map(|one| (one.axis, one.to)).collect();
    assert_eq!(begin, [("x".to_owned(), -2.0), ("y".to_owned(), 26.0)]);
    let line = first(1);
    assert_eq!((line.len(), line[0].to, line[0].speed), (1, 2.0, 5.0));
    assert_eq!(world.ordered.len(), 6, "a way and a line, three times");
    assert!(world.points.iter().all(|[x, y]| x.abs() <= 2.0 && [-1.0, 0.0, 1.0].contains(y)));
    // No two points of a line are nearer than 0.1 mm, and at 5 mm/s and 100 Hz none are farther apart than 0.15 mm.
    for pair in world.points.windows(2).filter(|pair| pair[0][1] == pair[1][1]) {
        let apart_mm = (pair[1][0] - pair[0][0]).abs();
        assert!((0.1 - 1e-9..=0.15 + 1e-9).contains(&apart_mm), "{pair:?}");
    }
    assert!((75..=123).contains(&world.points.len()), "{}", world.points.len());
    assert_eq!(world.scanner.figures(world.now).points, world.points.len() as u64);
    let lines_s = 3.0 * (4.0 / 5.0 + 5.0 / 200.0);
    assert!((lines_s..lines_s + 1.2).contains(&world.scanner.spent_s(world.now)));
    assert_eq!(world.scanner.arm(world.now), Err(ArmError::Ended));
}

#[test]
fn a_stop_halts_at_once_and_an_armed_scan_goes_on_with_its_line() {
    let mut world = World::armed(plan(false));
    world.run_until(|world| world.points.len() == 10);
    let moves = world.ordered.len();
    world.scanner.stop(world.now);
    world.obey();
    assert_eq!(world.ordered[moves].1, Motion::Halt);
    assert_eq!(world.text(), "disarmed: stopped by hand");
    let count = world.points.len();
    world.run(5000);
    assert_eq!((world.ordered.len(), world.points.len()), (moves + 1, count));
    world.scanner.arm(world.now).unwrap();
    assert_eq!(world.scanner.arm(world.now), Err(ArmError::Armed));
    world.run_until(|world| world.scanner.is_ended());
    let ends = [-1.0, 0.0, 1.0].map(|line| {
        let xs: Vec<f64> =
            world.points.iter().filter(|[_, y]| *y == line).map(|[x, _]| *x).collect();
        (
            xs.iter().copied().fold(f64::INFINITY, f64::min),
            xs.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        )
    });
    for (low, high) in ends {
        assert!(low < -1.85 && high > 1.85, "{ends:?}: every line is whole");
    }
}

#[test]
fn a_stop_of_a_disarmed_scan_halts_too() {
    let mut world = World::new(plan(false));
    world.run(100);
    world.scanner.stop(world.now);
    world.obey();
    assert_eq!(world.halts(), 1);
    assert_eq!(world.text(), "disarmed: nothing moves until the scan is armed");
}

/// What must halt the axes, and the words for it.
#[test]
fn trouble_halts_and_says_why() {
    let moving = || {
        let mut world = World::armed(plan(false));
        world.run_until(|world| world.points.len() == 5);
        world
    };
    let halted = |world: &mut World, words: &str| {
        world.obey();
        assert_eq!(world.halts(), 1, "{words}");
        assert!(
            world.text().starts_with("disarmed: ") && world.text().contains(words),
            "{}",
            world.text()
        );
        assert!(world.text().contains("then arm the scan again"), "{}", world.text());
        let orders = world.ordered.len();
        world.run(5000);
        assert_eq!(world.ordered.len(), orders, "{words}: nothing moves any more");
    };

    let mut world = moving();
    world.scanner.interrupted(world.now, 1, "stage");
    halted(&mut world, "the link stage was lost");

    let mut world = moving();
    world.scanner.interrupted(world.now, 0, "gauge");
    halted(&mut world, "the link gauge was lost");

    let mut world = moving();
    let limit =
        MotionFailure::new(MotionTrouble::Limit, "the stage reports WL: move it away from its end");
    world.scanner.motion(world.now, &MotionEvent::Failed(limit));
    halted(&mut world, "the stage reports WL");

    let mut world = moving();
    world.is_silent = true;
    world.run(600);
    halted(&mut world, "no position of axis x for 500 ms");

    let mut world = moving();
    world.axes[1] = (27.0, None);
    world.run(10);
    halted(
        &mut world,
        "axis y is at -2.0000, expected -1.0000 to -1.0000: something else moves it",
    );

    let mut world = moving();
    world.is_deaf = true;
    world.run(5000);
    halted(&mut world, "have not arrived in time");
}

#[test]
fn a_link_of_no_axis_disarms_nothing() {
    let mut world = World::armed(plan(false));
    world.run_until(|world| world.points.len() == 5);
    world.scanner.interrupted(world.now, 2, "thermometer");
    assert!(world.text().starts_with("moving"), "{}", world.text());
}

#[test]
fn a_stage_whose_link_was_lost_is_halted_when_it_opens() {
    let mut world = World::armed(plan(false));
    world.run_until(|world| world.points.len() == 5);
    world.scanner.interrupted(world.now, 1, "stage");
    let order = world.scanner.poll_order().unwrap();
    assert_eq!(order.motion, Motion::Halt);
    world.scanner.unhalted(order.device);
    assert_eq!(world.scanner.poll_order(), None);
    world.scanner.opened(0);
    assert_eq!(world.scanner.poll_order(), None);
    world.scanner.opened(1);
    assert_eq!(world.scanner.poll_order(), Some(Order { device: STAGE, motion: Motion::Halt }));
    world.scanner.opened(1);
    assert_eq!(world.scanner.poll_order(), None);
}

#[test]
fn an_axis_that_stands_elsewhere_than_it_was_sent_is_found_out() {
    let mut world = World::armed(plan(false));
    world.run_until(|world| world.points.len() == 5);
    // It says that it arrived, half way along its line.
    world.scanner.motion(world.now, &MotionEvent::Arrived);
    world.obey();
    assert!(world.text().contains("axis x stands at") && world.halts() == 1, "{}", world.text());
}

#[test]
fn passes_follow_as_they_are_decided() {
    let mut world = World::armed(plan(true));
    world.run_until(|world| world.scanner.wants_decision());
    let count = world.points.len();
    world.run(2000);
    assert_eq!(world.points.len(), count, "at rest nothing is measured");
    let stop = Stroke { from_nm: [500_000; 2], to_nm: [500_000; 2], spacing_nm: 500_000 };
    let line = Stroke { from_nm: [-1_500_000, 500_000], to_nm: [-500_000, 500_000], ..stop };
    world.scanner.decide(world.now, &ScanDecision::Measure(vec![stop, line]));
    world.obey();
    assert!(!world.scanner.wants_decision());
    world.run_until(|world| world.scanner.wants_decision());
    let new = &world.points[count..];
    assert_eq!(new[0], [0.5, 0.5], "one point at the stop");
    assert!(
        new.len() > 6 && new[1..].iter().all(|[x, y]| (-1.5..=-0.5).contains(x) && *y == 0.5),
        "{new:?}"
    );
    let figures = world.scanner.figures(world.now);
    assert_eq!((figures.pass, figures.pieces, figures.pieces_done), (2, 2, 2));
    world.scanner.decide(world.now, &ScanDecision::End(Ending::Reached));
    assert_eq!(world.text(), "ended: coverage, uncertainty and verdict are as wanted");
}

#[test]
fn a_fail_that_is_certain_ends_a_pass_in_its_middle() {
    let mut world = World::armed(plan(true));
    assert!(!world.scanner.ends_on_certain_fail());
    world.run_until(|world| world.points.len() == 20);
    assert!(world.scanner.ends_on_certain_fail());
    world.scanner.decide(world.now, &ScanDecision::End(Ending::FailCertain));
    world.obey();
    assert_eq!((world.halts(), world.is_moving()), (1, false));
    assert_eq!(world.text(), "ended: a limit is broken whatever comes");
    // A late decision of a pass begins nothing.
    world.scanner.decide(world.now, &ScanDecision::Measure(Vec::new()));
    assert!(world.scanner.is_ended());
}

#[test]
fn limits_of_points_and_of_time_end_a_scan() {
    let mut world = World::armed(ScanPlan { points_max: Some(30), ..plan(false) });
    world.run_until(|world| world.scanner.is_ended());
    world.obey();
    assert_eq!((world.points.len(), world.is_moving()), (30, false));
    let limit = Duration::from_millis(1500);
    let mut world = World::armed(ScanPlan { time_limit: Some(limit), ..plan(false) });
    world.run_until(|world| world.scanner.is_ended());
    assert_eq!(world.text(), "ended: the time is spent");
    assert!(world.scanner.spent_s(world.now) < 3.0);
}

#[test]
fn the_end_of_a_session_halts() {
    let mut world = World::armed(plan(false));
    world.run_until(|world| world.points.len() == 5);
    world.scanner.session_ends(world.now);
    world.obey();
    assert_eq!((world.halts(), world.text().as_str()), (1, "disarmed: the session ended"));
}

#[test]
fn the_same_happenings_give_the_same_orders() {
    let run = || {
        let mut world = World::armed(plan(true));
        world.run_until(|world| world.points.len() == 17);
        world.scanner.stop(world.now);
        world.run(500);
        world.scanner.arm(world.now).unwrap();
        world.run_until(|world| world.scanner.wants_decision());
        (world.ordered, world.points)
    };
    assert_eq!(run(), run());
}

/// Lines and stops in whole nanometres are those of their batch.
#[test]
fn a_batch_is_recorded_in_nanometres() {
    let line = Piece::Line { from_mm: [0.1, -0.2], to_mm: [1.25, 1e-6] };
    let stop = Piece::Stop { at_mm: [3.0, 4.0] };
    let pieces = vec![(line, Spacing::AtMost { mm: 0.25 }), (stop, Spacing::Every { mm: 1.0 })];
    let batch = asphera_plan::Batch { pieces, places: 6, regions: 1 };
    let ScanDecision::Measure(strokes) = ScanDecision::measure(&batch) else { panic!("a pass") };
    assert_eq!(strokes[0].to_nm, [1_250_000, 1]);
    assert!(
        matches!(strokes[0].piece(), (Piece::Line { .. }, Spacing::AtMost { mm }) if (mm - 0.25).abs() < 1e-12)
    );
    assert!(matches!(strokes[1].piece().0, Piece::Stop { .. }));
}

/// A table of which a unit of the channel is a radian, and whose stage counts backwards from 10 mm.
#[test]
fn a_turning_table_goes_where_its_axes_say() {
    let axis = |low: f64, high: f64| Axis { low, high, speed: 20.0, acceleration: 200.0 };
    let mut plan = plan(false);
    plan.limits.machine =
        Machine::Polar { r: axis(0.0, 10.0), c: axis(f64::NEG_INFINITY, f64::INFINITY) };
    plan.axes[0] = ScanAxis { scale: -1.0, offset: 10.0, ..plan.axes[0].clone() };
    plan.axes[1] = ScanAxis { scale: 1.0, offset: 0.0, ..plan.axes[1].clone() };
    let quarter = std::f64::consts::FRAC_PI_2;
    let piece = Piece::Line { from_mm: [0.0, 1.0], to_mm: [0.0, 4.0] };
    let runs =
        asphera_plan::axis_runs(&[(piece, Spacing::AtMost { mm: 1.0 })], &plan.limits, [0.0; 2])
            .unwrap();
    let moves: Vec<Vec<(String, f64)>> = runs
        .iter()
        .map(|run| plan.moves(run).into_iter().map(|(_, one)| (one.axis, one.to)).collect())
        .collect();
    assert_eq!(moves[0], [("x".to_owned(), 9.0), ("y".to_owned(), quarter)]);
    assert_eq!(moves[1], [("x".to_owned(), 6.0)], "along the line the table stands");
    let [x, y] = plan.place_mm(runs[1].to);
    assert!(x.abs() < 1e-12 && (y - 4.0).abs() < 1e-12);
}

fn homing_plan() -> ScanPlan {
    ScanPlan { home_within: Some(Duration::from_secs(5)), ..plan(false) }
}

#[test]
fn axes_find_home_once_and_before_the_first_piece() {
    let mut world = World::new(homing_plan());
    world.run(10_000);
    assert!(world.ordered.is_empty(), "nothing moves unless armed");
    world.scanner.arm(world.now).unwrap();
    world.run(100);
    assert_eq!(world.text(), "moving: the axes find home");
    assert_eq!(world.ordered.len(), 1);
    assert_eq!(world.ordered[0].1, Motion::Home);
    world.run_until(|world| world.points.len() > 10);
    world.scanner.stop(world.now);
    world.run(100);
    assert_eq!(world.halts(), 1);
    world.scanner.arm(world.now).unwrap();
    world.run_until(|world| world.scanner.is_ended());
    let homes = world.ordered.iter().filter(|(_, motion)| *motion == Motion::Home).count();
    assert_eq!(homes, 1, "a halt does not make a stage lose its home");
}

#[test]
fn a_lost_link_and_a_lost_reference_ask_for_home_again() {
    let unreferenced = MotionFailure::new(MotionTrouble::Unreferenced, "the stage was restarted");
    let harm: [fn(&mut World, &MotionFailure); 2] = [
        |world, _| world.scanner.interrupted(world.now, STAGE.0, "stage"),
        |world, failure| world.scanner.motion(world.now, &MotionEvent::Failed(failure.clone())),
    ];
    for harm in harm {
        let mut world = World::armed(homing_plan());
        world.run_until(|world| world.points.len() > 10);
        harm(&mut world, &unreferenced);
        world.run(100);
        world.scanner.arm(world.now).unwrap();
        world.run(200);
        assert_eq!(world.text(), "moving: the axes find home");
    }
}

#[test]
fn a_home_that_is_not_found_halts_and_disarms() {
    let mut world = World::armed(homing_plan());
    world.is_deaf = true;
    world.run(6_000);
    let text = world.text();
    assert!(text.starts_with("disarmed: the axes have not found home in time"), "{text}");
    assert_eq!(world.halts(), 1);
    let failure = MotionFailure::new(MotionTrouble::Device, "homing error: check its switches");
    let mut world = World::armed(homing_plan());
    world.run(50);
    world.scanner.motion(world.now, &MotionEvent::Failed(failure));
    world.run(50);
    assert!(
        world.text().contains("homing error: check its switches; then arm"),
        "{}",
        world.text()
    );
    assert_eq!(world.halts(), 1);
}
