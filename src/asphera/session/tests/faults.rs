//! A disk that fails, fills up, and loses power, at every single operation.

use std::path::Path;

use asphera_link::Nanos;

use super::super::{Counters, Ended, RecordError, Recorder, Session, Settings};
use super::memory_disk::{EIO, ENOSPC, Fault, MemoryDisk};
use super::{entries, header, read, recorded, settings};

const COUNT: u64 = 150;

/// Segments [`run`] makes of them; the manifest is written twice besides.
const SEGMENTS: usize = 7;

fn small_settings() -> Settings {
    // A segment lasts some 20 ms here, so each is synced in its course too.
    Settings { sync_ms: 12, segment_bytes: 3000, ..settings() }
}

/// Records [`COUNT`] entries until something fails. Gives the counters before the call that failed or
/// finished, and that call's error.
fn run(disk: &MemoryDisk) -> (Counters, Option<RecordError>) {
    let parent = Path::new("sessions");
    let storage = Box::new(disk.clone());
    let mut recorder =
        match Recorder::create(parent, header(), small_settings(), storage, Nanos::ZERO) {
            Ok(recorder) => recorder,
            Err(error) => return (Counters::default(), Some(error)),
        };
    for entry in entries(COUNT) {
        if let Err(error) = recorder.append(&entry) {
            let counters = recorder.counters();
            assert!(recorder.is_stopped());
            assert_eq!(recorder.poll_timeout(), None);
            let steps = disk.steps();
            assert!(matches!(recorder.append(&entry), Err(RecordError::Stopped)));
            assert!(matches!(recorder.tick(entry.at), Err(RecordError::Stopped)));
            assert!(matches!(recorder.sync(), Err(RecordError::Stopped)));
            drop(recorder);
            assert_eq!(disk.steps(), steps, "something was written after an error");
            return (counters, Some(error));
        }
    }
    let counters = recorder.counters();
    let error = recorder.finish(Nanos::from_millis(COUNT), "complete", None).err();
    (counters, error)
}

/// Reads the session left in a folder; nothing where there is none.
fn left_in(target: &Path) -> u64 {
    let folder = target.join("sessions").join(header().folder_name());
    if !folder.join("manifest.json").exists() {
        return 0;
    }
    let (read, recovery) = read(&folder).unwrap();
    assert_eq!(read, recorded(COUNT)[..read.len()]);
    assert_eq!(recovery.damaged_places, 0);
    assert!(recovery.torn_segments <= 1);
    read.len() as u64
}

#[test]
fn whatever_operation_fails_what_was_promised_is_there() {
    let sound = MemoryDisk::default();
    let (_, error) = run(&sound);
    assert!(error.is_none());
    let steps = sound.steps();
    assert_eq!(sound.files(), 2 + SEGMENTS);
    for fault in [Fault::Error(ENOSPC), Fault::Error(EIO), Fault::Short] {
        for (step, lasting) in (0..steps).flat_map(|step| [(step, true), (step, false)]) {
            let case = format!("{fault:?} at operation {step}, lasting: {lasting}");
            let disk = MemoryDisk::failing(step, fault, lasting);
            let (counters, error) = run(&disk);
            // A short write that is not followed by an error is simply continued.
            let failed = fault != Fault::Short || lasting;
            assert!(error.is_some() || !failed, "{case}");
            if let Some(error) = error {
                let RecordError::Storage { source, .. } = error else { panic!("{case}: {error}") };
                let code = if fault == Fault::Error(EIO) { EIO } else { ENOSPC };
                assert_eq!(source.raw_os_error(), Some(code), "{case}");
            }
            let target = tempfile::tempdir().unwrap();
            disk.copy_to(target.path());
            assert!(left_in(target.path()) >= counters.flushed.entries, "{case}");
            for quarters in [0, 1, 3] {
                let target = tempfile::tempdir().unwrap();
                disk.copy_after_power_cut(target.path(), quarters);
                let left = left_in(target.path());
                assert!(left >= counters.durable.entries, "{case}: {left} of {counters:?}");
            }
        }
    }
}

#[test]
fn reserve_stops_the_recording_in_good_order() {
    let disk = MemoryDisk::default();
    disk.set_free(10_000);
    let settings = Settings { reserve_bytes: 5000, ..small_settings() };
    let parent = Path::new("sessions");
    let storage = Box::new(disk.clone());
    let mut recorder = Recorder::create(parent, header(), settings, storage, Nanos::ZERO).unwrap();
    let all = entries(COUNT);
    all[..100].iter().for_each(|entry| recorder.append(entry).unwrap());
    disk.set_free(4999);
    recorder.sync().unwrap();
    assert_eq!(recorder.free_bytes(), 4999);
    let error = recorder.append(&all[100]).unwrap_err();
    let folder = parent.join(header().folder_name());
    assert!(matches!(
        &error,
        RecordError::DiskReserve { path, free_bytes: 4999, wanted_bytes: 5000 } if *path == folder
    ));
    assert_eq!(recorder.counters().durable.entries, 100);
    assert!(matches!(recorder.append(&all[100]), Err(RecordError::Stopped)));

    let target = tempfile::tempdir().unwrap();
    disk.copy_after_power_cut(target.path(), 0);
    let (read, recovery) = read(&target.path().join(folder)).unwrap();
    assert_eq!(read, all[..100]);
    assert_eq!((recovery.torn_segments, recovery.lost_at_least), (0, 0));
    assert_eq!(recovery.ended, Ended::Stopped { reason: error.to_string() });
}

#[test]
fn no_session_begins_below_the_reserve() {
    let disk = MemoryDisk::default();
    disk.set_free(99);
    let settings = Settings { reserve_bytes: 100, ..settings() };
    let storage = Box::new(disk.clone());
    let result = Recorder::create(Path::new("x"), header(), settings, storage, Nanos::ZERO);
    assert!(matches!(result, Err(RecordError::DiskReserve { free_bytes: 99, .. })));
    assert_eq!(disk.steps(), 1);
}

#[test]
fn finish_works_below_the_reserve() {
    let disk = MemoryDisk::default();
    let settings = Settings { reserve_bytes: 100, ..settings() };
    let storage = Box::new(disk.clone());
    let mut recorder =
        Recorder::create(Path::new("x"), header(), settings, storage, Nanos::ZERO).unwrap();
    disk.set_free(1);
    recorder.sync().unwrap();
    recorder.finish(Nanos::ZERO, "complete", None).unwrap();
    let target = tempfile::tempdir().unwrap();
    disk.copy_after_power_cut(target.path(), 0);
    let session = Session::open(&target.path().join("x").join(header().folder_name())).unwrap();
    assert_eq!(session.ended(), Ended::Finished { reason: "complete".to_owned() });
}
