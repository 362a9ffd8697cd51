//! One drive: power, modes and motion.

use std::time::Duration;

use asphera_cia402::wire::{
    AbortCode, Address, Cob, Emergency, NmtCommand, NmtRequest, NmtState, NodeId, PowerState,
    SdoRequest, SdoResponse, Statusword, WireError, control, frame, heartbeat_frame, object,
};
use asphera_link::{CanFrame, Nanos};

use crate::dictionary::Dictionary;
use crate::power;
use crate::profile::Profile;

mod origin;

use origin::Origin;

/// Axis of a drive, in counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveSettings {
    /// Number of the node, 1 to 127.
    pub node_id: u8,
    /// Travel from the negative limit switch to the end.
    pub travel: i32,
    /// Place on the travel at power-on. The drive counts from there until it is homed.
    pub at: i32,
    /// Acceleration after power-on, counts/s².
    pub acceleration: u32,
}

/// Trouble of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Something blocks the axis: following error, fault 8611h.
    Blocked,
    /// The next homing fails.
    HomingFails,
    /// Someone opens the enable input.
    Disabled,
    /// The drive restarts.
    Restart,
    /// The drive says nothing more.
    Silent,
}

/// Simulated drive.
#[derive(Clone, Debug)]
pub struct Drive {
    settings: DriveSettings,
    node: NodeId,
    dictionary: Dictionary,
    nmt: NmtState,
    power: PowerState,
    profile: Profile,
    /// Place on the travel that counts as 0.
    zero: f64,
    homing: HomingState,
    is_acknowledged: bool,
    is_limited: bool,
    has_following_error: bool,
    fails_homing: bool,
    is_silent: bool,
    control: u16,
    /// What it is again after a restart.
    origin: Origin,
    heartbeat_due: Option<Nanos>,
    event_due: Option<Nanos>,
    moves: u64,
    out: Vec<CanFrame>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum HomingState {
    Never,
    Searching,
    Attained,
    Failed,
}

impl Drive {
    /// A drive that has just been powered on. Fails on a number that is no node's.
    pub fn new(settings: DriveSettings) -> Result<Drive, WireError> {
        let node = NodeId::new(settings.node_id)?;
        Ok(Drive {
            node,
            dictionary: Dictionary::new(node, settings.acceleration),
            nmt: NmtState::PreOperational,
            power: PowerState::SwitchOnDisabled,
            profile: Profile::Still(settings.at.into()),
            zero: settings.at.into(),
            homing: HomingState::Never,
            is_acknowledged: false,
            is_limited: false,
            has_following_error: false,
            fails_homing: false,
            is_silent: false,
            control: 0,
            origin: Origin::default(),
            heartbeat_due: None,
            event_due: None,
            moves: 0,
            out: Vec::new(),
            settings,
        })
    }

    /// Place on the travel, in counts: the truth, whatever the drive counts from.
    pub fn place(&self, now: Nanos) -> f64 {
        self.profile.state(now.as_secs_f64()).0
    }

    /// Whether the axis moves.
    pub fn is_moving(&self, now: Nanos) -> bool {
        !self.profile.settled(now.as_secs_f64()).is_still()
    }

    /// Runs that began, homing among them.
    pub fn moves(&self) -> u64 {
        self.moves
    }

    /// Does harm, and gives what the drive sends because of it.
    pub fn fault(&mut self, now: Nanos, fault: Fault) -> Vec<CanFrame> {
        self.settle(now);
        match fault {
            Fault::Blocked => {
                self.freeze(now);
                self.has_following_error = true;
                self.power = PowerState::Fault;
                self.dictionary.set(object::ERROR_CODE, 0x8611);
                self.dictionary.set(object::ERROR_REGISTER, 0x21);
                let emergency = Emergency { code: 0x8611, register: 0x21, manufacturer: [0; 5] };
                self.out.push(emergency.encode(self.node));
            }
            Fault::HomingFails => self.fails_homing = true,
            Fault::Disabled => {
                self.freeze(now);
                self.power = PowerState::SwitchOnDisabled;
            }
            Fault::Restart => {
                let at = self.place(now).round() as i32;
                let settings = DriveSettings { at, ..self.settings };
                let (moves, origin) = (self.moves, self.origin);
                if let Ok(drive) = Drive::new(settings) {
                    *self = Drive { moves, origin, ..drive };
                    self.apply_origin();
                }
                self.out.push(heartbeat_frame(self.node, NmtState::BootUp));
            }
            Fault::Silent => self.is_silent = true,
        }
        self.take_out()
    }

