//! Joining through wraps, losses, stalls and reconnects.

use super::*;
use asphera_link::{Count, Values};
use proptest::prelude::*;

fn reading(stream: usize, trigger: u64, host: Nanos) -> Reading {
    let (first, modulus) = if stream == 0 { (0, 65_536) } else { (1, 240) };
    Reading {
        host,
        device_time_ns: None,
        count: Some(Count { raw: first + (trigger % u64::from(modulus)) as u32, first, modulus }),
        values: [Some(trigger as f64 + 0.5 * stream as f64)].into_iter().collect::<Values>(),
        flags: Flags::empty(),
    }
}

fn settings() -> SyncSettings {
    SyncSettings { wait: Duration::from_millis(500), capacity: 10_000, paced: true }
}

/// Two devices that are ready before the scan.
fn armed(settings: SyncSettings) -> Synchronizer {
    let mut sync = Synchronizer::new(2, settings);
    sync.ready(0, Nanos::ZERO);
    sync.ready(1, Nanos::ZERO);
    sync
}

/// All links have been silent for long.
const LONG_AFTER: Nanos = Nanos::from_millis(3_600_000);

fn at(trigger: u64) -> Nanos {
    Nanos::from_nanos(trigger * 250_000)
}

fn assert_joined(record: &Record) {
    let count = record.count.unwrap() as f64;
    assert_eq!(record.readings[0].as_ref().unwrap().values.get(0), Some(count));
    assert_eq!(record.readings[1].as_ref().unwrap().values.get(0), Some(count + 0.5));
}

#[test]
fn hundred_thousand_triggers_join_through_every_wrap() {
    let mut sync = armed(settings());
    let mut out = Vec::new();
    for trigger in 0..100_000 {
        sync.take(0, reading(0, trigger, at(trigger)), &mut out);
        sync.take(1, reading(1, trigger, at(trigger)), &mut out);
    }
    assert_eq!(out.len(), 100_000);
    out.iter().for_each(assert_joined);
    assert!(sync.counts().all(|counts| counts == StreamCounts::default()));
}

#[test]
fn companion_that_was_gone_for_three_seconds_joins_again_at_the_right_place() {
    let mut sync = armed(settings());
    let mut out = Vec::new();
    for trigger in 0..40_000 {
        let gone = (8_000..20_000).contains(&trigger);
        if trigger == 8_000 {
            sync.interrupted(1);
        }
        while let Some(due) = sync.poll_timeout().filter(|due| *due <= at(trigger)) {
            sync.timeout(due, &mut out);
        }
        sync.take(0, reading(0, trigger, at(trigger)), &mut out);
        if !gone {
            sync.take(1, reading(1, trigger, at(trigger)), &mut out);
        }
    }
    assert_eq!(out.len(), 40_000);
    let (joined, lonely): (Vec<_>, Vec<_>) = out.iter().partition(|record| record.flags.is_empty());
    joined.iter().for_each(|record| assert_joined(record));
    assert_eq!((joined.len(), lonely.len()), (28_000, 12_000));
    let counts: Vec<_> = sync.counts().collect();
    assert_eq!((counts[0].unjoined, counts[1].lost), (12_000, 12_000));
}

#[test]
fn cycles_lost_on_an_open_link_are_found_and_never_joined_wrongly() {
    let mut sync = armed(SyncSettings { wait: Duration::from_secs(2), ..settings() });
    let mut out = Vec::new();
    for trigger in 0..20_000 {
        while let Some(due) = sync.poll_timeout().filter(|due| *due <= at(trigger)) {
            sync.timeout(due, &mut out);
        }
        sync.take(0, reading(0, trigger, at(trigger)), &mut out);
        // 700 triggers, nearly three cycles, are gone without a trace on the link.
        if !(8_000..8_700).contains(&trigger) {
            sync.take(1, reading(1, trigger, at(trigger)), &mut out);
        }
    }
    sync.flush(LONG_AFTER, &mut out);
    assert_eq!(out.len(), 20_000);
    let joined: Vec<_> = out.iter().filter(|record| record.flags.is_empty()).collect();
    joined.iter().for_each(|record| assert_joined(record));
    assert!(joined.len() > 16_000, "{}", joined.len());
    assert_eq!(sync.counts().nth(1).unwrap().slips, 1);
}

