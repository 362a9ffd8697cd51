//! Nodes and drives on the bus of a stand, read by the station's drivers, and moved by an independent client.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::f64::consts::TAU;
use std::process::Stdio;
use std::time::Duration;

use asphera_link::{Command, DeviceSettings, Event, Family, Input, Nanos, Output, Reading};
use asphera_slcan::{Decoder, Item, encode};
use asphera_stand::{Instrument, Moving, Played, Stand};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until, timeout};

/// Far longer than any of these tests takes.
const PATIENCE: Duration = Duration::from_secs(60);

/// A gauge whose frames carry its height in steps of 0.1 µm.
const GAUGE: &str = "frame = \"can\"\nid = 0x300\n[[field]]\nname = \"height\"\nstart_bit = 0\nbits = 32\norder = \"little\"\nform = \"signed\"\nscale = 1e-4\nunit = \"mm\"\n";

fn settings(family: Family, text: &str) -> Box<dyn DeviceSettings> {
    family.parse("device", text).unwrap()
}

fn played(name: &str, settings: &dyn DeviceSettings, course: Option<Vec<f64>>) -> Played {
    let instrument = Instrument::new(name, 0, settings).unwrap();
    let still = Played::still(instrument);
    let others = vec![None; still.courses.len() - 1];
    Played { courses: std::iter::once(course).chain(others).collect(), ..still }
}

/// Readings of the driver of these settings on the bus at a port, until `is_enough`.
async fn readings(
    settings: &dyn DeviceSettings,
    address: std::net::SocketAddr,
    is_enough: impl Fn(&[Reading]) -> bool,
) -> Vec<Reading> {
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(b"S6\rO\r").await.unwrap();
    let (mut decoder, mut driver) = (Decoder::new(), settings.driver().unwrap());
    let start = Instant::now();
    let now = || Nanos::ZERO + start.elapsed();
    driver.connected(now());
    driver.command(now(), Command::Start);
    let (mut found, mut bytes) = (Vec::new(), [0; 4096]);
    loop {
        while let Some(Output::Frame(frame)) = driver.poll_transmit() {
            let mut line = Vec::new();
            encode(&frame, &mut line);
            stream.write_all(&line).await.unwrap();
        }
        while let Some(event) = driver.poll_event() {
            match event {
                Event::Reading(reading) => found.push(reading),
                Event::Fault(fault) => panic!("{fault:?}"),
                _ => {}
            }
        }
        if is_enough(&found) {
            return found;
        }
        let due = driver.poll_timeout().map(|due| start + due.since(Nanos::ZERO));
        tokio::select! {
            read = stream.read(&mut bytes) => {
                let mut input = &bytes[..read.unwrap()];
                while !input.is_empty() {
                    if let Some(Item::Frame(frame, _)) = decoder.decode(&mut input) {
                        driver.receive(now(), Input::Frame(&frame));
                    }
                }
            }
            () = sleep_until(due.unwrap_or(start + PATIENCE)) => driver.timeout(now()),
        }
    }
}

/// Nodes by timer, of which another master may set one up, and a drive that something else moves: each shows the way from the first place
/// to the last, and nothing is flagged.
#[tokio::test]
async fn devices_with_a_timer_of_their_own_show_where_the_machine_is() {
    let turn = |turns: f64| turns * TAU;
    let ways: [(Family, &str, f64, f64); 5] = [
        (asphera_cia406::FAMILY, "node_id = 5\nevent_timer_ms = 2\nstep_nm = 100", 3.0, 1e-4),
        (
            asphera_cia406::FAMILY,
            "node_id = 5\nevent_timer_ms = 2\nkind = \"rotary\"\ncounts_per_turn = 4096\nposition_object = \"6004\"",
            turn(-1.5),
            turn(1.0 / 4096.0),
        ),
        (
            asphera_cia406::FAMILY,
            "node_id = 5\nevent_timer_ms = 2\nstep_nm = 100\nlisten_only = true\nmap_status = true",
            3.0,
            1e-4,
        ),
        (asphera_cia402::FAMILY, "node_id = 6\nstep_nm = 100\nperiod_ms = 2", 3.0, 1e-4),
        (
            asphera_cia402::FAMILY,
            "node_id = 6\ncounts_per_turn = 8192\nperiod_ms = 2\nreference = \"absolute\"",
            turn(-1.5),
            turn(1.0 / 8192.0),
        ),
    ];
    for (family, text, end, step) in ways {
        let settings = settings(family, text);
        let instrument = Instrument::new("node", 0, &*settings).unwrap();
        let way = (0..=100).map(|k| instrument.shown(0, end * f64::from(k) / 100.0)).collect();
        let stand = Stand::start(vec![played("node", &*settings, Some(way))], 1000.0);
        let stand = stand.await.unwrap();
        let last = instrument.shown(0, end);
        let is_there = |reading: &Reading| {
            reading.values.get(0).is_some_and(|value| (value - last).abs() < 0.5 * step)
        };
        let address = stand.listing()[0].address;
        let arrived = |found: &[Reading]| found.last().is_some_and(is_there);
        let found = timeout(PATIENCE, readings(&*settings, address, arrived)).await.unwrap();
        let values: Vec<f64> = found.iter().map(|one| one.values.get(0).unwrap()).collect();
        assert!(values[0].abs() <= 0.5 * end.abs(), "{text}: begins at {}", values[0]);
        let goes_on = |pair: &[f64]| (pair[1] - pair[0]) * end.signum() > -0.5 * step;
        assert!(values.windows(2).all(goes_on), "{text}: {values:?}");
        assert!(found.iter().all(|reading| reading.flags.is_empty()), "{text}");
    }
}

