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
    /// Longest delay that was seen, ns.
    most_behind_ns: AtomicU64,
    /// Points that memory has room for.
    points: usize,
}

impl Waiting {
    /// Room for as many points as memory is to hold: [`POINTS`], less in tests.
    pub(super) fn with_room(points: usize) -> Waiting {
        let shared = Shared {
            room: Semaphore::new(points),
            handed: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            working_on_ns: AtomicU64::new(0),
            most_behind_ns: AtomicU64::new(0),
            points,
        };
        Waiting { shared: Arc::new(shared) }
    }

    /// Counts a batch where there is room for it. A batch larger than all the room takes all of it.
    pub(super) fn try_hand_over(&self, points: &[Point]) -> bool {
        let Ok(permits) = self.shared.room.try_acquire_many(self.permits_of(points)) else {
            return false;
        };
        permits.forget();
        self.hand_aside(points);
        true
    }

    /// Counts a batch that waits elsewhere than in memory.
    pub(super) fn hand_aside(&self, points: &[Point]) {
        self.shared.handed.fetch_add(points.len() as u64, Ordering::Relaxed);
    }

    /// The pipeline has taken a batch that waited elsewhere.
    pub(super) fn taken_aside(&self, points: &[Point]) {
        self.shared.taken.fetch_add(points.len() as u64, Ordering::Relaxed);
    }

    /// Waits until there is room for a batch, and counts it.
    pub(super) async fn hand_over(&self, points: &[Point]) {
        // The semaphore is never closed. A batch larger than all the room takes all of it.
        if let Ok(permits) = self.shared.room.acquire_many(self.permits_of(points)).await {
            permits.forget();
        }
        self.hand_aside(points);
    }

    /// The pipeline works on a batch from now on.
    pub(super) fn begin(&self, points: &[Point]) {
        if let Some(first) = points.first() {
            self.shared.working_on_ns.store(first.host.as_nanos(), Ordering::Relaxed);
        }
    }

    /// The pipeline has taken a batch.
    pub(super) fn taken(&self, points: &[Point]) {
        self.taken_aside(points);
        self.shared.room.add_permits(self.permits_of(points) as usize);
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
        let behind = clock.now().since(since);
        let behind_s = behind.as_secs_f64();
        if waiting_points > 0 {
            let behind_ns = u64::try_from(behind.as_nanos()).unwrap_or(u64::MAX);
            self.shared.most_behind_ns.fetch_max(behind_ns, Ordering::Relaxed);
        }
        (waiting_points > 0 && behind_s >= BEHIND_S).then_some(Backlog { waiting_points, behind_s })
    }

    /// Longest delay of the processing so far, s; 0 where it was that of the work itself.
    pub(super) fn most_behind_s(&self) -> f64 {
        let most_ns = self.shared.most_behind_ns.load(Ordering::Relaxed);
        let most_s = Nanos::from_nanos(most_ns).as_secs_f64();
        if most_s >= BEHIND_S { most_s } else { 0.0 }
    }

    fn permits_of(&self, points: &[Point]) -> u32 {
        points.len().min(self.shared.points) as u32
    }
}

/// Points that may wait, 80 bytes each: 336 MB, and 8 s of 500,000 points a second. Worked on they take more memory than that.
pub(super) const POINTS: usize = 1 << 22;
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
        let (clock, waiting) = (Clock::start(), Waiting::with_room(POINTS));
        let batch = points(POINTS / 2, Nanos::ZERO);
        waiting.hand_over(&batch).await;
        waiting.hand_over(&batch).await;
        assert_eq!((waiting.handed(), waiting.points()), (POINTS as u64, POINTS as u64));
        let one_more = points(1, Nanos::ZERO);
        let short = Duration::from_millis(20);
        assert!(timeout(short, waiting.hand_over(&one_more)).await.is_err(), "it is full");
        assert!(!waiting.try_hand_over(&one_more));
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
        let (clock, waiting) = (Clock::start(), Waiting::with_room(POINTS));
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
