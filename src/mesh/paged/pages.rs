//! Records in chunks, of which only some are in memory.
//!
//! As a computer's virtual memory does it: a page for each chunk says in which frame of memory its
//! records are. When a record is asked for whose chunk is in none, a chunk that was not used lately
//! makes way; it is put on the shelf first if it was written since it was there last. Which one makes
//! way is found by a hand that goes around the frames, passes those used since it came by last, and
//! takes the first that was not (F. J. Corbató, A paging experiment with the Multics system, MIT
//! Project MAC report MAC-M-384, 1968).
//!
//! Frames are filled and emptied through shared references, a word at a time: a record can be asked for
//! in the middle of a change.

use std::array;
use std::cell::{Cell, OnceCell};
use std::panic::resume_unwind;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::desk::Desk;
use super::shelf::{Part, Shelf, ShelfError};

/// A word of a record, as memory and shelf have it.
pub(super) trait Word: Copy {
    const BYTES: usize;

    /// Little-endian.
    fn write_to(self, bytes: &mut [u8]);
    fn read_from(bytes: &[u8]) -> Self;
}

impl Word for u32 {
    const BYTES: usize = 4;

    fn write_to(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }

    fn read_from(bytes: &[u8]) -> u32 {
        bytes.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte))
    }
}

impl Word for f64 {
    const BYTES: usize = 8;

    fn write_to(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }

    fn read_from(bytes: &[u8]) -> f64 {
        f64::from_bits(bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte)))
    }
}

/// Records of `WIDE` words each, 2 to the power of `BITS` of them a chunk.
pub(super) struct Pages<W, S, const WIDE: usize, const BITS: u32> {
    desk: Arc<Mutex<Desk<S>>>,
    part: Part,
    /// A record that was not written yet.
    unused: [W; WIDE],
    /// How many records there are.
    len: usize,
    /// One for each chunk.
    pages: Vec<Page>,
    /// One more than pages, of which the first `allocated` have memory.
    frames: Vec<Frame<W>>,
    allocated: Cell<usize>,
    /// How many frames are to have memory.
    most: usize,
    /// Which frame is looked at next to make way.
    hand: Cell<usize>,
}

/// Where a chunk is.
struct Page {
    /// Its frame; [`NONE`] if it is on the shelf alone.
    frame: Cell<u32>,
    /// Whether it was asked for since the hand came by.
    used: Cell<bool>,
    /// Whether it was written since it was put on the shelf.
    dirty: Cell<bool>,
    /// The checksum of what is on the shelf.
    sum: Cell<u64>,
}

/// Memory for one chunk.
struct Frame<W> {
    words: OnceCell<Box<[Cell<W>]>>,
    /// Which chunk is in it; [`NONE`] if none is.
    owner: Cell<u32>,
}

const NONE: u32 = u32::MAX;

impl<W: Word, S: Shelf, const WIDE: usize, const BITS: u32> Pages<W, S, WIDE, BITS> {
    pub(super) const CHUNK_BYTES: usize = (WIDE * W::BYTES) << BITS;

    const MASK: usize = (1 << BITS) - 1;