/// An unsigned rotary encoder stands a whole number of turns higher, so that it may turn back.
#[tokio::test]
async fn an_unsigned_encoder_may_turn_back() {
    let text = "node_id = 5\nkind = \"rotary\"\ncounts_per_turn = 3600\nposition_object = \"6004-unsigned\"";
    let settings = settings(asphera_cia406::FAMILY, text);
    let turns = [0.25, -0.5, 0.1];
    let course = turns.map(|turns| turns * TAU).to_vec();
    let stand = Stand::start(vec![played("node", &*settings, Some(course))], 100.0).await.unwrap();
    let address = stand.listing()[0].address;
    let all = |found: &[Reading]| found.len() == turns.len();
    let found = timeout(PATIENCE, readings(&*settings, address, all)).await.unwrap();
    for (reading, turns) in found.iter().zip(turns) {
        let found = reading.values.get(0).unwrap() / TAU;
        assert!(found > 0.0 && (found - turns - (found - turns).round()).abs() < 1e-6, "{found}");
    }
}

/// Python `canopen` homes and moves a drive on the bus of a stand, beside a gauge that shows where it stands.
///
/// Needs an interpreter with canopen, python-can and pyserial, named by `ASPHERA_PYTHON` or found as `python3`; skipped without.
#[tokio::test]
async fn an_independent_client_moves_a_drive_and_the_gauge_follows() {
    const TARGET: i32 = 12_345;
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let imports = ["-c", "import canopen, can, serial"];
    let mut probe = std::process::Command::new(&python);
    if !probe.args(imports).stderr(Stdio::null()).status().is_ok_and(|status| status.success()) {
        eprintln!("skipped: {python} cannot import canopen, can, serial");
        return;
    }
    let homed =
        "node_id = 5\nstep_nm = 100\nhoming = { method = 17, switch_mm_s = 4, zero_mm_s = 1 }";
    let (drive, gauge) =
        (settings(asphera_cia402::FAMILY, homed), settings(asphera_described::FAMILY, GAUGE));
    let devices = vec![played("x", &*drive, None), played("gauge", &*gauge, None)];
    let moving = Moving::new(vec![vec![Some([0.0, 5.0])], vec![None]], |_, values| {
        values[1][0] = 2.0 * values[0][0];
    });
    let stand = Stand::start_moving(devices, 200.0, moving).await.unwrap();
    let address = stand.listing()[0].address;
    let client = tokio::task::spawn_blocking(move || {
        std::process::Command::new(python)
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../cia402/tests/peer.py"))
            .args([address.port().to_string(), "5".to_owned(), TARGET.to_string()])
            .output()
    });
    let output = timeout(2 * PATIENCE, client).await.unwrap().unwrap().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}\n{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.lines().collect::<Vec<_>>(), ["homed 0", "arrived 12345"]);
    // The gauge sends while the drive is operational, which it still is.
    let one = |found: &[Reading]| !found.is_empty();
    let found = timeout(PATIENCE, readings(&*gauge, address, one)).await.unwrap();
    let height_mm = found[0].values.get(0).unwrap();
    assert!((height_mm - 2.0 * 1.2345).abs() < 1e-9, "{height_mm}");
}
