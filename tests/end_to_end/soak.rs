//! Many sessions in a row, and one with very many points: what they leave behind.

use std::process::Command;
use std::time::Duration;

use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{Running, asphera, http, page, repetitions, snapshot, until};
use serde_json::Value;

/// What a process holds.
#[derive(Debug)]
struct Held {
    files: usize,
    threads: u64,
    memory_kib: u64,
    /// Without pages of files, which come and go as the computer has room for them.
    own_kib: u64,
    heaps: usize,
}

fn held(process: u32) -> Held {
    let of = format!("/proc/{process}");
    let status = std::fs::read_to_string(format!("{of}/status")).unwrap();
    let number = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
        line.trim().trim_end_matches(" kB").parse().unwrap()
    };
    Held {
        files: std::fs::read_dir(format!("{of}/fd")).unwrap().count(),
        threads: number("Threads:"),
        memory_kib: number("VmRSS:"),
        own_kib: number("RssAnon:") + number("RssShmem:") + number("VmSwap:"),
        heaps: heaps(&std::fs::read_to_string(format!("{of}/maps")).unwrap()),
    }
}

/// Heaps of glibc beside the first: 64 MiB of addresses each, of which the lower part is in use.
fn heaps(maps: &str) -> usize {
    const RESERVED: u64 = 64 << 20;
    let range = |line: &str| {
        let (addresses, rights) = line.split_once(' ')?;
        let (from, to) = addresses.split_once('-')?;
        let parse = |number| u64::from_str_radix(number, 16).ok();
        Some((parse(from)?, parse(to)?, rights.get(..4)?.to_owned()))
    };
    let ranges: Vec<_> = maps.lines().filter_map(range).collect();
    let is_heap = |pair: &&[(u64, u64, String)]| {
        let [(from, used, rights), (unused, to, no_rights)] = pair else { return false };
        from % RESERVED == 0
            && used == unused
            && to - from == RESERVED
            && rights == "rw-p"
            && no_rights == "---p"
    };
    ranges.windows(2).filter(is_heap).count()
}

/// Runs a session to its end; gives the most memory seen.
fn measure(address: &str, token: &str, process: u32) -> u64 {
    let before = snapshot(address)["session"]["id"].clone();
    start(address, token);
    let mut most_kib = 0;
    let last = until(address, "end of the session", Duration::from_secs(3600), |snapshot| {
        most_kib = most_kib.max(held(process).memory_kib);
        let is_new = snapshot["session"]["id"] != before;
        is_new && snapshot["state"] == "complete" && !snapshot["outputs"].is_null()
    });
    // A scan that broke off tells nothing of memory.
    let (_, report) = http(address, "GET", "/api/v1/report", &[]);
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(last["session"]["ended"], "complete", "{:#}", report["links"]);
    most_kib
}

/// A station at a rig, with the address of its page and its token.
async fn station(folder: &std::path::Path, points: u64) -> (Rig, Running, String, String) {
    let scene = Scene::built_in("sphere").unwrap().with_points(points).with_speed(Speed::Max);
    let rig = Rig::start(scene, &folder.join("ports")).await.unwrap();
    let options = StationOptions {
        recordings: folder.join("recordings"),
        listen: ([127, 0, 0, 1], 0).into(),
    };
    let config = folder.join("station.toml");
    let text = rig.station_toml(&options).replace("[station]\n", "[station]\nautostart = false\n");
    // The simulator shares the processors with other tests. Where these hold it up for some seconds, that ends no session.
    let patient = text.replace("idle_s = 3.0\n", "idle_s = 120.0\n");
    assert_ne!(patient, text);
    std::fs::write(&config, patient).unwrap();
    let (daemon, address, token) = tokio::task::spawn_blocking(move || {
        let mut daemon = Running::start(
            Command::new(asphera())
                .args(["run", "--config"])
                .arg(config)
                .env_remove("MALLOC_ARENA_MAX"),
        );
        let (address, token) = page(&daemon.line("page:", Duration::from_secs(60)));
        (daemon, address, token)
    })
    .await
    .unwrap();
    (rig, daemon, address, token)
}

fn start(address: &str, token: &str) {
    let bearer = format!("Bearer {token}");
    let (status, body) =
        http(address, "POST", "/api/v1/session/start", &[("Authorization", &bearer)]);
    assert_eq!(status / 100, 2, "{}", String::from_utf8_lossy(&body));
}

/// The least that a process holds within a second: a connection that was answered a moment ago may not be closed yet.
fn settled(process: u32) -> Held {
    let looks = (0..20).map(|_| {
        std::thread::park_timeout(Duration::from_millis(50));
        held(process)
    });
    looks
        .reduce(|one, other| Held {
            files: one.files.min(other.files),
            threads: one.threads.min(other.threads),
            memory_kib: one.memory_kib.min(other.memory_kib),
            own_kib: one.own_kib.min(other.own_kib),
            heaps: one.heaps.min(other.heaps),
        })
        .unwrap()
}

/// 1,000 sessions in full length: as many as ten hours of a line that measures a part every 36 s.
#[tokio::test(flavor = "multi_thread")]
async fn sessions_in_a_row_leave_nothing_behind() {
    let sessions = repetitions(30, 1000);
    let folder = tempfile::tempdir().unwrap();
    let (rig, daemon, address, token) = station(folder.path(), 2000).await;
    tokio::task::spawn_blocking(move || {
        let process = daemon.id();
        // The allocator and its threads have what they need after some.
        let warm = sessions / 3;
        let mut before = None;
        for session in 0..sessions {
            measure(&address, &token, process);
            if session + 1 == warm {
                before = Some(settled(process));
            }
        }
        let (before, after) = (before.unwrap(), settled(process));
        eprintln!("after {warm} sessions {before:?}, after {sessions} {after:?}");
        assert!(after.files <= before.files, "{before:?} {after:?}");
        assert!(after.threads <= before.threads + 1, "{before:?} {after:?}");
        let more_kib = after.own_kib.saturating_sub(before.own_kib);
        assert!(more_kib < 8 * 1024, "{more_kib} KiB more: {before:?} {after:?}");
        // What each heap keeps after a session adds up. The daemon sees to their number, whatever its environment.
        assert!(after.heaps <= 1, "{after:?}");
    })
    .await
    .unwrap();
    drop(rig);
}

/// 10,000,000 points in full length.
#[tokio::test(flavor = "multi_thread")]
async fn memory_grows_with_the_points_and_is_given_back() {
    let points = repetitions(200_000, 10_000_000) as u64;
    let folder = tempfile::tempdir().unwrap();
    let (rig, daemon, address, token) = station(folder.path(), points).await;
    tokio::task::spawn_blocking(move || {
        let process = daemon.id();
        let base_kib = held(process).memory_kib;
        let peaks_kib: Vec<u64> = (0..3).map(|_| measure(&address, &token, process)).collect();
        let a_point = (peaks_kib[0] - base_kib) * 1024 / points;
        eprintln!("{base_kib} KiB at first; with {points} points at most {peaks_kib:?} KiB, {a_point} bytes a point");
        assert!(a_point < BYTES_A_POINT, "{a_point} bytes a point; {peaks_kib:?} KiB");
        // The result of the session before is there while the next one runs.
        let bound_kib = base_kib + 2 * points * BYTES_A_POINT / 1024;
        assert!(peaks_kib.iter().all(|&peak| peak < bound_kib), "{base_kib} {peaks_kib:?} KiB");
    })
    .await
    .unwrap();
    drop(rig);
}

/// What a point costs a daemon at most, its final figures and the recorder included.
const BYTES_A_POINT: u64 = 1000;
