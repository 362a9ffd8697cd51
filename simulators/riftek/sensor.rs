//! The sensor without a port.

use asphera_riftek::Settings;
use asphera_riftek::wire::{Identity, Request, RequestDecoder, encode_answer, result_of};

/// A sensor on its line.
#[derive(Clone, Debug)]
pub struct Sensor {
    address: u8,
    identity: Identity,
    requests: RequestDecoder,
    /// Number of the next answer.
    count: u8,
    result: u16,
    /// Whether the result was not sent yet.
    is_new: bool,
    is_streaming: bool,
}

impl Sensor {
    /// A sensor that a driver with these settings takes for the right one. It has measured nothing yet.
    pub fn new(settings: &Settings) -> Sensor {
        let serial = settings.serial.unwrap_or(SERIAL);
        let identity = Identity {
            device_type: DEVICE_TYPE,
            firmware: FIRMWARE,
            serial,
            base_mm: BASE_MM,
            range_mm: settings.range_mm,
        };
        let requests = RequestDecoder::default();
        let (result, is_new, is_streaming) = (0, false, false);
        let address = settings.address;
        Sensor { address, identity, requests, count: 1, result, is_new, is_streaming }
    }

    /// Takes a measured distance in mm from the start of the range; `None`: no target.
    pub fn measure(&mut self, distance_mm: Option<f64>) {
        let result = distance_mm.map_or(0, |mm| result_of(mm, self.identity.range_mm));
        (self.result, self.is_new) = (result, true);
    }

    /// Answers what a host sent, cut anywhere. Requests to other addresses have no answer.
    pub fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        bytes.iter().flat_map(|byte| self.byte(*byte)).collect()
    }

    fn byte(&mut self, byte: u8) -> Vec<u8> {
        let Some((address, request)) = self.requests.push(byte) else { return Vec::new() };
        if address != self.address && address != EVERYONE {
            return Vec::new();
        }
        self.is_streaming = request == Request::StartStream;
        match request {
            Request::Identify => self.answer(false, &self.identity.encode()),
            Request::Result => self.say_result(),
            Request::StartStream | Request::StopStream => Vec::new(),
        }
    }

    /// The next answer of the stream; `None` where none runs. A result that was sent before is marked as such.
    pub fn stream(&mut self) -> Option<Vec<u8>> {
        self.is_streaming.then(|| self.say_result())
    }

    /// Whether a stream runs.
    pub fn is_streaming(&self) -> bool {
        self.is_streaming
    }

    /// The line is cut: half a request is forgotten. A stream goes on, into nothing.
    pub fn disconnected(&mut self) {
        self.requests = RequestDecoder::default();
    }

    fn say_result(&mut self) -> Vec<u8> {
        let is_new = std::mem::take(&mut self.is_new);
        self.answer(is_new, &self.result.to_le_bytes())
    }

    fn answer(&mut self, is_new: bool, content: &[u8]) -> Vec<u8> {
        let answer = encode_answer(is_new, self.count, content);
        self.count = self.count.wrapping_add(1);
        answer
    }
}

/// Address of all sensors.
const EVERYONE: u8 = 0;
/// The sensor that the RF602 manual prints, page 16.
const DEVICE_TYPE: u8 = 0x3F;
const FIRMWARE: u8 = 0x90;
const SERIAL: u16 = 0x4321;
const BASE_MM: u16 = 80;
