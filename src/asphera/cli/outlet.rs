//! What a daemon prints on stdout: a reader that does not read holds nothing up.

use std::time::Duration;

use tokio::task::{JoinHandle, spawn_blocking};
use tokio::time::timeout;

use super::output::{print, say};

/// The way to stdout, one text at a time.
#[derive(Default)]
pub(super) struct Outlet {
    printing: Option<JoinHandle<()>>,
}

impl Outlet {
    /// Begins to print a text, on a thread of its own. Where the text before is not read yet, this one is left out, and stderr says so.
    pub(super) fn print(&mut self, text: String) {
        if self.printing.as_ref().is_some_and(|printing| !printing.is_finished()) {
            say(
                "nobody reads stdout: a summary was left out; the page shows it, and `asphera replay` of the recording",
            );
            return;
        }
        self.printing = Some(spawn_blocking(move || print(&text)));
    }

    /// Waits until all was read.
    pub(super) async fn read(&mut self) {
        if let Some(printing) = self.printing.as_mut() {
            // A printer that panicked has printed what it could.
            let _ = printing.await;
            self.printing = None;
        }
    }

    /// Waits for a reader that is there, as at the end of a daemon.
    pub(super) async fn close(mut self) {
        if timeout(READER, self.read()).await.is_err() {
            say("nobody reads stdout: the last figures were not printed");
        }
    }
}

/// How long a reader may take for the last text. It counts among the 5 s in which a signal ends a station.
const READER: Duration = Duration::from_millis(300);
