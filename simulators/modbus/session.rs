//! One connection to a device, without ports or clock.

use std::collections::BTreeMap;

use asphera_link::Nanos;
use asphera_modbus::Transport;

use crate::device::Device;
use crate::fault::Fault;
use crate::frame;
use crate::pdu;

/// One connection: requests in, answers out, each when it is due. Time is an argument.
pub struct Session {
    device: Device,
    transport: Transport,
    buffer: Vec<u8>,
    /// Answers by the time they are due and the order they were made in.
    answers: BTreeMap<(Nanos, u64), Vec<u8>>,
    made: u64,
    kept_back: Vec<u8>,
    closed: bool,
}

impl Session {
    /// A new connection to the device.
    pub fn new(device: Device, transport: Transport) -> Session {
        Session {
            device,
            transport,
            buffer: Vec::new(),
            answers: BTreeMap::new(),
            made: 0,
            kept_back: Vec::new(),
            closed: false,
        }
    }

    /// Takes received bytes, cut anywhere.
    pub fn receive(&mut self, now: Nanos, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
        while let Some(request) = frame::take_request(self.transport, &mut self.buffer) {
            self.request(now, &request);
        }
    }

    /// The next bytes due at `now`.
    pub fn poll_transmit(&mut self, now: Nanos) -> Option<Vec<u8>> {
        let first = self.answers.first_entry()?;
        (first.key().0 <= now).then(|| first.remove())
    }

    /// When there will be something to send, if nothing more is received.
    pub fn poll_timeout(&self) -> Option<Nanos> {
        self.answers.first_key_value().map(|((due, _), _)| *due)
    }

    /// Whether the device closed the connection.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    fn request(&mut self, now: Nanos, request: &frame::Request) {
        let Some(reply) = self.device.reply(now, request.unit_id, &request.pdu) else {
            return;
        };
        let (mut unit_id, mut pdu, mut due) = (reply.unit_id, reply.pdu, now + reply.delay);
        let (mut corrupt, mut keep_back) = (false, false);
        let mut bytes = std::mem::take(&mut self.kept_back);
        match reply.fault {
            None => {}
            Some(Fault::Late(time)) => due = due + time,
            Some(Fault::KeptBack) => keep_back = true,
            Some(Fault::Silent) => return,
            Some(Fault::Exception(code)) => pdu = pdu::exception(request.pdu[0], code),
            Some(Fault::WrongUnit(other)) => unit_id = other,
            Some(Fault::Corrupt) => corrupt = true,
            Some(Fault::Noise(noise)) => bytes.extend(noise),
            Some(Fault::Close) => {
                self.closed = true;
                return;
            }
        }
        let answer = frame::answer(self.transport, request.transaction, unit_id, &pdu, corrupt);
        if keep_back {
            self.kept_back = answer;
        } else {
            bytes.extend(answer);
        }
        if !bytes.is_empty() {
            self.answers.insert((due, self.made), bytes);
            self.made += 1;
        }
    }
}
