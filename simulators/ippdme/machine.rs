//! The server: commands in, answers out.

mod basics;
mod measuring;

use std::collections::VecDeque;

use asphera_ippdme::wire::{Call, Framer, ServerError, Severity, Tag};

use crate::motion::{Path, Place};
use crate::{Probe, Surface};

/// Machine and its probe.
#[derive(Clone, Debug)]
pub struct MachineSettings {
    /// Ball and part.
    pub probe: Probe,
    /// Standard deviation of the noise along z, nm.
    pub noise_nm: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Speed of a move, mm/s.
    pub speed_mm_s: f64,
    /// Speed at which a point is touched, mm/s.
    pub touch_mm_s: f64,
    /// Speed of a scan, mm/s.
    pub scan_mm_s: f64,
    /// Points of a line that a scan sends, at least 1.
    pub points_a_line: usize,
    /// The machine goes nowhere beyond, from the origin, mm.
    pub reach_mm: f64,
}

impl MachineSettings {
    /// A machine of usual speeds over a plane at z = 0, with a ball of 1 mm and without noise.
    pub fn usual() -> MachineSettings {
        MachineSettings {
            probe: Probe { surface: Surface::new(|_| Some(0.0)), radius_mm: 1.0 },
            noise_nm: 0.0,
            seed: 1,
            speed_mm_s: 100.0,
            touch_mm_s: 10.0,
            scan_mm_s: 20.0,
            points_a_line: 50,
            reach_mm: 500.0,
        }
    }
}

/// Something that happens to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The probe runs into something.
    Collision,
    /// The next command of a point touches nothing.
    NoTouch,
    /// It answers nothing from now on, or again.
    Silent(bool),
    /// The next line of a scan has a number too many.
    OddLine,
    /// So many points of scans from now on have a bad quality.
    PoorPoints(u64),
    /// An answer with a tag that no command had.
    ForeignTag,
    /// Bytes that no line may have.
    Noise,
}

/// A coordinate measuring machine. Times are seconds that never go back.
#[derive(Clone, Debug)]
pub struct Machine {
    settings: MachineSettings,
    framer: Framer,
    has_session: bool,
    is_homed: bool,
    tool: Option<String>,
    /// The error that has to be cleared.
    error: Option<u16>,
    point_columns: Vec<Column>,
    scan_columns: Vec<Column>,
    place: Place,
    activity: Option<Activity>,
    /// Commands that wait for the activity to end.
    waiting: VecDeque<(Tag, String)>,
    answers: Vec<u8>,
    points: u64,
    is_silent: bool,
    misses_next: bool,
    is_next_line_odd: bool,
    poor_points: u64,
}

/// Column of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    X,
    Y,
    Z,
    /// Quality.
    Q,
    /// Radius of the ball.
    Er,
}

/// Command that moves the machine.
#[derive(Clone, Debug)]
struct Activity {
    tag: Tag,
    text: String,
    path: Path,
    /// Answers, each with the time at which it is sent.
    answers: VecDeque<(f64, String)>,
    /// Error with which it ends.
    error: Option<ServerError>,
}

/// Error of a command.
fn error(severity: Severity, number: u16, cause: &str, text: &str) -> ServerError {
    ServerError { severity, number, cause: cause.replace('"', "'"), text: text.to_owned() }
}

impl Machine {
    /// A machine at rest where someone left it, not homed, without a tool.
    pub fn new(settings: MachineSettings) -> Machine {
        Machine {
            framer: Framer::default(),
            has_session: false,
            is_homed: false,
            tool: None,
            error: None,
            point_columns: vec![Column::X, Column::Y, Column::Z],
            scan_columns: vec![Column::X, Column::Y, Column::Z],
            place: LEFT_MM,
            activity: None,
            waiting: VecDeque::new(),
            answers: Vec::new(),
            points: 0,
            is_silent: false,
            misses_next: false,
            is_next_line_odd: false,
            poor_points: 0,
            settings,
        }
    }

