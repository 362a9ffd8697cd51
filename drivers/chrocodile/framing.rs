//! Finds telegrams and echoes in the stream of one connection.
//!
//! The protocol has no checksum and its sync bytes may stand in any value, so a telegram is released
//! only when what follows confirms it:
//!
//! ```text
//! FF FF c c … │ FF FF c' c' …      the next sync stands where it is due, and its exposure count
//!  telegram   │ next               c' follows c; without a count, the sync after that as well
//! FF FF c c … │ $ S T O            the echo of the command that was sent
//! FF FF c c … │ silence            nothing more for as long as the settings say
//! ```
//!
//! Released as suspect are telegrams that look like one but may consist of the parts of two with lost
//! bytes between them: before a jump of the count, around a silence, and, where other signals stand
//! before the count, the first one after the frame was lost; further those whose count does not
//! continue that of the last telegram within what the device can have exposed meanwhile.

use std::collections::VecDeque;
use std::ops::Range;

use asphera_link::Nanos;

use crate::wire::{Layout, Quantity, split_answer};

/// Longest text of an answer. `SCA ?` needs a dozen bytes; the rest is for messages.
const MAX_ANSWER_LEN: usize = 4096;

/// How far beyond the averaging the count may step between neighbouring telegrams when the frame is
/// sought: a device that sends less often than it exposes is still found.
const COUNT_SLACK: u16 = 15;

/// Telegrams that have to follow where a new frame does not continue the count of the old.
const CHAIN: usize = 4;

/// The bytes received and not yet understood.
#[derive(Debug)]
pub(crate) struct Framing {
    telegram_len: usize,
    sync: [u8; 2],
    count_offset: Option<usize>,
    averaging: u16,
    rate_hz: f64,
    buffer: Vec<u8>,
    /// Start of what is not yet understood, in `buffer`.
    head: usize,
    /// Bytes of the connection before `buffer`.
    base: u64,
    /// For each receipt that still has bytes at or after `head`: its end in the connection, its time.
    arrivals: VecDeque<(u64, Nanos)>,
    lock: Lock,
    /// How far the count stepped between the last two telegrams of an unbroken frame.
    usual_step: Option<u16>,
    /// Count and arrival of the last telegram released.
    last: Option<(u16, Nanos)>,
    /// Where a silence interrupted a telegram.
    interruption: Option<u64>,
    /// A silence ended the burst: what is buffered are whole telegrams.
    complete: bool,
    discarded: u64,
}

/// How much is known about where telegrams start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lock {
    /// One starts at `head`: a telegram ended there.
    Certain,
    /// One should start at `head`: the stream starts there, or a silence came before.
    Likely,
    /// Nothing.
    Lost,
}

/// What stands next in the stream.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// A confirmed telegram.
    Telegram {
        /// Its bytes, for [`Framing::bytes`] until the next receipt.
        at: Range<usize>,
        /// When its last byte was received.
        arrival: Nanos,
        /// Whether it may consist of parts of several telegrams, or be none at all.
        suspect: bool,
    },
    /// The whole echo that was asked for; it is passed.
    Echo,
    /// Nothing that could be told without more bytes.
    Nothing,
}

/// An answer that does not end.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct AnswerTooLong;

/// What the bytes at some place prove.
enum Proof {
    Confirmed { step: Option<u16>, suspect: bool },
    Refuted,
    Pending,
}

/// What stands behind a telegram.
#[derive(PartialEq, Eq)]
enum Follower {
    Sync,
    Echo,
    Other,
    Pending,
}

impl Framing {
    /// For telegrams of this layout, from exposures at no more than `rate_hz`, of which each
    /// telegram averages `averaging`.
    pub(crate) fn new(layout: &Layout, averaging: u16, rate_hz: f64) -> Framing {
        Framing {
            telegram_len: layout.telegram_len(),
            sync: layout.sync(),
            count_offset: layout.offset_of(Quantity::ExposureCount),
            averaging,
            rate_hz,
            buffer: Vec::new(),
            head: 0,
            base: 0,
            arrivals: VecDeque::new(),
            lock: Lock::Likely,
            usual_step: None,
            last: None,
            interruption: None,
            complete: false,
            discarded: 0,
        }
    }

    /// Forgets everything: a new connection.
    pub(crate) fn reset(&mut self) {
        self.buffer.clear();
        self.head = 0;
        self.base = 0;
        self.arrivals.clear();
        self.discarded = 0;
        self.begin();
    }

