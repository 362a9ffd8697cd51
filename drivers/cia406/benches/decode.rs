//! Readings from SYNC and TPDO frames, of one node and of one among eight.

use std::hint::black_box;

fn main() {
    divan::main();
}

use asphera_cia406::wire::object::Address;
use asphera_cia406::wire::{
    Cob, Expedited, NmtState, NodeId, SdoRequest, SdoResponse, heartbeat_frame, sync_frame,
};
use asphera_cia406::{Cia406, Settings};
use asphera_link::{CanFrame, CanId, Command, Driver, Event, Input, Nanos, Output};
use divan::Bencher;
use divan::counter::ItemsCount;

const CYCLES: usize = 10_000;

/// A driver whose node has said yes to everything and is operational.
fn running(node: NodeId) -> Cia406 {
    let settings = Settings { node_id: node.get(), ..Settings::default() };
    let mut driver = Cia406::new(settings).expect("default settings are good");
    let now = Nanos::ZERO;
    driver.command(now, Command::Start);
    driver.connected(now);
    while let Some(Output::Frame(frame)) = driver.poll_transmit() {
        let answer = match SdoRequest::decode(node, frame.data()) {
            Ok(SdoRequest::Upload(address)) => {
                let value = if address == Address::new(0x1000, 0) { 0x0008_0196 } else { 1 };
                SdoResponse::Uploaded(address, Expedited::u32(value))
            }
            Ok(SdoRequest::Download(address, _)) => SdoResponse::Downloaded(address),
            _ => continue,
        };
        driver.receive(now, Input::Frame(&answer.encode(node)));
    }
    driver.receive(now, Input::Frame(&heartbeat_frame(node, NmtState::Operational)));
    while driver.poll_event().is_some() {}
    driver
}

/// 10,000 cycles: a SYNC and the positions of `nodes` nodes, all shown to the driver of the last.
#[divan::bench(args = [1, 8])]
fn readings_of_10k_cycles(bencher: Bencher<'_, '_>, nodes: u8) {
    let node = |number| NodeId::new(number).expect("1 to 8");
    let frames: Vec<CanFrame> = (0..CYCLES)
        .flat_map(|cycle| {
            let positions = (1..=nodes).map(move |number| {
                let id = CanId::Standard(Cob::Tpdo1(node(number)).id());
                CanFrame::data_frame(id, &(cycle as u32).to_le_bytes()).expect("four bytes")
            });
            std::iter::once(sync_frame(Some((cycle % 240) as u8 + 1))).chain(positions)
        })
        .collect();
    bencher
        .counter(ItemsCount::new(frames.len()))
        .with_inputs(|| running(node(nodes)))
        .bench_values(|mut driver| {
            let mut readings = 0;
            for frame in black_box(&frames) {
                driver.receive(Nanos::ZERO, Input::Frame(frame));
                while let Some(event) = driver.poll_event() {
                    readings += usize::from(matches!(event, Event::Reading(_)));
                }
            }
            assert_eq!(readings, CYCLES);
        });
}
