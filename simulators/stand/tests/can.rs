//! Described devices on a CAN bus: frames of the stand against cantools, and read by the driver over an slcan adapter.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_link::{CanFrame, Command, DeviceSettings, Event, Input, Nanos, Output, Reading};
use asphera_slcan::{Decoder, Item, Timestamps, encode};
use asphera_stand::{Instrument, Played, Stand};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::time::timeout;

/// Far longer than any of these tests takes.
const PATIENCE: Duration = Duration::from_secs(60);

/// The gauge of config/examples/can-transducers.toml.
const GAUGE: &str = r#"
frame = "can"
id = 0x185
fd = true
length = 12
on_start = [{ id = 0x605, data = '\x01' }]
on_stop = [{ id = 0x605, data = '\x00' }]

[[field]]
name = "height"
start_bit = 0
bits = 32
order = "little"
form = "signed"
scale = 1e-4
unit = "mm"
valid_range = [-5, 5]

[[field]]
name = "count"
start_bit = 32
bits = 16
order = "little"
role = "count"
modulus = 65536

[[field]]
name = "state"
start_bit = 48
bits = 8
order = "little"
role = "bits"
device_error = ["7"]
"#;

/// The scale of the same file.
const SCALE: &str = r#"
frame = "can"
id = 0x00FF1200
extended = true
mask = 0x03FFFF00

[[field]]
name = "x"
start_bit = 7
bits = 24
order = "big"
scale = 1e-3
unit = "mm"

[[field]]
name = "y"
start_bit = 31
bits = 24
order = "big"
scale = 1e-3
unit = "mm"

[[field]]
name = "count"
start_bit = 55
bits = 16
order = "big"
role = "count"
modulus = 65536
"#;

/// Height, x and y in mm, and the data that cantools 40.2.3 makes of them by these signals of a DBC file:
///
/// ```text
/// BO_ 389 gauge: 12 X
///  SG_ height : 0|32@1- (0.0001,0) [0|0] "mm" X
///  SG_ count : 32|16@1+ (1,0) [0|0] "" X
///  SG_ state : 48|8@1+ (1,0) [0|0] "" X
/// BO_ 2164199936 scale: 8 X
///  SG_ x : 7|24@0+ (0.001,0) [0|0] "mm" X
///  SG_ y : 31|24@0+ (0.001,0) [0|0] "mm" X
///  SG_ count : 55|16@0+ (1,0) [0|0] "" X
/// ```
const BY_CANTOOLS: [([f64; 3], &str, &str); 3] = [
    ([0.0123, 24.0, 26.5], "7B0000000000000000000000", "005DC00067840000"),
    ([-4.9999, 0.001, 16.0], "B13CFFFF0100000000000000", "000001003E800001"),
    ([2.5, 16_777.215, 25.0], "A86100000200000000000000", "FFFFFF0061A80002"),
];

fn settings(text: &str) -> Box<dyn DeviceSettings> {
    asphera_described::FAMILY.parse("device", text).unwrap()
}

fn played(name: &str, settings: &dyn DeviceSettings, courses: Vec<Vec<f64>>) -> Played {
    let instrument = Instrument::new(name, 0, settings).unwrap();
    let courses = courses.into_iter().map(Some).collect();
    Played { instrument, courses, sight: None, touch: None, listen: None }
}

fn line(text: &str) -> CanFrame {
    let mut decoder = Decoder::new();
    let line = format!("{text}\r");
    match decoder.decode(&mut line.as_bytes()) {
        Some(Item::Frame(frame, None)) => frame,
        other => panic!("{text}: {other:?}"),
    }
}

/// An adapter that was opened at 500 kbit/s, with stamps where they are wanted.
async fn adapter(stand: &Stand, stamps: &str) -> TcpStream {
    let listing = &stand.listing()[0];
    assert_eq!((listing.kind, listing.sends_fd), ("slcan-tcp", true));
    let mut stream = TcpStream::connect(listing.address).await.unwrap();
    stream.write_all(format!("S6\rY2\r{stamps}\rO\r").as_bytes()).await.unwrap();
    stream
}

/// Frames of the bus with their stamps, until there are so many.
async fn frames(
    stream: &mut TcpStream,
    decoder: &mut Decoder,
    wanted: usize,
) -> Vec<(CanFrame, Option<u16>)> {
    let (mut found, mut bytes) = (Vec::new(), [0; 4096]);
    while found.len() < wanted {
        let len = timeout(PATIENCE, stream.read(&mut bytes)).await.unwrap().unwrap();
        assert!(len > 0, "the stand closed");
        let mut input = &bytes[..len];
        while !input.is_empty() {
            match decoder.decode(&mut input) {
                Some(Item::Frame(frame, stamp)) => found.push((frame, stamp)),
                Some(Item::Ok) | None => {}
                Some(other) => panic!("{other:?}"),
            }
        }
    }
    found
}