    /// Whether it moves.
    pub fn is_moving(&self) -> bool {
        self.activity.is_some()
    }

    /// Place of the centre of the ball, mm.
    pub fn place_mm(&self, now_s: f64) -> [f64; 3] {
        self.activity.as_ref().map_or(self.place, |activity| activity.path.at(now_s))
    }

    /// A client is there, or gone. Without one it comes to rest.
    pub fn connected(&mut self, now_s: f64) {
        self.advance(now_s);
        self.place = self.place_mm(now_s);
        self.framer.reset();
        self.has_session = false;
        (self.activity, self.error) = (None, None);
        self.waiting.clear();
        self.answers.clear();
    }

    /// Takes bytes of the client.
    pub fn receive(&mut self, now_s: f64, bytes: &[u8]) {
        self.advance(now_s);
        for &byte in bytes {
            match self.framer.push(byte) {
                Ok(None) => {}
                Ok(Some(line)) => self.command(now_s, &String::from_utf8_lossy(&line)),
                Err(_) => {
                    self.framer.reset();
                    let error = error(Severity::Critical, 7, "", "Illegal character");
                    self.answer(Tag::UNASKED, &format!("! {error}"));
                }
            }
        }
    }

    /// Lets something happen.
    pub fn fault(&mut self, now_s: f64, fault: Fault) {
        self.advance(now_s);
        match fault {
            Fault::EmergencyStop => {
                let stop = error(Severity::Critical, 500, "", "Emergency stop");
                self.break_off(now_s, None);
                self.error = Some(stop.number);
                self.answer(Tag::UNASKED, &format!("! {stop}"));
            }
            Fault::Collision => self.break_off(now_s, Some((2504, "Collision"))),
            Fault::NoTouch => self.misses_next = true,
            Fault::Silent(is_silent) => self.is_silent = is_silent,
            Fault::OddLine => self.is_next_line_odd = true,
            Fault::PoorPoints(count) => self.poor_points = count,
            Fault::ForeignTag => self.answer(Tag::Number(77_777), "%"),
            Fault::Noise => self.answers.extend(b"\x80\x00noise"),
        }
    }

    /// Bytes that are to be sent by now.
    pub fn poll_transmit(&mut self, now_s: f64) -> Vec<u8> {
        self.advance(now_s);
        std::mem::take(&mut self.answers)
    }

    /// When something is due next, if at all.
    pub fn poll_timeout(&self) -> Option<f64> {
        let activity = self.activity.as_ref()?;
        let answer_s = activity.answers.front().map(|(at_s, _)| *at_s);
        Some(answer_s.unwrap_or(activity.path.end().0))
    }

    fn advance(&mut self, now_s: f64) {
        while let Some(due_s) = self.poll_timeout().filter(|due_s| *due_s <= now_s) {
            let Some(activity) = &mut self.activity else { return };
            let tag = activity.tag;
            if let Some((_, text)) = activity.answers.pop_front() {
                self.answer(tag, &text);
                continue;
            }
            let (_, place) = activity.path.end();
            let error = activity.error.take();
            (self.place, self.activity) = (place, None);
            self.end(tag, error);
            self.begin_waiting(due_s);
        }
    }

    fn answer(&mut self, tag: Tag, text: &str) {
        if !self.is_silent {
            self.answers.extend(format!("{tag} {text}\r\n").into_bytes());
        }
    }

    /// A command is complete, with an error or without.
    fn end(&mut self, tag: Tag, error: Option<ServerError>) {
        if let Some(error) = error {
            if error.severity >= Severity::Error {
                self.error = Some(error.number);
            }
            self.answer(tag, &format!("! {error}"));
        }
        self.answer(tag, "%");
    }