    /// Takes a frame of the bus, and gives what the drive sends in turn.
    pub fn receive(&mut self, now: Nanos, frame: &CanFrame) -> Vec<CanFrame> {
        self.settle(now);
        match Cob::from_frame(frame) {
            Some(Cob::Nmt) => {
                let request = NmtRequest::decode(frame.data()).ok();
                let ours = request.filter(|one| one.node.is_none_or(|node| node == self.node));
                if let Some(request) = ours {
                    self.command(now, request.command);
                }
            }
            Some(Cob::SdoRequest(node)) if node == self.node => self.request(now, frame.data()),
            _ => {}
        }
        self.take_out()
    }

    /// When [`Drive::timeout`] is to be called.
    pub fn poll_timeout(&self) -> Option<Nanos> {
        self.heartbeat_due.into_iter().chain(self.event_due).min()
    }

    /// Heartbeat and TPDO that are due.
    pub fn timeout(&mut self, now: Nanos) -> Vec<CanFrame> {
        self.settle(now);
        if self.heartbeat_due.is_some_and(|due| due <= now) {
            self.out.push(heartbeat_frame(self.node, self.nmt));
            self.heartbeat_due =
                period(self.dictionary.value(object::HEARTBEAT_TIME)).map(|period| now + period);
        }
        if self.event_due.is_some_and(|due| due <= now) {
            if self.dictionary.has_tpdo() {
                self.out.push(frame(Cob::Tpdo1(self.node), &self.dictionary.tpdo()));
            }
            self.event_due = self.event_period().map(|period| now + period);
        }
        self.take_out()
    }

    fn take_out(&mut self) -> Vec<CanFrame> {
        let out = std::mem::take(&mut self.out);
        if self.is_silent { Vec::new() } else { out }
    }

    fn command(&mut self, now: Nanos, command: NmtCommand) {
        match command {
            NmtCommand::Start => {
                self.nmt = NmtState::Operational;
                self.event_due = self.event_period().map(|period| now + period);
            }
            NmtCommand::Stop => (self.nmt, self.event_due) = (NmtState::Stopped, None),
            NmtCommand::EnterPreOperational => {
                (self.nmt, self.event_due) = (NmtState::PreOperational, None);
            }
            NmtCommand::ResetNode | NmtCommand::ResetCommunication => {
                let frames = self.fault(now, Fault::Restart);
                self.out.extend(frames);
            }
        }
    }

    fn event_period(&self) -> Option<Duration> {
        period(self.dictionary.value(object::TPDO1_EVENT_TIMER))
    }

    fn request(&mut self, now: Nanos, data: &[u8]) {
        let response = match SdoRequest::decode(self.node, data) {
            Ok(SdoRequest::Upload(address)) => match self.dictionary.upload(address) {
                Ok(value) => SdoResponse::Uploaded(address, value),
                Err(code) => SdoResponse::Aborted(address, code),
            },
            Ok(SdoRequest::Download(address, value)) => {
                match self.dictionary.download(address, value) {
                    Ok(()) => {
                        self.written(now, address);
                        SdoResponse::Downloaded(address)
                    }
                    Err(code) => SdoResponse::Aborted(address, code),
                }
            }
            Ok(SdoRequest::Abort(..)) => return,
            Err(_) => {
                let &[_, low, high, sub, ..] = data else { return };
                let address = Address::new(u16::from_le_bytes([low, high]), sub);
                SdoResponse::Aborted(address, AbortCode::UNKNOWN_COMMAND)
            }
        };
        self.out.push(response.encode(self.node));
        self.refresh();
    }

    fn written(&mut self, now: Nanos, address: Address) {
        match address {
            object::HEARTBEAT_TIME => {
                self.heartbeat_due =
                    period(self.dictionary.value(address)).map(|period| now + period);
            }
            object::MODE => {
                let mode = self.dictionary.value(object::MODE);
                self.dictionary.set(object::MODE_DISPLAY, mode);
                self.is_acknowledged = false;
            }
            object::CONTROLWORD => self.controlled(now),
            _ => {}
        }
    }

    fn controlled(&mut self, now: Nanos) {
        let word = self.dictionary.value(object::CONTROLWORD) as u16;
        let last = std::mem::replace(&mut self.control, word);
        let before = self.power;
        self.power = power::next(before, word, last);
        if before == PowerState::Fault && self.power != PowerState::Fault {
            self.has_following_error = false;
            self.dictionary.set(object::ERROR_CODE, 0);
            self.dictionary.set(object::ERROR_REGISTER, 0);
            self.out
                .push(Emergency { code: 0, register: 0, manufacturer: [0; 5] }.encode(self.node));
        }
        match self.power {
            PowerState::OperationEnabled => {}
            PowerState::QuickStopActive if before == PowerState::OperationEnabled => {
                self.brake(now);
            }
            PowerState::QuickStopActive => {}
            _ => self.freeze(now),
        }
        if self.power != PowerState::OperationEnabled {
            self.abandon();
            return;
        }
        let starts = word & control::START != 0 && last & control::START == 0;
        match self.dictionary.value(object::MODE_DISPLAY) as u8 {
            object::PROFILE_POSITION if starts => self.set_point(now),
            object::PROFILE_POSITION => self.is_acknowledged &= word & control::START != 0,
            object::HOMING if starts => self.home(now),
            _ => {}
        }
    }

