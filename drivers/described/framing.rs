//! Frames of a stream of bytes.

use crate::checksum::Checksum;

/// How frames are told apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Framing {
    /// Frames of any length with bytes at their end.
    Lines {
        /// Bytes with which each begins; may be none.
        begin: Vec<u8>,
        /// Bytes with which each ends.
        end: End,
        /// Most bytes of a frame without its end, 1 to 65536. After more without an end nothing is believed until
        /// the next end.
        longest: usize,
    },
    /// Frames of one length.
    Records {
        /// Bytes with which each begins; may be none.
        begin: Vec<u8>,
        /// Bytes of a record, its beginning and its check among them: 1 to 65536.
        length: usize,
    },
}

/// Bytes with which a line ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// CR, LF, or both. Empty lines are none.
    Any,
    /// These bytes.
    Bytes(Vec<u8>),
}

impl Framing {
    /// Bytes with which each frame begins.
    pub fn begin(&self) -> &[u8] {
        match self {
            Framing::Lines { begin, .. } | Framing::Records { begin, .. } => begin,
        }
    }
}

/// Cuts received bytes into frames.
///
/// A frame has its beginning and its check, but not its end. Bytes of no frame are counted.
#[derive(Debug)]
pub(crate) struct Splitter {
    framing: Framing,
    checksum: Option<Checksum>,
    /// Records that nothing guards are believed once the next one begins behind them.
    confirm: bool,
    stream: Stream,
}

/// Bytes that are not yet a frame.
#[derive(Debug, Default)]
struct Stream {
    bytes: Vec<u8>,
    /// First byte that was not taken.
    start: usize,
    /// Whether a line begins there.
    aligned: bool,
    discarded: u64,
    /// All bytes passed over, ever.
    passed_over: u64,
}

impl Splitter {
    /// `asked`: each frame answers a question, so that bytes before the question are none of it.
    pub(crate) fn new(framing: Framing, checksum: Option<Checksum>, asked: bool) -> Splitter {
        let confirm = checksum.is_none() && !asked;
        Splitter { framing, checksum, confirm, stream: Stream::default() }
    }

    pub(crate) fn push(&mut self, bytes: &[u8]) {
        let stream = &mut self.stream;
        stream.bytes.drain(..stream.start);
        stream.start = 0;
        stream.bytes.extend_from_slice(bytes);
    }

    /// Drops what came so far: a frame begins with the next byte if `aligned`, else nobody knows where.
    pub(crate) fn clear(&mut self, aligned: bool) {
        if matches!(self.framing, Framing::Lines { end: End::Any, .. }) {
            // The LF of a CR LF whose line was taken already.
            self.stream.skip_ends();
        }
        self.stream.drop_all(aligned);
    }

    /// Whether bytes wait for more.
    pub(crate) fn is_waiting(&self) -> bool {
        !self.stream.rest().is_empty()
    }

    /// Bytes passed over since the last call.
    pub(crate) fn take_discarded(&mut self) -> u64 {
        std::mem::take(&mut self.stream.discarded)
    }

    /// A frame that turned out to be no reading.
    pub(crate) fn pass_over(&mut self, frame: &[u8]) {
        self.stream.count(frame.len());
    }

    /// All bytes passed over so far.
    pub(crate) fn passed_over(&self) -> u64 {
        self.stream.passed_over
    }

    /// The next whole frame.
    pub(crate) fn next(&mut self) -> Option<Vec<u8>> {
        match &self.framing {
            Framing::Lines { begin, end, longest } => self.stream.line(begin, end, *longest),
            Framing::Records { begin, length } => {
                self.stream.record(begin, *length, self.checksum, self.confirm)
            }
        }
    }

    /// The line was silent for so long that the bytes that wait are all there are. A record that nothing guards is
    /// whole if it is as long as a record: one that lost a byte would be shorter.
    pub(crate) fn silence(&mut self) -> Option<Vec<u8>> {
        let Framing::Records { begin, length } = &self.framing else { return None };
        let rest = self.stream.rest();
        if self.confirm && rest.len() == *length && rest.starts_with(begin) {
            return Some(self.stream.take(*length));
        }
        self.stream.drop_all(true);
        None
    }
}

impl Stream {
    fn rest(&self) -> &[u8] {
        &self.bytes[self.start..]
    }

    fn take(&mut self, len: usize) -> Vec<u8> {
        let taken = self.rest()[..len].to_vec();
        self.start += len;
        taken
    }

    fn skip(&mut self, len: usize) {
        self.start += len;
        self.count(len);
    }

    fn count(&mut self, len: usize) {
        self.discarded += len as u64;
        self.passed_over += len as u64;
    }

    /// Passes over ends of lines; they are part of no frame and none is lost with them.
    fn skip_ends(&mut self) {
        let ends = self.rest().iter().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        self.start += ends;
    }

