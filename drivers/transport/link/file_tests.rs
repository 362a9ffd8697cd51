//! Files and pipes of this machine as links.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use super::tests::{next, start};
use super::*;
use crate::FileSettings;

fn file(path: &Path, follow: bool, from_end: bool) -> Endpoint {
    Endpoint::File(FileSettings { path: path.to_owned(), follow, from_end })
}

/// A FIFO in a folder of its own.
fn fifo() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("profiles");
    let status = std::process::Command::new("mkfifo").arg(&path).status().unwrap();
    assert!(status.success());
    (dir, path)
}

/// Bytes up to this many, however they were cut.
async fn bytes(events: &mut mpsc::Receiver<LinkEvent>, count: usize) -> Vec<u8> {
    let mut all = Vec::new();
    while all.len() < count {
        match next(events).await {
            What::Received(bytes) => all.extend(bytes),
            other => panic!("{other:?} after {} bytes", all.len()),
        }
    }
    all
}

async fn closed(events: &mut mpsc::Receiver<LinkEvent>) -> String {
    match next(events).await {
        What::Closed(words) => words,
        other => panic!("{other:?} instead of a loss"),
    }
}

#[tokio::test]
async fn a_file_is_read_whole_and_once() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("points.csv");
    let text: Vec<u8> = (0..100_000_u32).flat_map(u32::to_le_bytes).collect();
    std::fs::write(&path, &text).unwrap();
    let (link, mut events) = start(file(&path, false, false));
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    link.command(LinkCommand::Send { epoch: 1, bytes: b"nobody".to_vec() });
    assert!(bytes(&mut events, text.len()).await == text);
    assert!(closed(&mut events).await.ends_with("points.csv was read to its end"));
    let more = timeout(Duration::from_millis(100), events.recv()).await;
    assert!(more.is_err(), "{more:?}");
    assert_eq!(std::fs::read(&path).unwrap(), text, "nothing was written");
}

/// A driver that wants to start over does not get the same bytes twice.
#[tokio::test]
async fn a_new_connection_to_a_file_reads_on() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("points.csv");
    std::fs::write(&path, "one\n").unwrap();
    let (link, mut events) = start(file(&path, true, false));
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    assert_eq!(bytes(&mut events, 4).await, b"one\n");
    link.command(LinkCommand::Reopen { epoch: 1 });
    assert_eq!(closed(&mut events).await, "closed to start over");
    assert_eq!(next(&mut events).await, What::Opened { epoch: 2 });
    OpenOptions::new().append(true).open(&path).unwrap().write_all(b"two\n").unwrap();
    assert_eq!(bytes(&mut events, 4).await, b"two\n");
}

#[tokio::test]
async fn a_followed_file_is_read_as_it_grows_and_from_its_end_where_asked() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("log");
    std::fs::write(&path, "old\n").unwrap();
    let (_whole, mut whole) = start(file(&path, true, false));
    let (_tail, mut tail) = start(file(&path, true, true));
    assert_eq!(next(&mut whole).await, What::Opened { epoch: 1 });
    assert_eq!(next(&mut tail).await, What::Opened { epoch: 1 });
    assert_eq!(bytes(&mut whole, 4).await, b"old\n");
    let mut writer = OpenOptions::new().append(true).open(&path).unwrap();
    for piece in ["ne", "w\n", "newer\n"] {
        writer.write_all(piece.as_bytes()).unwrap();
        assert_eq!(bytes(&mut whole, piece.len()).await, piece.as_bytes());
        assert_eq!(bytes(&mut tail, piece.len()).await, piece.as_bytes());
    }
}

