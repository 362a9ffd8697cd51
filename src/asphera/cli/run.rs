//! `asphera run`: a station until a signal.

use asphera_link::Command;
use clap::Args;

use super::ConfigArgs;
use super::exit::Exit;
use super::notify;
use super::output::{Failure, complain, print, say};
use super::serve::{Page, interrupted, stop_session};
use super::summary;
use super::token::TokenArgs;
use crate::config::Config;
use crate::live::{Finished, Station, StationError};

#[derive(Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    token: TokenArgs,
}

pub(super) fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let config = Config::load(&args.config.config)?;
    tokio::runtime::Runtime::new()?.block_on(station(config, &args.token))
}

async fn station(config: Config, token: &TokenArgs) -> Result<Exit, Failure> {
    let (listen, hosts, autostart) =
        (config.listen, config.allowed_hosts.clone(), config.autostart);
    let mut station = Station::start(config)?;
    // The page first: a port that is taken must not leave a recording behind.
    let page = Page::serve(station.handle(), listen, hosts, token.token()?).await?;
    if autostart {
        station.handle().session(Command::Start).await?;
    } else {
        station.handle().watch_links().await;
    }
    notify::ready(page.url());
    let watchdog = notify::watch(station.handle().beats());
    let mut stop = std::pin::pin!(interrupted());
    loop {
        tokio::select! {
            finished = station.finished() => match finished {
                Ok(finished) => show(&finished),
                Err(StationError::Ended) => return Err(StationError::Ended.into()),
                Err(error) => complain(&error.into()),
            },
            signal = &mut stop => {
                signal?;
                break;
            }
        }
    }
    notify::stopping();
    if let Some(finished) = stop_session(&mut station).await? {
        show(&finished);
    }
    page.close().await?;
    watchdog.abort();
    Ok(Exit::Done)
}

fn show(finished: &Finished) {
    print(&summary::of(&finished.measurement.report));
    match &finished.recording {
        Some(folder) => say(&format!("recording: {}", folder.display())),
        None => say("recording: not complete, see above"),
    }
}
