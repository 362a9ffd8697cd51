//! Damaged recordings: nothing panics, nothing is changed in silence, the rest is read.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use asphera_link::Nanos;
use mcap::records::MessageHeader;
use mcap::{Attachment, Writer};
use proptest::prelude::*;

use super::super::header::SegmentHeader;
use super::super::{
    Ended, Entry, FormatVersion, MajorVersion, MinorVersion, ReadError, Recorder, Session,
    SessionId, Settings,
};
use super::memory_disk::MemoryDisk;
use super::{entries, header, read, record, recorded, settings};

/// Entries of the small session most tests damage, the finish included.
const SMALL: usize = 61;

/// A finished session of one segment with several chunks: its folder, its segment, and the bytes of
/// that. It is recorded once, into memory.
fn small(parent: &Path) -> (PathBuf, PathBuf, Vec<u8>) {
    static RECORDED: LazyLock<MemoryDisk> = LazyLock::new(|| {
        let disk = MemoryDisk::default();
        let storage = Box::new(disk.clone());
        let mut recorder =
            Recorder::create(Path::new(""), header(), settings(), storage, Nanos::ZERO).unwrap();
        let count = SMALL as u64 - 1;
        entries(count).iter().for_each(|entry| recorder.append(entry).unwrap());
        recorder.finish(Nanos::from_millis(count), "complete", None).unwrap();
        disk
    });
    RECORDED.copy_to(parent);
    let folder = parent.join(header().folder_name());
    let segment = folder.join("0000.mcap");
    let bytes = fs::read(&segment).unwrap();
    (folder, segment, bytes)
}

/// Puts a file in the place of another. Some file systems wait for the disk when a file is overwritten.
fn put(path: &Path, bytes: &[u8]) {
    fs::remove_file(path).unwrap();
    fs::write(path, bytes).unwrap();
}

/// Places where chunks begin in a file: opcode 6, and the word `zstd` at its place.
fn chunks(bytes: &[u8]) -> Vec<usize> {
    let is_chunk = |window: &[u8]| window[0] == 6 && window[37..45] == *b"\x04\0\0\0zstd";
    let places = bytes.windows(45).enumerate();
    places.filter(|(_, window)| is_chunk(window)).map(|(at, _)| at).collect()
}

/// End of the record at a place.
fn end_of(bytes: &[u8], at: usize) -> usize {
    at + 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize
}

fn is_subsequence(part: &[Entry], whole: &[Entry]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|entry| rest.any(|other| other == entry))
}

#[test]
fn truncated_anywhere_every_whole_chunk_is_read() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, segment, bytes) = small(parent.path());
    let all = recorded(SMALL as u64 - 1);
    let ends: Vec<_> = chunks(&bytes).into_iter().map(|at| end_of(&bytes, at)).collect();
    assert!(ends.len() >= 4, "{} chunks", ends.len());
    // How many entries each chunk adds is learnt from the cuts right behind it, and must then stay.
    let mut counts = Vec::new();
    for &end in &ends {
        put(&segment, &bytes[..end]);
        counts.push(read(&folder).unwrap().0.len());
    }
    assert!(counts.is_sorted() && counts[0] == 0 && counts[ends.len() - 1] == all.len());
    for cut in 0..bytes.len() {
        put(&segment, &bytes[..cut]);
        let whole_chunks = ends.partition_point(|end| *end <= cut);
        let expected = if whole_chunks == 0 { 0 } else { counts[whole_chunks - 1] };
        let (read, recovery) = read(&folder).unwrap();
        assert_eq!(read, all[..expected], "cut at {cut}");
        assert_eq!(recovery.torn_segments, 1, "cut at {cut}");
        assert_eq!(recovery.lost_at_least as usize, all.len() - expected, "cut at {cut}");
        assert_eq!(Session::open(&folder).unwrap().config_toml(), header().config_toml);

        // Alone it cannot tell what it is before its first attachment is whole.
        match super::read(&segment) {
            Ok((read, recovery)) => {
                assert_eq!((read, recovery.torn_segments), (all[..expected].to_vec(), 1));
            }
            Err(error) => assert!(matches!(error, ReadError::NoHeader { .. }) && expected == 0),
        }
    }
}

/// Bits from one that is flipped to the next. Every byte is met, and every bit of a byte has its turn;
/// with 1, which takes five times as long, the test passes too.
const STRIDE: usize = 5;

