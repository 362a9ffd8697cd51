//! `asphera demo`: a simulated part on a simulated bench, measured over real protocols.

pub(super) mod ct;
pub(super) mod tray;

use crate::cli::usage::misused;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use asphera_link::Command;
use asphera_rig::{Rig, Scene, StationOptions};
use clap::Args;
use tokio::time::interval;

use super::exit::Exit;
use super::outlet::Outlet;
use super::output::{Failure, clear_progress, figures, progress, refuse_results, say, write_json};
use super::serve::{Page, block_on, interrupted, stop_session};
use super::{OutputArgs, Speed};
use crate::config::Config;
use crate::live::{Finished, Handle, Station, check_unshared};
use crate::results;

#[derive(Args)]
pub(super) struct DemoArgs {
    /// What is simulated; an unknown name lists them.
    #[arg(long, value_name = "NAME", default_value = "asphere")]
    scene: String,
    /// How many points the scan has.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(100..=10_000_000))]
    points: Option<u64>,
    /// How many times as fast as the bench would really be, or max.
    #[arg(long, default_value = "1")]
    speed: Speed,
    /// Seed of the probe's noise.
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// End when the scan is complete; otherwise the page stays until Ctrl-C.
    #[arg(long)]
    exit: bool,
    #[command(flatten)]
    output: OutputArgs,
    /// Where the page is.
    #[arg(long, value_name = "ADDR")]
    listen: Option<SocketAddr>,
}

pub(super) fn run(args: DemoArgs) -> Result<Exit, Failure> {
    if args.scene == ct::NAME {
        return ct::run(args);
    }
    if args.scene == tray::NAME {
        return tray::run(args);
    }
    let Some(mut scene) = Scene::built_in(&args.scene) else {
        let names: Vec<_> = Scene::names().chain([ct::NAME, tray::NAME]).collect();
        return Err(misused(format!("no scene {:?}; there are {}", args.scene, names.join(", "))));
    };
    if let Some(points) = args.points {
        scene = scene.with_points(points);
    }
    if let Some(seed) = args.seed {
        scene = scene.with_seed(seed);
    }
    scene = scene.with_speed(match args.speed {
        Speed::Times(times) => asphera_rig::Speed::Times(times),
        Speed::Max => asphera_rig::Speed::Max,
    });
    block_on(demo(scene, args))
}

/// The folder of the results, made if it is not there and no other demo works in it.
fn folder_of(args: &mut DemoArgs) -> Result<PathBuf, Failure> {
    refuse_results(&args.output)?;
    let folder = args.output.out.clone().unwrap_or_else(default_folder);
    args.output.out = Some(folder.clone());
    std::fs::create_dir_all(&folder)
        .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    // Before the ports and the truth of another demo there are overwritten.
    check_unshared(&folder, "demo")?;
    Ok(folder)
}

/// Where the page is.
fn page_of(args: &DemoArgs) -> SocketAddr {
    // A demo that ends by itself takes any port, so that it never fails because one is taken.
    let usual = || ([127, 0, 0, 1], if args.exit { 0 } else { 7717 }).into();
    args.listen.unwrap_or_else(usual)
}

async fn demo(scene: Scene, mut args: DemoArgs) -> Result<Exit, Failure> {
    let folder = folder_of(&mut args)?;
    let ports = folder.join("ports");
    let rig = Rig::start(scene, &ports).await?;
    let truth = rig.truth();
    for listing in rig.listing() {
        say(&format!("simulated: {:<8} {:<13} {}", listing.name, listing.kind, listing.address));
    }
    let toml =
        rig.station_toml(&StationOptions { recordings: folder.clone(), listen: page_of(&args) });
    // The truth of a part that is measured: a demo whose address is taken leaves nothing.
    let begin = |_| write_json(&folder.join("truth.json"), &truth);
    let exit = measured(&toml, &args, &folder, begin).await;
    drop(rig);
    // Of a bench that has gone nothing remains; a folder with something else in it stays.
    let _ = std::fs::remove_dir(&ports);
    exit
}

/// Measures on a bench with its page, until the session or the user ends it. `begin` is called with the station before its first
/// session.
async fn measured(
    toml: &str,
    args: &DemoArgs,
    folder: &Path,
    begin: impl FnOnce(Handle) -> Result<(), Failure>,
) -> Result<Exit, Failure> {
    let config = Config::parse("the demo's configuration", toml)?;
    let (listen, hosts) = (config.listen, config.allowed_hosts.clone());
    let mut station = Station::start(config)?;
    let page = Page::serve(station.handle(), listen, hosts, None).await?;
    begin(station.handle())?;
    station.handle().session(Command::Start).await?;
    say(&format!("results: {}", folder.display()));

    let drawn = tokio::spawn(draw(station.handle()));
    let mut stop = std::pin::pin!(interrupted());
    let (first, interrupted) = tokio::select! {
        closed = station.closed() => (Some(closed?.finished), false),
        signal = &mut stop => {
            signal?;
            // The session ends in good order; what was measured is kept.
            (stop_session(&mut station).await?.map(|closed| closed.finished), true)
        }
    };
    drawn.abort();
    clear_progress();
    let Some(finished) = first else { return Err("stopped before the session began".into()) };
    let mut outlet = Outlet::default();
    let exit = finish(&finished, args, &mut outlet)?;
    if args.exit && !interrupted {
        tokio::select! {
            () = outlet.read() => {}
            signal = &mut stop => signal?,
        }
    } else if !interrupted {
        say("the page stays; Ctrl-C ends");
        loop {
            tokio::select! {
                again = station.closed() => results::write(folder, &again?.finished.measurement)?,
                signal = &mut stop => {
                    signal?;
                    break;
                }
            }
        }
        if let Some(closed) = stop_session(&mut station).await? {
            results::write(folder, &closed.finished.measurement)?;
        }
    }
    page.close().await?;
    outlet.close().await;
    Ok(exit)
}

fn finish(finished: &Finished, args: &DemoArgs, outlet: &mut Outlet) -> Result<Exit, Failure> {
    if let Some(folder) = &args.output.out {
        results::write(folder, &finished.measurement)?;
    }
    outlet.print(figures(&finished.measurement, &args.output)?);
    if finished.recording.is_none() {
        say("the recording is not complete");
    }
    Ok(Exit::of(&finished.measurement.report))
}

/// Draws the progress on a terminal.
async fn draw(station: Handle) {
    let snapshots = station.watch();
    let mut ticks = interval(Duration::from_millis(200));
    loop {
        ticks.tick().await;
        let snapshot = snapshots.borrow().clone();
        let percent = snapshot.progress.fraction.map_or(0.0, |fraction| 100.0 * fraction);
        let figures = snapshot.form.as_ref().map_or_else(String::new, |form| {
            format!(", PV {:.0} nm, RMS {:.1} nm", form.deviation.pv_nm, form.deviation.rms_nm)
        });
        progress(&format!("{percent:5.1} %  {} points{figures}", snapshot.points.received));
    }
}

fn default_folder() -> PathBuf {
    std::env::temp_dir().join(format!("asphera-demo-{}", std::process::id()))
}
