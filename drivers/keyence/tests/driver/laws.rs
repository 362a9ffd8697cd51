//! Any bytes: no panic, no reading that the bytes do not hold, and the same readings however they are cut.

use crate::bench::{self, Bench, LAYOUT};
use asphera_keyence::Settings;
use asphera_keyence::wire::{
    Answer, Height, Layout, NoHeight, Notice, Profile, Request, Unit, heights,
};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn config() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    }
}

fn height() -> impl Strategy<Value = Height> {
    prop_oneof![
        8 => (-524_284..524_288_i32).prop_map(Ok),
        1 => Just(Err(NoHeight::NoPeak)),
        1 => Just(Err(NoHeight::Masked)),
        1 => Just(Err(NoHeight::DeadZone)),
        1 => Just(Err(NoHeight::Unprocessed)),
    ]
}

/// What a stream holds: profiles, ends of batches, and profiles with one bit wrong.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    let good = (any::<u32>(), any::<i32>(), prop::collection::vec(height(), 8)).prop_map(
        |(trigger, encoder, heights)| Profile::encode(&LAYOUT, trigger, encoder, heights),
    );
    let damaged = (plain_profile(), 4_usize..48, 0_u8..8).prop_map(|(mut bytes, at, bit)| {
        bytes[at] ^= 1 << bit;
        bytes
    });
    prop_oneof![
        6 => good,
        1 => damaged,
        1 => Just(Notice(0x1_0000).encode().to_vec()),
    ]
}

fn plain_profile() -> impl Strategy<Value = Vec<u8>> {
    any::<u32>().prop_map(|trigger| bench::profile(trigger, Ok(5)))
}

fn cut(bytes: &[u8], cuts: &[usize]) -> Vec<Vec<u8>> {
    let mut places: Vec<usize> = cuts.iter().map(|cut| cut % (bytes.len() + 1)).collect();
    places.extend([0, bytes.len()]);
    places.sort_unstable();
    places.windows(2).map(|pair| bytes[pair[0]..pair[1]].to_vec()).collect()
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn any_chunks_give_the_same_events(pieces in prop::collection::vec(piece(), 0..20), cuts in prop::collection::vec(any::<usize>(), 0..40)) {
        let bytes = pieces.concat();
        let mut whole = Bench::streaming(Settings::default());
        whole.stream(&bytes);
        let mut chunked = Bench::streaming(Settings::default());
        cut(&bytes, &cuts).iter().for_each(|chunk| chunked.stream(chunk));
        prop_assert_eq!(&whole.readings(), &chunked.readings());
        prop_assert_eq!(whole.driver.tally().damaged, chunked.driver.tally().damaged);
        if whole.reopens().is_none() {
            prop_assert_eq!(&whole.events, &chunked.events);
        }
    }

    #[test]
    fn answers_may_be_cut_anywhere(cuts in prop::collection::vec(any::<usize>(), 0..10)) {
        let units = Answer { command: 0x06, error: 0, content: &bench::content(Request::Units) }.encode();
        let stop = Answer { command: 0x48, error: 0, content: &[] }.encode();
        let mut bench = Bench::new(Settings::default());
        for answer in [stop, units] {
            cut(&answer, &cuts).iter().for_each(|chunk| bench.commands(chunk));
        }
        prop_assert_eq!(&bench.asked, &[Request::Stop, Request::Units, Request::Errors]);
    }

    /// A sum of 32 bits holds by chance once in four thousand million times.
    #[test]
    fn random_bytes_give_no_reading(chunks in prop::collection::vec((any::<bool>(), prop::collection::vec(any::<u8>(), 0..200)), 0..30)) {
        let mut bench = Bench::streaming(Settings::default());
        for (is_stream, bytes) in &chunks {
            if *is_stream { bench.stream(bytes) } else { bench.commands(bytes) }
        }
        let faults = bench.faults().len();
        prop_assert!(bench.readings().is_empty() && faults < 100, "{} faults", faults);
    }

    #[test]
    fn random_content_is_read_without_harm(content in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = (Unit::decode_all(&content), Layout::decode(&content), Request::decode(&content));
        let points = heights(&content, 1000).count();
        prop_assert_eq!(points, (content.len() * 8 / 20).min(1000));
        let mut bench = Bench::new(Settings::default());
        for _ in 0..8 {
            if bench.reopens().is_none() {
                bench.answer(0, &content);
            }
        }
    }

    #[test]
    fn profiles_survive_their_bytes(points in 1_u16..70, kind in prop_oneof![Just(1_u8), Just(0x41)], trigger: u32, encoder: i32, heights in prop::collection::vec(height(), 70)) {
        let layout = Layout { points, kind, ..LAYOUT };
        let heights = &heights[..usize::from(points)];
        let bytes = Profile::encode(&layout, trigger, encoder, heights.iter().copied());
        prop_assert_eq!(bytes.len(), Profile::len(&layout));
        let profile = Profile::decode(&bytes, &layout).unwrap().unwrap();
        prop_assert_eq!((profile.trigger_count, profile.encoder_count), (trigger, encoder));
        prop_assert_eq!(profile.heights().collect::<Vec<_>>(), heights);
    }
}