    /// Nothing more comes: what was not released yet never will be.
    pub(crate) fn abandon(&mut self) {
        self.discarded += (self.buffer.len() - self.head) as u64;
        self.head = self.buffer.len();
    }

    /// Telegrams start here.
    pub(crate) fn begin(&mut self) {
        self.lock = Lock::Likely;
        self.usual_step = None;
        self.last = None;
        self.interruption = None;
        self.complete = false;
    }

    /// Appends what was received. Amortized linear.
    pub(crate) fn receive(&mut self, now: Nanos, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        self.buffer.drain(..self.head);
        self.base += self.head as u64;
        self.head = 0;
        self.buffer.extend_from_slice(bytes);
        self.arrivals.push_back((self.base + self.buffer.len() as u64, now));
    }

    /// Whether bytes wait for more.
    pub(crate) fn is_waiting(&self) -> bool {
        self.head < self.buffer.len()
    }

    /// The bytes of a telegram just found.
    pub(crate) fn bytes(&self, at: Range<usize>) -> &[u8] {
        &self.buffer[at]
    }

    /// How many bytes were passed over since the last call.
    pub(crate) fn take_discarded(&mut self) -> u64 {
        std::mem::take(&mut self.discarded)
    }

    /// Passes over everything received.
    pub(crate) fn discard_all(&mut self) {
        self.discard(self.buffer.len() - self.head);
    }

    /// Nothing was received for the time of a silence: [`Framing::next`] may now release what no
    /// further bytes confirm.
    pub(crate) fn silence(&mut self) {
        let waiting = &self.buffer[self.head..];
        let is_whole = waiting.len().is_multiple_of(self.telegram_len)
            && waiting.chunks(self.telegram_len).all(|telegram| telegram.starts_with(&self.sync));
        match self.lock {
            Lock::Lost => {
                self.discard_all();
                self.lock = Lock::Likely;
            }
            Lock::Certain | Lock::Likely if is_whole => self.complete = true,
            Lock::Certain | Lock::Likely => {
                self.interruption = Some(self.base + self.buffer.len() as u64);
            }
        }
    }

    /// The next telegram, or the echo that was asked for.
    pub(crate) fn next(&mut self, echo: Option<&[u8]>) -> Found {
        if self.complete && self.is_waiting() {
            let step = self.count_step(self.head);
            let suspect = step.is_some_and(|step| !self.is_usual(step));
            return self.release(step, suspect);
        }
        if std::mem::take(&mut self.complete) {
            // The next burst starts with a telegram, however this one ended.
            self.lock = Lock::Likely;
        }
        while self.is_waiting() {
            if let Some(echo) = echo {
                let rest = &self.buffer[self.head..];
                if rest.starts_with(echo) {
                    self.advance(echo.len());
                    // An echo stands between telegrams, whatever came before.
                    self.lock = if self.lock == Lock::Lost { Lock::Likely } else { self.lock };
                    return Found::Echo;
                }
                if echo.starts_with(rest) {
                    return Found::Nothing;
                }
            }
            match self.proof_here(echo) {
                Proof::Confirmed { step, suspect } => return self.release(step, suspect),
                Proof::Pending if !echo.is_some_and(|echo| self.is_answered(echo)) => {
                    return Found::Nothing;
                }
                Proof::Pending | Proof::Refuted => {
                    self.lock = Lock::Lost;
                    self.discard(1);
                }
            }
        }
        Found::Nothing
    }

    /// Passes over everything up to and including `echo`, which need not stand between telegrams.
    /// False while it has not come.
    pub(crate) fn skip_to_echo(&mut self, echo: &[u8]) -> bool {
        let waiting = &self.buffer[self.head..];
        if let Some(skipped) = waiting.windows(echo.len()).position(|window| window == echo) {
            self.discard(skipped);
            self.advance(echo.len());
            return true;
        }
        let kept = (0..echo.len()).rev().find(|&kept| waiting.ends_with(&echo[..kept]));
        self.discard(waiting.len() - kept.unwrap_or(0));
        false
    }

    /// The text of the answer that starts here, once it is complete.
    pub(crate) fn take_answer(&mut self) -> Option<Result<String, AnswerTooLong>> {
        match split_answer(&self.buffer[self.head..]) {
            Some((text, len)) => {
                self.advance(len);
                Some(Ok(text))
            }
            None if self.buffer.len() - self.head > MAX_ANSWER_LEN => Some(Err(AnswerTooLong)),
            None => None,
        }
    }

