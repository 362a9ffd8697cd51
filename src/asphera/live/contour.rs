//! The contour of the running session: formed in a thread of its own, so that neither points nor figures wait for it.

use std::sync::Arc;
use std::thread::JoinHandle;

use asphera_contour::PlaceMm;
use asphera_link::Nanos;
use asphera_report::contour::{ContourReport, SessionContour};
use tokio::sync::watch;
use tracing::error;

use crate::contour::ContourPlan;
use crate::station::Point;

/// Gathers the places of points and has their contour formed when they grew by a quarter, one contour at a time and at
/// most a quarter of the time.
pub(super) struct Contours {
    plan: Arc<ContourPlan>,
    places: Vec<PlaceMm>,
    received: u64,
    next_at: usize,
    /// No contour is begun before.
    not_before: Nanos,
    running: Option<Running>,
    newest: watch::Sender<Option<Arc<SessionContour>>>,
}

/// A contour while it is formed.
struct Running {
    as_of_points: u64,
    began: Nanos,
    thread: JoinHandle<ContourReport>,
}

impl Contours {
    pub(super) fn new(
        plan: ContourPlan,
        newest: watch::Sender<Option<Arc<SessionContour>>>,
    ) -> Contours {
        Contours {
            plan: Arc::new(plan),
            places: Vec::new(),
            received: 0,
            next_at: FIRST,
            not_before: Nanos::ZERO,
            running: None,
            newest,
        }
    }

    pub(super) fn take(&mut self, points: &[Point]) {
        self.received += points.len() as u64;
        let good = points.iter().filter(|point| point.is_good());
        self.places.extend(good.filter_map(|point| self.plan.place(point.position_mm)));
    }

    /// Shows a contour that is done, and begins the next where there are enough new points.
    pub(super) fn keep_up(&mut self, now: Nanos) {
        let done = self.running.take_if(|running| running.thread.is_finished());
        if let Some(Running { as_of_points, began, thread }) = done {
            self.not_before = now + PAUSE * now.since(began);
            // A running contour that could not be formed is left out: the final one says why.
            if let Ok(contour) = thread.join() {
                self.newest.send_replace(Some(Arc::new(SessionContour {
                    as_of_points,
                    in_xy: self.plan.is_in_xy(),
                    contour,
                })));
            }
        }
        let is_due = self.places.len() >= self.next_at && now >= self.not_before;
        if self.running.is_none() && is_due {
            self.next_at = self.places.len() + self.places.len() / 4;
            let places = Arc::new(self.places.clone());
            let thread = spawn(self.plan.clone(), places);
            let as_of_points = self.received;
            self.running = thread.ok().map(|thread| Running { as_of_points, began: now, thread });
        }
    }

    /// Begins the final contour, of all points.
    pub(super) fn finish(self) -> FinalContour {
        let Contours { plan, places, .. } = self;
        let places = Arc::new(places);
        let thread = spawn(plan.clone(), places.clone());
        FinalContour { plan, places, thread }
    }
}

/// The final contour of a session, while it is formed.
pub(super) struct FinalContour {
    plan: Arc<ContourPlan>,
    places: Arc<Vec<PlaceMm>>,
    thread: std::io::Result<JoinHandle<ContourReport>>,
}

impl FinalContour {
    /// Waits for the contour. It is never absent: what went wrong stands in it.
    pub(super) fn wait(self) -> (Arc<ContourPlan>, ContourReport) {
        let FinalContour { plan, places, thread } = self;
        let contour = match thread.map(JoinHandle::join) {
            Ok(Ok(contour)) => contour,
            Ok(Err(_)) => {
                error!("the contour could not be formed: its thread broke off");
                plan.unknown(&places, "it could not be formed: see the log")
            }
            Err(error) => plan.unknown(&places, &format!("no thread could be started: {error}")),
        };
        (plan, contour)
    }
}

/// Starts a thread with a pool of its own: in the common one the mesh would wait for a contour.
fn spawn(
    plan: Arc<ContourPlan>,
    places: Arc<Vec<PlaceMm>>,
) -> std::io::Result<JoinHandle<ContourReport>> {
    std::thread::Builder::new().name("contour".to_owned()).spawn(move || {
        match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
            Ok(pool) => pool.install(|| plan.contour(&places)),
            Err(_) => plan.contour(&places),
        }
    })
}

/// So many times as long as a contour took the next one is not begun, for it may use a processor that links and mesh need.
const PAUSE: u32 = 3;

/// Fewer places show little of a curve: before them no contour is formed but the final one.
const FIRST: usize = 100;
