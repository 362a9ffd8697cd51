//! A RIFTEK RF60x laser sensor: its stream, or answers to questions.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asphera_riftek::wire::{FULL_RANGE, result_of};
use asphera_riftek::{Mode, Settings};
use asphera_sim_riftek::Sensor;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep};

use crate::connection::{QUEUE, Talker};
use crate::showing::Showing;

/// The value that is read where this one is measured: results are whole.
pub(crate) fn shown(settings: &Settings, value: f64) -> f64 {
    let result = result_of(value, settings.range_mm);
    f64::from(result) * f64::from(settings.range_mm) / f64::from(FULL_RANGE)
}

/// Smallest and largest distance, mm: the ends of the range are no values.
pub(crate) fn range(settings: &Settings) -> (f64, f64) {
    let range_mm = f64::from(settings.range_mm);
    let step_mm = range_mm / f64::from(FULL_RANGE);
    (step_mm, range_mm - step_mm)
}

/// The sensor at work.
pub(crate) struct Rf60x {
    device: usize,
    is_asked: bool,
    showing: Arc<Showing>,
    /// To the connection. While the host does not read, the scan waits.
    sent: mpsc::Sender<Vec<u8>>,
    state: Mutex<State>,
}

struct State {
    sensor: Sensor,
    has_host: bool,
    /// Answers to this host.
    answers: u64,
    /// When it measured last.
    measured: Instant,
}

impl Rf60x {
    /// A sensor, and what it sends by itself.
    pub(crate) fn new(
        device: usize,
        settings: &Settings,
        showing: Arc<Showing>,
    ) -> (Arc<Rf60x>, mpsc::Receiver<Vec<u8>>) {
        let (sent, queue) = mpsc::channel(QUEUE);
        let sensor = Sensor::new(settings);
        let state = State { sensor, has_host: false, answers: 0, measured: Instant::now() };
        let is_asked = matches!(settings.mode, Mode::Poll { .. });
        let state = Mutex::new(state);
        (Arc::new(Rf60x { device, is_asked, showing, sent, state }), queue)
    }

    /// Whether it sends by itself.
    pub(crate) fn is_triggered(&self) -> bool {
        !self.is_asked
    }

    pub(crate) fn is_armed(&self) -> bool {
        let state = self.state();
        state.has_host
            && match self.is_asked {
                // The first one says who it is.
                true => state.answers > 1,
                false => state.sensor.is_streaming(),
            }
    }

    /// Measures, and sends the result where a stream runs.
    pub(crate) async fn trigger(&self, trigger: u64) {
        // The connection ends with the stand.
        let Ok(permit) = self.sent.reserve().await else { return };
        let mut state = self.state();
        if self.is_asked || !state.has_host {
            return;
        }
        let distance_mm = self.showing.at(self.device, trigger).first().copied();
        state.sensor.measure(distance_mm);
        state.measured = Instant::now();
        if let Some(bytes) = state.sensor.stream() {
            permit.send(bytes);
        }
    }

    /// Says the last result again while no trigger comes, as a stream does.
    pub(crate) async fn repeat(&self) {
        loop {
            sleep(REPEAT).await;
            let Ok(permit) = self.sent.reserve().await else { return };
            let mut state = self.state();
            if !state.has_host || state.measured.elapsed() < REPEAT {
                continue;
            }
            if let Some(bytes) = state.sensor.stream() {
                permit.send(bytes);
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Whoever panicked left whole values.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Talker for Rf60x {
    fn connected(&self) {
        let mut state = self.state();
        (state.has_host, state.answers) = (true, 0);
    }

    fn hear(&self, bytes: &[u8]) -> Vec<u8> {
        let mut state = self.state();
        if self.is_asked {
            let distance_mm = self.showing.now(self.device).first().copied();
            state.sensor.measure(distance_mm);
        }
        let answers = state.sensor.receive(bytes);
        state.answers += u64::from(!answers.is_empty());
        answers
    }

    fn disconnected(&self) {
        let mut state = self.state();
        state.sensor.disconnected();
        state.has_host = false;
    }
}

/// Between two answers of a stream without a trigger.
const REPEAT: Duration = Duration::from_millis(200);
