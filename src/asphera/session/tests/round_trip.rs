//! What is recorded is read back, in order, whatever the settings.

use crate::station::{ScanDecision, ScanOrder, Stroke};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::Duration;

use asphera_link::{Command, Nanos};
use proptest::collection::vec;
use proptest::prelude::*;

use super::super::{
    Disk, Ended, Entry, LinkInfo, RecordError, Recorder, ResultsJson, Session, Settings, Tally,
    What,
};
use super::memory_disk::MemoryDisk;
use super::{create, entries, entry, header, read, record, recorded, settings};

#[test]
fn finished_session_is_read_back_whole() {
    let parent = tempfile::tempdir().unwrap();
    let mut recorder = create(parent.path(), settings());
    entries(200).iter().for_each(|entry| recorder.append(entry).unwrap());
    let results = ResultsJson::new(r#"{"pv_nm": 31.400000000000002, "b":1, "a":2}"#).unwrap();
    let end = Nanos::from_millis(200);
    let summary = recorder.finish(end, "complete", Some(&results)).unwrap();
    assert_eq!(summary.folder, parent.path().join("session-20261121T004006Z-0badcafe"));
    assert_eq!((summary.segments, summary.recorded.entries), (1, 202));
    let size = fs::metadata(summary.folder.join("0000.mcap")).unwrap().len();
    assert_eq!(summary.file_bytes, size);

    let session = Session::open(&summary.folder).unwrap();
    assert_eq!(session.header(), &header());
    assert_eq!(session.config_toml(), header().config_toml);
    let finished = Ended::Finished { reason: "complete".to_owned() };
    assert_eq!(session.ended(), finished);
    assert_eq!(session.manifest().end.as_ref().unwrap().at(), end);

    let (read, recovery) = read(&summary.folder).unwrap();
    let results = Entry { at: end, what: What::Results(results) };
    assert_eq!(read, recorded(200).into_iter().chain([results]).collect::<Vec<_>>());
    assert!(recovery.is_whole(), "{recovery:?}");
    assert_eq!((recovery.entries, recovery.ended), (202, finished));
}

#[test]
fn folder_is_for_its_owner_only() {
    let parent = tempfile::tempdir().unwrap();
    let summary = record(parent.path(), settings(), 3);
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&summary.folder), 0o700);
    assert_eq!(mode(&summary.folder.join("0000.mcap")), 0o600);
    let mut names: Vec<_> = fs::read_dir(&summary.folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["0000.mcap", "manifest.json"]);
}

#[test]
fn same_session_gives_the_same_bytes() {
    let [one, two] = [(), ()].map(|()| tempfile::tempdir().unwrap());
    let bytes = |parent: &tempfile::TempDir| {
        fs::read(record(parent.path(), settings(), 300).folder.join("0000.mcap")).unwrap()
    };
    assert_eq!(bytes(&one), bytes(&two));
}

#[test]
fn segments_are_rotated_by_size_and_by_time() {
    let by_size = Settings { segment_bytes: 4096, ..settings() };
    let by_time = Settings { segment_s: 1, ..settings() };
    for (settings, at_least) in [(by_size, 5), (by_time, 3)] {
        let parent = tempfile::tempdir().unwrap();
        let summary = record(parent.path(), settings, 3000);
        assert!(summary.segments >= at_least, "{} segments", summary.segments);
        let (read, recovery) = read(&summary.folder).unwrap();
        assert_eq!(read, recorded(3000));
        assert!(recovery.is_whole(), "{recovery:?}");
    }
}

#[test]
fn one_segment_alone_is_read() {
    let parent = tempfile::tempdir().unwrap();
    let summary = record(parent.path(), Settings { segment_s: 1, ..settings() }, 3000);
    let path = summary.folder.join("0001.mcap");
    let session = Session::open(&path).unwrap();
    assert_eq!((session.header(), session.manifest().end.as_ref()), (&header(), None));
    let (read, recovery) = read(&path).unwrap();
    assert_eq!(read, recorded(3000)[1000..2000]);
    assert_eq!((recovery.lost_at_least, recovery.torn_segments), (0, 0));
    assert_eq!(recovery.ended, Ended::Interrupted);
}

#[test]
fn missing_segment_is_a_gap() {
    let parent = tempfile::tempdir().unwrap();
    let summary = record(parent.path(), Settings { segment_s: 1, ..settings() }, 3000);
    for (missing, range) in [(0, 0..1000), (1, 1000..2000), (2, 2000..3001)] {
        let path = summary.folder.join(format!("{missing:04}.mcap"));
        let bytes = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        let (read, recovery) = read(&summary.folder).unwrap();
        let mut expected = recorded(3000);
        assert_eq!(recovery.lost_at_least, range.len() as u64);
        expected.drain(range);
        assert_eq!(read, expected);
        assert!(!recovery.is_whole());
        fs::write(&path, bytes).unwrap();
    }
}

