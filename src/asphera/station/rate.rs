//! How fast the trigger runs.

use std::time::Duration;

use asphera_link::Nanos;

/// Triggers a second, from the primary's counts, over windows of at least 50 ms.
#[derive(Debug, Default)]
pub(crate) struct Rate {
    window: Option<(u64, Nanos)>,
    pub(crate) hz: f64,
    /// The highest there was.
    pub(crate) peak_hz: f64,
}

impl Rate {
    /// Takes the count of a reading that arrived at `host`.
    pub(crate) fn take(&mut self, count: u64, host: Nanos) {
        let Some((from, since)) = self.window else {
            self.window = Some((count, host));
            return;
        };
        let span = host.since(since);
        if span >= Duration::from_millis(50) {
            self.hz = count.saturating_sub(from) as f64 / span.as_secs_f64();
            self.peak_hz = self.peak_hz.max(self.hz);
            self.window = Some((count, host));
        }
    }
}
