//! A daemon that is killed at any moment keeps what it received.

use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asphera::session::{Ended, Session, What};
use asphera_tests::{Running, asphera, http, now, page, recording, repetitions, root};

use crate::random::Random;

/// What is received longer than this before a kill is in the recording.
const PROMISED: Duration = Duration::from_millis(250);
/// A machine that lets a test wait longer than this may let the daemon wait, too.
const HELD_UP: Duration = Duration::from_millis(60);

/// A source that sends numbered words of 16 bytes for as long as it is wanted. It is no device: what a link receives is
/// recorded whatever it means.
struct Source {
    address: String,
    wanted: Arc<AtomicBool>,
    /// What it has sent to its newest connection.
    sent: Arc<AtomicU64>,
    task: Option<JoinHandle<()>>,
}

fn word(number: u64) -> Vec<u8> {
    format!("word {number:010}\n").into_bytes()
}

impl Source {
    fn start() -> Source {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let wanted = Arc::new(AtomicBool::new(true));
        let sent = Arc::new(AtomicU64::new(0));
        let (goes_on, counts) = (wanted.clone(), sent.clone());
        listener.set_nonblocking(true).unwrap();
        let task = std::thread::spawn(move || {
            let mut connection = None;
            while goes_on.load(Ordering::Relaxed) {
                if let Ok((stream, _)) = listener.accept() {
                    counts.store(0, Ordering::Relaxed);
                    stream.set_nonblocking(true).unwrap();
                    connection = Some((stream, 0));
                }
                if let Some((stream, number)) = &mut connection {
                    // What the daemon asks of its device is of no interest.
                    let _ = stream.read(&mut [0; 1024]);
                    for _ in 0..4 {
                        if stream.write_all(&word(*number)).is_err() {
                            break;
                        }
                        *number += 1;
                    }
                    counts.store(*number, Ordering::Relaxed);
                }
                std::thread::park_timeout(Duration::from_millis(2));
            }
        });
        Source { address, wanted, sent, task: Some(task) }
    }
}

impl Drop for Source {
    fn drop(&mut self) {
        self.wanted.store(false, Ordering::Relaxed);
        self.task.take().unwrap().join().unwrap();
    }
}

fn configuration(folder: &Path, source: &str) -> PathBuf {
    let example = std::fs::read_to_string(root().join("config/examples/om30-line.toml")).unwrap();
    let text = format!(
        "{}\n[publish]\nlisten = \"127.0.0.1:0\"\n[session]\ndir = {:?}\n",
        example
            .replace("autostart = false", "autostart = true")
            .replace("192.168.170.2:7890", source)
            .replace("sample_rate_hz = 2000", "sample_rate_hz = 2000\nready_timeout_ms = 60000"),
        folder.to_str().unwrap()
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    std::fs::copy(root().join("config/examples/flat.toml"), folder.join("flat.toml")).unwrap();
    path
}

/// What was seen of a daemon up to its end.
struct Seen {
    /// Bytes of the link that the daemon said it had, each with the time before it was asked.
    received: Vec<(Instant, u64)>,
    /// The longest time that the test itself had to wait for its turn, in its last half second.
    late: Duration,
    killed: Instant,
}

/// Asks a daemon what it has, again and again, and kills it after a time.
fn watched(daemon: &Running, address: &str, lives: Duration) -> Seen {
    let end = now() + lives;
    let mut received = Vec::new();
    let mut turns = vec![now()];
    while now() < end {
        let (_, body) = http(address, "GET", "/api/v1/snapshot", &[]);
        let snapshot: serde_json::Value = serde_json::from_slice(&body).unwrap();
        let link = snapshot["links"].as_array().and_then(|links| {
            links.iter().find(|link| link["name"] == "probe")?["received_bytes"].as_u64()
        });
        received.push((now(), link.unwrap_or(0)));
        std::thread::park_timeout(Duration::from_millis(5));
        turns.push(now());
    }
    let killed = now();
    daemon.signal("KILL");
    let recent = turns.windows(2).filter(|two| killed - two[1] < 2 * PROMISED);
    let late = recent.map(|two| two[1] - two[0]).max().unwrap_or(lives);
    Seen { received, late, killed }
}

/// 200 kills in full length.
#[test]
fn what_was_received_a_quarter_of_a_second_before_a_kill_is_in_the_recording() {
    let kills = repetitions(15, 200);
    let source = Source::start();
    let (mut judged, mut bytes) = (0, 0);
    let mut random = Random(20_261_123);
    for kill in 0..kills {
        let folder = tempfile::tempdir().unwrap();
        let mut daemon = Running::start(
            Command::new(asphera())
                .args(["run", "--config"])
                .arg(configuration(folder.path(), &source.address))
                .stdout(Stdio::null()),
        );
        let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
        let lives = Duration::from_millis(200 + random.below(900));
        let seen = watched(&daemon, &address, lives);
        drop(daemon);

        let session = Session::open(&recording(folder.path())).unwrap();
        let mut entries = session.entries();
        let mut recorded = Vec::new();
        for entry in entries.by_ref() {
            match entry.unwrap().what {
                What::Received { bytes, .. } => recorded.extend(bytes),
                What::Closed { reason, .. } => panic!("kill {kill}: the link closed: {reason}"),
                _ => {}
            }
        }
        let recovery = entries.recovery().clone();
        assert_eq!((recovery.lost_at_least, recovery.damaged_places), (0, 0), "kill {kill}");
        assert_eq!(recovery.ended, Ended::Interrupted, "kill {kill}");
        // Never another byte than came, nor one that is missing.
        let sent = source.sent.load(Ordering::Relaxed) + 4;
        let all: Vec<u8> = (0..sent).flat_map(word).collect();
        assert!(all.starts_with(&recorded), "kill {kill}: other bytes than were sent");
        bytes += recorded.len();
        let promised = seen
            .received
            .iter()
            .filter(|(at, _)| seen.killed.duration_since(*at) > PROMISED)
            .map(|(_, received)| *received)
            .max()
            .unwrap_or(0);
        if seen.late < HELD_UP {
            assert!(
                recorded.len() as u64 >= promised,
                "kill {kill} after {lives:?}: {} bytes, {promised} promised",
                recorded.len()
            );
            judged += usize::from(promised > 0);
        }
    }
    assert!(bytes > 100_000, "{bytes} bytes in all");
    // On a machine that has no time for its tests little can be said of 0.25 s.
    if judged < kills / 4 {
        asphera_tests::skipped(&format!("only {judged} of {kills} kills met a machine with time"));
    }
}
