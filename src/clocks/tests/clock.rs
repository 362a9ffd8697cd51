//! Clocks of known offset and drift, read over links that are late at random.

use asphera_clocks::{Clock, Placed};
use asphera_link::{DeviceClock, Nanos};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// One-sided delays in ns.
#[derive(Clone, Copy, Debug)]
enum Delays {
    Exponential(f64),
    Uniform(f64),
    /// An adapter that hands over all it has, on average every so many ns.
    Bursts(f64),
    /// Short, and now and then very long.
    Tail,
}

struct Bench {
    random: Pcg64Mcg,
    period_ns: f64,
    drift_ppm: f64,
    offset_ns: f64,
    delays: Delays,
    next_burst_ns: f64,
    last_host: Nanos,
}

impl Bench {
    fn new(seed: u64, period_ns: f64, drift_ppm: f64, delays: Delays) -> Bench {
        let random = Pcg64Mcg::seed_from_u64(seed);
        Bench {
            random,
            period_ns,
            drift_ppm,
            offset_ns: 7.3e12,
            delays,
            next_burst_ns: 0.0,
            last_host: Nanos::ZERO,
        }
    }

    fn unit(&mut self) -> f64 {
        (self.random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// True time of reading n on the host's clock, ns.
    fn true_ns(&self, n: u64) -> f64 {
        2e8 + n as f64 * self.period_ns
    }

    fn device_ns(&self, n: u64) -> u64 {
        (self.offset_ns + self.true_ns(n) * (1.0 + self.drift_ppm * 1e-6)).round() as u64
    }

    fn host(&mut self, n: u64) -> Nanos {
        let (unit, at_ns) = (self.unit(), self.true_ns(n));
        let arrives_ns = match self.delays {
            Delays::Exponential(mean_ns) => at_ns - mean_ns * (1.0 - unit).ln(),
            Delays::Uniform(most_ns) => at_ns + most_ns * unit,
            Delays::Bursts(every_ns) => {
                while self.next_burst_ns < at_ns {
                    self.next_burst_ns += every_ns * (0.5 + self.unit());
                }
                self.next_burst_ns
            }
            Delays::Tail => {
                at_ns + 1e5 * unit + if unit > 0.98 { 4e7 * (unit - 0.98) * 50.0 } else { 0.0 }
            }
        };
        self.last_host = self.last_host.max(Nanos::from_nanos(arrives_ns as u64));
        self.last_host
    }
}

fn at(placed: Placed) -> (f64, f64) {
    let Placed::At { ns, u_ns } = placed else { panic!("{placed:?}") };
    (ns, u_ns)
}

#[test]
fn times_and_drift_are_found_within_their_uncertainties_under_one_sided_delays() {
    let kinds = [
        Delays::Exponential(1e6),
        Delays::Exponential(5e4),
        Delays::Uniform(2e6),
        Delays::Bursts(1.6e7),
        Delays::Tail,
    ];
    let (mut placed, mut within, mut drifts, mut drifts_within) = (0, 0, 0, 0);
    for (seed, delays) in (0_u64..).zip(kinds.into_iter().cycle()).take(60) {
        let period_ns =
            [3.1e5, 1.03e6, 2.07e7].map(|ns: f64| ns * 1.000_618_03)[seed as usize / 5 % 3];
        let drift_ppm = [-80.0, 0.0, 35.0, 400.0][seed as usize % 4];
        let mut bench = Bench::new(seed, period_ns, drift_ppm, delays);
        let mut clock = Clock::new(DeviceClock::default());
        let readings = (2e10 / period_ns) as u64;
        for n in 0..readings {
            let (device_ns, host) = (bench.device_ns(n), bench.host(n));
            let stamp = clock.take(device_ns, host).unwrap();
            if n % (readings / 50) != 0 || n < readings / 10 {
                continue;
            }
            // A reading that is very late is placed after the next one in time.
            let Placed::At { ns, u_ns } = clock.placed(stamp) else { continue };
            let off_ns = ns - bench.true_ns(n);
            placed += 1;
            within += u32::from(off_ns.abs() <= 2.0 * u_ns + 10.0);
            assert!(
                off_ns.abs() <= 6.0 * u_ns + 100.0,
                "{delays:?} {period_ns} {n}: {off_ns} u {u_ns}"
            );
        }
        let state = clock.state();
        assert_eq!((state.jumps, state.wraps, state.repeated), (0, 0, 0), "{delays:?} {period_ns}");
        let off_ppm = (state.drift_ppm.unwrap() - drift_ppm).abs();
        drifts += 1;
        drifts_within += u32::from(off_ppm <= 2.0 * state.u_drift_ppm.unwrap() + 1e-3);
    }
    assert!(placed > 2000 && f64::from(within) > 0.95 * f64::from(placed), "{within} of {placed}");
    assert!(f64::from(drifts_within) >= 0.95 * f64::from(drifts), "{drifts_within} of {drifts}");
}

#[test]
fn plain_delays_bias_a_least_squares_line_and_not_this_one() {
    let mut bench = Bench::new(3, 1e6, 20.0, Delays::Exponential(1e6));
    let mut clock = Clock::new(DeviceClock::default());
    for n in 0..20_000 {
        let (device_ns, host) = (bench.device_ns(n), bench.host(n));
        let stamp = clock.take(device_ns, host).unwrap();
        if n == 19_999 {
            let (ns, u_ns) = at(clock.placed(stamp));
            assert!(
                (ns - bench.true_ns(n)).abs() < 2e4 && u_ns < 2e4,
                "1 ms of delays became {u_ns} ns"
            );
        }
    }
    let jitter_s = clock.state().jitter_s.unwrap();
    assert!((jitter_s - 1e-3).abs() < 2e-4, "{jitter_s}");
    let offset_s = clock.state().offset_s.unwrap();
    assert!((offset_s + 7300.0).abs() < 1e-2, "{offset_s}");
}

#[test]
fn nothing_is_placed_before_there_is_enough() {
    let mut clock = Clock::new(DeviceClock::default());
    let mut first = None;
    for n in 0..100_u64 {
        let stamp = clock.take(n * 20_000_000, Nanos::from_millis(1000 + 20 * n)).unwrap();
        let first = *first.get_or_insert(stamp);
        let is_placed = matches!(clock.placed(first), Placed::At { .. });
        assert_eq!(is_placed, n >= 25, "{n}");
    }
    assert_eq!(at(clock.placed(first.unwrap())).0, 1e9, "and then from the first reading on");
}

#[test]
fn a_clock_that_jumps_ahead_begins_anew_and_old_times_stay() {
    let mut clock = Clock::new(DeviceClock::default());
    let host = |n: u64| Nanos::from_millis(10 * n);
    let mut before = None;
    for n in 0..200 {
        before = clock.take(n * 10_000_000, host(n));
    }
    let after = clock.take(200 * 10_000_000 + 5_000_000, host(200)).unwrap();
    assert_eq!(clock.state().jumps, 1);
    assert_eq!(clock.placed(after), Placed::NotYet);
    assert_eq!(at(clock.placed(before.unwrap())).0, 1.99e9);
    for n in 201..300 {
        clock.take(n * 10_000_000 + 5_000_000, host(n));
    }
    assert_eq!(at(clock.placed(after)).0, 2e9);
}

#[test]
fn a_clock_that_goes_back_is_in_doubt_and_then_begins_anew() {
    let mut clock = Clock::new(DeviceClock::default());
    let host = |n: u64| Nanos::from_millis(10 * n);
    for n in 0..200 {
        clock.take(n * 10_000_000, host(n));
    }
    // By less than one period: times still grow.
    let doubted = clock.take(200 * 10_000_000 - 6_000_000, host(200)).unwrap();
    assert_eq!(clock.placed(doubted), Placed::NotYet);
    for n in 201..320 {
        clock.take(n * 10_000_000 - 6_000_000, host(n));
    }
    assert_eq!((clock.state().jumps, clock.placed(doubted)), (1, Placed::Never));
    // By more: at once.
    clock.take(5, host(400));
    assert_eq!(clock.state().jumps, 2);
}

#[test]
fn readings_that_waited_in_a_buffer_are_placed_when_one_comes_in_time() {
    let mut clock = Clock::new(DeviceClock::default());
    for n in 0..200_u64 {
        clock.take(n * 10_000_000, Nanos::from_millis(10 * n));
    }
    let late: Vec<_> = (200..230_u64)
        .map(|n| clock.take(n * 10_000_000, Nanos::from_millis(2290)).unwrap())
        .collect();
    let Placed::At { ns, .. } = clock.placed(late[0]) else { panic!("the last was in time") };
    assert_eq!((ns, clock.state().jumps), (2e9, 0));
}

#[test]
fn a_counter_that_begins_again_is_followed_and_one_that_was_reset_is_not() {
    // 16 bits of ms: 65.536 s.
    let facts = DeviceClock { wraps_ns: Some(65_536_000_000), tick_ns: 0 };
    let mut clock = Clock::new(facts);
    let mut last = None;
    for n in 0..20_000_u64 {
        last = clock.take((60_000 + 10 * n) % 65_536 * 1_000_000, Nanos::from_millis(10 * n));
    }
    assert_eq!((clock.state().wraps, clock.state().jumps), (3, 0));
    assert!((at(clock.placed(last.unwrap())).0 - 199.99e9).abs() < 1.0);
    // Silent for two turns and a half.
    clock.take((60_000 + 363_830) % 65_536 * 1_000_000, Nanos::from_millis(363_830));
    assert_eq!(clock.state().jumps, 0);
    clock.take(0, Nanos::from_millis(363_840));
    assert_eq!(clock.state().jumps, 1);
}

#[test]
fn coarse_ticks_are_taken_at_their_middle_and_counted() {
    let facts = DeviceClock { wraps_ns: None, tick_ns: 1_000_000 };
    let mut clock = Clock::new(facts);
    let mut off = Vec::new();
    for n in 0..5000_u64 {
        let true_ns = n * 3_217_345;
        let device_ns = true_ns / 1_000_000 * 1_000_000;
        let stamp = clock.take(device_ns, Nanos::from_nanos(true_ns + 1)).unwrap();
        if n > 1000 {
            let (ns, u_ns) = at(clock.placed(stamp));
            assert!((2.8e5..4e5).contains(&u_ns), "{u_ns}");
            off.push(ns - true_ns as f64);
        }
    }
    let mean_ns = off.iter().sum::<f64>() / off.len() as f64;
    assert!(mean_ns.abs() < 2e4, "{mean_ns}");
    assert!(off.iter().all(|off| off.abs() < 5.3e5));
}

#[test]
fn any_numbers_give_times_or_none_and_no_panic() {
    let wraps = [None, Some(0), Some(1), Some(u64::MAX), Some(u64::MAX / 2), Some(65_536)];
    for wraps_ns in wraps {
        let mut random = Pcg64Mcg::seed_from_u64(9);
        let mut clock = Clock::new(DeviceClock { wraps_ns, tick_ns: u64::MAX });
        let mut host_ns = 0;
        for n in 0..3000_u32 {
            host_ns += random.next_u64() % 40_000_000;
            let device_ns = random.next_u64() >> (random.next_u64() % 64);
            let stamp = clock.take(device_ns, Nanos::from_nanos(host_ns));
            if let Some(Placed::At { ns, u_ns }) = stamp.map(|stamp| clock.placed(stamp)) {
                assert!(!ns.is_nan() && !u_ns.is_nan(), "{n}");
            }
        }
    }
}

#[test]
fn a_time_that_repeats_is_no_second_time() {
    let mut clock = Clock::new(DeviceClock::default());
    assert!(clock.take(5, Nanos::from_millis(1)).is_some());
    assert!(clock.take(5, Nanos::from_millis(2)).is_none());
    assert_eq!(clock.state().repeated, 1);
}
