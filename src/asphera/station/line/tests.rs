//! A link whose bus opens later than its connection, and one that is a log.

use std::time::Duration;

use asphera_link::{Channel, Unit};

use super::*;

/// A device that sends one frame when it is connected, and says what frames came.
struct Node {
    reads_fd: bool,
    channels: Vec<Channel>,
    sent: Vec<CanFrame>,
    events: Vec<Event>,
    /// Due 1 s after the connection.
    due: Option<Nanos>,
}

impl Driver for Node {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn reads_fd(&self) -> bool {
        self.reads_fd
    }

    fn connected(&mut self, now: Nanos) {
        self.sent.push(frame(0x605, &[0x40]));
        self.due = Some(now + Duration::from_secs(1));
    }

    fn disconnected(&mut self, _: Nanos) {
        self.due = None;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Frame(frame) = input else { panic!("bytes on a bus") };
        let mut values = asphera_link::Values::new();
        values.push(frame.data().first().map(|byte| f64::from(*byte)));
        let flags = Flags::empty();
        self.events.push(Event::Reading(Reading {
            host: now,
            device_time_ns: None,
            count: None,
            values,
            flags,
        }));
    }

    fn timeout(&mut self, _: Nanos) {
        self.due = None;
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        self.due
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.sent.pop().map(Output::Frame)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, _: Nanos, _: Command) {}
}

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(asphera_link::CanId::Standard(id), data).unwrap()
}

fn line(framing: Framing) -> Line {
    line_with(framing, false)
}

fn line_with(framing: Framing, reads_fd: bool) -> Line {
    let channels = vec![Channel::new("position", Unit::Count)];
    let node = Node { reads_fd, channels, sent: Vec::new(), events: Vec::new(), due: None };
    Line::new("bus".to_owned(), framing, vec![("node".to_owned(), Box::new(node))])
}

fn server() -> Line {
    line(Framing::Socketcand { bus: "can0".to_owned() })
}

/// What a line wants after it has received `bytes`, in short: `send …`, `reopen`, `reading …`.
fn received(line: &mut Line, at_ms: u64, bytes: &[u8]) -> Vec<String> {
    let mut out = Vec::new();
    line.received(Nanos::from_millis(at_ms), bytes, &mut out);
    words(&out)
}

fn words(effects: &[Effect]) -> Vec<String> {
    let word = |effect: &Effect| match effect {
        Effect::Send { bytes, .. } => Some(format!("send {}", String::from_utf8_lossy(bytes))),
        Effect::Reopen { epoch } => Some(format!("reopen {epoch}")),
        Effect::Reading { reading, .. } => Some(format!("reading {:?}", reading.values.get(0))),
        _ => None,
    };
    effects.iter().filter_map(word).collect()
}

fn opened(line: &mut Line, at_ms: u64, epoch: u64) -> Vec<String> {
    let mut out = Vec::new();
    line.opened(Nanos::from_millis(at_ms), epoch, &mut out);
    words(&out)
}

#[test]
fn devices_are_connected_when_the_server_has_opened_the_bus() {
    let mut line = server();
    assert!(opened(&mut line, 0, 1).is_empty(), "the server speaks first");
    assert_eq!(line.poll_timeout(), Some(Nanos::from_millis(3000)));
    assert!(received(&mut line, 1, b"< h").is_empty());
    assert_eq!(received(&mut line, 2, b"i >"), ["send < open can0 >"]);
    assert_eq!(received(&mut line, 3, b"< ok >"), ["send < rawmode >"]);
    // The frame of the device goes out only now, and the first frame of the bus comes in the same piece.
    let wanted = received(&mut line, 4, b"< ok >< frame 185 23.424242 07 >");
    assert_eq!(wanted, ["send < send 605 1 40 >", "reading Some(7.0)"]);
    assert_eq!(line.poll_timeout(), Some(Nanos::from_millis(1004)), "that of the device");
    assert_eq!(line.figures(&[]).discarded_bytes, 0);
}

