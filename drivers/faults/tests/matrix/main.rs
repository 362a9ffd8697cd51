//! The fault matrix: every driver against every fault, and the tables of drivers/README.md.
//!
//! One file a driver says how its device talks and how each fault must look.
//! `ASPHERA_WRITE_TABLES=1 cargo test -p asphera-faults` writes the tables anew.

mod chrocodile;
mod chrocodile_packets;
mod cia402;
mod cia406;
mod described;
mod described_can;
mod ippdme;
mod keyence;
mod lines;
mod modbus;
mod optoncdt;
mod rf627;
mod riftek;
mod scpi;
mod zaber;

use std::path::Path;

use asphera_faults::{Bench, Fault, Outcome, Row, play, replaced, table};

/// All benches, in the order of the table.
fn benches() -> Vec<Box<dyn Bench>> {
    vec![
        Box::new(chrocodile::Chrocodile { is_triggered: false }),
        Box::new(chrocodile::Chrocodile { is_triggered: true }),
        Box::new(chrocodile_packets::Packets),
        Box::new(cia406::Cia406 { is_timed: false }),
        Box::new(cia406::Cia406 { is_timed: true }),
        Box::new(rf627::Rf627),
        Box::new(keyence::Keyence),
        Box::new(optoncdt::Optoncdt),
        Box::new(riftek::Riftek { is_stream: true }),
        Box::new(riftek::Riftek { is_stream: false }),
        Box::new(described::Described { gauge: described::Kind::Guarded }),
        Box::new(described::Described { gauge: described::Kind::Bare }),
        Box::new(described::Described { gauge: described::Kind::Asked }),
        Box::new(described::Described { gauge: described::Kind::Packets }),
        Box::new(described_can::DescribedCan),
        Box::new(scpi::Scpi),
        Box::new(modbus::Modbus { is_tcp: true }),
        Box::new(modbus::Modbus { is_tcp: false }),
        Box::new(zaber::Zaber),
        Box::new(cia402::Cia402),
        Box::new(ippdme::Ippdme),
    ]
}

/// One test, since the memory of the process is measured in it.
#[test]
fn every_driver_meets_every_fault_as_the_table_says() {
    let (mut wrong, mut rows) = (Vec::new(), Vec::new());
    let only = std::env::var("ASPHERA_MATRIX").ok();
    for bench in benches() {
        let name = bench.name();
        let mut outcomes = Vec::new();
        for fault in Fault::ALL {
            let cell = format!("{name}, {}", fault.name());
            if only.as_ref().is_some_and(|only| !cell.contains(only.as_str())) {
                continue;
            }
            let outcome = play(&*bench, fault);
            if outcome != play(&*bench, fault) {
                wrong.push(format!("{cell}: another outcome the second time"));
            }
            match outcome {
                Ok(outcome) => outcomes.push(outcome),
                Err(laws) => wrong.extend(laws.into_iter().map(|law| format!("{cell}: {law}"))),
            }
        }
        rows.push(Row { driver: name, outcomes });
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    if only.is_some() {
        return;
    }
    let played = rows.iter().flat_map(|row| &row.outcomes);
    let played = played.filter(|outcome| matches!(outcome, Outcome::Played(..))).count();
    assert!(played > 100, "only {played} cells are played");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let document = std::fs::read_to_string(&path).expect("the README of the drivers");
    let expected = replaced(&document, &table(&rows)).expect("the README has the markers");
    if std::env::var_os("ASPHERA_WRITE_TABLES").is_some() {
        std::fs::write(&path, expected).expect("the README can be written");
    } else {
        let cure = "run this test with ASPHERA_WRITE_TABLES=1, and read the difference";
        assert!(document == expected, "drivers/README.md holds another matrix: {cure}");
    }
}