#[tokio::test]
async fn truncated_replaced_and_removed_files_are_said_and_read_anew() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("log");
    std::fs::write(&path, "a long first line\n").unwrap();
    let (_link, mut events) = start(file(&path, true, false));
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    assert_eq!(bytes(&mut events, 18).await, b"a long first line\n");

    OpenOptions::new().write(true).open(&path).unwrap().set_len(6).unwrap();
    let words = closed(&mut events).await;
    assert!(words.contains("log was truncated from 18 to 6 bytes"), "{words}");
    assert!(words.contains("rename a new file over it"), "{words}");
    assert_eq!(next(&mut events).await, What::Opened { epoch: 2 });
    assert_eq!(bytes(&mut events, 6).await, b"a long");

    // What the old file got last is read before the new one.
    let mut old = OpenOptions::new().append(true).open(&path).unwrap();
    std::fs::write(dir.path().join("new"), "second file\n").unwrap();
    old.write_all(b"last\n").unwrap();
    std::fs::rename(dir.path().join("new"), &path).unwrap();
    assert_eq!(bytes(&mut events, 5).await, b"last\n");
    let words = closed(&mut events).await;
    assert!(words.contains("log was replaced by another file"), "{words}");
    assert_eq!(next(&mut events).await, What::Opened { epoch: 3 });
    assert_eq!(bytes(&mut events, 12).await, b"second file\n");

    std::fs::remove_file(&path).unwrap();
    let words = closed(&mut events).await;
    assert!(words.contains("log was removed: a new file of this name"), "{words}");
    let What::OpenFailed(words) = next(&mut events).await else { panic!("it is gone") };
    assert!(words.contains("mkfifo") && words.contains("No such file"), "{words}");
    std::fs::write(dir.path().join("new"), "third\n").unwrap();
    std::fs::rename(dir.path().join("new"), &path).unwrap();
    loop {
        match next(&mut events).await {
            What::OpenFailed(_) => {}
            What::Opened { epoch } => break assert_eq!(epoch, 4),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(bytes(&mut events, 6).await, b"third\n");
}

/// A file that comes after the link is new: it is read whole, though files that are there are read from their end.
#[tokio::test]
async fn a_file_that_comes_later_is_read_whole() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("late");
    let (_link, mut events) = start(file(&path, true, true));
    assert!(matches!(next(&mut events).await, What::OpenFailed(_)));
    std::fs::write(dir.path().join("new"), "whole\n").unwrap();
    std::fs::rename(dir.path().join("new"), &path).unwrap();
    while matches!(next(&mut events).await, What::OpenFailed(_)) {}
    assert_eq!(bytes(&mut events, 6).await, b"whole\n");
}

#[tokio::test]
async fn writers_of_a_fifo_come_and_go_without_a_lost_byte() {
    let (_dir, path) = fifo();
    let (link, mut events) = start(file(&path, false, false));
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    for epoch in 1..=20_u64 {
        let path = path.clone();
        let text: Vec<u8> = (0..5000_u64).flat_map(|n| (n * epoch).to_le_bytes()).collect();
        let written = text.clone();
        let writer = std::thread::spawn(move || {
            File::options().write(true).open(path).unwrap().write_all(&written).unwrap();
        });
        assert!(bytes(&mut events, text.len()).await == text, "writer {epoch}");
        writer.join().unwrap();
        let words = closed(&mut events).await;
        assert!(words.ends_with("closed it: start it again, or another"), "{words}");
        assert_eq!(next(&mut events).await, What::Opened { epoch: epoch + 1 });
    }
    // A driver that starts over does not cost the program its reader.
    let mut writer = File::options().write(true).open(&path).unwrap();
    link.command(LinkCommand::Reopen { epoch: 21 });
    assert_eq!(closed(&mut events).await, "closed to start over");
    writer.write_all(b"meanwhile").unwrap();
    assert_eq!(next(&mut events).await, What::Opened { epoch: 22 });
    assert_eq!(bytes(&mut events, 9).await, b"meanwhile");
}

/// Standard input of a program is such a pipe: below /proc, without a name.
#[tokio::test]
async fn a_pipe_without_a_name_ends_the_link_with_its_writer() {
    use std::os::fd::AsRawFd as _;
    let (reader, mut writer) = io::pipe().unwrap();
    let path = format!("/proc/self/fd/{}", reader.as_raw_fd());
    let (_link, mut events) = start(file(Path::new(&path), false, false));
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    writer.write_all(b"1.5\n").unwrap();
    assert_eq!(bytes(&mut events, 4).await, b"1.5\n");
    drop(writer);
    assert_eq!(closed(&mut events).await, format!("the program that wrote to {path} ended"));
    assert!(timeout(Duration::from_millis(100), events.recv()).await.is_err());
    assert_eq!(
        FileSettings { path: "-".into(), follow: false, from_end: false }.to_string(),
        "standard input"
    );
}

#[tokio::test]
async fn what_cannot_be_read_is_said_with_its_cure() {
    let dir = tempfile::tempdir().unwrap();
    let refused = |path: &Path| {
        let endpoint = file(path, false, false);
        async move {
            let (_link, mut events) = start(endpoint);
            match next(&mut events).await {
                What::OpenFailed(words) => words,
                other => panic!("{other:?}"),
            }
        }
    };
    let words = refused(&dir.path().join("none.csv")).await;
    assert!(words.contains("none.csv; correct its path") && words.contains("No such"), "{words}");
    let words = refused(dir.path()).await;
    assert!(words.contains("name a file in this folder") && words.contains("directory"), "{words}");
    let words = refused(Path::new("/dev/null")).await;
    assert_eq!(
        words,
        "/dev/null is neither a file nor a pipe: name one of these; a serial port needs kind = \"serial\""
    );
    let shut = dir.path().join("shut.csv");
    std::fs::write(&shut, "1\n").unwrap();
    std::fs::set_permissions(&shut, std::fs::Permissions::from_mode(0o000)).unwrap();
    // Who may read everything cannot be refused.
    if File::open(&shut).is_err() {
        let words = refused(&shut).await;
        assert!(words.contains("let the user of asphera read it"), "{words}");
    }
}
