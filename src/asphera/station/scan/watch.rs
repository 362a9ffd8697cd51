//! Where the axes are, and whether they are where they should be.

use asphera_link::{Nanos, Reading};
use asphera_plan::AxisRun;

use super::plan::ScanPlan;

/// Watches places and silence of the devices of a plan.
#[derive(Debug)]
pub(super) struct Watch {
    /// Newest position of each axis, in units of the machine, and when it was read.
    axes: [Option<(f64, Nanos)>; 2],
    /// Newest reading of the primary.
    primary: Option<Nanos>,
    /// Where the axes stand, or stood when the run began.
    stands: Option<[f64; 2]>,
    /// Silence counts from here at the earliest.
    since: Nanos,
}

impl Watch {
    pub(super) fn new(_plan: &ScanPlan) -> Watch {
        Watch { axes: [None; 2], primary: None, stands: None, since: Nanos::ZERO }
    }

    pub(super) fn begin(&mut self, now: Nanos) {
        self.since = now;
        self.stands = None;
    }

    pub(super) fn reading(&mut self, stream: usize, reading: &Reading, plan: &ScanPlan) {
        if stream == 0 {
            self.primary = Some(reading.host);
        }
        for (axis, known) in plan.axes.iter().zip(&mut self.axes) {
            if axis.stream == stream
                && let Some(value) = reading.values.get(axis.channel)
            {
                *known = Some((axis.scale * value + axis.offset, reading.host));
            }
        }
    }

    /// The axes on a line are not known any more.
    pub(super) fn forget(&mut self, line: usize, devices: &[(usize, usize); 2]) {
        for (known, (of, _)) in self.axes.iter_mut().zip(devices) {
            if *of == line {
                *known = None;
            }
        }
    }

    /// Every axis counts anew: what was read before does not tell its place.
    pub(super) fn rehomed(&mut self, now: Nanos) {
        self.axes = [None; 2];
        self.begin(now);
    }

    /// The axes stand where they are.
    pub(super) fn stand(&mut self) {
        self.stands = self.places();
    }

    /// Whether every axis and the primary answered.
    pub(super) fn is_known(&self) -> bool {
        self.places().is_some() && self.primary.is_some_and(|primary| primary >= self.since)
    }

    pub(super) fn places(&self) -> Option<[f64; 2]> {
        let [first, second] = self.axes;
        Some([first?.0, second?.0])
    }

    /// Time of the newest reading.
    pub(super) fn newest(&self) -> Nanos {
        let axes = self.axes.iter().flatten().map(|(_, at)| *at);
        axes.chain(self.primary).max().unwrap_or(self.since)
    }

    /// Why an axis is not where it should be: where it stands, or between both ends of its run.
    pub(super) fn strayed(&self, run: Option<&AxisRun>, plan: &ScanPlan) -> Option<String> {
        let (stands, places) = self.stands.zip(self.places())?;
        (0..2).find_map(|k| {
            let axis = &plan.axes[k];
            let to = run.map_or(stands[k], |run| run.to[k]);
            let (low, high) = (stands[k].min(to), stands[k].max(to));
            let at = places[k];
            let is_within = at >= low - axis.tolerance && at <= high + axis.tolerance;
            (!is_within).then(|| {
                format!(
                    "axis {} is at {at:.4}, expected {low:.4} to {high:.4}: something else moves it; \
                     leave the stage to asphera, then arm the scan again",
                    axis.name
                )
            })
        })
    }

    /// Why an axis that arrived is not where it was sent.
    pub(super) fn missed(&self, run: &AxisRun, plan: &ScanPlan) -> Option<String> {
        let places = self.places()?;
        (0..2).find_map(|k| {
            let axis = &plan.axes[k];
            let off = (places[k] - run.to[k]).abs();
            (off > axis.tolerance).then(|| {
                format!(
                    "axis {} stands at {:.4}, expected {:.4}: it was stopped, or its microstep size is wrong; \
                     look at the stage, then arm the scan again",
                    axis.name, places[k], run.to[k]
                )
            })
        })
    }

    /// Why a device has been silent for too long.
    pub(super) fn silent(&self, now: Nanos, plan: &ScanPlan) -> Option<String> {
        let is_late = |heard: Nanos| heard.max(self.since) + plan.watchdog <= now;
        let cure = "check its cable and power, then arm the scan again";
        let ms = plan.watchdog.as_millis();
        for (known, axis) in self.axes.iter().zip(&plan.axes) {
            if known.is_none_or(|(_, at)| is_late(at)) {
                return Some(format!("no position of axis {} for {ms} ms: {cure}", axis.name));
            }
        }
        let is_silent = self.primary.is_none_or(is_late);
        is_silent.then(|| format!("no reading of the primary device for {ms} ms: {cure}"))
    }

    /// When the next of them has been silent for too long.
    pub(super) fn poll_timeout(&self, plan: &ScanPlan) -> Option<Nanos> {
        let axes = self.axes.iter().flatten().map(|(_, at)| *at);
        let oldest = axes.chain(self.primary).min().unwrap_or(self.since);
        Some(oldest.max(self.since) + plan.watchdog)
    }
}
