//! A device that says yes to everything, and streams whose truth is known.

use asphera_chrocodile::wire::{Layout, Part, Quantity, SYNC};
use asphera_chrocodile::{Chrocodile, Settings};
use asphera_link::{Command, Driver, Event, Input, Nanos, Output};

/// A driver that streams since time 0, its events drained.
pub(crate) fn streaming(settings: Settings) -> Chrocodile {
    let mut driver = Chrocodile::new(settings).expect("usable settings");
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    while let Some(Output::Bytes(mut answer)) = driver.poll_transmit() {
        answer.extend(b"ready\r\n");
        driver.receive(Nanos::ZERO, Input::Bytes(&answer));
    }
    let events: Vec<Event> = std::iter::from_fn(|| driver.poll_event()).collect();
    assert_eq!(events, [Event::Online, Event::Ready]);
    driver
}

/// What the telegram of an exposure says, in the manual's units: an encoder that passes 0, a slope of
/// 50 nm a step with 3 µm of waviness, an intensity that drifts.
pub(crate) fn truth(exposure: u64, quantity: Quantity) -> f64 {
    let step = exposure as f64;
    match quantity {
        Quantity::ExposureCount | Quantity::SampleCounter => (exposure % 65536) as f64,
        Quantity::ExposureFlags => 0.0,
        Quantity::EncoderStart(_) => step - 2030.0,
        Quantity::Peak { part: Part::Value, .. } => {
            1000.0 + 0.05 * (step % 10_000.0) + 3.0 * (0.7 * step).sin()
        }
        _ => 80.0 + (0.3 * step).cos(),
    }
}

/// The telegrams of some exposures, one after the other.
pub(crate) fn stream(signals: &[u16], exposures: std::ops::Range<u64>) -> Vec<u8> {
    let layout = Layout::new(SYNC, signals).expect("supported signals");
    let mut stream = Vec::new();
    for exposure in exposures {
        layout.encode(FULL_SCALE_UM, |signal| truth(exposure, signal.quantity), &mut stream);
    }
    stream
}

/// Full scale of the probe that [`stream`] imitates.
pub(crate) const FULL_SCALE_UM: f64 = 3000.0;
