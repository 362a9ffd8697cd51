//! What a stand sends is what a station's driver reads, over TCP and at full speed.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_link::{Command, DeviceSettings, Event, Family, Input, Nanos, Output, Reading};
use asphera_stand::{Instrument, Played, Stand};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until, timeout};

/// Far longer than any of these tests takes.
const PATIENCE: Duration = Duration::from_secs(60);

const COLUMNS: &str = r#"
separator = ","
columns = 5
on_start = ['GO\r\n']
on_stop = ['STOP\r\n']

[hello]
ask = 'ID\r\n'
answer = 'ARM 7,.*'

[[field]]
name = "n"
column = 1
role = "count"
first = 7
modulus = 10

[[field]]
name = "x"
column = 2
unit = "mm"
valid_range = [-300, 300]

[[field]]
name = "z"
column = 4
unit = "mm"
scale = 1e-3
offset = 2.5

[[field]]
name = "state"
column = 5
role = "status"
good = ["OK"]
"#;

const RECORD: &str = r#"
frame = "record"
begin = '\xAA\x55'
length = 14
checksum = { kind = "crc16-modbus", form = "binary", order = "little" }

[[field]]
name = "n"
at = 2
form = "u16"
role = "count"
modulus = 65536

[[field]]
name = "x"
at = 4
form = "i32"
order = "little"
unit = "mm"
scale = 1e-4

[[field]]
name = "z"
at = 8
form = "f32"
unit = "mm"
"#;

const PATTERN: &str = r#"
begin = '$'
end = '\r'
pattern = 'H,(?<n>\d{3}),(?<x>[+-]\d{2}\.\d{4}),(?<z>-?\d+\.\d{6})'
checksum = { kind = "xor8", form = "hex", skip_first = 1, skip_last = 1 }

[[field]]
name = "n"
group = "n"
role = "count"
modulus = 1000

[[field]]
name = "x"
group = "x"
unit = "mm"

[[field]]
name = "z"
group = "z"
unit = "mm"
"#;

fn settings(family: Family, text: &str) -> Box<dyn DeviceSettings> {
    family.parse("device", text).unwrap()
}

/// A course of so many values, none of which is a round number.
fn course(points: usize, from: f64) -> Vec<f64> {
    (0..points).map(|k| from + 17.0 * (0.3 * k as f64).sin()).collect()
}

fn played(name: &str, link: usize, settings: &dyn DeviceSettings, points: usize) -> Played {
    let instrument = Instrument::new(name, link, settings).unwrap();
    let course = |channel: usize| {
        let values = course(points, channel as f64).into_iter();
        Some(values.map(|value| instrument.shown(channel, value)).collect())
    };
    let courses = (0..settings.channels().len()).map(course).collect();
    Played { instrument, courses, sight: None, listen: None }
}

/// Readings of the driver of these settings at a port, until there are so many.
async fn readings(
    settings: &dyn DeviceSettings,
    address: std::net::SocketAddr,
    wanted: usize,
) -> Vec<Reading> {
    let mut stream = TcpStream::connect(address).await.unwrap();
    let mut driver = settings.driver().unwrap();
    let start = Instant::now();
    let now = || Nanos::ZERO + start.elapsed();
    driver.connected(now());
    driver.command(now(), Command::Start);
    let (mut found, mut bytes) = (Vec::new(), [0; 4096]);
    loop {
        while let Some(Output::Bytes(bytes)) = driver.poll_transmit() {
            stream.write_all(&bytes).await.unwrap();
        }
        while let Some(event) = driver.poll_event() {
            if let Event::Reading(reading) = event {
                found.push(reading);
            }
        }
        if found.len() >= wanted {
            return found;
        }
        let due = driver.poll_timeout().map(|due| start + due.since(Nanos::ZERO));
        tokio::select! {
            read = stream.read(&mut bytes) => match read.unwrap() {
                0 => return found,
                len => driver.receive(now(), Input::Bytes(&bytes[..len])),
            },
            () = sleep_until(due.unwrap_or(start + PATIENCE)) => driver.timeout(now()),
        }
    }
}

/// Values that were sent are read, bit for bit where digits are not limited, and nothing is flagged.
#[tokio::test]
async fn described_devices_are_read_as_they_were_shown() {
    for text in [COLUMNS, RECORD, PATTERN] {
        let settings = settings(asphera_described::FAMILY, text);
        let device = played("arm", 0, &*settings, 200);
        let courses = device.courses.clone();
        let stand = Stand::start(vec![device], 5000.0).await.unwrap();
        let address = stand.listing()[0].address;
        // A driver believes a line, and a record, once it knows where frames begin.
        let found = timeout(PATIENCE, readings(&*settings, address, 190)).await.unwrap();
        let first = found[0].values.get(0).unwrap();
        let from = courses[0].as_ref().unwrap().iter().position(|x| *x == first).unwrap();
        assert!(from < 3, "{text}: the first of {from}");
        for (index, reading) in found.iter().enumerate().skip(1) {
            assert!(reading.flags.is_empty(), "{text}: {index}: {:?}", reading.flags);
            for (channel, course) in courses.iter().enumerate() {
                let shown = course.as_ref().unwrap()[from + index];
                assert_eq!(reading.values.get(channel), Some(shown), "{text}: {index}, {channel}");
            }
        }
    }
}

/// A stage that is asked answers with the place of the last trigger.
#[tokio::test]
async fn a_stage_that_is_asked_answers() {
    let text = "interval_ms = 5\n[[axis]]\nname = \"x\"\nmicrostep_um = 0.1\n[[axis]]\nname = \"y\"\nmicrostep_um = 0.2\n";
    let settings = settings(asphera_zaber::FAMILY, text);
    let mut stage = played("stage", 3, &*settings, 2);
    stage.courses = vec![Some(vec![1.2345, 1.2345]), None];
    let stand = Stand::start(vec![stage], 100.0).await.unwrap();
    assert_eq!((stand.listing()[0].link, stand.listing()[0].kind), (3, "tcp"));
    let found =
        timeout(PATIENCE, readings(&*settings, stand.listing()[0].address, 3)).await.unwrap();
    for reading in found {
        let x_mm = reading.values.get(0).unwrap();
        assert!((x_mm - 1.2345).abs() < 1e-12 && reading.values.get(1) == Some(0.0), "{reading:?}");
    }
}

/// What nothing plays is said with the name of the device.
#[test]
fn devices_that_nothing_plays_are_named() {
    let row = "separator = \",\"\n[profile]\ncolumn = 1\npoints = 3\npitch_mm = 0.1\n";
    let described = settings(asphera_described::FAMILY, row);
    let error = Instrument::new("rows", 0, &*described).unwrap_err().to_string();
    assert!(error.contains("device rows") && error.contains("profiles"), "{error}");
    let free = "trigger = \"free\"\nsignals = [75, 76, 256, 257]\n";
    let settings = settings(asphera_chrocodile::FAMILY, free);
    let error = Instrument::new("probe", 0, &*settings).unwrap_err().to_string();
    assert!(error.contains("device probe") && error.contains("trigger = \"each\""), "{error}");
}
