//! A process killed while it records loses nothing it had counted as flushed.

use std::env;
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};

use super::super::{Ended, Recorder, Settings};
use super::{create, entries, entry, header, read};

/// Where the child records; without it the child's test does nothing.
const FOLDER: &str = "ASPHERA_TEST_RECORD_IN";

const SIGKILL: i32 = 9;

/// Records until it is killed. The pipe to its parent blocks it when the parent does not read.
#[test]
fn child() {
    let Some(folder) = env::var_os(FOLDER) else { return };
    let settings =
        Settings { chunk_ms: 7, sync_ms: 20, segment_bytes: 20_000, ..super::settings() };
    let mut recorder: Recorder = create(Path::new(&folder), settings);
    println!();
    for index in 0.. {
        recorder.append(&entry(index)).unwrap();
        let counters = recorder.counters();
        println!("counted {} {}", counters.flushed.entries, counters.durable.entries);
    }
}

#[test]
fn killed_recorder_keeps_its_promise() {
    let child_test = format!("{}::child", module_path!().split_once("::").unwrap().1);
    for (run, lines) in [1, 2, 17, 150, 400, 701, 1023, 1500].into_iter().enumerate() {
        let parent = tempfile::tempdir().unwrap();
        let mut child = Command::new(env::current_exe().unwrap())
            .args([&child_test, "--exact", "--nocapture", "--test-threads=1"])
            .env(FOLDER, parent.path())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
        let counted = output
            .by_ref()
            .map(Result::unwrap)
            .filter_map(|line| {
                let (flushed, durable) = line.strip_prefix("counted ")?.split_once(' ')?;
                Some((flushed.parse().unwrap(), durable.parse().unwrap()))
            })
            .take(lines)
            .last();
        // The child runs on behind the line just read, so this meets it anywhere.
        child.kill().unwrap();
        assert_eq!(child.wait().unwrap().signal(), Some(SIGKILL));
        // Kept open until here: a broken pipe would have ended the child in good order.
        drop(output);
        let (flushed, durable): (u64, u64) = counted.unwrap();

        let (read, recovery) = read(&parent.path().join(header().folder_name())).unwrap();
        let count = read.len() as u64;
        assert!(count >= flushed && flushed >= durable, "run {run}: {count} of {flushed}");
        assert_eq!(read, entries(count), "run {run}");
        assert_eq!((recovery.lost_at_least, recovery.damaged_places), (0, 0), "run {run}");
        assert_eq!(recovery.ended, Ended::Interrupted);
    }
}