#[test]
fn single_flipped_bits_are_detected_or_harmless() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, segment, bytes) = small(parent.path());
    let all = recorded(SMALL as u64 - 1);
    let mut harmless = 0;
    let mut flipped = 0;
    for bit in (0..bytes.len() * 8).step_by(STRIDE) {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        put(&segment, &damaged);
        let (read, recovery) = read(&folder).unwrap();
        assert!(is_subsequence(&read, &all), "bit {bit}");
        assert_eq!(recovery.lost_at_least as usize, all.len() - read.len(), "bit {bit}");
        assert!(read == all || !recovery.is_whole(), "bit {bit}");
        harmless += usize::from(read == all);
        flipped += 1;
        assert_eq!(Session::open(&folder).unwrap().config_toml(), header().config_toml);
    }
    assert!(flipped > 1000 && harmless < flipped, "{harmless} of {flipped}");
}

#[test]
fn flipped_bits_of_the_manifest_leave_entries_and_header() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, ..) = small(parent.path());
    let path = folder.join("manifest.json");
    let bytes = fs::read(&path).unwrap();
    let all = recorded(SMALL as u64 - 1);
    for bit in (0..bytes.len() * 8).step_by(STRIDE) {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        put(&path, &damaged);
        assert_eq!(Session::open(&folder).unwrap().header(), &header(), "bit {bit}");
        let (read, recovery) = read(&folder).unwrap();
        assert_eq!(read, all, "bit {bit}");
        assert_eq!(recovery.ended, Ended::Finished { reason: "complete".to_owned() });
    }
}

#[test]
fn chunks_behind_a_damaged_one_are_read() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, segment, bytes) = small(parent.path());
    let all = recorded(SMALL as u64 - 1);
    for chunk in chunks(&bytes) {
        // The opcode, the length, the sizes, the checksum, and the content.
        for place in [0, 1, 3, 8, 9 + 16, 9 + 24, 9 + 36, 9 + 60] {
            let mut damaged = bytes.clone();
            damaged[chunk + place] ^= 0x5A;
            put(&segment, &damaged);
            let (read, recovery) = read(&folder).unwrap();
            let lost = all.len() - read.len();
            assert!(is_subsequence(&read, &all));
            assert!(!recovery.is_whole(), "chunk at {chunk}, byte {place}");
            // No chunk of 1024 bytes has more than 26 entries of 39 bytes and more.
            assert!(lost <= 26, "chunk at {chunk}, byte {place}: {lost} lost");
            assert_eq!(recovery.lost_at_least as usize, lost);
        }
    }
}

#[test]
fn segment_of_random_bytes_is_passed_over() {
    let parent = tempfile::tempdir().unwrap();
    let folder = record(parent.path(), Settings { segment_s: 1, ..settings() }, 3000).folder;
    let mut state = 1u64;
    let noise: Vec<u8> = (0..300_000)
        .map(|_| {
            // Knuth's MMIX generator: any noise will do.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        })
        .collect();
    let all = recorded(3000);
    for (segment, range) in [(0, 0..1000), (1, 1000..2000)] {
        let path = folder.join(format!("{segment:04}.mcap"));
        let bytes = fs::read(&path).unwrap();
        put(&path, &noise);
        assert!(matches!(Session::open(&path), Err(ReadError::NoHeader { .. })));
        let (read, recovery) = read(&folder).unwrap();
        let mut expected = all.clone();
        assert_eq!(recovery.lost_at_least, range.len() as u64);
        expected.drain(range);
        assert_eq!((read, recovery.torn_segments), (expected, 1));
        put(&path, &bytes);
    }
}

#[test]
fn empty_segment_and_missing_manifest() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, segment, bytes) = small(parent.path());
    fs::remove_file(folder.join("manifest.json")).unwrap();
    let (read, recovery) = read(&folder).unwrap();
    assert_eq!(read, recorded(SMALL as u64 - 1));
    assert!(recovery.manifest_damaged && !recovery.is_whole());
    put(&segment, b"");
    assert!(matches!(Session::open(&folder), Err(ReadError::NoHeader { .. })));
    put(&segment, &bytes);
    let missing = Session::open(&folder.join("0009.mcap"));
    assert!(matches!(missing, Err(ReadError::Storage { action: "open", .. })));
}

#[test]
fn segment_of_another_session_is_told_and_left_out() {
    let parent = tempfile::tempdir().unwrap();
    let (folder, ..) = small(parent.path());
    let other = SegmentHeader { segment: 1, ..segment_header(1, 0) };
    let session = super::super::Header { id: SessionId(1), ..header() };
    write_segment(&folder.join("0001.mcap"), &SegmentHeader { session, ..other }, &[7]);
    let mut entries = Session::open(&folder).unwrap().entries();
    let (read, errors): (Vec<_>, Vec<_>) = entries.by_ref().partition(Result::is_ok);
    assert_eq!(read.len(), SMALL);
    assert!(matches!(
        errors[..],
        [Err(ReadError::ForeignSegment {
            found: SessionId(1),
            expected: SessionId(0xbad_cafe),
            ..
        })]
    ));
}

