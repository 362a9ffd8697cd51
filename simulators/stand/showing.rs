//! What the devices show: at a trigger, and to whoever asks in between.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use crate::axes::Axes;
use crate::moving::Moving;

/// Values of one channel at every trigger; `None`: it stands still.
pub(crate) type Course = Option<Vec<f64>>;

/// What all devices show.
pub(crate) struct Showing {
    /// Of each device and channel.
    courses: Vec<Vec<Course>>,
    /// Of each device and channel, where there is no course.
    still: Vec<Vec<f64>>,
    period: Duration,
    power_on: Instant,
    last: Mutex<Option<(u64, Instant)>>,
    axes: Axes,
    /// Of a station that moves its axes: what follows them, instead of courses.
    moving: Option<Moving>,
}

impl Showing {
    pub(crate) fn new(
        courses: Vec<Vec<Course>>,
        still: Vec<Vec<f64>>,
        period: Duration,
        (axes, moving): (Axes, Option<Moving>),
    ) -> Showing {
        let (power_on, last) = (Instant::now(), Mutex::new(None));
        Showing { courses, still, period, power_on, last, axes, moving }
    }

    /// The axes with a drive.
    pub(crate) fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Whether the station moves the axes.
    pub(crate) fn is_moved(&self) -> bool {
        self.moving.is_some()
    }

    /// How many triggers the scan has; a station that moves its axes has them as long as it likes.
    pub(crate) fn triggers(&self) -> u64 {
        if self.is_moved() {
            return u64::MAX;
        }
        let lengths = self.courses.iter().flatten().flatten().map(Vec::len);
        lengths.max().unwrap_or(0) as u64
    }

    /// Says that a trigger happens now.
    pub(crate) fn step(&self, trigger: u64) {
        *self.last() = Some((trigger, Instant::now()));
    }

    /// Says that the machine stands at the first trigger again.
    pub(crate) fn back(&self) {
        *self.last() = None;
    }

    /// Number of the last trigger; 0 before the first.
    pub(crate) fn trigger(&self) -> u64 {
        self.last().map_or(0, |(trigger, _)| trigger)
    }

    /// Values of a device at a trigger.
    pub(crate) fn at(&self, device: usize, trigger: u64) -> Vec<f64> {
        self.between(device, trigger, 0.0)
    }

    /// Values of a device now: on the way from the last trigger to the next.
    pub(crate) fn now(&self, device: usize) -> Vec<f64> {
        let last = *self.last();
        let Some((trigger, at)) = last else { return self.between(device, 0, 0.0) };
        let share = at.elapsed().as_secs_f64() / self.period.as_secs_f64();
        self.between(device, trigger, share.min(1.0))
    }

    /// Whether the scan has been over for a while, so that what lies at its end was seen from both sides.
    pub(crate) fn is_over(&self) -> bool {
        let ended = (*self.last()).filter(|(trigger, _)| trigger + 1 >= self.triggers());
        ended.is_some_and(|(_, at)| at.elapsed() > self.period + REST)
    }

    /// Whether a device shows something of the scan.
    pub(crate) fn changes(&self, device: usize) -> bool {
        self.courses[device].iter().any(Option::is_some)
    }

    /// Time since the devices were switched on, s.
    pub(crate) fn clock_s(&self) -> f64 {
        self.power_on.elapsed().as_secs_f64()
    }

    fn between(&self, device: usize, trigger: u64, share: f64) -> Vec<f64> {
        if let Some(moving) = &self.moving {
            return self.where_axes_stand(moving, trigger).swap_remove(device);
        }
        let value = |(course, still): (&Course, &f64)| {
            let Some(course) = course else { return *still };
            let Some(end) = course.len().checked_sub(1) else { return *still };
            let from = usize::try_from(trigger).unwrap_or(end).min(end);
            let to = (from + 1).min(end);
            (1.0 - share) * course[from] + share * course[to]
        };
        self.courses[device].iter().zip(&self.still[device]).map(value).collect()
    }

    /// Values of all devices where the axes stand now.
    fn where_axes_stand(&self, moving: &Moving, trigger: u64) -> Vec<Vec<f64>> {
        let mut values = self.still.clone();
        for (device, places) in self.axes.values() {
            for (value, place) in values[device].iter_mut().zip(places) {
                *value = place;
            }
        }
        moving.follow(trigger, &mut values);
        values
    }

    fn last(&self) -> MutexGuard<'_, Option<(u64, Instant)>> {
        // Whoever panicked left a whole value.
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How long devices that are asked answer after the scan.
const REST: Duration = Duration::from_secs(1);
