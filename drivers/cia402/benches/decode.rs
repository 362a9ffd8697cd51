//! Rate of statuswords and positions through the driver.

use std::hint::black_box;

use asphera_cia402::wire::{
    Expedited, NodeId, SdoRequest, SdoResponse, Statusword, encode_tpdo, object,
};
use asphera_cia402::{Cia402, Reference, Settings};
use asphera_link::{CanFrame, CanId, Command, Driver, Event, Input, Nanos, Output};
use divan::Bencher;
use divan::counter::ItemsCount;

const FRAMES: u64 = 100_000;

fn main() {
    divan::main();
}

/// A driver whose node is set up and started.
fn started() -> Cia402 {
    let settings = Settings { reference: Reference::Absolute, ..Settings::default() };
    let mut driver = Cia402::new(settings).expect("good settings");
    let node = NodeId::new(1).expect("1 to 127");
    driver.command(Nanos::ZERO, Command::Start);
    driver.connected(Nanos::ZERO);
    while let Some(Output::Frame(frame)) = driver.poll_transmit() {
        let response = match SdoRequest::decode(node, frame.data()) {
            Ok(SdoRequest::Upload(address)) => {
                let value = if address == object::DEVICE_TYPE { 402 } else { 0x21 };
                SdoResponse::Uploaded(address, Expedited::u32(value))
            }
            Ok(SdoRequest::Download(address, _)) => SdoResponse::Downloaded(address),
            _ => continue,
        };
        driver.receive(Nanos::ZERO, Input::Frame(&response.encode(node)));
    }
    driver
}

/// 100,000 TPDOs, 10 µs apart.
#[divan::bench]
fn read_100k_positions(bencher: Bencher<'_, '_>) {
    let frame = |k: u64| {
        let data = encode_tpdo(Statusword(0x0237), k as i32);
        CanFrame::data_frame(CanId::Standard(0x181), &data).expect("six bytes")
    };
    let frames: Vec<CanFrame> = (0..FRAMES).map(frame).collect();
    bencher.counter(ItemsCount::new(FRAMES)).with_inputs(started).bench_values(|mut driver| {
        let mut readings = 0;
        for (k, frame) in (0..).zip(black_box(&frames)) {
            driver.receive(Nanos::from_nanos(k * 10_000), Input::Frame(frame));
            while let Some(event) = driver.poll_event() {
                readings += u64::from(matches!(event, Event::Reading(_)));
            }
        }
        assert_eq!(readings, FRAMES);
    });
}