#[test]
fn a_host_that_was_held_up_joins_everything() {
    for primary_first in [true, false] {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        let mut backlog = Vec::new();
        for trigger in 0..10_000 {
            // 200 ms in which nothing is read, then one link's backlog after the other's.
            if (4_000..4_800).contains(&trigger) {
                backlog.push(trigger);
                continue;
            }
            let streams = if primary_first { [0, 1] } else { [1, 0] };
            for stream in streams {
                for late in &backlog {
                    sync.take(stream, reading(stream, *late, at(trigger)), &mut out);
                }
            }
            backlog.clear();
            for stream in streams {
                sync.take(stream, reading(stream, trigger, at(trigger)), &mut out);
            }
        }
        sync.flush(LONG_AFTER, &mut out);
        assert_eq!(out.len(), 10_000);
        out.iter().for_each(|record| assert!(record.flags.is_empty()));
        out.iter().for_each(assert_joined);
    }
}

#[test]
fn a_cycle_lost_beyond_all_rates_shows_at_the_end() {
    let mut sync = armed(settings());
    let mut out = Vec::new();
    for trigger in 0..2_000 {
        sync.take(0, reading(0, trigger, Nanos::ZERO), &mut out);
        if !(500..1_000).contains(&trigger) {
            sync.take(1, reading(1, trigger, Nanos::ZERO), &mut out);
        }
    }
    sync.flush(LONG_AFTER, &mut out);
    assert_eq!(sync.counts().nth(1).unwrap().slips, 1);
}

/// At 16 kHz one link may be 166 triggers, 10 ms, behind the other when an operator stops the scan. That is no lost cycle; the
/// same is one where both have been silent since.
#[test]
fn a_scan_that_is_stopped_at_full_rate_lost_no_cycle() {
    for (now_ms, slips) in [(251, 0), (351, 1)] {
        let mut sync = armed(settings());
        let fast = |trigger: u64| Nanos::from_nanos(trigger * 62_500);
        let mut out = Vec::new();
        for trigger in 0..4_000 {
            sync.take(0, reading(0, trigger, fast(trigger)), &mut out);
            if let Some(late) = trigger.checked_sub(166) {
                sync.take(1, reading(1, late, fast(trigger)), &mut out);
            }
        }
        sync.flush(Nanos::from_millis(now_ms), &mut out);
        let joined = out.iter().filter(|record| record.flags.is_empty());
        assert_eq!(joined.inspect(|record| assert_joined(record)).count(), 3_834);
        assert_eq!(sync.counts().nth(1).unwrap().slips, slips, "at {now_ms} ms");
    }
}

/// A bench that waits for its host, on a host that is busy: one link is hundreds of triggers ahead of the other
/// for seconds, at rates at which a paced trigger's host times would tell that a cycle is missing.
#[test]
fn without_a_pace_no_link_is_suspected_for_being_late() {
    for (paced, late) in [(true, true), (false, true), (false, false)] {
        let mut sync = armed(SyncSettings { wait: Duration::from_secs(60), paced, ..settings() });
        let mut out = Vec::new();
        // 1000 a second for 20 s, the companion (or the primary) 700 triggers behind.
        let at = |trigger: u64| Nanos::from_millis(trigger);
        for trigger in 0..20_700 {
            let (first, second) = if late { (0, 1) } else { (1, 0) };
            if trigger < 20_000 {
                sync.take(first, reading(first, trigger, at(trigger)), &mut out);
            }
            if trigger >= 700 {
                sync.take(second, reading(second, trigger - 700, at(trigger)), &mut out);
            }
        }
        sync.flush(LONG_AFTER, &mut out);
        assert_eq!(out.len(), 20_000);
        let slips = sync.counts().nth(1).unwrap().slips;
        if paced {
            // Taken for a lost cycle, and said so.
            assert!(slips > 0);
            continue;
        }
        assert!(out.iter().all(|record| record.flags.is_empty()));
        out.iter().for_each(assert_joined);
        assert_eq!(slips, 0);
    }
}