    fn release(&mut self, step: Option<u16>, suspect: bool) -> Found {
        let at = self.head..self.head + self.telegram_len;
        let (start, end) = (self.base + at.start as u64, self.base + at.end as u64);
        let is_interrupted = self.interruption.is_some_and(|place| start < place && place < end);
        let arrival = self.arrival_of(at.end);
        let is_ahead = self.last.is_none() || self.ahead(at.start).is_some();
        // What stands before the count might be the rest of something else.
        let is_cut = self.lock == Lock::Lost && self.count_offset != Some(self.sync.len());
        // Behind a jump of the count the frame has to be found anew: it may have shifted as well.
        let is_unbroken = step.is_none_or(|step| self.is_usual(step));
        self.lock = if is_unbroken { Lock::Certain } else { Lock::Lost };
        self.usual_step = step.or(self.usual_step);
        self.last = self.count_at(at.start).map(|count| (count, arrival));
        self.advance(self.telegram_len);
        let suspect = suspect || is_interrupted || !is_ahead || is_cut;
        Found::Telegram { at, arrival, suspect }
    }

    fn discard(&mut self, len: usize) {
        self.discarded += len as u64;
        self.advance(len);
    }

    fn advance(&mut self, len: usize) {
        self.head += len;
        let head = self.base + self.head as u64;
        while self.arrivals.front().is_some_and(|&(end, _)| end <= head) {
            self.arrivals.pop_front();
        }
        if self.interruption.is_some_and(|place| place <= head) {
            self.interruption = None;
        }
    }

    /// Whether a telegram starts at `head` and, where the frame is lost, at no other place near it:
    /// a value that holds the sync before another that counts looks like a frame, too.
    ///
    /// A place whose count continues that of the last telegram released is taken, unless another
    /// continues it better. One that does not has to be followed by [`CHAIN`] telegrams without any
    /// other place in sight.
    fn proof_here(&self, echo: Option<&[u8]>) -> Proof {
        let proof = self.proof(self.head, echo);
        if self.lock != Lock::Lost || !matches!(proof, Proof::Confirmed { .. }) {
            return proof;
        }
        let own = self.ahead(self.head);
        let last = if own.is_some() { self.head } else { self.head + CHAIN * self.telegram_len };
        for place in (self.head..=last).step_by(self.telegram_len) {
            match self.proof(place, echo) {
                Proof::Confirmed { .. } => {}
                undecided => return undecided,
            }
            for rival in place + 1..place + self.telegram_len {
                match (self.proof(rival, echo), own, self.ahead(rival)) {
                    (Proof::Refuted, _, _) => {}
                    (Proof::Pending, _, _) => return Proof::Pending,
                    (Proof::Confirmed { .. }, Some(_), None) => {}
                    (Proof::Confirmed { .. }, Some(own), Some(rival)) if own < rival => {}
                    (Proof::Confirmed { .. }, _, _) => return Proof::Refuted,
                }
            }
        }
        proof
    }

    /// How far the count of the telegram at `place` is ahead of the last one released, where that is
    /// no further than the device can have exposed since.
    fn ahead(&self, place: usize) -> Option<u16> {
        let (last_count, last_arrival) = self.last?;
        let ahead = self.count_at(place)?.wrapping_sub(last_count);
        let elapsed_s =
            self.arrival_of(place + self.telegram_len).since(last_arrival).as_secs_f64();
        let most =
            f64::from(self.averaging) + f64::from(COUNT_SLACK) + 2.0 * self.rate_hz * elapsed_s;
        (ahead > 0 && f64::from(ahead) <= most).then_some(ahead)
    }

    /// When the byte before `place` was received.
    fn arrival_of(&self, place: usize) -> Nanos {
        let end = self.base + place as u64;
        let receipt = self.arrivals.iter().find(|&&(receipt_end, _)| receipt_end >= end);
        receipt.or(self.arrivals.back()).map_or(Nanos::ZERO, |&(_, time)| time)
    }

    /// Whether the whole answer to a command has come: nothing before it is going to be completed.
    fn is_answered(&self, echo: &[u8]) -> bool {
        let waiting = &self.buffer[self.head..];
        waiting
            .windows(echo.len())
            .position(|window| window == echo)
            .is_some_and(|place| split_answer(&waiting[place + echo.len()..]).is_some())
    }