/// Nothing comes before the gauge was started; then the frames are those of cantools.
#[tokio::test]
async fn frames_are_those_of_cantools() {
    let course = |channel: usize| BY_CANTOOLS.map(|(values, _, _)| values[channel]).to_vec();
    let gauge = played("gauge", &*settings(GAUGE), vec![course(0)]);
    let scale = played("scale", &*settings(SCALE), vec![course(1), course(2)]);
    let stand = Stand::start(vec![gauge, scale], 1000.0).await.unwrap();
    let mut stream = adapter(&stand, "Z0").await;
    let mut bytes = [0; 64];
    let silent = timeout(Duration::from_millis(300), async {
        loop {
            let len = stream.read(&mut bytes).await.unwrap();
            assert!(bytes[..len].iter().all(|byte| *byte == b'\r'), "before the start");
        }
    });
    assert!(silent.await.is_err());
    stream.write_all(b"t605101\r").await.unwrap();
    let mut decoder = Decoder::expecting(Timestamps::Never);
    let found = frames(&mut stream, &mut decoder, 6).await;
    let frames: Vec<CanFrame> = found.into_iter().map(|(frame, _)| frame).collect();
    let expected = BY_CANTOOLS.iter().flat_map(|(_, gauge, scale)| {
        [line(&format!("b1859{gauge}")), line(&format!("T00FF12008{scale}"))]
    });
    assert_eq!(frames, expected.collect::<Vec<_>>());
}

/// What the stand sends, the driver reads, bit for bit where the bits say it.
#[tokio::test]
async fn the_driver_reads_what_was_shown() {
    let gauge = settings(GAUGE);
    let instrument = Instrument::new("gauge", 0, &*gauge).unwrap();
    let wave = |k: usize| instrument.shown(0, 4.9 * (0.37 * k as f64).sin());
    let heights: Vec<f64> = (0..300).map(wave).collect();
    let stand = Stand::start(vec![played("gauge", &*gauge, vec![heights.clone()])], 3000.0);
    let stand = stand.await.unwrap();
    let mut stream = adapter(&stand, "Z1").await;
    let mut driver = gauge.driver().unwrap();
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    while let Some(Output::Frame(frame)) = driver.poll_transmit() {
        let mut bytes = Vec::new();
        encode(&frame, &mut bytes);
        stream.write_all(&bytes).await.unwrap();
    }
    let mut decoder = Decoder::expecting(Timestamps::Always);
    let found = frames(&mut stream, &mut decoder, 300).await;
    let stamps: Vec<u16> = found.iter().map(|(_, stamp)| stamp.unwrap()).collect();
    // 299 triggers at 3 kHz.
    let passed_ms = (u32::from(stamps[299]) + 60_000 - u32::from(stamps[0])) % 60_000;
    assert!((90..10_000).contains(&passed_ms), "{passed_ms}");
    for (frame, _) in &found {
        driver.receive(Nanos::ZERO, Input::Frame(frame));
    }
    let readings: Vec<Reading> = std::iter::from_fn(|| driver.poll_event())
        .filter_map(|event| if let Event::Reading(reading) = event { Some(reading) } else { None })
        .collect();
    assert_eq!(readings.len(), 300);
    for (index, (reading, height)) in readings.iter().zip(&heights).enumerate() {
        assert!(reading.flags.is_empty(), "{index}: {:?}", reading.flags);
        assert_eq!(reading.values.get(0), Some(*height), "{index}");
        assert_eq!(reading.count.unwrap().raw, index as u32);
    }
}

/// A device that is asked answers, and none that sends by itself is on its bus.
#[tokio::test]
async fn a_device_that_is_asked_answers() {
    let text = format!("{SCALE}[poll]\nid = 0x40\nremote = 0\ninterval_ms = 10\n");
    let scale = played("scale", &*settings(&text), vec![vec![12.5, 12.5], vec![3.25, 3.25]]);
    let stand = Stand::start(vec![scale], 100.0).await.unwrap();
    let mut stream = TcpStream::connect(stand.listing()[0].address).await.unwrap();
    stream.write_all(b"S6\rO\rr0400\r").await.unwrap();
    let found = frames(&mut stream, &mut Decoder::new(), 1).await;
    let [(frame, None)] = found[..] else { panic!("{found:?}") };
    // 12500 and 3250 steps of 1 µm, highest byte first.
    assert_eq!(frame.data()[..6], [0x00, 0x30, 0xD4, 0x00, 0x0C, 0xB2]);
}
