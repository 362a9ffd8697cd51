//! Bytes inserted, lost and mixed on the way must not become values.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

mod common;

use asphera_chrocodile::wire::{Layout, SYNC};
use asphera_chrocodile::{Chrocodile, Settings};
use asphera_link::{Driver, Event, Flags, Input, Nanos, Reading};
use common::{FULL_SCALE_UM, stream, streaming, truth};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Exposures of one run: enough for a frame before and after the damage.
const EXPOSURES: std::ops::Range<u64> = 2000..2060;

/// Damaged streams per layout and kind of damage.
const RUNS: u64 = 2500;

/// Orders of the signals: the count first, in the middle and last; values that end in FF.
const LAYOUTS: [&[u16]; 4] =
    [&[75, 76, 65, 256, 257], &[65, 256, 257, 75], &[75, 256, 65], &[16640, 75, 16641, 65, 64]];

/// Fate of the runs.
#[derive(Debug, Default)]
struct Tally {
    wrong: u64,
    suspect: u64,
    right: u64,
    /// Most exposures that one run lost or flagged, with the count first and a whole first telegram.
    most_lost: u64,
}

fn settings(signals: &[u16]) -> Settings {
    Settings { signals: signals.to_vec(), scale_um: Some(FULL_SCALE_UM), ..Settings::default() }
}

fn below(rng: &mut Pcg64Mcg, limit: usize) -> usize {
    (rng.next_u64() % limit as u64) as usize
}

/// Feeds a stream in pieces, about one exposure a ms, ends it with a silence.
fn run(
    driver: &mut Chrocodile,
    bytes: &[u8],
    telegram_len: usize,
    rng: &mut Pcg64Mcg,
) -> Vec<Reading> {
    let mut fed = 0;
    let mut now = Nanos::ZERO;
    while fed < bytes.len() {
        let piece = (1 + below(rng, 40)).min(bytes.len() - fed);
        now = Nanos::from_millis((fed / telegram_len) as u64);
        driver.receive(now, Input::Bytes(&bytes[fed..fed + piece]));
        fed += piece;
    }
    driver.timeout(now + std::time::Duration::from_secs(1));
    std::iter::from_fn(|| driver.poll_event())
        .filter_map(|event| match event {
            Event::Reading(reading) => Some(reading),
            _ => None,
        })
        .collect()
}

/// Whether a reading says what the exposure of its count really was.
fn is_right(reading: &Reading, signals: &[u16]) -> bool {
    let count = reading.count.expect("the layout has the count").raw;
    let layout = Layout::new(SYNC, signals).unwrap();
    let expected = layout.fields().iter().filter(|(_, signal)| signal.channel().is_some()).map(
        |(_, signal)| {
            let mut bytes = Vec::new();
            signal.write(truth(count.into(), signal.quantity), FULL_SCALE_UM, &mut bytes);
            let (multiplier, divisor) = signal.scale(FULL_SCALE_UM);
            let unit = if signal.is_length() { 1000.0 } else { 1.0 };
            Some(signal.value_type.read(&bytes) * multiplier / (divisor * unit))
        },
    );
    EXPOSURES.contains(&count.into()) && reading.values.iter().eq(expected)
}

/// Damages one stream per run and judges every reading that is not flagged.
fn tally(damage: impl Fn(&mut Vec<u8>, &mut Pcg64Mcg)) -> Tally {
    let mut tally = Tally::default();
    for signals in LAYOUTS {
        let whole = stream(signals, EXPOSURES);
        let telegram_len = Layout::new(SYNC, signals).unwrap().telegram_len();
        for seed in 0..RUNS {
            let mut rng = Pcg64Mcg::seed_from_u64(seed);
            let mut bytes = whole.clone();
            damage(&mut bytes, &mut rng);
            let readings = run(&mut streaming(settings(signals)), &bytes, telegram_len, &mut rng);
            let (suspect, sound): (Vec<_>, Vec<_>) =
                readings.iter().partition(|reading| reading.flags.contains(Flags::SUSPECT));
            let right = sound.iter().filter(|reading| is_right(reading, signals)).count() as u64;
            tally.suspect += suspect.len() as u64;
            tally.wrong += sound.len() as u64 - right;
            tally.right += right;
            let is_first_whole = bytes.starts_with(&whole[..telegram_len + 8]);
            if signals[0] == 75 && is_first_whole {
                tally.most_lost = tally.most_lost.max(EXPOSURES.end - EXPOSURES.start - right);
            }
        }
    }
    tally
}

#[test]
fn inserted_bytes_never_become_values() {
    let tally = tally(|bytes, rng| {
        let mut noise = vec![0; 1 + below(rng, 10_000)];
        rng.fill_bytes(&mut noise);
        let place = below(rng, bytes.len() + 1);
        bytes.splice(place..place, noise);
    });
    assert_eq!(tally.wrong, 0, "{tally:?}");
    assert!(tally.most_lost <= 3, "{tally:?}");
}

#[test]
fn few_inserted_bytes_never_become_values_and_cost_few_telegrams() {
    let tally = tally(|bytes, rng| {
        let mut noise = vec![0; 1 + below(rng, 40)];
        rng.fill_bytes(&mut noise);
        let place = below(rng, bytes.len() + 1);
        bytes.splice(place..place, noise);
    });
    assert_eq!(tally.wrong, 0, "{tally:?}");
    assert!(tally.most_lost <= 3, "{tally:?}");
}

#[test]
fn inserted_sync_bytes_never_become_values() {
    let tally = tally(|bytes, rng| {
        let noise = vec![0xFF; 1 + below(rng, 60)];
        let place = below(rng, bytes.len() + 1);
        bytes.splice(place..place, noise);
    });
    assert_eq!(tally.wrong, 0, "{tally:?}");
    assert!(tally.most_lost <= 3, "{tally:?}");
}

#[test]
fn lost_bytes_never_mix_telegrams() {
    let tally = tally(|bytes, rng| {
        // A loss within the first or the last telegram of all has no neighbours to be told by.
        let lost = 1 + below(rng, 200);
        let place = 20 + below(rng, bytes.len() - lost - 60);
        bytes.drain(place..place + lost);
    });
    assert_eq!(tally.wrong, 0, "{tally:?}");
}

#[test]
fn a_lost_sync_costs_one_telegram() {
    for signals in LAYOUTS {
        let telegram_len = Layout::new(SYNC, signals).unwrap().telegram_len();
        let mut bytes = stream(signals, EXPOSURES);
        bytes[20 * telegram_len] ^= 0x55;
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let readings = run(&mut streaming(settings(signals)), &bytes, telegram_len, &mut rng);
        assert!(readings.iter().all(|reading| is_right(reading, signals)));
        // The one before it cannot be confirmed either.
        assert_eq!(readings.len() as u64, EXPOSURES.end - EXPOSURES.start - 2, "{signals:?}");
    }
}
