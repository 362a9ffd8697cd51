//! `asphera run`: a station until a signal.

use asphera_link::Command;
use clap::Args;

use super::ConfigArgs;
use super::check::is_nominal;
use super::exit::Exit;
use super::notify;
use super::outlet::Outlet;
use super::output::{Failure, complain, say};
use super::serve::{Page, block_on, interrupted, stop_session};
use super::summary::summary;
use super::token::TokenArgs;
use super::usage::misused;
use crate::config::Config;
use crate::live::{Closed, Station, StationError};

#[derive(Args)]
pub(super) struct RunArgs {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    token: TokenArgs,
    /// Measure one session at once, then end with the exit code of its verdict. Links that do not open end it after
    /// `[scan] open_s`, or else `first_s`.
    #[arg(long)]
    once: bool,
    /// Arm the scan of [scan.plan], or the program of a machine, as soon as the first session runs: it moves.
    #[arg(long)]
    arm: bool,
}

pub(super) fn run(args: &RunArgs) -> Result<Exit, Failure> {
    let path = &args.config.config;
    if is_nominal(path) {
        let name = path.display();
        return Err(format!("{name} is a nominal file: expected the configuration of a station. `asphera measure POINTS --nominal {name}` measures against it").into());
    }
    let mut config = Config::load(path)?;
    if args.once {
        // Nobody may be there to plug a device in.
        config.end.open = config.end.open.or(config.end.first);
    }
    block_on(station(config, args))
}

async fn station(config: Config, args: &RunArgs) -> Result<Exit, Failure> {
    let (listen, hosts) = (config.listen, config.allowed_hosts.clone());
    let autostart = config.autostart || args.once;
    if args.arm && config.scan.is_none() && config.program.is_none() {
        return Err(misused(
            "--arm: expected a table [scan.plan] in the configuration, or a device with a program, found neither: there is no scan to arm",
        ));
    }
    if args.arm && !autostart {
        return Err(misused(
            "--arm: expected a session that starts with the daemon, found [station] autostart = false: add --once, or arm on the page",
        ));
    }
    let mut station = Station::start(config)?;
    // The page first: a port that is taken must not leave a recording behind.
    let page = Page::serve(station.handle(), listen, hosts, args.token.token()?).await?;
    if autostart {
        station.handle().session(Command::Start).await?;
        if args.arm {
            station.handle().arm_scan().await?;
        }
    } else {
        station.handle().watch_links().await;
    }
    notify::ready(page.url());
    let watchdog = notify::watch(station.handle().beats());
    let mut stop = std::pin::pin!(interrupted());
    let mut exit = Exit::Done;
    let mut outlet = Outlet::default();
    loop {
        tokio::select! {
            closed = station.closed() => match closed {
                Ok(closed) => {
                    show(&closed, &mut outlet);
                    if args.once {
                        exit = exit_of(&closed);
                        tokio::select! {
                            _ = async { tokio::join!(station.commands_ended(), outlet.read()) } => {}
                            signal = &mut stop => signal?,
                        }
                        break;
                    }
                }
                Err(StationError::Ended) => return Err(StationError::Ended.into()),
                Err(error) if args.once => return Err(error.into()),
                Err(error) => complain(&error.into()),
            },
            signal = &mut stop => {
                signal?;
                break;
            }
        }
    }
    notify::stopping();
    let stopped = stop_session(&mut station).await;
    page.close().await?;
    watchdog.abort();
    if station.commands() > 0 {
        say("the command of [output] still runs; asphera does not wait for it");
    }
    if let Some(closed) = stopped? {
        show(&closed, &mut outlet);
        if args.once {
            exit = exit_of(&closed);
        }
    }
    outlet.close().await;
    Ok(exit)
}

/// A part that passed without the report that was asked for is no success: somebody waits for the file.
fn exit_of(closed: &Closed) -> Exit {
    match Exit::of(&closed.finished.measurement.report) {
        Exit::Done if closed.outputs.problem.is_some() => Exit::Failed,
        verdict => verdict,
    }
}

fn show(closed: &Closed, outlet: &mut Outlet) {
    let finished = &closed.finished;
    outlet.print(summary(&finished.measurement.report, false));
    match &finished.recording {
        Some(folder) => say(&format!("recording: {}", folder.display())),
        None => say("recording: not complete, see above"),
    }
    if let Some(problem) = &closed.outputs.problem {
        say(&format!("results: not written: {problem}"));
    }
}
