//! Progress of a long command: one line on a terminal, drawn over the one before, and cleared at the end.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use asphera_link::Nanos;

use super::output;
use crate::clock::Clock;
use asphera_measure::Step;

/// The progress of one command. Without a terminal on stderr it does nothing.
///
/// A thread of its own draws, so that the time moves on while one step takes long. Dropping it clears the line.
pub(super) struct Progress {
    shared: Arc<Shared>,
    drawer: Option<JoinHandle<()>>,
}

struct Shared {
    verb: &'static str,
    clock: Clock,
    stage: Mutex<Stage>,
    done: AtomicU64,
    has_ended: AtomicBool,
}

/// What is being done.
#[derive(Clone, Debug, Default, PartialEq)]
struct Stage {
    what: String,
    /// Whether points are counted, and how many there are in all.
    counts: Option<Option<u64>>,
    since: Nanos,
}

impl Progress {
    /// Starts to show the progress of a command.
    pub(super) fn start(verb: &'static str) -> Progress {
        let shared = Arc::new(Shared {
            verb,
            clock: Clock::start(),
            stage: Mutex::default(),
            done: AtomicU64::new(0),
            has_ended: AtomicBool::new(false),
        });
        let drawn = shared.clone();
        // Without a thread there is no line; the command itself goes on.
        let drawer = output::draws_progress()
            .then(move || {
                std::thread::Builder::new().name("progress".to_owned()).spawn(move || draw(&drawn))
            })
            .and_then(Result::ok);
        Progress { shared, drawer }
    }

    /// Says what is being done from now on.
    pub(super) fn stage(&self, what: impl Into<String>) {
        self.begin(what.into(), None);
    }

    /// Says what is being done with points, which [`Progress::add`] counts; `total` is how many there are.
    pub(super) fn count(&self, what: impl Into<String>, total: Option<u64>) {
        self.begin(what.into(), Some(total));
    }

    /// Says which step of the final figures is made.
    pub(super) fn step(&self, step: Step) {
        self.stage(step.words());
    }

    /// Counts points that are done.
    pub(super) fn add(&self, points: u64) {
        self.shared.done.fetch_add(points, Ordering::Relaxed);
    }

    fn begin(&self, what: String, counts: Option<Option<u64>>) {
        let since = self.shared.clock.now();
        let mut stage = self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner);
        self.shared.done.store(0, Ordering::Relaxed);
        *stage = Stage { what, counts, since };
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        let Some(drawer) = self.drawer.take() else { return };
        self.shared.has_ended.store(true, Ordering::Relaxed);
        drawer.thread().unpark();
        // A drawer that panicked has nothing left to clear.
        let _ = drawer.join();
        output::clear_progress();
    }
}

fn draw(shared: &Shared) {
    // A command that is done at once shows nothing.
    std::thread::park_timeout(FIRST);
    while !shared.has_ended.load(Ordering::Relaxed) {
        let stage = shared.stage.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let done = shared.done.load(Ordering::Relaxed);
        output::progress(&line(shared.verb, &stage, done, shared.clock.now()));
        std::thread::park_timeout(PERIOD);
    }
}

/// The line as a person reads it: verb, what is done, count, rate and the time since the start.
fn line(verb: &str, stage: &Stage, done: u64, now: Nanos) -> String {
    let mut text = format!("{verb}: {}", stage.what);
    if let Some(total) = stage.counts {
        text.push_str(&format!(" {}", grouped(done)));
        if let Some(total) = total {
            text.push_str(&format!(" of {}", grouped(total)));
        }
        text.push_str(" points");
        let took_s = now.since(stage.since).as_secs_f64();
        if done > 0 && took_s > 0.0 {
            text.push_str(&format!(", {}/s", grouped(rounded(done as f64 / took_s))));
        }
    }
    text.push_str(&format!(", {:.1} s", now.as_secs_f64()));
    // A line that wraps cannot be drawn over.
    text.chars().take(WIDTH).collect()
}

/// A rate with three digits that count.
fn rounded(rate: f64) -> u64 {
    let unit = 10_f64.powf(rate.max(1.0).log10().floor() - 2.0).max(1.0);
    ((rate / unit).round() * unit) as u64
}

/// A number with commas between its thousands.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Before this nothing is drawn.
const FIRST: Duration = Duration::from_millis(300);
/// How often the line is drawn.
const PERIOD: Duration = Duration::from_millis(150);
/// The narrowest terminal that is in use has 80 columns.
const WIDTH: usize = 79;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_names_verb_stage_count_rate_and_time() {
        let second = Nanos::from_nanos(1_000_000_000);
        let stage =
            Stage { what: "meshing".to_owned(), counts: Some(Some(3_000_000)), since: second };
        let at = Nanos::from_nanos(4_000_000_000);
        assert_eq!(
            line("measure", &stage, 1_234_567, at),
            "measure: meshing 1,234,567 of 3,000,000 points, 412,000/s, 4.0 s"
        );
        let stage = Stage { what: "sampling".to_owned(), ..Stage::default() };
        assert_eq!(line("measure", &stage, 0, at), "measure: sampling, 4.0 s");
        let long = Stage { what: "x".repeat(200), ..Stage::default() };
        assert_eq!(line("measure", &long, 0, at).len(), WIDTH);
    }

    #[test]
    fn numbers_have_commas_and_rates_three_digits() {
        let said = [0, 999, 1000, 12_345_678].map(grouped);
        assert_eq!(said, ["0", "999", "1,000", "12,345,678"]);
        assert_eq!([0.4, 12.6, 1234.5, 987_654.0].map(rounded), [0, 13, 1230, 988_000]);
    }
}