    /// Whether a telegram starts at `head` of the buffer, as far as the bytes received tell.
    fn proof(&self, head: usize, echo: Option<&[u8]>) -> Proof {
        match self.follower(head, None) {
            Follower::Sync => {}
            Follower::Pending => return Proof::Pending,
            Follower::Echo | Follower::Other => return Proof::Refuted,
        }
        let next = head + self.telegram_len;
        match self.follower(next, echo) {
            Follower::Sync => {}
            Follower::Echo => return Proof::Confirmed { step: None, suspect: false },
            Follower::Pending => return Proof::Pending,
            Follower::Other => return Proof::Refuted,
        }
        if self.count_offset.is_none() {
            return match self.follower(next + self.telegram_len, echo) {
                Follower::Sync | Follower::Echo => Proof::Confirmed { step: None, suspect: false },
                Follower::Pending => Proof::Pending,
                Follower::Other => Proof::Refuted,
            };
        }
        let Some(step) = self.count_step(head) else { return Proof::Pending };
        let confirmed = Proof::Confirmed { step: Some(step), suspect: !self.is_usual(step) };
        if self.is_near(step) {
            return confirmed;
        }
        if self.lock != Lock::Certain {
            return Proof::Refuted;
        }
        // The count jumped. If the frame goes on behind the jump, this telegram was in it.
        match self.follower(next + self.telegram_len, echo) {
            Follower::Echo => confirmed,
            Follower::Pending => Proof::Pending,
            Follower::Other => Proof::Refuted,
            Follower::Sync => match self.count_step(next) {
                None => Proof::Pending,
                Some(step_after) if self.is_near(step_after) => confirmed,
                Some(_) => Proof::Refuted,
            },
        }
    }

    fn follower(&self, place: usize, echo: Option<&[u8]>) -> Follower {
        let rest = self.buffer.get(place..).unwrap_or_default();
        if rest.starts_with(&self.sync) {
            Follower::Sync
        } else if self.sync.starts_with(rest) {
            Follower::Pending
        } else {
            match echo {
                Some(echo) if rest.starts_with(echo) => Follower::Echo,
                Some(echo) if echo.starts_with(rest) => Follower::Pending,
                _ => Follower::Other,
            }
        }
    }

    /// From the count of the telegram at `place` to that of the next one.
    fn count_step(&self, place: usize) -> Option<u16> {
        Some(self.count_at(place + self.telegram_len)?.wrapping_sub(self.count_at(place)?))
    }

    /// The count of the telegram at `place`, as far as it was received.
    fn count_at(&self, place: usize) -> Option<u16> {
        let place = place + self.count_offset?;
        let bytes = self.buffer.get(place..place + 2)?;
        Some(u16::from_be_bytes([bytes[0], bytes[1]]))
    }

    /// Whether a step of the count is what two neighbouring telegrams have.
    fn is_usual(&self, step: u16) -> bool {
        (1..=self.averaging).contains(&step) || self.usual_step == Some(step)
    }