    fn drop_all(&mut self, aligned: bool) {
        self.skip(self.rest().len());
        self.aligned = aligned;
    }

    fn line(&mut self, begin: &[u8], end: &End, longest: usize) -> Option<Vec<u8>> {
        loop {
            let rest = self.rest();
            let (at, width) = match end {
                End::Any => (rest.iter().position(|byte| matches!(byte, b'\r' | b'\n')), 1),
                End::Bytes(end) => (find(rest, end), end.len()),
            };
            let Some(at) = at else {
                if rest.len() > longest + width {
                    // A beginning or an end may be half there.
                    let half = begin.len().max(width) - 1;
                    let begun = if begin.is_empty() { None } else { rfind(rest, begin) };
                    let begun = begun.filter(|from| rest.len() - from <= longest + width);
                    self.skip(begun.unwrap_or(rest.len() - half));
                    self.aligned = false;
                }
                return None;
            };
            // The last beginning: what stands before it lost its end.
            let from = if begin.is_empty() {
                self.aligned.then_some(0)
            } else {
                rfind(&rest[..at], begin)
            };
            self.aligned = true;
            match from.filter(|from| at > *from && at - from <= longest) {
                Some(from) => {
                    self.skip(from);
                    let line = self.take(at - from);
                    self.start += width;
                    return Some(line);
                }
                None if at == 0 => self.start += width,
                // Without an end before it, it may be the second half of a line.
                None => self.skip(at + width),
            }
        }
    }

    fn record(
        &mut self,
        begin: &[u8],
        length: usize,
        checksum: Option<Checksum>,
        confirm: bool,
    ) -> Option<Vec<u8>> {
        loop {
            let rest = self.rest();
            if begins(rest, begin) {
                let (record, next) = rest.split_at_checked(length)?;
                let is_whole = checksum.is_none_or(|check| check.body(record).is_some());
                if is_whole && (!confirm || next.starts_with(begin)) {
                    return Some(self.take(length));
                }
                if is_whole && begins(next, begin) {
                    // Half of the next beginning proves nothing.
                    return None;
                }
            }
            self.skip(1);
        }
    }
}

/// Whether bytes begin so, as far as they go.
fn begins(bytes: &[u8], begin: &[u8]) -> bool {
    let len = begin.len().min(bytes.len());
    bytes[..len] == begin[..len]
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len().max(1)).position(|window| window == wanted)
}

