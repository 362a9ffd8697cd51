//! A serial adapter of a CAN bus: its lines to frames, each with its time where the adapter stamps it.

use asphera_link::Nanos;
use asphera_slcan::{BitRate, CR, Command, DataBitRate, Decoder, Item, StampClock, Timestamps};

use super::bus::{Piece, unread};

/// A serial adapter on one connection.
pub(super) struct Adapter {
    decoder: Decoder,
    /// Commands and frames that it refused.
    refusals: u64,
    /// Those of an adapter that is in order.
    expected_refusals: u64,
    /// Whether a device of the bus reads CAN FD.
    reads_fd: bool,
    stamps: Stamps,
    /// Words on its stamps that were not said yet.
    words: Option<&'static str>,
}

/// What the adapter does about stamps.
enum Stamps {
    /// It was told to give none.
    Off,
    /// It was told to give them, and its first frames show whether it does: so many have one, and so many have none.
    Asked { with: u8, without: u8, clock: StampClock },
    /// It stamps every frame.
    On(StampClock),
    /// It was asked, and stamps none.
    Refused,
}

/// Bytes that set an adapter up before it is opened. It takes bit rates and stamps only while it is closed, and may have been left open. An
/// empty line ends what it may have half read.
pub(super) fn commands(
    bit_rate: BitRate,
    data_bit_rate: Option<DataBitRate>,
    timestamps: bool,
) -> Vec<u8> {
    let mut bytes = vec![CR];
    let commands = [Command::Close, Command::BitRate(bit_rate)].into_iter();
    let commands = commands
        .chain(data_bit_rate.map(Command::DataBitRate))
        .chain([Command::Timestamps(timestamps)]);
    commands.for_each(|command| command.encode(&mut bytes));
    bytes
}

impl Adapter {
    /// An adapter that was just set up.
    pub(super) fn new(reads_fd: bool, timestamps: bool) -> Adapter {
        let (stamps, expecting) = match timestamps {
            // A line that has a stamp is damaged.
            false => (Stamps::Off, Timestamps::Never),
            true => {
                let clock = StampClock::default();
                (Stamps::Asked { with: 0, without: 0, clock }, Timestamps::Maybe)
            }
        };
        let expected_refusals = EXPECTED_REFUSALS + u64::from(timestamps);
        let decoder = Decoder::expecting(expecting);
        Adapter { decoder, refusals: 0, expected_refusals, reads_fd, stamps, words: None }
    }

    /// Bytes that wait for the end of their line.
    pub(super) fn pending(&self) -> u64 {
        self.decoder.pending()
    }

    /// Whether it stamps its frames; `None` where that is not known yet, or nobody asked.
    pub(super) fn is_stamped(&self) -> Option<bool> {
        match self.stamps {
            Stamps::Off | Stamps::Asked { .. } => None,
            Stamps::On(_) => Some(true),
            Stamps::Refused => Some(false),
        }
    }

    /// Words on its stamps that were not said yet.
    pub(super) fn take_words(&mut self) -> Option<&'static str> {
        self.words.take()
    }

    /// Time of a frame by its stamp, where the adapter is known to stamp its frames.
    fn stamped(&mut self, stamp: Option<u16>, read: Nanos) -> Option<Nanos> {
        match (&mut self.stamps, stamp) {
            (Stamps::On(clock), Some(stamp)) => {
                let stamped = clock.take(stamp, read);
                self.words = self.words.or(stamped.has_jumped.then_some(JUMPED));
                Some(stamped.at)
            }
            (Stamps::Asked { with, without, clock }, Some(stamp)) => {
                clock.take(stamp, read);
                (*with, *without) = (*with + 1, 0);
                if *with == PROOF {
                    self.decoder = Decoder::expecting(Timestamps::Always);
                    self.stamps = Stamps::On(*clock);
                }
                None
            }
            (Stamps::Asked { with, without, .. }, None) => {
                (*with, *without) = (0, *without + 1);
                if *without == PROOF {
                    self.decoder = Decoder::expecting(Timestamps::Never);
                    self.stamps = Stamps::Refused;
                    self.words = Some(REFUSED);
                }
                None
            }
            _ => None,
        }
    }

    /// Content of the next line, read now; outer `None` where no line ends in the input, inner where it says nothing.
    #[expect(clippy::option_option, reason = "outer: no whole line; inner: one that says nothing")]
    pub(super) fn receive(&mut self, now: Nanos, input: &mut &[u8]) -> Option<Option<Piece>> {
        let before = self.decoder.pending() + input.len() as u64;
        let item = self.decoder.decode(input)?;
        // Nothing is pending behind a line.
        let bytes = before - input.len() as u64;
        Some(match item {
            Item::Frame(frame, stamp) => {
                let at = self.stamped(stamp, now);
                match frame.fd().is_some() && !self.reads_fd {
                    true => Some(unread("the adapter", bytes)),
                    false => Some(Piece::Frame(frame, at)),
                }
            }
            Item::Malformed { bytes } => Some(Piece::Discarded { bytes, why: None }),
            Item::Error => {
                self.refusals += 1;
                let words = "the adapter refused a command or a frame";
                (self.refusals > self.expected_refusals).then(|| Piece::Trouble(words.to_owned()))
            }
            Item::Status(status) if !status.is_empty() => {
                Some(Piece::Trouble(format!("the adapter reports {status:?}")))
            }
            Item::Status(_)
            | Item::Ok
            | Item::TransmitAck { .. }
            | Item::Version { .. }
            | Item::SerialNumber(_)
            | Item::Command(_) => None,
        })
    }
}

