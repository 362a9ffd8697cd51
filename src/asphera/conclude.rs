//! The end of a measurement: the points' figures joined with what the links delivered and lost.
//!
//! Live and replay both end here, so that their reports agree.

use std::time::Duration;

use asphera_link::Nanos;
use asphera_report::words::{count, counted};
use asphera_report::{DeviceFigures, LinkFigures, SessionFigures, Verdict};

use crate::calibration::CalibrationFile;
use crate::session::{Header, Recovery};
use crate::station::{Bench, Kinematics};
use asphera_measure::{Measurement, doubt, undecide};

/// Knowledge of the station at the end of a session.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Triggers the primary device skipped.
    pub lost: u64,
    /// Triggers the scan should have had and that never came, where that is known.
    pub missing: u64,
    /// The primary's first count, if the counters had not been reset.
    pub unreset: Option<u64>,
    /// How long the computer was suspended since the first reading.
    pub suspended: Duration,
    /// When the last reading of the primary arrived.
    pub last_point: Option<Nanos>,
    /// Links with a device that would not answer a trigger.
    pub unready: Vec<String>,
    /// Links with such a device that have never opened.
    pub unopened: Vec<String>,
    /// Bytes and readings of every link and device, delivered and lost.
    pub links: Vec<LinkFigures>,
    /// Whose session it is and how it ended.
    pub session: SessionFigures,
    /// How its axes make points.
    pub kinematics: Kinematics,
}

impl Outcome {
    /// Taken at the end, before the devices are told to stop.
    pub fn new(bench: &Bench, session: SessionFigures) -> Outcome {
        Outcome {
            lost: bench.lost(),
            missing: bench.missing(),
            unreset: bench.unreset(),
            suspended: bench.suspended(),
            last_point: bench.last_primary(),
            unready: bench.unready().map(str::to_owned).collect(),
            unopened: bench.unopened().map(str::to_owned).collect(),
            links: bench.figures(),
            session: SessionFigures {
                calibration: bench.calibration().map(CalibrationFile::figures),
                error_tables: error_tables(bench.kinematics()),
                places: bench.places(),
                thermal: bench.thermal(),
                ..session
            },
            kinematics: bench.kinematics().clone(),
        }
    }
}

/// Names of the files of errors of the axes.
fn error_tables(kinematics: &Kinematics) -> Vec<String> {
    let tables = kinematics.axes().into_iter().filter_map(|axis| axis.errors);
    tables.map(|table| table.file.clone()).collect()
}

/// Adds to the figures of the points what the station knows: losses, links, session.
pub fn conclude(measurement: &mut Measurement, outcome: Outcome) {
    let report = &mut measurement.report;
    report.points.lost = outcome.lost;
    report.points.missing = outcome.missing;
    outcome.judge(&mut report.verdict);
    let direction_deg = report.profile.as_ref().map(|profile| profile.direction_deg);
    let stood_still = direction_deg.and_then(|of| outcome.kinematics.stood_still(of));
    if let Some((axis, key)) = stood_still {
        undecide(
            &mut report.verdict,
            format!(
                "all points of the session lie on a straight line: the axis {axis} may have stood still; for a line scan give \
                 it {key} in the table kinematics of the station"
            ),
        );
    }
    report.links = outcome.links;
    report.session = Some(outcome.session);
}

impl Outcome {
    /// Adds to a verdict what was lost, and takes a pass back where that is in doubt.
    pub(crate) fn judge(&self, verdict: &mut Verdict) {
        for (name, slips) in devices(&self.links, |device| device.slips) {
            doubt(
                verdict,
                format!(
                    "{name}: a whole cycle of the shared count was missing {}; points in between may be misplaced",
                    counted(slips, "time")
                ),
            );
        }
        if let Some(first) = self.unreset {
            doubt(
                verdict,
                format!(
                    "the counters were not reset before the scan: the first count was {first}, so no readings could be joined. Reset them and scan again"
                ),
            );
        }
        if !self.suspended.is_zero() {
            undecide(
                verdict,
                format!(
                    "the computer was suspended for {:.1} s during the scan, and readings may be missing. Turn suspending off and measure again",
                    self.suspended.as_secs_f64()
                ),
            );
        }
        if self.missing > 0 {
            let triggers = counted(self.missing, "trigger");
            undecide(verdict, format!("{triggers} of the scan never came"));
        }
        if self.last_point.is_none() && self.session.ended == "idle" {
            undecide(verdict, self.why_no_trigger());
        }
        if !matches!(self.session.ended.as_str(), "complete" | "idle") {
            undecide(verdict, format!("the session was {} before its end", self.session.ended));
        }
        let jumps = |device: &DeviceFigures| device.clock.as_ref().map_or(0, |clock| clock.jumps);
        for (name, jumps) in devices(&self.links, jumps).into_iter().filter(|_| self.is_by_time()) {
            doubt(
                verdict,
                format!(
                    "{name}: its clock jumped {}, or its link became slower for longer than a second; points after that may be misplaced",
                    counted(jumps, "time")
                ),
            );
        }
        for (name, lost) in devices(&self.links, |device| device.lost) {
            let were = if lost == 1 { "was" } else { "were" };
            verdict.reasons.push(format!("{name}: {} {were} lost", counted(lost, "trigger")));
        }
    }
}

