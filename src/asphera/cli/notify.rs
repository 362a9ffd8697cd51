//! Words to the service manager, where one started the daemon (sd_notify(3), systemd.service(5) `Type=notify`).
//!
//! Without one they go nowhere. One that cannot be reached is no reason to stop measuring: it is logged.

use sd_notify::NotifyState;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep_until};
use tracing::warn;

/// The page is served, and the links are open or being opened.
pub(super) fn ready(url: &str) {
    tell(&[NotifyState::Ready, NotifyState::Status(&format!("page: {url}"))]);
}

/// The end has begun; a session ends in good order first.
pub(super) fn stopping() {
    tell(&[NotifyState::Stopping]);
}

/// Feeds the watchdog of the unit, if it has one, as long as `beats` counts on: looked at four times in its period.
pub(super) fn watch(beats: watch::Receiver<u64>) -> JoinHandle<()> {
    tokio::spawn(async move {
        let Some(period) = sd_notify::watchdog_enabled() else { return };
        let mut last = None;
        loop {
            let now = Some(*beats.borrow());
            if now != last {
                tell(&[NotifyState::Watchdog]);
            } else {
                warn!("the station does not get on; the watchdog is not fed");
            }
            last = now;
            sleep_until(Instant::now() + period / 4).await;
        }
    })
}

fn tell(words: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(words) {
        warn!(%error, "cannot notify the service manager");
    }
}