/// Without a pace a loss leaves the cycle open until both are seen to have had the same last trigger, however
/// far apart they were read.
#[test]
fn a_loss_without_a_pace_is_never_joined_on_a_guess() {
    for (lost, end_joins) in [(3, true), (700, false), (240, false)] {
        let wait = Duration::from_secs(100);
        let mut sync = armed(SyncSettings { wait, paced: false, ..settings() });
        let mut out = Vec::new();
        for trigger in 0..6_000 {
            sync.take(0, reading(0, trigger, Nanos::from_millis(trigger)), &mut out);
            if !(3_000..3_000 + lost).contains(&trigger) {
                let late = Nanos::from_millis(trigger + 300);
                sync.take(1, reading(1, trigger, late), &mut out);
            }
        }
        sync.flush(LONG_AFTER, &mut out);
        let joined = out.iter().filter(|record| record.flags.is_empty());
        if lost % 240 == 0 {
            // What left no trace in the counts shows at the end.
            assert_eq!(sync.counts().nth(1).unwrap().slips, 1);
            continue;
        }
        assert_eq!(
            joined.clone().inspect(|record| assert_joined(record)).count() > 5_000,
            end_joins
        );
    }
}

/// Beyond all rates nothing tells the cycle of a device that came late: nothing of it is joined.
#[test]
fn a_device_that_comes_late_to_a_fast_scan_is_not_joined_on_a_guess() {
    let mut sync = Synchronizer::new(2, settings());
    sync.ready(0, Nanos::ZERO);
    let fast = |trigger: u64| Nanos::from_nanos(1_000_000 + trigger * 5_000);
    let mut out = Vec::new();
    for trigger in 0..50_000 {
        sync.take(0, reading(0, trigger, fast(trigger)), &mut out);
        if trigger == 20_000 {
            sync.ready(1, fast(trigger));
        }
        if trigger >= 20_000 {
            sync.take(1, reading(1, trigger, fast(trigger)), &mut out);
        }
    }
    sync.flush(LONG_AFTER, &mut out);
    assert_eq!(out.len(), 50_000);
    assert!(out.iter().all(|record| record.flags == Flags::UNJOINED));
    assert_eq!(sync.counts().nth(1).unwrap().ambiguous, 30_000);
}

#[test]
fn counters_that_were_not_reset_are_not_joined_and_cost_nothing_that_was_not_lost() {
    let mut sync = armed(settings());
    let mut out = Vec::new();
    for trigger in 0..20_000 {
        sync.take(0, reading(0, 5_000 + trigger, at(trigger)), &mut out);
        sync.take(1, reading(1, 56 + trigger, at(trigger)), &mut out);
    }
    sync.flush(LONG_AFTER, &mut out);
    assert_eq!(sync.unreset(), Some(5_000));
    assert!(out.iter().all(|record| record.flags == Flags::UNJOINED));
    assert_eq!(sync.counts().next().unwrap().lost, 0);
}

/// Beyond all rates a loss leaves the cycle open until both are seen to have had the same last trigger.
#[test]
fn a_loss_beyond_all_rates_is_never_joined_on_a_guess() {
    for (lost, end_joins) in [(3, true), (700, false)] {
        let mut sync = armed(SyncSettings { wait: Duration::from_secs(100), ..settings() });
        let fast = |trigger: u64| Nanos::from_nanos(trigger * 20_000);
        let mut out = Vec::new();
        for trigger in 0..10_000 {
            sync.take(0, reading(0, trigger, fast(trigger)), &mut out);
            if !(5_000..5_000 + lost).contains(&trigger) {
                sync.take(1, reading(1, trigger, fast(trigger)), &mut out);
            }
        }
        sync.flush(LONG_AFTER, &mut out);
        let joined = out.iter().filter(|record| record.flags.is_empty());
        assert_eq!(
            joined.clone().inspect(|record| assert_joined(record)).count() > 6_000,
            end_joins
        );
        assert_eq!(sync.counts().nth(1).unwrap().slips, u64::from(!end_joins));
    }
}

