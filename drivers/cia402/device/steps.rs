//! Requests that a job is made of, one in flight at a time.

use std::time::Duration;

use asphera_link::{AxisMove, CanFrame, Nanos};

use crate::wire::{Address, Cob, Expedited, MappedObject, NodeId, SdoRequest, control, object};
use crate::{Reference, Settings};

/// One request, and the meaning of its answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Reads an object.
    Read(Address, Use),
    /// Writes an object. An optional one may be refused.
    Write { address: Address, value: Expedited, is_optional: bool },
    /// Reads an object again and again until it is as it must be. `by`: since the first time.
    Until { goal: Goal, by: Option<Nanos> },
}

/// Use of a value that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Profile,
    Vendor(u32),
    ErrorRegister,
    Modes,
    /// The power must be off before the mode may be changed for a question.
    PowerOff,
    Attained,
}

/// Condition that a job waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goal {
    /// The mode of operation is in force.
    Mode(u8),
    /// The mode is in force, or the question for the reference is given up.
    ModeForQuestion(u8),
    /// Operation enabled; controlwords are sent on the way.
    Enabled,
    /// The set-point is acknowledged.
    Acknowledged,
    /// The drive stands after a quick stop.
    Standing,
}

/// Request that waits for its answer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct InFlight {
    pub(super) request: SdoRequest,
    pub(super) step: Step,
    pub(super) until: Nanos,
    pub(super) tries: u8,
}

/// Time from one question to the next while a job waits.
pub(super) const AGAIN: Duration = Duration::from_millis(10);

impl Step {
    pub(super) fn request(self) -> SdoRequest {
        match self {
            Step::Read(address, _) => SdoRequest::Upload(address),
            Step::Write { address, value, .. } => SdoRequest::Download(address, value),
            Step::Until { goal: Goal::Mode(_) | Goal::ModeForQuestion(_), .. } => {
                SdoRequest::Upload(object::MODE_DISPLAY)
            }
            Step::Until { .. } => SdoRequest::Upload(object::STATUSWORD),
        }
    }

    const fn until(goal: Goal) -> Step {
        Step::Until { goal, by: None }
    }
}

/// Frame of a controlword by itself.
pub(super) fn controlword(node: NodeId, word: u16) -> CanFrame {
    SdoRequest::Download(object::CONTROLWORD, Expedited::u16(word)).encode(node)
}

pub(super) fn control_step(word: u16) -> Step {
    write(object::CONTROLWORD, Expedited::u16(word))
}

fn write(address: Address, value: Expedited) -> Step {
    Step::Write { address, value, is_optional: false }
}

fn signed(value: i32) -> Expedited {
    Expedited::u32(value.cast_unsigned())
}

/// Steps that set a node up. The order of the mapping is that of CiA 301: PDO off, count 0, entries, count, PDO on.
pub(super) fn setup(settings: &Settings, node: NodeId) -> Vec<Step> {
    let cob = u32::from(Cob::Tpdo1(node).id()) | object::PDO_NO_REMOTE;
    let mapping = object::TPDO1_MAPPING;
    let mut steps = vec![Step::Read(object::DEVICE_TYPE, Use::Profile)];
    steps.extend(settings.vendor_id.map(|vendor| Step::Read(object::VENDOR, Use::Vendor(vendor))));
    steps.extend([
        Step::Read(object::ERROR_REGISTER, Use::ErrorRegister),
        Step::Read(object::SUPPORTED_MODES, Use::Modes),
        write(object::TPDO1_COB, Expedited::u32(cob | object::PDO_INVALID)),
        write(object::TPDO1_TYPE, Expedited::u8(BY_EVENT)),
        write(object::TPDO1_EVENT_TIMER, Expedited::u16(settings.period_ms)),
        write(mapping, Expedited::u8(0)),
    ]);
    for (sub, entry) in (1..).zip(object::TPDO1.map(MappedObject::entry)) {
        steps.push(write(Address::new(mapping.index, sub), Expedited::u32(entry)));
    }
    steps.extend([
        write(mapping, Expedited::u8(object::TPDO1.len() as u8)),
        write(object::TPDO1_COB, Expedited::u32(cob)),
        write(object::HEARTBEAT_TIME, Expedited::u16(settings.heartbeat_ms)),
        Step::Write {
            address: object::QUICK_STOP_OPTION,
            value: Expedited::u16(STAY_IN_QUICK_STOP),
            is_optional: true,
        },
    ]);
    if settings.reference == Reference::Homing {
        steps.push(Step::Read(object::STATUSWORD, Use::PowerOff));
        steps.push(write(object::MODE, Expedited::u8(object::HOMING)));
        steps.push(Step::until(Goal::ModeForQuestion(object::HOMING)));
        steps.push(Step::Read(object::STATUSWORD, Use::Attained));
    }
    steps
}

/// Steps up to the start of a move; `None` where a number is beyond its object.
pub(super) fn moving(settings: &Settings, order: &AxisMove) -> Option<Vec<Step>> {
    let target = settings.counts(order.to)?;
    let velocity = settings.velocity(order.speed)?;
    let mut steps = vec![
        write(object::MODE, Expedited::u8(object::PROFILE_POSITION)),
        Step::until(Goal::Mode(object::PROFILE_POSITION)),
        Step::until(Goal::Enabled),
        write(object::PROFILE_VELOCITY, Expedited::u32(velocity)),
    ];
    if let Some(acceleration) = order.acceleration {
        let value = Expedited::u32(settings.acceleration(acceleration)?);
        steps.push(write(object::PROFILE_ACCELERATION, value));
        steps.push(write(object::PROFILE_DECELERATION, value));
    }
    steps.extend([
        write(object::TARGET, signed(target)),
        control_step(control::ENABLE_OPERATION),
        control_step(control::ENABLE_OPERATION | control::START | control::AT_ONCE),
        Step::until(Goal::Acknowledged),
        control_step(control::ENABLE_OPERATION),
    ]);
    Some(steps)
}

/// Steps up to the start of homing; `None` without its settings, or where a number is beyond its object.
pub(super) fn homing(settings: &Settings) -> Option<Vec<Step>> {
    let homing = settings.homing?;
    let [switch, zero] = homing.speeds;
    let mut steps = vec![
        write(object::MODE, Expedited::u8(object::HOMING)),
        Step::until(Goal::Mode(object::HOMING)),
        write(object::HOMING_METHOD, Expedited::u8(homing.method.cast_unsigned())),
        write(object::HOMING_SPEED_SWITCH, Expedited::u32(settings.velocity(switch)?)),
        write(object::HOMING_SPEED_ZERO, Expedited::u32(settings.velocity(zero)?)),
        write(object::HOME_OFFSET, signed(settings.counts(homing.offset)?)),
    ];
    if let Some(acceleration) = homing.acceleration {
        let value = Expedited::u32(settings.acceleration(acceleration)?);
        steps.push(write(object::HOMING_ACCELERATION, value));
    }
    steps.extend([
        Step::until(Goal::Enabled),
        control_step(control::ENABLE_OPERATION),
        control_step(control::ENABLE_OPERATION | control::START),
    ]);
    Some(steps)
}

/// Steps of a halt.
pub(super) fn halting() -> Vec<Step> {
    vec![control_step(control::QUICK_STOP), Step::until(Goal::Standing)]
}

/// Transmission type "by events of the device profile", the event timer among them.
const BY_EVENT: u8 = 255;
/// Quick stop option code: slow down on the quick stop ramp and stay in quick stop.
const STAY_IN_QUICK_STOP: u16 = 6;
