//! The controller without a network: commands in, answers and profiles out.

use std::f64::consts::TAU;

use asphera_keyence::wire::{
    Answer, ErrorCodes, Height, Layout, NoHeight, Profile, Request, Series, Unit,
};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// What does not change while a controller runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Series: it answers requests of this one.
    pub series: Series,
    /// Points of a profile, 1 to 3200.
    pub points: u16,
    /// Distance of points in 10 nm; the middle of the line is x = 0.
    pub pitch_10nm: i32,
    /// Unit of heights in 10 nm.
    pub unit_10nm: u16,
    /// Half the measuring range in z, mm. Beyond there is no peak.
    pub half_range_mm: f64,
    /// Standard deviation of the noise of heights in µm.
    pub noise_um: f64,
    /// Whether luminances are sent, all 0.
    pub luminances: bool,
    /// Whether the preparation of the stream gives 0 for the unit, as some controllers do.
    pub hides_unit: bool,
}

impl Default for Optics {
    /// A small one, with 400 points on 20 mm.
    fn default() -> Optics {
        Optics {
            series: Series::LjX8000,
            points: 400,
            pitch_10nm: 5000,
            unit_10nm: 8,
            half_range_mm: 5.0,
            noise_um: 0.0,
            luminances: false,
            hides_unit: false,
        }
    }
}

impl Optics {
    /// Layout of the profiles.
    pub fn layout(&self) -> Layout {
        let last = i32::from(self.points) - 1;
        Layout {
            start_code: START_CODE,
            kind: if self.luminances { 0x41 } else { 0x01 },
            points: self.points,
            unit_10nm: self.unit_10nm,
            x_start_10nm: last * self.pitch_10nm / -2,
            x_pitch_10nm: self.pitch_10nm,
        }
    }
}

/// A controller with one head.
#[derive(Clone, Debug)]
pub struct Controller {
    optics: Optics,
    serial: String,
    random: Pcg64Mcg,
    triggers: u32,
    errors: Vec<u16>,
    /// Commands that it refuses, each with its error.
    refuses: Vec<(u8, u8)>,
    is_streaming: bool,
    /// A stream was stopped by command since this was asked last.
    was_stopped: bool,
    /// Bytes of a request that has not come whole.
    pending: Vec<u8>,
}

impl Controller {
    /// A controller whose triggers count from 0. The same seed gives the same bytes.
    pub fn new(optics: Optics, seed: u64) -> Controller {
        Controller {
            optics,
            serial: SERIAL.to_owned(),
            random: Pcg64Mcg::seed_from_u64(seed),
            triggers: 0,
            errors: Vec::new(),
            refuses: Vec::new(),
            is_streaming: false,
            was_stopped: false,
            pending: Vec::new(),
        }
    }

    /// The controller with this serial number, of 16 signs at most.
    #[must_use]
    pub fn with_serial(self, serial: &str) -> Controller {
        Controller { serial: serial.to_owned(), ..self }
    }

    /// The optics that it was made with.
    pub fn optics(&self) -> &Optics {
        &self.optics
    }

