//! Points that are recorded and wait for the pipeline: how many, since when, and how many may.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asphera_link::Nanos;
use asphera_report::Backlog;
use tokio::sync::Semaphore;

use crate::clock::Clock;
use crate::station::Point;

/// Count of the points between the core, which hands over, and the pipeline, which takes. Clones are the same.
#[derive(Clone)]
pub(super) struct Waiting {
    shared: Arc<Shared>,
}

struct Shared {
    /// One permit for each point that may still wait.
    room: Semaphore,
    /// Points handed over since the start.
    handed: AtomicU64,
    /// Points that the pipeline has taken.
    taken: AtomicU64,
    /// When the first of the points was read that the pipeline works on, or worked on last.
    working_on_ns: AtomicU64,
}

impl Waiting {
    pub(super) fn new() -> Waiting {
        let shared = Shared {
            room: Semaphore::new(POINTS),
            handed: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            working_on_ns: AtomicU64::new(0),
        };
        Waiting { shared: Arc::new(shared) }
    }

    /// Waits until there is room for a batch, and counts it.
    pub(super) async fn hand_over(&self, points: &[Point]) {
        // The semaphore is never closed. A batch larger than all the room takes all of it.
        if let Ok(permits) = self.shared.room.acquire_many(permits_of(points)).await {
            permits.forget();
        }
        self.shared.handed.fetch_add(points.len() as u64, Ordering::Relaxed);
    }

    /// The pipeline works on a batch from now on.
    pub(super) fn begin(&self, points: &[Point]) {
        if let Some(first) = points.first() {
            self.shared.working_on_ns.store(first.host.as_nanos(), Ordering::Relaxed);
        }
    }

    /// The pipeline has taken a batch.
    pub(super) fn taken(&self, points: &[Point]) {
        self.shared.taken.fetch_add(points.len() as u64, Ordering::Relaxed);
        self.shared.room.add_permits(permits_of(points) as usize);
    }

    /// Points handed over since the start.
    pub(super) fn handed(&self) -> u64 {
        self.shared.handed.load(Ordering::Relaxed)
    }

    /// Points that wait now; those of the batch that the pipeline works on are among them.
    pub(super) fn points(&self) -> u64 {
        let taken = self.shared.taken.load(Ordering::Relaxed);
        self.handed().saturating_sub(taken)
    }

    /// Points that wait and for how long; `None` where processing keeps up.
    pub(super) fn backlog(&self, clock: &Clock) -> Option<Backlog> {
        let waiting_points = self.points();
        let since = Nanos::from_nanos(self.shared.working_on_ns.load(Ordering::Relaxed));
        let behind_s = clock.now().since(since).as_secs_f64();
        (waiting_points > 0 && behind_s >= BEHIND_S).then_some(Backlog { waiting_points, behind_s })
    }
}

fn permits_of(points: &[Point]) -> u32 {
    points.len().min(POINTS) as u32
}

/// Points that may wait, 80 bytes each: 336 MB, and 8 s of 500,000 points a second. Worked on they take more memory than that.
const POINTS: usize = 1 << 22;
/// Shorter delays are those of the work itself.
const BEHIND_S: f64 = 0.5;

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use asphera_link::Flags;
    use tokio::time::timeout;

    use super::*;

    fn points(count: usize, host: Nanos) -> Vec<Point> {
        let position_mm = [0.0; 3];
        vec![
            Point { count: None, host, position_mm, flags: Flags::empty(), u_mm: position_mm };
            count
        ]
    }

    #[tokio::test]
    async fn what_waits_is_counted_and_bounded() {
        let (clock, waiting) = (Clock::start(), Waiting::new());
        let batch = points(POINTS / 2, Nanos::ZERO);
        waiting.hand_over(&batch).await;
        waiting.hand_over(&batch).await;
        assert_eq!((waiting.handed(), waiting.points()), (POINTS as u64, POINTS as u64));
        let one_more = points(1, Nanos::ZERO);
        let short = Duration::from_millis(20);
        assert!(timeout(short, waiting.hand_over(&one_more)).await.is_err(), "it is full");
        waiting.begin(&batch);
        waiting.taken(&batch);
        waiting.hand_over(&one_more).await;
        assert_eq!(waiting.points(), POINTS as u64 / 2 + 1);
        // A batch that is larger than all the room waits for all of it, and for no more.
        waiting.taken(&batch);
        waiting.taken(&one_more);
        waiting.hand_over(&points(POINTS + 1, Nanos::ZERO)).await;
        assert_eq!(waiting.points(), POINTS as u64 + 1);
        waiting.taken(&points(POINTS + 1, Nanos::ZERO));
        assert_eq!((waiting.points(), waiting.backlog(&clock)), (0, None));
    }

    #[tokio::test]
    async fn a_backlog_counts_from_when_its_first_point_was_read() {
        let (clock, waiting) = (Clock::start(), Waiting::new());
        let early = points(3, clock.now());
        waiting.begin(&early);
        waiting.hand_over(&early).await;
        assert_eq!(waiting.backlog(&clock), None, "that is no delay yet");
        tokio::time::sleep(Duration::from_millis(600)).await;
        let backlog = waiting.backlog(&clock).unwrap();
        assert_eq!(backlog.waiting_points, 3);
        assert!((0.6..60.0).contains(&backlog.behind_s), "{}", backlog.behind_s);
        let late = points(2, clock.now());
        waiting.hand_over(&late).await;
        waiting.taken(&early);
        waiting.begin(&late);
        assert_eq!((waiting.points(), waiting.backlog(&clock)), (2, None), "it catches up");
    }
}
