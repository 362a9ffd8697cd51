//! The stream of profiles: what arrives on the second connection.

use asphera_link::{Count, Event, FaultKind, Flags, Nanos, Profile as Points, Reading, Values};

use super::{COUNTS, Profiler, State};
use crate::wire::{Layout, NOTICE_LEN, NoHeight, Notice, Profile, is_notice};

/// The stream of a connection.
#[derive(Debug, Default)]
pub(super) struct Stream {
    layout: Option<Layout>,
    /// x of every point, mm.
    x_mm: Vec<f64>,
    /// Whether what arrives are profiles of the layout.
    is_open: bool,
    /// The controller was told to stop, and may say that it did.
    expects_stop: bool,
    /// Bytes of a profile or notice that has not come whole.
    pending: Vec<u8>,
    /// Trigger count of the last profile.
    last_trigger: Option<u32>,
    /// Profiles with a wrong sum since the last good one.
    damaged: u32,
}

impl Stream {
    /// Profiles will have this layout.
    pub(super) fn prepare(&mut self, layout: Layout) {
        let place_mm = |index: u16| {
            let step = f64::from(index) * f64::from(layout.x_pitch_10nm);
            (f64::from(layout.x_start_10nm) + step) / PER_MM
        };
        self.x_mm = (0..layout.points).map(place_mm).collect();
        self.layout = Some(layout);
    }

    /// Heights have this unit, in 10 nm.
    pub(super) fn set_unit(&mut self, unit_10nm: u16) {
        if let Some(layout) = &mut self.layout {
            layout.unit_10nm = unit_10nm;
        }
    }

    /// From now on profiles are expected; the code that starts them.
    pub(super) fn open(&mut self) -> u32 {
        self.is_open = true;
        self.damaged = 0;
        self.layout.map_or(0, |layout| layout.start_code)
    }

    /// A notice that the stream has stopped is none of a failure.
    pub(super) fn expect_stop(&mut self) {
        self.expects_stop = true;
    }

    /// Nothing is expected any more; how many bytes were pending.
    pub(super) fn close(&mut self) -> usize {
        self.is_open = false;
        std::mem::take(&mut self.pending).len()
    }

    /// The same, and what comes after another start does not go on with the counts of this one.
    pub(super) fn end(&mut self) -> usize {
        self.last_trigger = None;
        self.close()
    }

    fn layout(&self) -> Option<Layout> {
        self.layout.filter(|_| self.is_open)
    }
}

impl Profiler {
    pub(super) fn take_stream(&mut self, now: Nanos, bytes: &[u8]) {
        self.stream.pending.extend_from_slice(bytes);
        let pending = std::mem::take(&mut self.stream.pending);
        let mut rest = &pending[..];
        while self.state != State::Abandoned
            && let Some(len) = self.take_one(now, rest)
        {
            rest = &rest[len..];
        }
        if self.state == State::Abandoned {
            self.discard(rest.len());
        } else {
            self.stream.pending = rest.to_vec();
        }
    }

    /// Takes what stands at the beginning of `bytes`; how long it is. `None`: more bytes are needed.
    fn take_one(&mut self, now: Nanos, bytes: &[u8]) -> Option<usize> {
        let may_be_notice = bytes.len() < 4 && bytes.iter().all(|byte| *byte == 0xFF);
        if is_notice(bytes) || may_be_notice {
            self.take_notice(now, Notice::decode(bytes)?);
            return Some(NOTICE_LEN);
        }
        let Some(layout) = self.stream.layout() else {
            // Nobody asked for it, and nobody knows where a profile ends.
            self.discard(bytes.len());
            return Some(bytes.len());
        };
        match Profile::decode(bytes, &layout)? {
            Ok(profile) => {
                (self.last_profile, self.stream.damaged) = (now, 0);
                self.stream.expects_stop &= self.state == State::Stopping;
                self.note_trigger(profile.trigger_count);
                self.give(now, &profile, &layout);
            }
            Err(error) => {
                self.tally.damaged += 1;
                self.stream.damaged += 1;
                self.discard(Profile::len(&layout));
                if self.stream.damaged < DAMAGED_IN_ROW {
                    self.events
                        .fault(FaultKind::Protocol, format!("a profile was passed over: {error}"));
                } else {
                    let detail = format!(
                        "{DAMAGED_IN_ROW} profiles in a row with a wrong sum: they have not the {} points that were announced, or bytes are missing: check that the active program stays as it is, and has one head",
                        layout.points
                    );
                    self.give_up(FaultKind::Protocol, detail);
                }
            }
        }
        Some(Profile::len(&layout))
    }

