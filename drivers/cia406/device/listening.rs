//! A node that another master has set up: nothing is sent, and what cannot be asked comes from the settings.

use asphera_link::{CanFrame, Event, FaultKind, Flags, Nanos};

use super::setup::Learned;
use super::{Cia406, State};
use crate::wire::{AreaState, Cob, NmtState};
use crate::{Kind, Transmission};

impl Cia406 {
    /// Begins to listen. The SYNCs are followed from the first one on, the node from its first frame on. A node measures
    /// whether that is wanted already or not; only what comes after a stop is left.
    pub(super) fn begin_listening(&mut self, stopped: bool) {
        let step_nm = match self.settings.kind {
            Kind::Linear { step_nm: Some(step) } => step,
            _ => 0.0,
        };
        let velocity_step_mm_s = self.settings.velocity_step_mm_s.unwrap_or(0.0);
        let learned = Learned { step_nm, velocity_step_mm_s, error: false };
        self.length_told = false;
        self.state = State::Listening { learned, cycle: self.cycle(), measures: false, stopped };
    }

    /// Takes a frame of the bus. Answers to another master are not ours.
    pub(super) fn overhear(&mut self, now: Nanos, frame: &CanFrame) {
        let data = frame.data();
        match Cob::from_frame(frame) {
            Some(Cob::Sync) => {
                if let State::Listening { cycle, .. } = &mut self.state
                    && matches!(self.settings.transmission, Transmission::Sync { .. })
                {
                    cycle.sync(now, data, &mut self.events);
                }
            }
            Some(Cob::Tpdo1(node)) if node == self.node => self.overhear_position(now, data),
            Some(Cob::Heartbeat(node)) if node == self.node => self.overhear_heartbeat(data),
            Some(Cob::Emergency(node)) if node == self.node => self.on_emergency(data),
            _ => {}
        }
    }

    fn overhear_position(&mut self, now: Nanos, data: &[u8]) {
        // Nobody can be asked what is mapped: another length is another mapping, and no position.
        let Some(position) =
            self.layout.decode(data).filter(|_| data.len() == self.layout.byte_len())
        else {
            if !self.length_told {
                self.length_told = true;
                let detail = format!(
                    "TPDO1 of node {} has {} bytes, expected {} of these settings: set map_velocity, map_status and node_id as the node is set up",
                    self.node,
                    data.len(),
                    self.layout.byte_len()
                );
                self.events.fault(FaultKind::Protocol, detail);
            }
            return self.discard(data);
        };
        self.measures();
        let State::Listening { learned, cycle, measures: true, .. } = &mut self.state else {
            return self.discard(data);
        };
        let learned = *learned;
        let (count, mut flags) = match self.settings.transmission {
            Transmission::Sync { .. } => cycle.position(now, &mut self.events),
            Transmission::EventTimer { .. } => (None, Flags::empty()),
        };
        flags.set(Flags::DEVICE_ERROR, self.error);
        flags.set(Flags::OUT_OF_RANGE, position.area_state.is_some_and(AreaState::is_outside));
        let reading = self.reading(now, position, learned, count, flags);
        self.events.push(Event::Reading(reading));
    }

    fn overhear_heartbeat(&mut self, data: &[u8]) {
        let Ok(state) = NmtState::decode(self.node, data) else {
            return self.discard(data);
        };
        match state {
            NmtState::Operational => self.measures(),
            NmtState::BootUp | NmtState::PreOperational | NmtState::Stopped => {
                self.is_there();
                let State::Listening { cycle, measures, .. } = &mut self.state else { return };
                if std::mem::take(measures) {
                    cycle.end(&mut self.events);
                    let detail = format!(
                        "node {} is {state} and sends no positions: its master must start it",
                        self.node
                    );
                    self.events.fault(FaultKind::Device, detail);
                }
                if state == NmtState::BootUp {
                    self.error = false;
                }
            }
        }
    }

    fn is_there(&mut self) {
        self.events.prove_online();
    }

    /// The node is operational. It owes positions from now on.
    fn measures(&mut self) {
        self.is_there();
        if let State::Listening { cycle, measures, stopped: false, .. } = &mut self.state
            && !*measures
        {
            *measures = true;
            cycle.begin();
            self.events.push(Event::Ready);
        }
    }
}