#[test]
fn a_server_that_is_silent_is_left_and_tried_again() {
    let mut line = server();
    opened(&mut line, 0, 1);
    let mut out = Vec::new();
    line.timeout(Nanos::from_millis(3000), &mut out);
    assert_eq!(words(&out), ["reopen 1"]);
    assert!(line.last_error().unwrap().contains("within 3 s its greeting < hi >"));
    assert!(received(&mut line, 3001, b"< hi >").is_empty(), "late");
    assert_eq!((line.poll_timeout(), line.figures(&[]).discarded_bytes), (None, 6));
    line.closed(Nanos::from_millis(3002), "closed to start over".to_owned(), &mut out);
    assert!(line.last_error().unwrap().contains("greeting"), "the cause stays");
    opened(&mut line, 4000, 2);
    assert_eq!(received(&mut line, 4001, b"< hi >"), ["send < open can0 >"]);
}

#[test]
fn a_bus_that_the_server_does_not_have_is_said() {
    let mut line = server();
    opened(&mut line, 0, 1);
    received(&mut line, 1, b"< hi >");
    assert_eq!(received(&mut line, 2, b"< error could not open bus >"), ["reopen 1"]);
    let error = line.last_error().unwrap();
    assert!(
        error.contains("can0") && error.contains("could not open bus") && error.contains("set bus"),
        "{error}"
    );
}

#[test]
fn what_is_lost_and_damaged_is_counted_and_the_next_connection_begins_anew() {
    let mut line = server();
    opened(&mut line, 0, 1);
    received(&mut line, 1, b"< hi >");
    received(&mut line, 2, b"< ok >< ok >");
    let wanted = received(&mut line, 3, b"noise< frame 185 2< frame 185 2.0 09 >< frame 18");
    assert_eq!(wanted, ["reading Some(9.0)"]);
    let mut out = Vec::new();
    line.closed(Nanos::from_millis(4), "the other end closed the connection".to_owned(), &mut out);
    // "noise", the frame that was cut, and the half at the end.
    assert_eq!(line.figures(&[]).discarded_bytes, 5 + 13 + 10);
    opened(&mut line, 100, 2);
    assert!(received(&mut line, 101, b"5 2.0 09 >").is_empty());
    assert_eq!(received(&mut line, 102, b"< hi >"), ["send < open can0 >"]);
}

#[test]
fn trouble_on_the_bus_is_said_and_ends_nothing() {
    let mut line = server();
    opened(&mut line, 0, 1);
    received(&mut line, 1, b"< hi >");
    received(&mut line, 2, b"< ok >< ok >< error 040 23.424242 >");
    assert_eq!(line.last_error(), Some("trouble on the bus: bus off"));
    received(&mut line, 3, b"< error unknown command >");
    assert!(line.last_error().unwrap().contains("unknown command"));
    assert_eq!(received(&mut line, 4, b"< frame 185 2.0 09 >"), ["reading Some(9.0)"]);
}

#[test]
fn a_log_takes_nothing_and_says_at_its_end_what_was_left_out() {
    let mut line = line(Framing::Candump { interface: Some("can0".to_owned()) });
    assert!(opened(&mut line, 0, 1).is_empty(), "the frame of the device goes nowhere");
    let log =
        b"(1.0) can0 185#05\n(1.1) can1 185#06\n(1.2) can0 185##007\nrubbish\n(1.3) can0 185#08\n";
    assert_eq!(received(&mut line, 1, log), ["reading Some(5.0)", "reading Some(8.0)"]);
    assert_eq!(line.figures(&[]).discarded_bytes, 20 + 8);
    assert!(line.last_error().unwrap().starts_with("line 4 of the log is no line of candump"));
    line.closed(Nanos::from_millis(2), "the log bus.log ended".to_owned(), &mut Vec::new());
    assert_eq!(
        line.last_error().unwrap(),
        "the log bus.log ended: 2 frames in 5 lines; 1 times a CAN FD frame, first in line 3; \
         1 times no line of candump, first in line 4"
    );
}

