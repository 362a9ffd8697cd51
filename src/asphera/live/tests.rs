//! A station whose probe is there and never triggered.

use std::net::Ipv4Addr;
use std::time::Duration;

use asphera_link::Command;
use asphera_report::{Snapshot, State, Status, Waiting};
use asphera_sim_chrocodile::{Device, Sample, Simulator, tcp};
use tokio::io::AsyncWriteExt as _;
use tokio::time::timeout;

use super::{Asked, Control, Station};
use crate::config::Config;

fn station(address: &str, recordings: &str, first: &str) -> Config {
    let text = format!(
        r#"
[station]
name = "bench"
[link.probe]
kind = "tcp"
address = "{address}"
[device.probe]
driver = "chrocodile2"
link = "probe"
[device.probe.settings]
signals = [75, 76, 65, 256, 257]
sample_rate_hz = 2000.0
trigger = "each"
[sync]
devices = ["probe"]
[kinematics]
kind = "cartesian"
x = {{ device = "probe", channel = "encoder_x", mm_per_count = 0.001 }}
y = {{ constant_mm = 0.0 }}
z = {{ device = "probe", channel = "distance1" }}
[nominal]
surface = {{ kind = "plane" }}
[nominal.tolerance]
pv_nm = 100
[scan]
{first}
[session]
dir = {recordings:?}
[output]
files = ["report.json", "report.html", "qif.xml"]
command = ["/bin/sh", "-c", 'printf "%s %s" "$ASPHERA_VERDICT" "$ASPHERA_SESSION" > "$0/told"']
"#
    );
    Config::parse("test", &text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Follows the snapshots until one is as wanted.
async fn until(
    snapshots: &mut tokio::sync::watch::Receiver<std::sync::Arc<Snapshot>>,
    wanted: impl Fn(&Snapshot) -> bool,
) -> std::sync::Arc<Snapshot> {
    let found = timeout(Duration::from_secs(60), snapshots.wait_for(|now| wanted(now)));
    found.await.expect("such a snapshot").expect("the station is there").clone()
}

#[tokio::test]
async fn a_session_waits_for_its_devices_then_for_a_trigger_and_ends_without_one() {
    let folder = tempfile::tempdir().unwrap();
    let recordings = folder.path().to_str().unwrap();
    let simulator = Simulator::new(Device::new(3000.0), 64);
    // An address that is free until the probe is switched on.
    let listening = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let address = listening.local_addr().unwrap();
    drop(listening);
    let config = station(&address.to_string(), recordings, "idle_s = 0.5\nfirst_s = 1.0");
    let mut station = Station::start(config).unwrap();
    let mut snapshots = station.handle().watch();
    station.handle().session(Command::Start).await.unwrap();
    let absent = until(&mut snapshots, |now| now.progress.waiting.is_some()).await;
    let links = vec!["probe".to_owned()];
    assert_eq!(absent.progress.waiting, Some(Waiting::Devices { links, ends_in_s: None }));

    let (_, serving) = tcp(simulator, address).await.unwrap();
    let serving = tokio::spawn(serving);
    let is_ready =
        |now: &Snapshot| matches!(now.progress.waiting, Some(Waiting::FirstTrigger { .. }));
    let ready = until(&mut snapshots, is_ready).await;
    let Some(Waiting::FirstTrigger { ends_in_s: Some(ends_in_s) }) = ready.progress.waiting else {
        panic!("{:?}", ready.progress.waiting);
    };
    assert!((0.0..=1.0).contains(&ends_in_s), "{ends_in_s}");
    assert_eq!((ready.state, ready.points.received), (State::Measuring, 0));

    let finished =
        timeout(Duration::from_secs(60), station.closed()).await.unwrap().unwrap().finished;
    let report = &finished.measurement.report;
    assert_eq!(report.session.as_ref().unwrap().ended, "idle");
    assert_eq!(report.verdict.status, Status::Undecided);
    let reason = "no trigger came, though every device was ready: start the scan sooner, or set [scan] first_s to more";
    assert!(report.verdict.reasons.iter().any(|found| found == reason), "{:?}", report.verdict);
    let ended = until(&mut snapshots, |now| now.outputs.is_some()).await;
    assert_eq!((ended.state, &ended.progress.waiting), (State::Complete, &None));
    let outputs = ended.outputs.as_ref().unwrap();
    assert_eq!(
        (&outputs.files[..], &outputs.problem),
        (&["report.json", "report.html", "qif.xml"].map(str::to_owned)[..], &None)
    );

    // The command runs beside the station.
    let folder = finished.recording.as_ref().unwrap();
    let told = async {
        loop {
            match std::fs::read_to_string(folder.join("told")) {
                Ok(told) if !told.is_empty() => return told,
                _ => tokio::time::sleep(Duration::from_millis(20)).await,
            }
        }
    };
    let told = timeout(Duration::from_secs(60), told).await.unwrap();
    assert_eq!(told, format!("undecided {}", report.session.as_ref().unwrap().id));

    // The replay has its end from the recording.
    let mut again = crate::replay::replay(folder, |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
    serving.abort();
}

#[tokio::test]
async fn a_device_that_connects_and_says_nothing_ends_the_session_too() {
    let folder = tempfile::tempdir().unwrap();
    let listening = tokio::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
    let address = listening.local_addr().unwrap();
    let silent = tokio::spawn(async move {
        let mut sockets = Vec::new();
        while let Ok((socket, _)) = listening.accept().await {
            sockets.push(socket);
        }
    });
    let recordings = folder.path().to_str().unwrap();
    let config = station(&address.to_string(), recordings, "idle_s = 0.5\nfirst_s = 1.0");
    let mut station = Station::start(config).unwrap();
    let mut snapshots = station.handle().watch();
    station.handle().session(Command::Start).await.unwrap();
    let is_ending = |now: &Snapshot| {
        matches!(now.progress.waiting, Some(Waiting::Devices { ends_in_s: Some(_), .. }))
    };
    until(&mut snapshots, is_ending).await;
    let finished =
        timeout(Duration::from_secs(60), station.closed()).await.unwrap().unwrap().finished;
    let report = &finished.measurement.report;
    assert_eq!(report.session.as_ref().unwrap().ended, "idle");
    let reason = "no trigger came: probe gave no answer since its link opened";
    assert!(report.verdict.reasons.iter().any(|found| found.starts_with(reason)), "{report:?}");
    let ended = until(&mut snapshots, |now| now.state == State::Complete).await;
    assert!(ended.elapsed_s >= 1.0, "{}", ended.elapsed_s);
    // The replay has the same words.
    let mut again = crate::replay::replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
    silent.abort();
}

#[tokio::test]
async fn a_link_that_never_opens_ends_the_session_where_that_is_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let listening = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let address = listening.local_addr().unwrap().to_string();
    drop(listening);
    let recordings = folder.path().to_str().unwrap();
    let config = station(&address, recordings, "idle_s = 0.5\nopen_s = 1.0");
    let mut station = Station::start(config).unwrap();
    station.handle().session(Command::Start).await.unwrap();
    let finished =
        timeout(Duration::from_secs(60), station.closed()).await.unwrap().unwrap().finished;
    let report = &finished.measurement.report;
    assert_eq!(report.session.as_ref().unwrap().ended, "idle");
    let reason = "no trigger came: the link probe did not open. ";
    assert!(report.verdict.reasons.iter().any(|found| found.starts_with(reason)), "{report:?}");
    let mut again = crate::replay::replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
}

/// A GPS receiver at an address of its own.
async fn gps_receiver() -> (std::net::SocketAddr, tokio::task::JoinHandle<()>) {
    let listening = tokio::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
    let address = listening.local_addr().unwrap();
    let receiver = tokio::spawn(async move {
        while let Ok((mut socket, _)) = listening.accept().await {
            tokio::spawn(async move {
                while socket.write_all(b"$GPGGA,123519,4807.038,N,01131.000,E\r\n").await.is_ok() {
                    tokio::time::sleep(Duration::from_millis(20)).await;
                }
            });
        }
    });
    (address, receiver)
}

/// The verdict of a session with another device at the address of the probe says that bytes came.
#[tokio::test]
async fn a_session_with_another_device_says_what_came() {
    let folder = tempfile::tempdir().unwrap();
    let (address, receiver) = gps_receiver().await;
    let recordings = folder.path().to_str().unwrap();
    let config = station(&address.to_string(), recordings, "idle_s = 0.5\nfirst_s = 1.0");
    let mut station = Station::start(config).unwrap();
    station.handle().session(Command::Start).await.unwrap();
    let finished =
        timeout(Duration::from_secs(60), station.closed()).await.unwrap().unwrap().finished;
    let report = &finished.measurement.report;
    let is_said = |reason: &String| {
        reason.starts_with("no trigger came: probe sent ")
            && reason.ends_with(" bytes and no telegram: wrong device or baud rate?")
    };
    assert!(report.verdict.reasons.iter().any(is_said), "{:?}", report.verdict);
    let mut again = crate::replay::replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
    receiver.abort();
}

#[tokio::test]
async fn a_link_to_another_device_says_what_came() {
    let folder = tempfile::tempdir().unwrap();
    let (address, receiver) = gps_receiver().await;
    let config = station(&address.to_string(), folder.path().to_str().unwrap(), "");
    let station = Station::start(config).unwrap();
    let mut snapshots = station.handle().watch();
    station.handle().watch_links().await;
    let said = |now: &Snapshot| {
        let error = now.links.first().and_then(|link| link.last_error.clone()).unwrap_or_default();
        error.contains(" bytes of text, no telegram: wrong device or baud rate?")
    };
    until(&mut snapshots, said).await;
    receiver.abort();
}

#[tokio::test]
async fn points_are_recorded_while_processing_is_behind_and_the_snapshot_says_by_how_much() {
    const POINTS: u64 = 3000;
    let folder = tempfile::tempdir().unwrap();
    let simulator = Simulator::new(Device::new(3000.0), 64);
    let (address, serving) = tcp(simulator.clone(), (Ipv4Addr::LOCALHOST, 0).into()).await.unwrap();
    let serving = tokio::spawn(serving);
    let recordings = folder.path().to_str().unwrap();
    let config = station(&address.to_string(), recordings, "idle_s = 600\nfirst_s = 600");
    let mut station = Station::start(config).unwrap();
    let mut snapshots = station.handle().watch();
    station.handle().session(Command::Start).await.unwrap();
    let is_ready =
        |now: &Snapshot| matches!(now.progress.waiting, Some(Waiting::FirstTrigger { .. }));
    until(&mut snapshots, is_ready).await;

    let (goes_on, stands) = std::sync::mpsc::channel();
    let handle = station.handle();
    handle.control.send(Control::Asked(Asked::Stand(stands))).await.unwrap();
    for exposure_count in 0..POINTS {
        let encoder = [(exposure_count % 50) as i32 * 20, 0, 0, 0, 0];
        simulator.trigger(Sample { exposure_count, encoder, ..Sample::default() }).await.unwrap();
    }
    let all_wait = |now: &Snapshot| {
        now.progress.backlog.is_some_and(|backlog| backlog.waiting_points == POINTS)
    };
    let behind = until(&mut snapshots, all_wait).await;
    // All of them were read, and none was worked on.
    assert_eq!((behind.links[0].readings, behind.points.received), (POINTS, 0));
    let backlog = behind.progress.backlog.unwrap();
    assert!(backlog.behind_s >= 0.5, "{backlog}");
    let words = format!("{backlog}");
    assert!(words.ends_with(" s behind: 3000 points are recorded and wait"), "{words}");

    drop(goes_on);
    let caught_up =
        |now: &Snapshot| now.points.received == POINTS && now.progress.backlog.is_none();
    until(&mut snapshots, caught_up).await;
    station.handle().session(Command::Stop).await.unwrap();
    let finished =
        timeout(Duration::from_secs(60), station.closed()).await.unwrap().unwrap().finished;
    let report = &finished.measurement.report;
    assert_eq!((report.points.received, report.points.lost), (POINTS, 0));
    let mut again = crate::replay::replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
    serving.abort();
}