impl Outcome {
    /// Whether good points are there that were joined by time.
    fn is_by_time(&self) -> bool {
        self.session.places.is_some()
    }

    /// Why a session ended without a trigger.
    fn why_no_trigger(&self) -> String {
        if self.unready.is_empty() {
            return "no trigger came, though every device was ready: start the scan sooner, or set [scan] first_s to more"
                .to_owned();
        }
        if !self.unopened.is_empty() {
            return format!(
                "no trigger came: the link {} did not open. Plug the device in and switch it on, or check the table of the link",
                self.unopened.join(", the link ")
            );
        }
        let (strangers, silent): (Vec<_>, Vec<_>) = self
            .unready
            .iter()
            .map(|name| (name, self.strange_bytes(name)))
            .partition(|(_, bytes)| *bytes > 0);
        let strangers: Vec<String> = strangers
            .iter()
            .map(|(name, bytes)| format!("{name} sent {} and no telegram", counted(*bytes, "byte")))
            .collect();
        let silent: Vec<&str> = silent.iter().map(|(name, _)| name.as_str()).collect();
        let mut sentences = Vec::new();
        if !strangers.is_empty() {
            sentences.push(format!("{}: wrong device or baud rate?", strangers.join(", ")));
        }
        if !silent.is_empty() {
            sentences.push(format!(
                "{} gave no answer since its link opened. Switch the device on, or check address, wiring and baud rate",
                silent.join(", ")
            ));
        }
        format!("no trigger came: {}", sentences.join(" "))
    }

    /// Bytes of a link that were no telegram, where nine in ten were none; 0 of any other link.
    fn strange_bytes(&self, link: &str) -> u64 {
        // A driver may still hold the last few of them.
        let is_strange = |figures: &&LinkFigures| {
            figures.name == link && 10 * figures.discarded_bytes >= 9 * figures.received_bytes
        };
        self.links.iter().find(is_strange).map_or(0, |figures| figures.discarded_bytes)
    }
}

/// Notes what a recording lacks: its figures are those of a part of the session.
pub fn note_recovery(verdict: &mut Verdict, recovery: &Recovery) {
    if recovery.lost_at_least > 0 || recovery.damaged_places > 0 {
        doubt(
            verdict,
            format!(
                "the recording is damaged: at least {} {}, {} could not be read",
                count(recovery.lost_at_least),
                if recovery.lost_at_least == 1 {
                    "entry is missing"
                } else {
                    "entries are missing"
                },
                counted(recovery.damaged_places, "place")
            ),
        );
    }
}

/// Whose session it is and how it ended.
pub fn session_figures(header: &Header, ended: &str) -> SessionFigures {
    SessionFigures {
        id: header.folder_name(),
        started: header.started_rfc3339(),
        station: header.station.clone(),
        version: header.version.clone(),
        ended: ended.to_owned(),
        label: header.label.clone(),
        calibration: None,
        error_tables: Vec::new(),
        places: None,
        thermal: None,
    }
}

/// Devices of which a count is not zero.
fn devices(links: &[LinkFigures], count: impl Fn(&DeviceFigures) -> u64) -> Vec<(String, u64)> {
    links
        .iter()
        .flat_map(|link| &link.devices)
        .map(|device| (device.name.clone(), count(device)))
        .filter(|(_, count)| *count > 0)
        .collect()
}