/// The adapter is opened with `L`, and takes frames as any other.
#[test]
fn an_adapter_that_listens_only_is_opened_so() {
    let bit_rate = asphera_slcan::BitRate::from_bits_per_s(500_000).unwrap();
    let first = |listen_only| {
        opened(
            &mut line(Framing::Slcan {
                bit_rate,
                data_bit_rate: None,
                listen_only,
                timestamps: false,
            }),
            0,
            1,
        )
    };
    assert_eq!(first(true)[0], "send \rC\rS6\rZ0\rL\r");
    assert_eq!(first(false)[0], "send \rC\rS6\rZ0\rO\r");
    let mut line = line(Framing::Slcan {
        bit_rate,
        data_bit_rate: None,
        listen_only: true,
        timestamps: false,
    });
    opened(&mut line, 0, 1);
    assert_eq!(received(&mut line, 1, b"\r\r\r\rt185105\r"), ["reading Some(5.0)"]);
    assert!(received(&mut line, 2, b"b1851FF\r").is_empty());
    assert_eq!(line.figures(&[]).discarded_bytes, 8);
    assert!(line.last_error().unwrap().starts_with("the adapter gave a CAN FD frame"));
}

/// Text of another device says that no adapter is there; answers of an adapter say nothing of the devices behind it.
#[test]
fn what_is_no_adapter_says_what_came() {
    let bit_rate = asphera_slcan::BitRate::Kbps500;
    let slcan = || {
        let mut line = line(Framing::Slcan {
            bit_rate,
            data_bit_rate: None,
            listen_only: false,
            timestamps: false,
        });
        opened(&mut line, 0, 1);
        line
    };
    let mut console = slcan();
    received(&mut console, 1, &b"login: hello world\r\n".repeat(20));
    // The line feed at the end may begin something.
    let said = console.with_heard("node 6 did not answer");
    assert_eq!(said, "node 6 did not answer (399 bytes, no telegram: wrong device or baud rate?)");
    let mut adapter = slcan();
    received(&mut adapter, 1, b"\r\r\r\r");
    assert_eq!(adapter.with_heard("node 6 did not answer"), "node 6 did not answer");
}

/// A device that reads CAN FD gets both kinds from each link that carries them; beside it, one that does not gets the classic ones.
#[test]
fn fd_frames_go_to_those_that_read_them() {
    let flags = asphera_link::FdFlags { bit_rate_switch: true, error_passive: false };
    let flexible =
        CanFrame::fd_frame(asphera_link::CanId::Standard(0x185), &[7; 12], flags).unwrap();
    let classic = frame(0x185, &[5]);
    let data_bit_rate = Some(asphera_slcan::DataBitRate::Mbps2);
    let bit_rate = asphera_slcan::BitRate::Kbps500;
    let records = [flexible.to_record(), classic.to_record()].concat();
    for (framing, bytes) in [
        (
            Framing::Slcan { bit_rate, data_bit_rate, listen_only: false, timestamps: false },
            format!("b1859{}\rt185105\r", "07".repeat(12)).into_bytes(),
        ),
        (Framing::CanRecords { timestamps: true }, records.clone()),
        (Framing::CanRecords { timestamps: false }, records),
        (
            Framing::Candump { interface: None },
            format!("(1.0) can0 185##1{}\n(1.1) can0 185#05\n", "07".repeat(12)).into_bytes(),
        ),
    ] {
        assert!(framing.carries_fd());
        let mut both = line_with(framing.clone(), true);
        let first = opened(&mut both, 0, 1);
        if matches!(framing, Framing::Slcan { .. }) {
            assert_eq!(first[0], "send \rC\rS6\rY2\rZ0\rO\r");
        }
        let readings = ["reading Some(7.0)", "reading Some(5.0)"];
        assert_eq!(received(&mut both, 1, &bytes), readings, "{framing:?}");
        let figures = both.figures(&[]);
        assert_eq!(figures.discarded_bytes, 0);
        let clock = match framing {
            Framing::CanRecords { timestamps } => {
                Some(if timestamps { "controller" } else { "kernel" })
            }
            _ => None,
        };
        assert_eq!(figures.clock.as_deref(), clock);
        let mut classic = line_with(framing, false);
        opened(&mut classic, 0, 1);
        assert_eq!(received(&mut classic, 1, &bytes), ["reading Some(5.0)"]);
        assert!(classic.figures(&[]).discarded_bytes > 24);
        assert!(classic.last_error().unwrap().contains("a CAN FD frame: drivers read classic"));
    }
    assert!(!Framing::Socketcand { bus: "can0".to_owned() }.carries_fd());
    assert!(
        !Framing::Slcan { bit_rate, data_bit_rate: None, listen_only: false, timestamps: false }
            .carries_fd()
    );
}