    /// Whether a step of the count is small enough to find the frame by.
    fn is_near(&self, step: u16) -> bool {
        (1..=self.averaging.saturating_add(COUNT_SLACK)).contains(&step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::SYNC;

    const NOW: Nanos = Nanos::from_millis(1);

    fn framing() -> Framing {
        Framing::new(&Layout::new(SYNC, &[75, 256]).unwrap(), 1, 1000.0)
    }

    /// A telegram of 8 bytes: sync, count, and four bytes of a float.
    fn telegram(count: u16, rest: [u8; 4]) -> Vec<u8> {
        [&SYNC[..], &count.to_be_bytes(), &rest].concat()
    }

    fn drain(framing: &mut Framing, echo: Option<&[u8]>) -> Vec<(u16, bool)> {
        let mut found = Vec::new();
        while let Found::Telegram { at, suspect, .. } = framing.next(echo) {
            let bytes = framing.bytes(at);
            found.push((u16::from_be_bytes([bytes[2], bytes[3]]), suspect));
        }
        found
    }

    #[test]
    fn a_telegram_waits_for_the_count_of_the_next() {
        let mut framing = framing();
        framing.receive(NOW, &telegram(7, [1; 4]));
        assert_eq!(drain(&mut framing, None), []);
        let later = Nanos::from_millis(2);
        framing.receive(later, &telegram(8, [2; 4])[..4]);
        assert!(
            matches!(framing.next(None), Found::Telegram { at, arrival: NOW, suspect: false } if at == (0..8))
        );
        assert_eq!(framing.take_discarded(), 0);
    }

    #[test]
    fn a_silence_releases_whole_telegrams_only() {
        let mut framing = framing();
        framing.receive(NOW, &telegram(7, [1; 4])[..5]);
        framing.silence();
        assert_eq!(drain(&mut framing, None), []);
        framing.receive(NOW, &telegram(7, [1; 4])[5..]);
        framing.silence();
        assert_eq!(drain(&mut framing, None), [(7, true)], "interrupted");
        framing.receive(NOW, &telegram(8, [1; 4]));
        framing.silence();
        assert_eq!(drain(&mut framing, None), [(8, false)]);
    }

    #[test]
    fn halves_of_two_telegrams_are_suspect() {
        // The end of 7 and all of 8 to 11 were lost with the start of 12: the frame looks whole.
        let mut framing = framing();
        let stream = [
            telegram(5, [0; 4]),
            telegram(6, [0; 4]),
            telegram(7, [0, 0, 9, 9]),
            telegram(13, [9; 4]),
            telegram(14, [9; 4]),
            telegram(15, [9; 4]),
        ];
        framing.receive(NOW, &stream.concat());
        let found = drain(&mut framing, None);
        assert_eq!(found, [(5, false), (6, false), (7, true), (13, false), (14, false)]);
    }

    /// Telegrams that hold the sync and a second counter at the same place: two frames fit.
    fn ambiguous(counts: Range<u16>) -> Vec<u8> {
        counts.flat_map(|count| telegram(count, [0xFF, 0xFF, 3, count as u8])).collect()
    }

    #[test]
    fn of_two_frames_the_one_that_continues_the_count_is_taken() {
        let mut framing = framing();
        framing.receive(NOW, &ambiguous(0..20));
        assert_eq!(drain(&mut framing, None).len(), 19);
        // Six bytes are lost: the stream goes on at the second counter of telegram 20.
        framing.receive(NOW, &ambiguous(20..40)[4..]);
        framing.receive(NOW, &ambiguous(40..42));
        let found: Vec<u16> =
            drain(&mut framing, None).into_iter().map(|(count, _)| count).collect();
        assert_eq!(found, (19..20).chain(21..41).collect::<Vec<_>>());
    }

    #[test]
    fn of_two_frames_none_is_taken_without_a_count_to_continue() {
        let mut framing = framing();
        framing.receive(NOW, &[&[7][..], &ambiguous(0..20)].concat());
        assert_eq!(drain(&mut framing, None), []);
    }

    #[test]
    fn a_truncated_telegram_does_not_hide_an_answer() {
        let mut framing = Framing::new(&Layout::new(SYNC, &[75; 20]).unwrap(), 1, 1000.0);
        framing.receive(NOW, b"\xFF\xFF\x00\x01$STO\rready\r\n");
        assert_eq!(framing.next(Some(b"$STO")), Found::Echo);
        assert_eq!(framing.take_answer(), Some(Ok(String::new())));
        assert_eq!(framing.take_discarded(), 4);
    }

    #[test]
    fn an_echo_confirms_and_interrupts_nothing() {
        let mut framing = framing();
        let stream =
            [telegram(1, [0; 4]), b"$STO\rready\r\n".to_vec(), telegram(2, [0; 4])].concat();
        for byte in stream {
            framing.receive(NOW, &[byte]);
            match framing.next(Some(b"$STO")) {
                Found::Nothing => {}
                Found::Telegram { at, .. } => assert_eq!(framing.bytes(at)[3], 1),
                Found::Echo => break,
            }
        }
        assert_eq!(framing.take_discarded(), 0);
        assert_eq!(framing.take_answer(), None);
    }

    #[test]
    fn echo_is_found_in_noise_and_across_receipts() {
        let mut framing = framing();
        framing.receive(NOW, b"\xFF\xFF$ST$S");
        assert!(!framing.skip_to_echo(b"$STO"));
        framing.receive(NOW, b"TO\r");
        assert!(framing.skip_to_echo(b"$STO"));
        assert_eq!(framing.take_discarded(), 5);
    }

    #[test]
    fn an_endless_answer_is_an_error() {
        let mut framing = framing();
        framing.receive(NOW, &[b'x'; MAX_ANSWER_LEN + 1]);
        assert_eq!(framing.take_answer(), Some(Err(AnswerTooLong)));
    }
}