fn rfind(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len().max(1)).rposition(|window| window == wanted)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::checksum::{Algorithm, Digits};
    use crate::number::ByteOrder;

    fn lines(begin: &[u8], end: End) -> Splitter {
        Splitter::new(Framing::Lines { begin: begin.to_vec(), end, longest: 16 }, None, false)
    }

    fn all(splitter: &mut Splitter) -> Vec<Vec<u8>> {
        std::iter::from_fn(|| splitter.next()).collect()
    }

    #[test]
    fn a_line_is_believed_after_the_first_end() {
        let mut splitter = lines(b"", End::Any);
        splitter.push(b"345\r\n1.25\r\n\n2.5\n3");
        assert_eq!(all(&mut splitter), [b"1.25".to_vec(), b"2.5".to_vec()]);
        assert_eq!(splitter.take_discarded(), 4, "345 and its CR");
        splitter.clear(true);
        splitter.push(b"7\r");
        assert_eq!(all(&mut splitter), [b"7".to_vec()]);
    }

    #[test]
    fn the_second_sign_of_an_end_is_no_lost_byte() {
        let mut splitter = lines(b"", End::Any);
        splitter.clear(true);
        splitter.push(b"1.5\r\n");
        assert_eq!(splitter.next(), Some(b"1.5".to_vec()));
        splitter.clear(false);
        assert_eq!(splitter.take_discarded(), 0);
        splitter.push(b"\n2\n");
        splitter.clear(false);
        assert_eq!(splitter.take_discarded(), 2, "a line nobody waited for is lost");
    }

    #[test]
    fn a_line_with_a_beginning_needs_no_end_before_it() {
        let mut splitter = lines(b"\x02", End::Bytes(vec![3]));
        splitter.push(b"9\x025\x03\x026\x02\x027\x03noise\x03");
        assert_eq!(all(&mut splitter), [b"\x025".to_vec(), b"\x027".to_vec()]);
        assert_eq!(splitter.take_discarded(), 1 + 3 + 6);
    }

    #[test]
    fn a_line_without_an_end_is_given_up() {
        let mut splitter = lines(b"", End::Bytes(b"\r\n".to_vec()));
        splitter.clear(true);
        splitter.push(&[b'1'; 19]);
        assert_eq!(
            (splitter.next(), splitter.take_discarded()),
            (None, 18),
            "the last may be half an end"
        );
        splitter.push(b"11\r\n2\r\n");
        assert_eq!(all(&mut splitter), [b"2".to_vec()], "the end of the long one is no line");
        assert_eq!(splitter.take_discarded(), 5);
    }

    #[test]
    fn a_line_that_begins_in_a_flood_is_read() {
        for cut in 0..40 {
            let mut splitter = lines(b"$$", End::Bytes(b"\r\n".to_vec()));
            let bytes = [&[b'7'; 25][..], b"$$12.5\r\n"].concat();
            let (first, second) = bytes.split_at(cut.min(bytes.len()));
            let mut found = Vec::new();
            for part in [first, second] {
                splitter.push(part);
                found.extend(std::iter::from_fn(|| splitter.next()));
            }
            assert_eq!((found, splitter.take_discarded()), (vec![b"$$12.5".to_vec()], 25), "{cut}");
        }
    }

    fn records(begin: &[u8], checksum: Option<Checksum>) -> Splitter {
        Splitter::new(Framing::Records { begin: begin.to_vec(), length: 4 }, checksum, false)
    }

    const SUM: Checksum = Checksum {
        algorithm: Algorithm::Sum8,
        digits: Digits::Binary(ByteOrder::Big),
        skip_first: 0,
        skip_last: 0,
    };

    #[test]
    fn a_record_that_nothing_guards_waits_for_the_next() {
        let mut splitter = records(&[0xAA, 0x55], None);
        splitter.push(&[0x55, 0xAA, 0x55, 1, 2]);
        assert_eq!((splitter.next(), splitter.is_waiting()), (None, true));
        assert_eq!(splitter.take_discarded(), 1);
        splitter.push(&[0xAA]);
        assert_eq!(splitter.next(), None, "half a beginning proves nothing");
        splitter.push(&[0x55, 3]);
        assert_eq!(splitter.next(), Some(vec![0xAA, 0x55, 1, 2]));
        // A byte is lost: the record and what follows it are no longer in step.
        splitter.push(&[0xAA, 0x55, 5, 6, 0xAA, 0x55, 7, 8]);
        assert_eq!(splitter.next(), Some(vec![0xAA, 0x55, 5, 6]));
        assert_eq!(splitter.next(), None);
        assert_eq!(splitter.take_discarded(), 3);
        assert_eq!(splitter.silence(), Some(vec![0xAA, 0x55, 7, 8]));
        splitter.push(&[0xAA, 0x55, 5]);
        assert_eq!((splitter.silence(), splitter.take_discarded()), (None, 3));
    }

    #[test]
    fn a_check_finds_records_again() {
        let mut splitter = records(&[], Some(SUM));
        splitter.push(&[9, 1, 2, 3, 6, 4, 5, 6, 15, 1]);
        assert_eq!(all(&mut splitter), [vec![1, 2, 3, 6], vec![4, 5, 6, 15]]);
        assert_eq!(splitter.take_discarded(), 1);
    }

    proptest! {
        /// Chunks do not matter, and every byte is in a frame, counted, waiting or an end.
        #[test]
        fn chunks_change_nothing(
            bytes in proptest::collection::vec(prop_oneof![Just(0xAAu8), Just(0x55), 0u8..4, Just(b'\r'), Just(b'\n')], 0..200),
            cuts in proptest::collection::vec(0usize..200, 0..8),
            guarded: bool,
            begin: bool,
        ) {
            let begin = if begin { vec![0xAA] } else { Vec::new() };
            let record = Framing::Records { begin: begin.clone(), length: 4 };
            let line = Framing::Lines { begin, end: End::Any, longest: 16 };
            for framing in [record, line] {
                let checksum = guarded.then_some(SUM);
                let run = |cuts: &[usize]| {
                    let mut splitter = Splitter::new(framing.clone(), checksum, false);
                    let (mut from, mut frames) = (0, Vec::new());
                    for to in cuts.iter().copied().chain([bytes.len()]) {
                        let to = to.clamp(from, bytes.len());
                        splitter.push(&bytes[from..to]);
                        frames.extend(std::iter::from_fn(|| splitter.next()));
                        from = to;
                    }
                    let waiting = splitter.stream.rest().len();
                    (frames, splitter.take_discarded(), waiting)
                };
                let mut cuts = cuts.clone();
                cuts.sort_unstable();
                let (frames, discarded, waiting) = run(&[]);
                let chunked = run(&cuts);
                if matches!(framing, Framing::Records { .. }) {
                    let framed: usize = frames.iter().map(Vec::len).sum();
                    prop_assert_eq!(framed + discarded as usize + waiting, bytes.len());
                    prop_assert_eq!((&frames, discarded, waiting), (&chunked.0, chunked.1, chunked.2));
                } else {
                    // Where a line without an end is given up depends on how much of it came at once; what is
                    // believed after it does not.
                    prop_assert_eq!(&frames, &chunked.0);
                }
            }
        }
    }
}
