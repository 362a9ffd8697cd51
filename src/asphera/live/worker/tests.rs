//! A pipeline that does not keep up: what memory has no room for waits in a file, and comes back in its order.

use std::time::Duration;

use asphera_form::Nominal;
use asphera_link::Flags;
use asphera_measure::{Along, Part};
use tokio::time::timeout;

use super::*;

/// Points of a raster with waves, one after the other.
fn burst(points: u64, clock: &Clock) -> Vec<Point> {
    let (side, host) = (points.isqrt(), clock.now());
    let point = |k: u64| {
        let [x, y] = [k % side, k / side].map(|at| at as f64 * 0.1);
        let position_mm = [x, y, 1e-4 * (0.7 * x).sin() * (0.4 * y).cos()];
        Point { count: Some(k), host, position_mm, flags: Flags::empty(), u_mm: [0.0; 3] }
    };
    (0..points).map(point).collect()
}

fn worker(overflow: Overflow, clock: &Clock) -> Worker {
    let part = Part::new(Nominal::Plane);
    let weighing = Weighing::new(&part, None);
    let timed = (clock.clone(), overflow);
    Worker::start(part, (Along::default(), None, false), None, (None, None), weighing, timed)
        .expect("a thread")
}

/// A burst of forty times the room of memory, while the pipeline stands: nothing holds the links back, every point is in the mesh, and the
/// figures are those of a memory without end, bit for bit. How far processing was behind is said.
#[tokio::test]
async fn a_burst_beyond_all_memory_ends_with_every_point_in_the_mesh() {
    const ROOM: usize = 1000;
    const POINTS: u64 = 40_000;
    let folder = tempfile::tempdir().unwrap();
    let clock = Clock::start();
    let points = burst(POINTS, &clock);
    let mut reports = Vec::new();
    for room in [ROOM, usize::MAX >> 4] {
        let overflow = Overflow::beside(folder.path(), 0).beyond(room);
        let worker = worker(overflow.clone(), &clock);
        let (goes_on, stands) = std::sync::mpsc::channel();
        worker.stand(stands).await;
        for batch in points.chunks(300) {
            let handed = timeout(Duration::from_secs(30), worker.points(batch.to_vec()));
            assert!(handed.await.expect("nothing is held back").is_ok());
        }
        assert_eq!(overflow.is_waiting(), room == ROOM);
        sleep(Duration::from_millis(600)).await;
        let backlog = worker.backlog(&clock).expect("it is behind");
        assert_eq!(backlog.waiting_points, POINTS);
        drop(goes_on);
        // More come while it catches up, and a question for all so far.
        let late = burst(900, &clock);
        let late: Vec<Point> = late
            .iter()
            .map(|point| Point {
                position_mm: [-50.0 - point.position_mm[0], point.position_mm[1], 0.0],
                ..*point
            })
            .collect();
        assert!(worker.points(late).await.is_ok());
        let all = worker.assess().await.expect("figures");
        assert_eq!(all.points.received, POINTS + 900);
        let measured = worker.finish(Vec::new()).await.await.expect("a measurement");
        assert_eq!(measured.report.points.received, POINTS + 900);
        assert_eq!(measured.report.points.used, POINTS + 900);
        assert!(worker.most_behind_s() >= 0.6, "{}", worker.most_behind_s());
        assert!(!overflow.is_waiting());
        reports.push(measured.report);
    }
    assert_eq!(reports[0], reports[1], "the figures do not depend on the room");
}

/// Where the disk has no room either, the links are held back, as before, until the pipeline goes on; nothing is lost and nothing overtakes.
#[tokio::test]
async fn without_a_disk_the_links_are_held_back() {
    let folder = tempfile::tempdir().unwrap();
    let clock = Clock::start();
    let worker = worker(Overflow::beside(folder.path(), u64::MAX / 2).beyond(500), &clock);
    let (goes_on, stands) = std::sync::mpsc::channel();
    worker.stand(stands).await;
    let points = burst(1600, &clock);
    let mut batches = points.chunks(400);
    assert!(worker.points(batches.next().unwrap().to_vec()).await.is_ok());
    let mut held_back = Box::pin(worker.points(batches.next().unwrap().to_vec()));
    assert!(timeout(Duration::from_millis(300), &mut held_back).await.is_err(), "it is full");
    drop(goes_on);
    assert!(timeout(Duration::from_secs(30), held_back).await.unwrap().is_ok());
    for batch in batches {
        assert!(worker.points(batch.to_vec()).await.is_ok());
    }
    let measured = worker.finish(Vec::new()).await.await.expect("a measurement");
    assert_eq!(measured.report.points.used, 1600);
}