    /// No records yet, of which `most` chunks are to be in memory, but at least one.
    pub(super) fn new(
        desk: Arc<Mutex<Desk<S>>>,
        part: Part,
        unused: [W; WIDE],
        most: usize,
    ) -> Self {
        let frames = vec![Frame { words: OnceCell::new(), owner: Cell::new(NONE) }];
        Pages {
            desk,
            part,
            unused,
            len: 0,
            pages: Vec::new(),
            frames,
            allocated: Cell::new(0),
            most: most.max(1),
            hand: Cell::new(0),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.allocated.get() * Self::CHUNK_BYTES
            + size_of_val(&self.pages[..])
            + size_of_val(&self.frames[..])
    }

    /// Adds unused records.
    pub(super) fn grow(&mut self, count: usize) {
        self.len += count;
        while self.pages.len() << BITS < self.len {
            let chunk = self.pages.len();
            let frame = self.free_frame();
            self.frames.push(Frame { words: OnceCell::new(), owner: Cell::new(NONE) });
            let words = self.frames[frame].words.get().into_iter().flatten();
            for (word, &unused) in words.zip(self.unused.iter().cycle()) {
                word.set(unused);
            }
            self.pages.push(Page {
                frame: Cell::new(frame as u32),
                used: Cell::new(true),
                dirty: Cell::new(true),
                sum: Cell::new(0),
            });
            self.frames[frame].owner.set(chunk as u32);
        }
    }

    /// Leaves out all but the first `len` records. Their chunks stay, for records to come.
    pub(super) fn shorten(&mut self, len: usize) {
        self.len = self.len.min(len);
    }

    /// Words of a record, from one of them on.
    ///
    /// Unwinds with a [`ShelfError`], see [`Pages::page_in`].
    #[inline(always)]
    pub(super) fn read<const N: usize>(&self, record: usize, from: usize) -> [W; N] {
        let words = self.words(record >> BITS);
        let at = (record & Self::MASK) * WIDE + from;
        let words = &words[at..at + N];
        array::from_fn(|i| words[i].get())
    }

    /// Writes words of a record, from one of them on.
    ///
    /// Unwinds as [`Pages::read`].
    #[inline(always)]
    pub(super) fn write<const N: usize>(&self, record: usize, from: usize, values: [W; N]) {
        let words = self.words(record >> BITS);
        self.pages[record >> BITS].dirty.set(true);
        let at = (record & Self::MASK) * WIDE + from;
        for (word, value) in words[at..at + N].iter().zip(values) {
            word.set(value);
        }
    }

    #[inline(always)]
    fn words(&self, chunk: usize) -> &[Cell<W>] {
        let page = &self.pages[chunk];
        // `NONE` is no frame.
        match self.frames.get(page.frame.get() as usize).and_then(|frame| frame.words.get()) {
            Some(words) => {
                page.used.set(true);
                words
            }
            None => self.page_in(chunk),
        }
    }

    /// Brings a chunk back into memory.
    ///
    /// Records are asked for from deep inside of changes that cannot go on without, and whose every
    /// step would have to hand a failure on, also where all is in memory and there is none. So a
    /// [`ShelfError`] unwinds to the mesh that began the change, without a message.
    #[cold]
    #[inline(never)]
    fn page_in(&self, chunk: usize) -> &[Cell<W>] {
        let frame = self.free_frame();
        let Frame { words, owner } = &self.frames[frame];
        let words = words.get().map_or(&[][..], |words| words);
        let page = &self.pages[chunk];
        let mut desk = self.desk();
        if let Err(error) = desk.get(self.part, chunk, page.sum.get()) {
            drop(desk);
            resume_unwind(Box::new(error));
        }
        for (word, bytes) in words.iter().zip(desk.bytes.chunks_exact(W::BYTES)) {
            word.set(W::read_from(bytes));
        }
        owner.set(chunk as u32);
        page.frame.set(frame as u32);
        page.used.set(true);
        words
    }

    /// A frame that has memory and no chunk; a chunk makes way for it if need be.
    fn free_frame(&self) -> usize {
        if self.allocated.get() >= self.most
            && let Some(frame) = self.vacate()
        {
            return frame;
        }
        let frame = self.allocated.get();
        let words = vec![Cell::new(self.unused[0]); WIDE << BITS].into_boxed_slice();
        self.frames[frame].words.get_or_init(|| words);
        self.allocated.set(frame + 1);
        frame
    }

    /// Takes a chunk out of its frame; `None` if the shelf did not take it.
    fn vacate(&self) -> Option<usize> {
        let allocated = &self.frames[..self.allocated.get()];
        // Where a chunk could not be read there is none.
        if let Some(frame) = allocated.iter().position(|frame| frame.owner.get() == NONE) {
            return Some(frame);
        }
        let mut frame = self.hand.get();
        let chunk = loop {
            frame = if frame + 1 < allocated.len() { frame + 1 } else { 0 };
            let chunk = allocated[frame].owner.get() as usize;
            if !self.pages[chunk].used.replace(false) {
                break chunk;
            }
        };
        self.hand.set(frame);
        let page = &self.pages[chunk];
        if page.dirty.get() {
            let mut desk = self.desk();
            let words = self.frames[frame].words.get().into_iter().flatten();
            for (word, bytes) in words.zip(desk.bytes.chunks_exact_mut(W::BYTES)) {
                word.get().write_to(bytes);
            }
            page.sum.set(desk.put(self.part, chunk)?);
            page.dirty.set(false);
        }
        page.frame.set(NONE);
        self.frames[frame].owner.set(NONE);
        Some(frame)
    }

    /// Gives back memory that was taken while the shelf failed, if it does not fail any more.
    pub(super) fn trim(&mut self) {
        while self.allocated.get() > self.most {
            let Some(frame) = self.vacate() else { return };
            let last = self.allocated.get() - 1;
            self.frames.swap(frame, last);
            if let Some(page) = self.pages.get(self.frames[frame].owner.get() as usize) {
                page.frame.set(frame as u32);
            }
            self.frames[last].words.take();
            self.allocated.set(last);
        }
    }

    /// Calls `take` with the words of one chunk after the other, without those after the last record.
    ///
    /// Chunks on the shelf are read and not kept.
    pub(super) fn for_each_chunk(&self, mut take: impl FnMut(&[W])) -> Result<(), ShelfError> {
        let mut words: Vec<W> = Vec::with_capacity(WIDE << BITS);
        let mut left = self.len * WIDE;
        for (chunk, page) in self.pages.iter().enumerate() {
            words.clear();
            match self.frames.get(page.frame.get() as usize).and_then(|frame| frame.words.get()) {
                Some(held) => words.extend(held.iter().map(Cell::get)),
                None => {
                    let mut desk = self.desk();
                    desk.get(self.part, chunk, page.sum.get())?;
                    words.extend(desk.bytes.chunks_exact(W::BYTES).map(W::read_from));
                }
            }
            words.truncate(left);
            left -= words.len();
            take(&words);
        }
        Ok(())
    }

    fn desk(&self) -> MutexGuard<'_, Desk<S>> {
        // It is whole between any two of its calls.
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
