//! A part that moves under the scanner, and what leaves the scanner.

use asphera_rf627::wire::EncodeError;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use crate::{Part, Scanner};

/// A scan of a part along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scan {
    /// The part.
    pub part: Part,
    /// Place of the first profile along y, mm.
    pub first_y_mm: f64,
    /// Steps of the encoder from one profile to the next.
    pub steps: u32,
    /// Length of a step along y, mm.
    pub step_mm: f64,
    /// How many profiles are measured.
    pub profiles: u32,
}

/// Something that happens at a profile, which is counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The network loses it.
    Lose,
    /// The network delivers it twice.
    Repeat,
    /// It comes after the next one.
    Swap,
    /// The scanner measures and does not send.
    Skip,
    /// The scanner is switched off and on before it.
    Restart,
    /// So many random bytes come before it.
    Garbage(usize),
    /// So many ms pass before it.
    Silence(u64),
    /// Only so many of its bytes come.
    Cut(usize),
}

/// A datagram that leaves the scanner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Departure {
    /// When, in ns from the beginning.
    pub at_ns: u64,
    /// Its bytes.
    pub datagram: Vec<u8>,
}

impl Scan {
    /// All datagrams in the order in which they leave. `faults` name the profiles they happen to; `seed` makes garbage.
    ///
    /// # Errors
    ///
    /// When the profiles have too many points for a datagram.
    pub fn departures(
        &self,
        scanner: &mut Scanner,
        faults: &[(u32, Fault)],
        seed: u64,
    ) -> Result<Vec<Departure>, EncodeError> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (mut at_ns, mut out) = (0, Vec::new());
        let mut waiting: Option<Vec<u8>> = None;
        for profile in 0..self.profiles {
            let at_this =
                || faults.iter().filter(move |(at, _)| *at == profile).map(|(_, fault)| *fault);
            let is = |fault| at_this().any(|other| other == fault);
            for fault in at_this() {
                match fault {
                    Fault::Restart => scanner.restart(),
                    Fault::Silence(ms) => at_ns += ms * 1_000_000,
                    Fault::Garbage(bytes) => {
                        let datagram = (0..bytes).map(|_| random.next_u64() as u8).collect();
                        out.push(Departure { at_ns, datagram });
                    }
                    _ => {}
                }
            }
            let step_count = profile.wrapping_mul(self.steps);
            let y_mm = self.first_y_mm + f64::from(step_count) * self.step_mm;
            if is(Fault::Skip) {
                scanner.skip();
            } else {
                let mut datagram =
                    scanner.measure(step_count, |x_mm| self.part.height_mm(x_mm, y_mm))?;
                for fault in at_this() {
                    if let Fault::Cut(bytes) = fault {
                        datagram.truncate(bytes);
                    }
                }
                if is(Fault::Swap) {
                    waiting = Some(datagram);
                } else if !is(Fault::Lose) {
                    let copies = if is(Fault::Repeat) { 2 } else { 1 };
                    let copies = std::iter::repeat_n(datagram, copies).chain(waiting.take());
                    out.extend(copies.map(|datagram| Departure { at_ns, datagram }));
                }
            }
            at_ns += scanner.period_ns();
        }
        out.extend(waiting.map(|datagram| Departure { at_ns, datagram }));
        Ok(out)
    }
}