#[test]
fn other_formats_are_named() {
    let parent = tempfile::tempdir().unwrap();
    let segment = parent.path().join("0000.mcap");
    write_segment(&segment, &segment_header(2, 0), &[]);
    for path in [parent.path(), &segment] {
        let error = Session::open(path).unwrap_err();
        assert!(matches!(error, ReadError::TooNew { .. }));
        assert_eq!(
            error.to_string(),
            "the recording has format 2.0, and this asphera reads up to 1.6: use a newer one"
        );
    }
    write_segment(&segment, &segment_header(0, 0), &[]);
    let error = Session::open(&segment).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the recording has format 0.0, and this asphera reads 1 and newer"
    );

    // Without a segment that can tell, the manifest decides; the rest of it may mean anything.
    put(&segment, b"");
    let manifest = r#"{"format": {"major": 3, "minor": 1}, "new": true}"#;
    fs::write(parent.path().join("manifest.json"), manifest).unwrap();
    assert!(matches!(Session::open(parent.path()), Err(ReadError::TooNew { .. })));
}

#[test]
fn newer_minor_version_is_read_and_what_it_adds_is_counted() {
    let parent = tempfile::tempdir().unwrap();
    let segment = parent.path().join("0000.mcap");
    let mut header = segment_header(1, 0);
    header.format.minor = MinorVersion(7);
    write_segment(&segment, &header, &[0, 1, 2]);
    let (read, recovery) = read(&segment).unwrap();
    assert_eq!((read.len(), recovery.unknown, recovery.lost_at_least), (0, 3, 0));
}

#[test]
fn sequence_numbers_pass_32_bits() {
    let parent = tempfile::tempdir().unwrap();
    let segment = parent.path().join("0000.mcap");
    let sequences = [u32::MAX - 1, u32::MAX, 0, 1, 5];
    write_segment(&segment, &segment_header(1, u64::from(u32::MAX) - 1), &sequences);
    assert_eq!(read(&segment).unwrap().1.lost_at_least, 3);
}

fn segment_header(major: u16, first_sequence: u64) -> SegmentHeader {
    let format = FormatVersion { major: MajorVersion(major), minor: MinorVersion(0) };
    SegmentHeader { format, session: header(), segment: 0, first_sequence }
}

/// A segment with messages of these numbers on a channel no version has yet.
fn write_segment(path: &Path, header: &SegmentHeader, sequences: &[u32]) {
    let mut writer = Writer::new(fs::File::create(path).unwrap()).unwrap();
    writer
        .attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: "segment.json".to_owned(),
            media_type: "application/json".to_owned(),
            data: serde_json::to_vec(header).unwrap().into(),
        })
        .unwrap();
    let channel = writer.add_channel_with_id(9999, 0, "/new", "", &BTreeMap::new()).unwrap();
    for &sequence in sequences {
        let header = MessageHeader { channel_id: channel, sequence, log_time: 0, publish_time: 0 };
        writer.write_to_known_channel(&header, b"").unwrap();
    }
    writer.finish().unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Bytes overwritten, removed and inserted: no panic, and nothing but entries of the session.
    #[test]
    fn any_damage_gives_a_subsequence(
        at in any::<prop::sample::Index>(),
        removed in 0..200usize,
        inserted in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let parent = tempfile::tempdir().unwrap();
        let (folder, segment, mut bytes) = small(parent.path());
        let at = at.index(bytes.len());
        let end = (at + removed).min(bytes.len());
        bytes.splice(at..end, inserted);
        put(&segment, &bytes);
        let (read, _) = read(&folder).unwrap();
        prop_assert!(is_subsequence(&read, &recorded(SMALL as u64 - 1)));
    }

    /// Records with lengths and contents of chance, as no writer makes them.
    #[test]
    fn any_records_are_survived(
        records in prop::collection::vec(
            (0..16u8, prop::collection::vec(any::<u8>(), 0..80), prop::option::of(any::<u64>())),
            0..12,
        ),
    ) {
        let parent = tempfile::tempdir().unwrap();
        let (folder, segment, mut bytes) = small(parent.path());
        bytes.truncate(8);
        for (opcode, body, len) in records {
            bytes.push(opcode);
            bytes.extend(len.unwrap_or(body.len() as u64).to_le_bytes());
            bytes.extend(body);
        }
        put(&segment, &bytes);
        let (read, _) = read(&folder).unwrap();
        prop_assert_eq!(read, entries(0));
    }
}
