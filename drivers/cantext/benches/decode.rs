//! Reading rates of logs and of elements.

use std::hint::black_box;

use asphera_cantext::candump::{self, Item, Reader};
use asphera_cantext::socketcand::Decoder;
use asphera_link::{CanFrame, CanId};
use divan::Bencher;
use divan::counter::ItemsCount;

const FRAMES: usize = 100_000;

fn main() {
    divan::main();
}

fn frame(k: u64) -> CanFrame {
    let data = k.wrapping_mul(0x9E37_79B9_7F4A_7C15).to_le_bytes();
    CanFrame::data_frame(CanId::Standard(0x185), &data).expect("a short frame")
}

/// 100,000 lines of 8 data bytes, given in pieces of 4096 bytes.
#[divan::bench]
fn read_100k_lines(bencher: Bencher<'_, '_>) {
    let mut log = String::new();
    (0..FRAMES as u64).for_each(|k| candump::encode(k * 1000, "can0", &frame(k), &mut log));
    bencher.counter(ItemsCount::new(FRAMES)).bench(|| {
        let (mut reader, mut found) = (Reader::new(None), 0);
        for mut piece in black_box(log.as_bytes()).chunks(4096) {
            while !piece.is_empty() {
                found += usize::from(matches!(reader.read(&mut piece), Some(Item::Frame(_))));
            }
        }
        assert_eq!(found, FRAMES);
    });
}

/// 100,000 elements of 8 data bytes, given in pieces of 4096 bytes.
#[divan::bench]
fn decode_100k_elements(bencher: Bencher<'_, '_>) {
    let data = |k| frame(k).data().iter().map(|byte| format!("{byte:02X}")).collect::<String>();
    let text: String =
        (0..FRAMES as u64).map(|k| format!("< frame 185 23.424242 {} >", data(k))).collect();
    bencher.counter(ItemsCount::new(FRAMES)).bench(|| {
        let (mut decoder, mut found) = (Decoder::new(), 0);
        for mut piece in black_box(text.as_bytes()).chunks(4096) {
            while !piece.is_empty() {
                found += usize::from(decoder.decode(&mut piece).is_some());
            }
        }
        assert_eq!(found, FRAMES);
    });
}