/// An adapter that is closed already refuses to be closed, and some refuse the empty line before.
const EXPECTED_REFUSALS: u64 = 2;
/// Frames of one kind, one after the other, that show whether an adapter stamps: one of them may be damaged.
const PROOF: u8 = 3;

const REFUSED: &str = "the adapter gives no time stamps: it refused Z1 or does not know it; frames are timed as they are read: set timestamps = false, or update the adapter";
const JUMPED: &str = "the clock of the adapter jumped: check its power and cable";

#[cfg(test)]
mod tests {
    use asphera_link::{CanFrame, CanId};

    use super::*;

    /// All that an adapter says of lines read at this time, ms.
    fn read(adapter: &mut Adapter, at_ms: u64, lines: &[u8]) -> Vec<Piece> {
        let mut input = lines;
        let mut pieces = Vec::new();
        while let Some(piece) = adapter.receive(Nanos::from_millis(at_ms), &mut input) {
            pieces.extend(piece);
            if input.is_empty() {
                break;
            }
        }
        pieces
    }

    fn frame(at_ms: Option<u64>) -> Piece {
        let frame = CanFrame::data_frame(CanId::Standard(0x100), &[0x11, 0x33]);
        Piece::Frame(frame.expect("two bytes"), at_ms.map(Nanos::from_millis))
    }

    /// Commands of EasySYNC ES_000005, section 4.1: close, 500 kbit/s, stamps on.
    #[test]
    fn stamps_are_asked_for_before_the_channel_is_opened() {
        assert_eq!(commands(BitRate::Kbps500, None, true), b"\rC\rS6\rZ1\r");
        assert_eq!(commands(BitRate::Kbps500, None, false), b"\rC\rS6\rZ0\r");
    }

    #[test]
    fn frames_have_the_times_of_their_stamps_once_three_had_one() {
        let mut adapter = Adapter::new(false, true);
        // The answers: a closed channel, then done.
        assert!(read(&mut adapter, 1000, b"\x07\x07\r\r\r").is_empty());
        assert_eq!(adapter.is_stamped(), None);
        let first = b"t100211330000\rt100211330001\rt100211330002\r";
        assert_eq!(read(&mut adapter, 1002, first), [frame(None), frame(None), frame(None)]);
        assert_eq!((adapter.is_stamped(), adapter.take_words()), (Some(true), None));
        // Read 10 ms late, in one piece: the stamps tell the times.
        let late = read(&mut adapter, 1020, b"t10021133000A\rt10021133EA5F\r");
        let [Piece::Frame(_, Some(at)), Piece::Frame(_, Some(before))] = late[..] else {
            panic!("{late:?}")
        };
        assert!(at.since(Nanos::from_millis(1010)).as_micros() < 10, "{at}");
        assert!(before < at, "of stamps out of order each has its own");
    }

    /// A frame without a stamp among frames with one is damaged.
    #[test]
    fn a_missing_stamp_is_counted_as_damage() {
        let mut adapter = Adapter::new(false, true);
        read(&mut adapter, 1000, b"t100211330000\rt100211330000\rt100211330000\r");
        let pieces = read(&mut adapter, 1001, b"t10021133\rt100211330001\r");
        let damaged = Piece::Discarded { bytes: 10, why: None };
        assert_eq!(pieces, [damaged, frame(Some(1001))]);
    }

    /// An adapter that answers BEL to `Z1` goes on without stamps, and that is said.
    #[test]
    fn a_refusal_is_said_and_frames_come_all_the_same() {
        let mut adapter = Adapter::new(false, true);
        assert!(read(&mut adapter, 1000, b"\x07\x07\r\x07\r").is_empty());
        let pieces = read(&mut adapter, 1000, b"t10021133\rt10021133\rt10021133\r");
        assert_eq!(pieces, [frame(None), frame(None), frame(None)]);
        assert_eq!(adapter.is_stamped(), Some(false));
        assert!(adapter.take_words().is_some_and(|words| words.contains("Z1")));
        // One that was not asked gives none, and a line that has one is damaged.
        let pieces = read(&mut Adapter::new(false, false), 1000, b"t100211330000\r");
        assert_eq!(pieces, [Piece::Discarded { bytes: 14, why: None }]);
    }

    #[test]
    fn a_jump_is_said() {
        let mut adapter = Adapter::new(false, true);
        read(&mut adapter, 1000, b"t100211330000\rt100211330000\rt100211330000\r");
        assert_eq!(read(&mut adapter, 1010, b"t100211337530\r"), [frame(Some(1010))]);
        assert!(adapter.take_words().is_some_and(|words| words.contains("jumped")));
    }
}
