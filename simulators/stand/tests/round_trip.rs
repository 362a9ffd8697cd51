//! What a stand sends is what a station's driver reads, over TCP and at full speed.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_link::{Command, DeviceSettings, Event, Family, Input, Nanos, Output, Reading};
use asphera_stand::{Instrument, Played, Sight, Stand};
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
    Played { instrument, courses, sight: None, touch: None, listen: None }
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

/// Rows of heights are those that the scanner sees: in text as fine as a line has room for, in records bit for bit, and gaps as gaps.
#[tokio::test]
async fn rows_of_heights_are_read_as_they_were_seen() {
    let text = "separator = \",\"\nlongest = 400\nbegins_whole = true\n[profile]\ncolumn = 2\npoints = 20\nx_first_mm = -1\npitch_mm = 0.1\nno_signal = [\"nan\"]\n[[field]]\nname = \"n\"\ncolumn = 1\nrole = \"count\"\nmodulus = 1000\n";
    let record = "frame = \"record\"\nbegin = '\\xAA\\x55'\nlength = 46\nchecksum = { kind = \"crc16-modbus\", form = \"binary\", order = \"little\" }\n[profile]\nat = 4\nform = \"i16\"\npoints = 20\nx_first_mm = -1\npitch_mm = 0.1\nscale = 1e-3\noffset_mm = 4\nno_value = -32768\n[[field]]\nname = \"n\"\nat = 2\nform = \"u16\"\nrole = \"count\"\nmodulus = 1000\n";
    let height_mm = |trigger: u64, x_mm: f64| (trigger as f64 * 0.01).sin() + x_mm * x_mm;
    for (text, fine_mm) in [(text, 1e-9), (record, 0.5e-3)] {
        let settings = settings(asphera_described::FAMILY, text);
        let instrument = Instrument::new("rows", 0, &*settings).unwrap();
        assert_eq!(instrument.line_points(), Some(20));
        let seen = move |trigger: u64, point: usize, x_mm: f64| {
            (point != 7).then(|| height_mm(trigger, x_mm))
        };
        let still = Played::still(instrument);
        // What has a course has so many triggers.
        let courses = vec![Some(vec![0.0; 60]); still.courses.len().max(1)];
        let rows = Played { courses, sight: Some(Sight::new(20, seen)), ..still };
        let stand = Stand::start(vec![rows], 1000.0).await.unwrap();
        let address = stand.listing()[0].address;
        let found = timeout(PATIENCE, readings(&*settings, address, 50)).await.unwrap();
        for reading in &found {
            assert!(reading.flags.is_empty(), "{:?}", reading.flags);
            let trigger = u64::from(reading.count.unwrap().raw);
            let points_mm = reading.values.profile().unwrap().points_mm();
            assert_eq!((points_mm.len(), points_mm[7]), (20, None));
            for [x_mm, z_mm] in points_mm.iter().flatten() {
                let off_mm = z_mm - height_mm(trigger, *x_mm);
                assert!(off_mm.abs() <= 1.001 * fine_mm, "{x_mm}: {off_mm} mm");
            }
        }
    }
}

/// A probe that runs by its own clock measures on where the scan ended.
#[tokio::test]
async fn a_free_probe_measures_on_after_the_scan() {
    let text = "trigger = \"free\"\nsignals = [75, 76, 65, 256, 257]\nsample_rate_hz = 2000\n";
    let settings = settings(asphera_chrocodile::FAMILY, text);
    let instrument = Instrument::new("probe", 0, &*settings).unwrap();
    assert_eq!(instrument.free_rate_hz(), Some(2000.0));
    let encoder = settings.channels().iter().position(|one| one.name == "encoder_x").unwrap();
    let mut probe = Played::still(instrument);
    probe.courses[encoder] = Some((0..50).map(f64::from).collect());
    let stand = Stand::start(vec![probe], 2000.0).await.unwrap();
    let address = stand.listing()[0].address;
    let found = timeout(PATIENCE, readings(&*settings, address, 90)).await.unwrap();
    let places: Vec<f64> = found.iter().map(|one| one.values.get(encoder).unwrap()).collect();
    let last = places.iter().position(|place| *place == 49.0).unwrap();
    assert!(places[..last].windows(2).all(|pair| pair[1] == pair[0] + 1.0), "{places:?}");
    assert!(places[last..].iter().all(|place| *place == 49.0), "{places:?}");
}

/// What nothing plays is said with the name of the device, why, and what would do.
#[test]
fn devices_that_nothing_plays_are_named() {
    for (family, text, cure) in [
        (
            asphera_chrocodile::FAMILY,
            "averaging = 4\nsignals = [75, 76, 256, 257]",
            "averaging = 1",
        ),
        (asphera_cia406::FAMILY, "node_id = 5\nevery_sync = 2", "every_sync = 1"),
        (
            asphera_cia402::FAMILY,
            "node_id = 5\nstep_nm = 100\nhoming = { method = 1, switch_mm_s = 1, zero_mm_s = 1 }",
            "17, 35 and 37",
        ),
        (
            asphera_cia402::FAMILY,
            "node_id = 5\nstep_nm = 100\nvelocity_scale = 10",
            "velocity_scale = 1",
        ),
    ] {
        let settings = settings(family, text);
        let error = Instrument::new("one", 0, &*settings).unwrap_err().to_string();
        assert!(error.contains("device one") && error.contains(cure), "{error}");
    }
}