    /// A homing that is broken off has failed.
    fn abandon(&mut self) {
        self.is_acknowledged = false;
        if self.homing == HomingState::Searching {
            self.homing = HomingState::Failed;
        }
    }

    fn set_point(&mut self, now: Nanos) {
        let target = f64::from(self.dictionary.signed(object::TARGET)) + self.zero;
        let end = target.clamp(0.0, self.settings.travel.into());
        self.is_acknowledged = true;
        self.is_limited = false;
        self.run(now, end, object::PROFILE_VELOCITY, object::PROFILE_ACCELERATION);
    }

    fn home(&mut self, now: Nanos) {
        self.is_limited = false;
        match (self.dictionary.value(object::HOMING_METHOD) as u8).cast_signed() {
            _ if std::mem::take(&mut self.fails_homing) => self.homing = HomingState::Failed,
            17 => {
                self.homing = HomingState::Searching;
                self.run(now, 0.0, object::HOMING_SPEED_SWITCH, object::HOMING_ACCELERATION);
            }
            35 | 37 => {
                self.homing = HomingState::Searching;
                self.moves += 1;
            }
            _ => self.homing = HomingState::Failed,
        }
        self.settle(now);
    }

    fn run(&mut self, now: Nanos, to: f64, speed: Address, acceleration: Address) {
        let now_s = now.as_secs_f64();
        let from = self.profile.state(now_s).0;
        let [speed, acceleration] =
            [speed, acceleration].map(|address| f64::from(self.dictionary.value(address)).max(1.0));
        self.profile = Profile::Run { begin_s: now_s, from, to, speed, acceleration };
        self.moves += 1;
    }

    /// Brakes ten times as hard as it accelerates.
    fn brake(&mut self, now: Nanos) {
        let now_s = now.as_secs_f64();
        let (from, speed) = self.profile.state(now_s);
        let deceleration = f64::from(self.settings.acceleration).max(1.0) * 10.0;
        self.profile = Profile::Brake { begin_s: now_s, from, speed, deceleration };
    }

    fn freeze(&mut self, now: Nanos) {
        self.profile = Profile::Still(self.place(now));
    }

    /// Brings the drive up to a time.
    fn settle(&mut self, now: Nanos) {
        self.profile = self.profile.settled(now.as_secs_f64());
        if self.profile.is_still() && self.power == PowerState::OperationEnabled {
            if self.homing == HomingState::Searching {
                let offset = self.dictionary.signed(object::HOME_OFFSET);
                self.zero = self.place(now) - f64::from(offset);
                self.homing = HomingState::Attained;
            }
            let target = f64::from(self.dictionary.signed(object::TARGET)) + self.zero;
            let is_in_position = self.mode() == object::PROFILE_POSITION;
            self.is_limited = is_in_position
                && self.moves > 0
                && (target < 0.0 || target > f64::from(self.settings.travel));
        }
        let position = (self.place(now) - self.zero).round() as i32;
        self.dictionary.set(object::POSITION, position.cast_unsigned());
        self.refresh();
    }

    fn mode(&self) -> u8 {
        self.dictionary.value(object::MODE_DISPLAY) as u8
    }

    fn refresh(&mut self) {
        let mut word = power::bits(self.power);
        let mut bit = |at: u16, is_set: bool| word |= u16::from(is_set) << at;
        let is_still = self.profile.is_still();
        bit(11, self.is_limited);
        match self.mode() {
            object::HOMING => {
                bit(10, is_still && self.homing != HomingState::Searching);
                bit(12, self.homing == HomingState::Attained);
                bit(13, self.homing == HomingState::Failed);
            }
            object::PROFILE_POSITION => {
                bit(10, is_still && !self.is_limited && !self.is_acknowledged);
                bit(12, self.is_acknowledged);
                bit(13, self.has_following_error);
            }
            _ => bit(10, is_still),
        }
        if self.power == PowerState::QuickStopActive {
            word = word & !(1 << 10) | u16::from(is_still) << 10;
        }
        self.dictionary.set(object::STATUSWORD, Statusword(word).0.into());
    }
}

fn period(time_ms: u32) -> Option<Duration> {
    (time_ms > 0).then(|| Duration::from_millis(time_ms.into()))
}