/// Frames of an adapter that stamps them have their own times, in order, none later than its read. One that does not is said, and its frames
/// have the times of their reads.
#[test]
fn stamps_of_an_adapter_are_the_times_of_its_frames() {
    let bit_rate = asphera_slcan::BitRate::Kbps500;
    let framing =
        Framing::Slcan { bit_rate, data_bit_rate: None, listen_only: false, timestamps: true };
    let times = |line: &mut Line, at_ms: u64, bytes: &[u8]| -> Vec<u64> {
        let mut out = Vec::new();
        line.received(Nanos::from_millis(at_ms), bytes, &mut out);
        let time = |effect: &Effect| match effect {
            // In 0.1 ms: the clock of an adapter may drift by less.
            Effect::Reading { reading, .. } => Some(reading.host.as_nanos() / 100_000),
            _ => None,
        };
        out.iter().filter_map(time).collect()
    };
    let mut stamping = line(framing.clone());
    assert_eq!(opened(&mut stamping, 0, 1)[0], "send \rC\rS6\rZ1\rO\r");
    let first = b"\r\x07\r\r\rt1851050000\rt1851050001\rt1851050002\r";
    assert_eq!(times(&mut stamping, 100, first), [1000, 1000, 1000]);
    assert_eq!(stamping.figures(&[]).clock.as_deref(), Some("adapter"));
    // 3 frames wait in a buffer, one of them with a stamp before the frames that were read.
    let late = b"t185105000A\rt185105EA5F\rt1851050014\r";
    assert_eq!(times(&mut stamping, 130, late), [1080, 1080, 1180]);
    assert_eq!(times(&mut stamping, 131, b"t185105\r"), [0; 0]);
    assert_eq!(stamping.figures(&[]).discarded_bytes, 8, "a frame without its stamp is damaged");

    let mut refusing = line(framing);
    opened(&mut refusing, 0, 1);
    let first = b"\x07\x07\r\x07\rt185105\rt185105\rt185105\r";
    assert_eq!(times(&mut refusing, 100, first), [1000, 1000, 1000]);
    assert_eq!(times(&mut refusing, 130, b"t185105\r"), [1300]);
    let figures = refusing.figures(&[]);
    assert_eq!((figures.clock, figures.discarded_bytes), (None, 0));
    assert!(refusing.last_error().unwrap().contains("no time stamps: it refused Z1"));
}

/// A device whose readings are its bytes, but for the last that came: it is half a record.
#[derive(Default)]
struct Halves {
    pending: u64,
    events: Vec<Event>,
}

impl Driver for Halves {
    fn channels(&self) -> &[Channel] {
        &[]
    }

    fn connected(&mut self, _: Nanos) {}

    fn disconnected(&mut self, _: Nanos) {
        let bytes = std::mem::take(&mut self.pending);
        self.events.extend((bytes > 0).then_some(Event::Discarded { bytes }));
    }

    fn receive(&mut self, _: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { panic!("a frame in a file") };
        self.pending = bytes.iter().rev().take_while(|byte| **byte != b'\n').count() as u64;
    }

    fn timeout(&mut self, _: Nanos) {}

    fn poll_timeout(&self) -> Option<Nanos> {
        None
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        None
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, _: Nanos, _: Command) {}
}

/// Half a record at the end of a file is counted, and said with its cure.
#[test]
fn half_a_record_at_the_end_of_a_file_is_said() {
    let device = ("gauge".to_owned(), Box::<Halves>::default() as _);
    let mut line = Line::new("file".to_owned(), Framing::File, vec![device]);
    opened(&mut line, 0, 1);
    received(&mut line, 1, b"1.5\n2.5\n3.");
    line.closed(Nanos::from_millis(2), "a.csv was read to its end".to_owned(), &mut Vec::new());
    assert_eq!(line.figures(&[]).discarded_bytes, 2);
    assert_eq!(
        line.last_error().unwrap(),
        "a.csv was read to its end; its last 2 bytes are no whole record: let the program end its last line, or write whole records"
    );
    opened(&mut line, 10, 2);
    received(&mut line, 11, b"4.5\n");
    line.closed(Nanos::from_millis(12), "the program closed it".to_owned(), &mut Vec::new());
    assert_eq!(line.last_error(), Some("the program closed it"));
}