#[test]
fn time_closes_chunks_and_makes_them_durable() {
    let parent = tempfile::tempdir().unwrap();
    let mut recorder = create(parent.path(), Settings { chunk_bytes: 65_536, ..settings() });
    let counts = |recorder: &Recorder| {
        let counters = recorder.counters();
        [counters.appended, counters.flushed, counters.durable].map(|tally: Tally| tally.entries)
    };
    assert_eq!(recorder.poll_timeout(), None);
    recorder.append(&entry(5)).unwrap();
    assert_eq!(recorder.poll_timeout(), Some(Nanos::from_millis(130)));
    recorder.tick(Nanos::from_millis(129)).unwrap();
    assert_eq!(counts(&recorder), [1, 0, 0]);
    recorder.tick(Nanos::from_millis(130)).unwrap();
    assert_eq!(counts(&recorder), [1, 1, 0]);
    assert_eq!(recorder.poll_timeout(), Some(Nanos::from_millis(1005)));
    recorder.append(&entry(900)).unwrap();
    assert_eq!(recorder.poll_timeout(), Some(Nanos::from_millis(1005)));
    recorder.tick(Nanos::from_millis(1005)).unwrap();
    assert_eq!(counts(&recorder), [2, 2, 2]);
    assert_eq!(recorder.poll_timeout(), None);
    recorder.append(&entry(1100)).unwrap();
    recorder.sync().unwrap();
    assert_eq!(counts(&recorder), [3, 3, 3]);
}

#[test]
fn sync_at_every_append() {
    let parent = tempfile::tempdir().unwrap();
    let mut recorder = create(parent.path(), Settings { sync_ms: 0, ..settings() });
    for (count, entry) in (1..).zip(entries(20)) {
        recorder.append(&entry).unwrap();
        let counters = recorder.counters();
        assert_eq!((counters.durable.entries, counters.appended), (count, counters.durable));
        assert_eq!(recorder.poll_timeout(), None);
    }
}

#[test]
fn dropped_recorder_leaves_an_interrupted_session() {
    let parent = tempfile::tempdir().unwrap();
    let mut recorder = create(parent.path(), settings());
    entries(100).iter().for_each(|entry| recorder.append(entry).unwrap());
    let folder = recorder.folder().to_owned();
    drop(recorder);
    let (read, recovery) = read(&folder).unwrap();
    assert_eq!(read, entries(100));
    assert_eq!((recovery.ended.clone(), recovery.lost_at_least), (Ended::Interrupted, 0));
    assert!(!recovery.is_whole());
}

#[test]
fn running_session_is_read_as_far_as_it_is_flushed() {
    let parent = tempfile::tempdir().unwrap();
    let mut recorder = create(parent.path(), settings());
    entries(500).iter().for_each(|entry| recorder.append(entry).unwrap());
    let flushed = recorder.counters().flushed.entries;
    assert!(flushed > 0);
    let (read, recovery) = read(recorder.folder()).unwrap();
    assert_eq!(read, entries(flushed));
    assert_eq!((recovery.torn_segments, recovery.ended), (1, Ended::Interrupted));
}

#[test]
fn session_without_entries_is_read() {
    let parent = tempfile::tempdir().unwrap();
    let folder = create(parent.path(), settings()).folder().to_owned();
    assert_eq!(read(&folder).unwrap().0, []);
}

#[test]
fn long_entries_have_a_chunk_of_their_own() {
    let parent = tempfile::tempdir().unwrap();
    let long = |len: usize| Entry {
        at: Nanos::ZERO,
        what: What::Received {
            link: 0,
            bytes: (0..len).map(|byte| ((byte * byte) >> 3) as u8).collect(),
        },
    };
    let expected = [entry(4), long(16 << 20), entry(5), long(70_000), long(0)];
    let mut recorder = create(parent.path(), settings());
    expected.iter().for_each(|entry| recorder.append(entry).unwrap());
    assert!(matches!(
        recorder.append(&long((16 << 20) + 1)),
        Err(RecordError::EntryTooLarge { limit: 16_777_216, .. })
    ));
    let folder = recorder.finish(Nanos::ZERO, "complete", None).unwrap().folder;
    let (read, recovery) = read(&folder).unwrap();
    assert!(read[..5] == expected);
    assert!(recovery.is_whole(), "{recovery:?}");
}

#[test]
fn too_long_results_are_left_out_and_told() {
    let parent = tempfile::tempdir().unwrap();
    let recorder = create(parent.path(), settings());
    let folder = recorder.folder().to_owned();
    let results = ResultsJson::encode(&"x".repeat(16 << 20)).unwrap();
    let error = recorder.finish(Nanos::ZERO, "complete", Some(&results)).unwrap_err();
    assert!(matches!(error, RecordError::EntryTooLarge { bytes: 16_777_218, .. }));
    assert!(read(&folder).unwrap().1.is_whole());
}

