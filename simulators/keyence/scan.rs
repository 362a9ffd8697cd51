//! A part that moves under the profiler, and what the stream holds.

use asphera_keyence::wire::Notice;

use crate::{Controller, Surface};

/// A scan of a part along y.
#[derive(Clone, Debug)]
pub struct ScanSettings {
    /// The part.
    pub surface: Surface,
    /// Place of the first profile along y, mm.
    pub first_y_mm: f64,
    /// Counts of the encoder from one profile to the next.
    pub steps: i32,
    /// Length of a count along y, mm.
    pub step_mm: f64,
    /// How many profiles are measured.
    pub profiles: u32,
    /// Profiles a second.
    pub rate_hz: f64,
}

/// Something that happens at a profile, which is counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A bit of it is wrong, and its sum is not.
    BadSum,
    /// Only so many of its bytes come.
    Cut(usize),
    /// So many triggers before it have no profile, and the encoder goes on.
    Lost(u32),
    /// The controller stops the stream before it, for this reason, above 0.
    Stop(u16),
    /// An error is reported from then on.
    Error(u16),
    /// Both connections end before it.
    Unplug,
}

/// A scan as it goes on. The stage stands while nobody reads the stream.
#[derive(Clone, Debug)]
pub struct Scan {
    settings: ScanSettings,
    /// Faults to come.
    faults: Vec<(u32, Fault)>,
    next: u32,
    /// Triggers without a profile so far.
    lost: u32,
}

impl Scan {
    /// A scan from its first profile on.
    pub fn new(settings: ScanSettings, faults: &[(u32, Fault)]) -> Scan {
        Scan { settings, faults: faults.to_vec(), next: 0, lost: 0 }
    }

    /// Time from one profile to the next in ns.
    pub fn period_ns(&self) -> u64 {
        (1e9 / self.settings.rate_hz) as u64
    }

    /// Whether every profile was measured.
    pub fn is_complete(&self) -> bool {
        self.next >= self.settings.profiles
    }

    /// The stage goes back, and triggers count from 0.
    pub fn rewind(&mut self, controller: &mut Controller) {
        (self.next, self.lost) = (0, 0);
        controller.restart();
    }

    /// What the stream holds next; `None`: both connections end. The stream must be running, and the scan not complete.
    ///
    /// A notice of the end of the batch follows the last profile.
    pub fn advance(&mut self, controller: &mut Controller) -> Option<Vec<u8>> {
        let due = self.faults.extract_if(.., |(at, _)| *at == self.next);
        let due: Vec<Fault> = due.map(|(_, fault)| fault).collect();
        for fault in &due {
            match fault {
                Fault::Unplug => return None,
                Fault::Stop(reason) => {
                    controller.halt();
                    return Some(Notice(u32::from(*reason)).encode().to_vec());
                }
                Fault::Error(code) => controller.report(*code),
                Fault::Lost(triggers) => {
                    self.lost += triggers;
                    (0..*triggers).for_each(|_| controller.skip());
                }
                Fault::BadSum | Fault::Cut(_) => {}
            }
        }
        let ScanSettings { surface, first_y_mm, steps, step_mm, profiles, .. } = &self.settings;
        let encoder = (self.next + self.lost).cast_signed().wrapping_mul(*steps);
        let y_mm = first_y_mm + f64::from(encoder) * step_mm;
        let mut bytes = controller.measure(encoder, |x_mm| surface.height_mm([x_mm, y_mm]));
        for fault in &due {
            match fault {
                Fault::BadSum => bytes[25] ^= 0x04,
                Fault::Cut(len) => bytes.truncate(*len),
                _ => {}
            }
        }
        self.next += 1;
        if self.next == *profiles {
            bytes.extend(Notice(END_OF_BATCH).encode());
        }
        Some(bytes)
    }
}

const END_OF_BATCH: u32 = 0x1_0000;
