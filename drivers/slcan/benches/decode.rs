//! Decoding and encoding rates of TPDO-like lines.

use std::hint::black_box;

use asphera_link::{CanFrame, CanId};
use asphera_slcan::{Decoder, Item, encode};
use divan::Bencher;
use divan::counter::ItemsCount;

const FRAMES: usize = 100_000;

fn main() {
    divan::main();
}

fn frames(len: usize) -> Vec<CanFrame> {
    (0..FRAMES as u64)
        .map(|k| {
            let data = k.wrapping_mul(0x9E37_79B9_7F4A_7C15).to_le_bytes();
            CanFrame::data_frame(CanId::Standard(0x185), &data[..len]).expect("a short frame")
        })
        .collect()
}

/// 100,000 lines of 4 and of 8 data bytes, given in pieces of 4096 bytes.
#[divan::bench(args = [4, 8])]
fn decode_100k_lines(bencher: Bencher<'_, '_>, len: usize) {
    let mut line = Vec::new();
    frames(len).iter().for_each(|frame| encode(frame, &mut line));
    bencher.counter(ItemsCount::new(FRAMES)).bench(|| {
        let mut decoder = Decoder::new();
        let mut found = 0;
        for mut piece in black_box(&line).chunks(4096) {
            while !piece.is_empty() {
                if let Some(Item::Frame(frame, _)) = decoder.decode(&mut piece) {
                    found += frame.data().len();
                }
            }
        }
        assert_eq!(found, FRAMES * len);
    });
}

/// 100,000 frames of 4 and of 8 data bytes.
#[divan::bench(args = [4, 8])]
fn encode_100k_frames(bencher: Bencher<'_, '_>, len: usize) {
    let frames = frames(len);
    let mut out = Vec::with_capacity(30 * FRAMES);
    bencher.counter(ItemsCount::new(FRAMES)).bench_local(|| {
        out.clear();
        frames.iter().for_each(|frame| encode(frame, &mut out));
        black_box(out.len())
    });
}
