//! A station and a simulated line sensor at full rate, over UDP or TCP: losses, delay until a snapshot, lag, memory.
//!
//! `cargo bench -p asphera --bench live -- rf627 500000 60` sends 500,000 points a second for 60 s. The devices are `rf627`
//! (datagrams), `keyence` and `chrocodile` (TCP). The simulated device has a thread of this process. The delay of a profile runs
//! from its last byte, as sent, to the first snapshot whose mesh holds it. `ASPHERA_BENCH_FINISH=1` also waits for the final
//! figures. Nothing is asserted about time.

mod senders;

use std::sync::Arc;

use asphera::clock::Clock;
use asphera::config::Config;
use asphera::live::Station;
use asphera_link::{Command, Nanos};
use asphera_report::{Snapshot, State};

use senders::{Device, Load};

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let words: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let device = words.first().map_or("rf627", String::as_str);
    let number = |at: usize, default: f64| {
        words.get(at).map_or(default, |word| word.parse().expect("a number"))
    };
    let (rate_hz, seconds) = (number(1, 500_000.0), number(2, 10.0));
    let device = Device::named(device).expect("rf627, keyence or chrocodile");
    let load = Load::new(device, rate_hz, seconds);
    println!(
        "{device:?}: {} profiles of {} points, {rate_hz} points a second for {seconds} s",
        load.profiles, load.points
    );
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    runtime.block_on(run(&load));
}

/// Snapshots as they came.
#[derive(Default)]
struct Watched {
    /// When, and the points in the mesh.
    held: Vec<(Nanos, u64)>,
    /// The most points that waited for the pipeline, and the longest time.
    lag: (u64, f64),
    lost: u64,
}

impl Watched {
    fn take(&mut self, at: Nanos, snapshot: &Snapshot) {
        let points = snapshot.points.received
            - snapshot.progress.pending_points.min(snapshot.points.received);
        self.held.push((at, points));
        self.lost = snapshot.points.lost;
        if let Some(backlog) = snapshot.progress.backlog {
            self.lag = (self.lag.0.max(backlog.waiting_points), self.lag.1.max(backlog.behind_s));
        }
    }
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
async fn run(load: &Load) {
    let folder = tempfile::tempdir().expect("a folder");
    let (sender, text) = senders::start(load, folder.path());
    let config = Config::parse("bench", &text).unwrap_or_else(|problems| panic!("{problems}"));
    let clock = Clock::start();
    let mut station = Station::start(config).expect("a station");
    let mut snapshots = station.handle().watch();
    station.handle().session(Command::Start).await.expect("a session");
    let sending = sender.send(clock.clone());
    let mut watched = Watched::default();
    loop {
        snapshots.changed().await.expect("the station is there");
        let snapshot = Arc::clone(&snapshots.borrow_and_update());
        watched.take(clock.now(), &snapshot);
        if snapshot.state != State::Measuring {
            break;
        }
    }
    let sent = sending.join().expect("the sender ended");
    println!("{}", summary(load, &sent, &watched));
    println!("memory while points arrived: {} MB at most", peak_mb());
    if std::env::var("ASPHERA_BENCH_FINISH").is_ok_and(|value| value == "1") {
        let closed = station.closed().await.expect("final figures");
        let report = &closed.finished.measurement.report;
        println!(
            "report: {} points received, {} lost, {:.1} s after the last point; memory {} MB at most",
            report.points.received,
            report.points.lost,
            report.timing.after_last_point_s,
            peak_mb()
        );
    }
    runtime_end(station);
}

/// Ends the process without the final figures.
fn runtime_end(station: Station) {
    drop(station);
    std::process::exit(0);
}

/// Delays of profiles and what was lost, in words.
fn summary(load: &Load, sent: &[Nanos], watched: &Watched) -> String {
    let mut snapshots = watched.held.iter().peekable();
    let mut delays_ms = Vec::with_capacity(sent.len());
    for (profile, &at) in sent.iter().enumerate() {
        let points = (profile as u64 + 1) * load.points as u64;
        while snapshots.next_if(|(_, held)| *held < points).is_some() {}
        let Some((shown, _)) = snapshots.peek() else { break };
        delays_ms.push(1e3 * shown.since(at).as_secs_f64());
    }
    let shown = delays_ms.len();
    delays_ms.sort_by(f64::total_cmp);
    let at =
        |share: f64| delays_ms.get((share * shown as f64) as usize).copied().unwrap_or(f64::NAN);
    let (first, last) = (sent[0], sent[sent.len() - 1]);
    let took_s = last.since(first).as_secs_f64();
    format!(
        "sent {} profiles in {took_s:.2} s, {:.0} points a second; {} profiles lost; delay median {:.0} ms, 99 % {:.0} ms, longest {:.0} ms \
         ({shown} profiles in snapshots, {} snapshots); said: up to {:.1} s behind, {} points",
        sent.len(),
        (sent.len() * load.points) as f64 / took_s,
        watched.lost,
        at(0.5),
        at(0.99),
        delays_ms.last().copied().unwrap_or(f64::NAN),
        watched.held.len(),
        watched.lag.1,
        watched.lag.0
    )
}

/// The most memory so far (Linux).
fn peak_mb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kb = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    kb.unwrap_or(0) / 1000
}