    fn take_notice(&mut self, now: Nanos, notice: Notice) {
        if notice.ends_batch() {
            self.tally.batches += 1;
        }
        match notice.stopped() {
            Some(_) if std::mem::take(&mut self.stream.expects_stop) => {}
            Some(reason) if self.stream.is_open => {
                self.tally.stops += 1;
                let detail = format!(
                    "the controller stopped the stream (notice {reason:04X}h): it is started anew; see the errors of the controller"
                );
                self.events.fault(FaultKind::Device, detail);
                self.wait(now);
            }
            Some(_) => {}
            None if notice.ends_batch() => {}
            None => {
                self.events.fault(
                    FaultKind::Protocol,
                    format!("a notice {:08X}h that says nothing", notice.0),
                );
                self.discard(NOTICE_LEN);
            }
        }
    }

    /// Reports triggers without a profile.
    fn note_trigger(&mut self, trigger: u32) {
        let Some(last) = self.stream.last_trigger.replace(trigger) else { return };
        match trigger.wrapping_sub(last) {
            1 => {}
            ahead @ 2..COUNTS => {
                let missing = ahead - 1;
                self.tally.missing += u64::from(missing);
                let detail = format!(
                    "{missing} profiles are missing before trigger {trigger}, not sent or with a wrong sum: check trigger rate and network"
                );
                self.events.fault(FaultKind::Protocol, detail);
            }
            _ => {
                self.tally.restarts += 1;
                let detail = format!(
                    "the controller counts triggers from {trigger} again after {last}: it was restarted, or its counts were reset; start the scan anew"
                );
                self.events.fault(FaultKind::Device, detail);
            }
        }
    }

    fn give(&mut self, now: Nanos, profile: &Profile<'_>, layout: &Layout) {
        let unit_10nm = f64::from(layout.unit_10nm);
        let mut without = [0_u32; 4];
        let heights = profile.heights().zip(&self.stream.x_mm);
        let points: Points = heights
            .map(|(height, x_mm)| match height {
                Ok(height) => Some([*x_mm, f64::from(height) * unit_10nm / PER_MM]),
                Err(why) => {
                    without[reason(why)] += 1;
                    None
                }
            })
            .collect();
        let count = points.points_mm().len();
        let valid = points.valid();
        self.tally.readings += 1;
        self.tally.points += count as u64;
        self.tally.empty_points += (count - valid) as u64;
        let [no_peak, masked, dead_zone, unprocessed] = without.map(f64::from);
        let encoder = f64::from(profile.encoder_count);
        let values = [encoder, valid as f64, no_peak, masked, dead_zone, unprocessed].map(Some);
        self.events.push(Event::Reading(Reading {
            host: now,
            device_time_ns: None,
            count: Some(Count { raw: profile.trigger_count % COUNTS, first: 0, modulus: COUNTS }),
            values: Values::from_iter(values).with_profile(points),
            flags: if valid == 0 { Flags::NO_SIGNAL } else { Flags::empty() },
        }));
    }
}

/// Place of a reason among the channels.
fn reason(why: NoHeight) -> usize {
    match why {
        NoHeight::NoPeak => 0,
        NoHeight::Masked => 1,
        NoHeight::DeadZone => 2,
        NoHeight::Unprocessed => 3,
    }
}

/// Units of 10 nm in a mm.
const PER_MM: f64 = 1e5;

/// After so many profiles with a wrong sum nobody knows where the next one begins.
const DAMAGED_IN_ROW: u32 = 2;
