//! The port on real pseudo-terminals.

use std::fs::{File, OpenOptions, read_link};
use std::io::{Read, Write};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::timeout;

use super::*;

const PATIENCE: Duration = Duration::from_secs(20);

fn port() -> (tempfile::TempDir, Port) {
    let dir = tempfile::tempdir().unwrap();
    let port = Port::new(dir.path().join("probe")).unwrap();
    (dir, port)
}

fn open(port: &Port) -> File {
    OpenOptions::new().read(true).write(true).open(port.path()).unwrap()
}

async fn hear(wire: &mut Wire, expected: &[u8]) {
    let mut heard = vec![0; expected.len()];
    timeout(PATIENCE, wire.read_exact(&mut heard)).await.unwrap().unwrap();
    assert_eq!(heard, expected);
}

/// Says something and has the host read it; the wire must already know the host.
async fn say(wire: &mut Wire, host: &mut File, said: &[u8]) {
    timeout(PATIENCE, wire.write_all(said)).await.unwrap().unwrap();
    let mut heard = vec![0; said.len()];
    host.read_exact(&mut heard).unwrap();
    assert_eq!(heard, said);
}

#[tokio::test]
async fn every_byte_passes_both_ways_as_it_is() {
    let (_dir, port) = port();
    let mut wire = port.wire();
    let mut host = open(&port);
    let all: Vec<u8> = (0..=255).collect();
    host.write_all(&all).unwrap();
    hear(&mut wire, &all).await;
    say(&mut wire, &mut host, &all).await;
}

#[tokio::test]
async fn what_nobody_hears_is_lost_and_never_waits() {
    let (_dir, port) = port();
    let mut wire = port.wire();
    // Far more than any buffer of the system holds.
    timeout(PATIENCE, wire.write_all(&vec![7; 1 << 20])).await.unwrap().unwrap();
    let mut host = open(&port);
    host.write_all(b"?").unwrap();
    hear(&mut wire, b"?").await;
    say(&mut wire, &mut host, b"first").await;
}

#[tokio::test]
async fn a_host_that_does_not_read_holds_the_writer_back() {
    let (_dir, port) = port();
    let mut wire = port.wire();
    let mut host = open(&port);
    host.write_all(b"?").unwrap();
    hear(&mut wire, b"?").await;
    let mut sent = 0_usize;
    while let Ok(len) = timeout(Duration::from_millis(50), wire.write(&[sent as u8])).await {
        sent += len.unwrap();
        assert!(sent < 1 << 20, "the port has no bound");
    }
    let mut heard = vec![0; sent];
    host.read_exact(&mut heard).unwrap();
    assert!(heard.iter().enumerate().all(|(index, &byte)| byte == index as u8));
    say(&mut wire, &mut host, b"on").await;
}

#[tokio::test]
async fn a_host_that_left_leaves_no_lock_and_no_bytes_behind() {
    let (_dir, port) = port();
    let mut wire = port.wire();
    let mut host = open(&port);
    rustix::termios::ioctl_tiocexcl(&host).unwrap();
    host.write_all(b"?").unwrap();
    hear(&mut wire, b"?").await;
    wire.write_all(b"nobody reads this").await.unwrap();
    let first = read_link(port.path()).unwrap();
    drop(host);
    // The wire finds out as it waits for bytes; then there is another device under the name.
    let mut next = [0; 4];
    let mut read = Box::pin(wire.read_exact(&mut next));
    while read_link(port.path()).unwrap() == first {
        assert!(timeout(Duration::from_millis(1), &mut read).await.is_err());
    }
    let mut host = open(&port);
    host.write_all(b"next").unwrap();
    timeout(PATIENCE, read).await.unwrap().unwrap();
    assert_eq!(&next, b"next");
    say(&mut wire, &mut host, b"fresh").await;
}

#[tokio::test]
async fn a_host_that_came_and_went_unseen_is_found() {
    let (_dir, port) = port();
    let mut wire = port.wire();
    let first = read_link(port.path()).unwrap();
    open(&port).write_all(b"gone").unwrap();
    let mut byte = [0];
    assert!(timeout(Duration::from_millis(20), wire.read(&mut byte)).await.is_err());
    assert_ne!(read_link(port.path()).unwrap(), first);
}

#[tokio::test]
async fn the_plug_out_hangs_the_host_up_and_in_again_is_another_device() {
    let (_dir, port) = port();
    let mut wire = port.wire();
    let mut host = open(&port);
    host.write_all(b"?").unwrap();
    hear(&mut wire, b"?").await;
    let first = read_link(port.path()).unwrap();
    port.unplug();
    port.unplug();
    assert!(!port.path().is_symlink());
    // Linux says end of file or an input/output error to the reader of a line that hung up.
    assert!(matches!(host.read(&mut [0; 8]), Ok(0) | Err(_)));
    timeout(PATIENCE, wire.write_all(&vec![7; 1 << 20])).await.unwrap().unwrap();
    port.plug();
    assert!(!port.path().is_symlink(), "one of two outages goes on");
    port.plug();
    assert_ne!(read_link(port.path()).unwrap(), first);
    let mut host = open(&port);
    host.write_all(b"back").unwrap();
    hear(&mut wire, b"back").await;
    say(&mut wire, &mut host, b"again").await;
    port.remove();
    assert!(!port.path().is_symlink());
}

#[tokio::test]
async fn only_a_link_is_replaced() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("probe");
    File::create(&path).unwrap();
    assert_eq!(Port::new(path.clone()).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
    std::fs::remove_file(&path).unwrap();
    std::os::unix::fs::symlink("/dev/pts/none", &path).unwrap();
    let port = Port::new(path).unwrap();
    assert!(open(&port).write(b"x").is_ok());
}