    fn command(&mut self, now_s: f64, line: &str) {
        let (tag, text) = line.split_at_checked(5).unwrap_or((line, ""));
        let Some((tag, text)) = Tag::parse(tag.as_bytes()).zip(text.strip_prefix(' ')) else {
            let error = error(Severity::Error, 1, line, "Illegal tag");
            self.answer(Tag::UNASKED, &format!("! {error}"));
            return;
        };
        self.answer(tag, "&");
        if text == "AbortE()" {
            self.break_off(
                now_s,
                Some((6, "Transaction aborted (Use ClearAllErrors to Continue)")),
            );
            self.error.get_or_insert(6);
            self.answer(tag, "%");
        } else if self.activity.is_some() && matches!(tag, Tag::Number(_)) {
            self.waiting.push_back((tag, text.to_owned()));
        } else {
            self.execute(now_s, tag, text);
        }
    }

    fn begin_waiting(&mut self, now_s: f64) {
        while self.activity.is_none() {
            let Some((tag, text)) = self.waiting.pop_front() else { return };
            self.execute(now_s, tag, &text);
        }
    }

    /// The machine stands, and its commands end with an error; without one they never end.
    fn break_off(&mut self, now_s: f64, reason: Option<(u16, &str)>) {
        self.place = self.place_mm(now_s);
        let activity = self.activity.take().map(|activity| (activity.tag, activity.text));
        let commands: Vec<(Tag, String)> =
            activity.into_iter().chain(self.waiting.drain(..)).collect();
        let Some((number, text)) = reason else { return };
        let severity = if number == 6 { Severity::Error } else { Severity::Critical };
        for (tag, command) in commands {
            self.end(tag, Some(error(severity, number, &format!("{tag} {command}"), text)));
        }
    }

    /// Does a command at once, or begins it.
    fn execute(&mut self, now_s: f64, tag: Tag, text: &str) {
        let cause = format!("{tag} {text}");
        let result = match Call::parse(text) {
            Ok(call) => self.obey(now_s, &call),
            Err(_) => Err((Severity::Critical, 507, "Illegal command")),
        };
        match result {
            Ok(Done::Now(data)) => {
                data.iter().for_each(|data| self.answer(tag, &format!("# {data}")));
                self.end(tag, None);
            }
            Ok(Done::Later(path, answers, failure)) => {
                let failed = |(severity, number, text)| error(severity, number, &cause, text);
                let error = failure.map(failed);
                let text = text.to_owned();
                self.activity = Some(Activity { tag, text, path, answers, error });
                self.advance(now_s);
            }
            Err((severity, number, text)) => {
                self.end(tag, Some(error(severity, number, &cause, text)));
            }
        }
    }

    fn obey(&mut self, now_s: f64, call: &Call) -> Result<Done, Failure> {
        let name = call.name.as_str();
        if !self.has_session && name != "StartSession" {
            return Err((Severity::Critical, 508, "Bad context"));
        }
        let is_allowed = ["StartSession", "EndSession", "ClearAllErrors", "GetErrStatusE"];
        if self.error.is_some() && !is_allowed.contains(&name) {
            return Err((Severity::Error, 514, "Use ClearAllErrors to continue"));
        }
        match name {
            "Home" | "GoTo" | "ChangeTool" | "PtMeas" | "ScanOnLine" | "ScanOnCircle" => {
                self.move_by(now_s, call)
            }
            _ => self.basic(call),
        }
    }
}

/// Outcome of a command that can be done.
enum Done {
    /// Data of a command that is complete at once.
    Now(Vec<String>),
    /// Path of a command that takes its time, its data with their times, and the error with which it ends.
    Later(Path, VecDeque<(f64, String)>, Option<Failure>),
}

/// Severity, number and text of an error.
type Failure = (Severity, u16, &'static str);

/// Place in mm at which the probe stands at first.
const LEFT_MM: Place = [40.0, -30.0, 60.0];
/// Place in mm at which it stands when it is homed.
const PARKED_MM: Place = [0.0, 0.0, 20.0];