    /// Answers what a client sent, cut anywhere. Bytes that are no request have no answer, and nothing after them.
    pub fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.pending.extend_from_slice(bytes);
        let pending = std::mem::take(&mut self.pending);
        let (mut rest, mut answers) = (&pending[..], Vec::new());
        while let Ok(Some((series, request, len))) = Request::decode(rest) {
            rest = &rest[len..];
            if series == self.optics.series {
                answers.extend(self.answer(request));
            }
        }
        self.pending = rest.to_vec();
        answers
    }

    fn answer(&mut self, request: Request) -> Vec<u8> {
        let command = request.command();
        let refused = self.refuses.iter().find(|(refused, _)| *refused == command);
        let error = refused.map_or(0, |(_, error)| *error);
        if error != 0 {
            return Answer { command, error, content: &[] }.encode();
        }
        let unit = |model: &str, serial: &str| Unit { model: model.into(), serial: serial.into() };
        let mut layout = self.optics.layout();
        let content = match request {
            Request::Units => {
                Unit::encode_all(&[unit("LJ-X8000", &self.serial), unit("LJ-X8080", "SIM00002")])
            }
            Request::Errors => ErrorCodes(self.errors.clone()).encode(),
            Request::Prepare => {
                if self.optics.hides_unit {
                    layout.unit_10nm = 0;
                }
                layout.encode()
            }
            Request::Profile => self.memory(&layout),
            Request::Start { code } => {
                let error = if code == START_CODE { 0 } else { WRONG_CODE };
                self.is_streaming = error == 0;
                return Answer { command, error, content: &[] }.encode();
            }
            Request::Stop => {
                self.was_stopped |= std::mem::take(&mut self.is_streaming);
                Vec::new()
            }
            Request::StartMeasure | Request::StopMeasure => Vec::new(),
        };
        Answer { command, error: 0, content: &content }.encode()
    }

    /// Content of an answer with one profile of the memory, without a height anywhere.
    fn memory(&self, layout: &Layout) -> Vec<u8> {
        let mut content = vec![0; 36];
        content[12] = 1;
        content[20] = layout.kind;
        content[24..26].copy_from_slice(&layout.points.to_le_bytes());
        content[26..28].copy_from_slice(&layout.unit_10nm.to_le_bytes());
        content[28..32].copy_from_slice(&layout.x_start_10nm.to_le_bytes());
        content[32..36].copy_from_slice(&layout.x_pitch_10nm.to_le_bytes());
        let heights = (0..layout.points).map(|_| Err(NoHeight::Unprocessed));
        content.extend(Profile::encode(layout, self.triggers, 0, heights));
        content
    }

    /// Whether profiles are wanted.
    pub fn is_streaming(&self) -> bool {
        self.is_streaming
    }

    /// Whether a stream was stopped by command since this was asked last.
    pub fn was_stopped(&mut self) -> bool {
        std::mem::take(&mut self.was_stopped)
    }

    /// The client has gone: nothing streams, and nothing of what it sent is left.
    pub fn disconnected(&mut self) {
        self.is_streaming = false;
        self.pending.clear();
    }

    /// It stops the stream by itself.
    pub fn halt(&mut self) {
        self.is_streaming = false;
    }

    /// Triggers count from 0 again.
    pub fn restart(&mut self) {
        self.triggers = 0;
    }

    /// An error that it reports from now on.
    pub fn report(&mut self, error: u16) {
        self.errors.push(error);
    }

    /// Refuses a command with this error from now on; with error 0 no more.
    pub fn refuse(&mut self, command: u8, error: u8) {
        self.refuses.retain(|(refused, _)| *refused != command);
        self.refuses.push((command, error));
    }

    /// A trigger without a profile.
    pub fn skip(&mut self) {
        self.triggers = self.triggers.wrapping_add(1);
    }

    /// Measures, and gives the bytes of the profile. `height_mm` is the surface along the laser line.
    pub fn measure(
        &mut self,
        encoder_count: i32,
        height_mm: impl Fn(f64) -> Option<f64>,
    ) -> Vec<u8> {
        let layout = self.optics.layout();
        let heights: Vec<Height> = (0..layout.points)
            .map(|index| {
                let x_10nm = i64::from(layout.x_start_10nm)
                    + i64::from(index) * i64::from(layout.x_pitch_10nm);
                self.height(height_mm(x_10nm as f64 / 1e5))
            })
            .collect();
        let bytes = Profile::encode(&layout, self.triggers, encoder_count, heights);
        self.skip();
        bytes
    }

    fn height(&mut self, height_mm: Option<f64>) -> Height {
        let noise_mm = self.optics.noise_um * 1e-3 * self.normal();
        let measured_mm = height_mm.map(|height_mm| height_mm + noise_mm);
        let within = measured_mm.filter(|mm| mm.abs() <= self.optics.half_range_mm);
        let unit_mm = f64::from(self.optics.unit_10nm) / 1e5;
        within.map_or(Err(NoHeight::NoPeak), |mm| Ok((mm / unit_mm).round() as i32))
    }

    /// A standard normal number: Box and Muller, A Note on the Generation of Random Normal Deviates,
    /// Ann. Math. Statist. 29 (1958), doi:10.1214/aoms/1177706645.
    fn normal(&mut self) -> f64 {
        // In (0, 1], so that the logarithm is finite.
        let mut uniform = || ((self.random.next_u64() >> 11) + 1) as f64 / (1_u64 << 53) as f64;
        (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
    }
}

/// Code that it gives for the start of a stream.
const START_CODE: u32 = 0x0A5F_0001;

/// Serial number where none is given.
const SERIAL: &str = "SIM00001";

/// Error for a start with another code. The number is our choice.
const WRONG_CODE: u8 = 0x31;