#[test]
fn suspect_readings_are_not_counted_twice() {
    let mut sync = Synchronizer::new(1, settings());
    let mut out = Vec::new();
    for trigger in 0..100 {
        let flags = if trigger % 10 == 5 { Flags::SUSPECT } else { Flags::empty() };
        sync.take(0, Reading { flags, ..reading(0, trigger, at(trigger)) }, &mut out);
    }
    sync.flush(LONG_AFTER, &mut out);
    assert_eq!(out.len(), 100);
    assert_eq!(sync.counts().next().unwrap().lost, 0);
}

/// The end of a scan that was read late: nothing comes after it that could show that the backlog is gone.
#[test]
fn what_a_backlog_held_is_joined_when_the_links_fall_silent() {
    let mut sync = armed(settings());
    let mut out = Vec::new();
    for trigger in 0..2_000 {
        sync.take(0, reading(0, trigger, at(trigger)), &mut out);
        sync.take(1, reading(1, trigger, at(trigger)), &mut out);
    }
    for trigger in 2_000..3_000 {
        sync.take(0, reading(0, trigger, at(2_000)), &mut out);
    }
    sync.backlogged(1, true);
    for trigger in 2_000..3_000 {
        sync.take(1, reading(1, trigger, at(2_000)), &mut out);
    }
    let due = sync.poll_timeout();
    if let Some(due) = due {
        assert!(due.since(at(2_000)) <= Duration::from_millis(100));
        sync.timeout(due, &mut out);
    }
    assert_eq!((out.len(), sync.pending()), (3_000, 0));
    out.iter().for_each(assert_joined);
}

#[test]
fn wait_is_bounded_in_number_too() {
    let mut sync = armed(SyncSettings { capacity: 10, ..settings() });
    let mut out = Vec::new();
    (0..100).for_each(|trigger| sync.take(0, reading(0, trigger, at(0)), &mut out));
    assert!(sync.pending() <= 10);
    sync.flush(LONG_AFTER, &mut out);
    assert_eq!(out.len(), 100);
    assert!(out.iter().all(|record| record.flags == Flags::UNJOINED));
}

/// A trigger whose companion lay unread while the host did not run.
#[test]
fn a_wait_over_which_the_host_was_held_up_is_not_over() {
    let ms = Nanos::from_millis;
    for (put_off, joined) in [(true, 2), (false, 1)] {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        sync.take(0, reading(0, 0, ms(10)), &mut out);
        if put_off {
            sync.put_off(ms(2_250));
        }
        sync.take(0, reading(0, 1, ms(2_000)), &mut out);
        sync.take(1, reading(1, 0, ms(2_001)), &mut out);
        sync.take(1, reading(1, 1, ms(2_001)), &mut out);
        assert_eq!(out.iter().filter(|record| record.flags.is_empty()).count(), joined);
    }
}

#[test]
fn suspect_readings_do_not_move_the_count() {
    let mut sync = armed(settings());
    let mut out = Vec::new();
    sync.take(0, reading(0, 0, at(0)), &mut out);
    sync.take(0, Reading { flags: Flags::SUSPECT, ..reading(0, 40_000, at(0)) }, &mut out);
    sync.take(0, reading(0, 1, at(0)), &mut out);
    assert_eq!(sync.counts().next().unwrap().lost, 0);
    assert_eq!(out.len(), 1);
}

proptest! {
    /// Whatever is lost on either side and however the two interleave, no reading is joined to a
    /// stranger and every primary reading becomes one record.
    #[test]
    fn nothing_is_joined_wrongly(
        losses in prop::collection::vec((0u8..10, 0u8..10), 1..600),
        lag in 0usize..40,
    ) {
        let mut sync = armed(settings());
        let mut out = Vec::new();
        let mut late = std::collections::VecDeque::new();
        let mut primaries = 0;
        for (trigger, (a, b)) in losses.iter().enumerate() {
            if *a > 0 {
                primaries += 1;
                sync.take(0, reading(0, trigger as u64, at(trigger as u64)), &mut out);
            }
            if *b > 0 {
                late.push_back(trigger as u64);
            }
            if late.len() > lag {
                let companion = late.pop_front().unwrap();
                sync.take(1, reading(1, companion, at(trigger as u64)), &mut out);
            }
        }
        sync.flush(LONG_AFTER, &mut out);
        prop_assert_eq!(out.len(), primaries);
        out.iter().filter(|record| record.flags.is_empty()).for_each(assert_joined);
    }
}
