//! `asphera run`: a station until a signal.

use std::path::Path;
use std::time::Duration;

use asphera_link::Command;
use tokio::time::timeout;

use super::exit::Exit;
use super::output::{Failure, print, say};
use super::serve::{Page, interrupted};
use super::summary;
use crate::config::Config;
use crate::live::{Finished, Station};

pub(super) fn run(path: &Path) -> Result<Exit, Failure> {
    let config = Config::load(path)?;
    tokio::runtime::Runtime::new()?.block_on(station(config))
}

async fn station(config: Config) -> Result<Exit, Failure> {
    let (listen, hosts, autostart) =
        (config.listen, config.allowed_hosts.clone(), config.autostart);
    let mut station = Station::start(config, autostart)?;
    let page = Page::serve(station.handle(), listen, hosts).await?;
    let mut stop = std::pin::pin!(interrupted());
    loop {
        tokio::select! {
            finished = station.finished() => match finished {
                Some(finished) => show(&finished),
                None => break,
            },
            signal = &mut stop => {
                signal?;
                break;
            }
        }
    }
    // A running session is ended in good order, so that its recording says why it ended.
    let stopped = station.handle().session(Command::Stop).await.is_ok();
    if stopped && let Ok(Some(finished)) = timeout(STOP, station.finished()).await {
        show(&finished);
    }
    page.close().await?;
    Ok(Exit::Done)
}

fn show(finished: &Finished) {
    print(&summary::of(&finished.measurement.report));
    match &finished.recording {
        Some(folder) => say(&format!("recording: {}", folder.display())),
        None => say("recording: not complete, see above"),
    }
}

/// How long the figures of an interrupted session may take.
const STOP: Duration = Duration::from_secs(30);