#[test]
fn wrong_calls_are_refused_and_leave_the_recorder_as_it_was() {
    let parent = tempfile::tempdir().unwrap();
    let mut recorder = create(parent.path(), settings());
    let at = Nanos::ZERO;
    let finish = Entry { at, what: What::Finish { reason: String::new() } };
    assert!(matches!(recorder.append(&finish), Err(RecordError::OnlyByFinish)));
    let results = Entry { at, what: What::Results(ResultsJson::new("1").unwrap()) };
    assert!(matches!(recorder.append(&results), Err(RecordError::OnlyByFinish)));
    let unknown = Entry { at, what: What::Opened { link: 3 } };
    let error = recorder.append(&unknown).unwrap_err();
    assert!(matches!(error, RecordError::UnknownLink { link: 3, links: 3 }));
    assert_eq!(recorder.counters().appended, Tally::default());
    recorder.append(&entry(0)).unwrap();
    assert!(!recorder.is_stopped());

    let again = Recorder::create(parent.path(), header(), settings(), Box::new(Disk), at);
    assert!(matches!(again, Err(RecordError::Storage { action: "create", .. })));
    let bad = Settings { chunk_ms: 0, ..settings() };
    let bad = Recorder::create(parent.path(), header(), bad, Box::new(Disk), at);
    assert!(matches!(bad, Err(RecordError::Value { key, .. }) if key == "chunk_ms"));
    assert!(ResultsJson::new("{").is_err());
}

fn any_entry() -> impl Strategy<Value = Entry> {
    let link = 0..3usize;
    let bytes = vec(any::<u8>(), 0..300);
    let what = prop_oneof![
        1 => link.clone().prop_map(|link| What::Opened { link }),
        8 => (link.clone(), bytes.clone()).prop_map(|(link, bytes)| What::Received { link, bytes }),
        4 => (link.clone(), bytes).prop_map(|(link, bytes)| What::Sent { link, bytes }),
        1 => (link, any::<String>()).prop_map(|(link, reason)| What::Closed { link, reason }),
        1 => Just(What::Command(Command::Start)),
        1 => Just(What::Command(Command::Stop)),
        1 => Just(What::Scan(ScanOrder::Halt)),
        1 => any::<[i64; 5]>().prop_map(|[x0, y0, x1, y1, spacing_nm]| {
            let stroke = Stroke { from_nm: [x0, y0], to_nm: [x1, y1], spacing_nm };
            What::Scan(ScanOrder::Decide(ScanDecision::Measure(vec![stroke])))
        }),
        1 => (any::<u64>(), any::<u64>()).prop_map(|(until, suspended)| What::HeldUp {
            until: Nanos::from_nanos(until),
            suspended: Duration::from_nanos(suspended),
        }),
    ];
    // Times may be equal and may even go back: the order is the order of appending.
    (any::<u64>(), what).prop_map(|(ns, what)| Entry { at: Nanos::from_nanos(ns), what })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_is_appended_is_read_back_in_order(
        all in vec(any_entry(), 0..120),
        chunk_bytes in 1024..4096u32,
        chunk_ms in 1..60_000u32,
        sync_ms in 0..60_000u32,
        segment_bytes in 1024..20_000u64,
        segment_s in 1..86_400u32,
        name in "[^\\p{Cc}]{1,20}",
    ) {
        let parent = tempfile::tempdir().unwrap();
        let settings = Settings { chunk_bytes, chunk_ms, sync_ms, segment_bytes, segment_s, reserve_bytes: 0 };
        let mut header = header();
        header.links[1] = LinkInfo { name: format!("/{name}"), ..header.links[1].clone() };
        let disk = MemoryDisk::default();
        let storage = Box::new(disk.clone());
        let mut recorder =
            Recorder::create(Path::new(""), header, settings, storage, Nanos::ZERO).unwrap();
        for entry in &all {
            recorder.append(entry).unwrap();
        }
        let counters = recorder.counters();
        prop_assert_eq!(counters.appended.entries, all.len() as u64);
        prop_assert!(counters.durable.entries <= counters.flushed.entries);
        prop_assert!(counters.flushed.entries <= counters.appended.entries);
        let folder = recorder.finish(Nanos::ZERO, "", None).unwrap().folder;
        disk.copy_to(parent.path());
        let (read, recovery) = read(&parent.path().join(folder)).unwrap();
        prop_assert_eq!(&read[..all.len()], &all[..]);
        prop_assert!(recovery.is_whole());
    }
}
