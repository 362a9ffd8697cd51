//! `asphera simulate`: the simulators of a bench alone, the devices of a station, or a recorded session played back from the devices' side.

mod haste;
mod links;
mod path;
mod playback;
mod silence;
mod station;

use std::path::{Path, PathBuf};

use asphera_rig::{CmmRig, CmmScene, DriveRig, DriveScene, ProfilerRig, ProfilerScene, Rig, Scene};
use clap::{ArgGroup, Args};

use super::Speed;
use super::exit::Exit;
use super::files::toml_text;
use super::output::{Failure, print, say};
use super::serve::{block_on, interrupted};
use super::usage::misused;
use playback::Playback;
use station::{PartArgs, is_station, simulate};

#[derive(Args)]
#[command(group(ArgGroup::new("what").required(true).args(["rig", "session"])))]
pub(super) struct SimulateArgs {
    /// The bench, or the configuration of a station, whose devices are then simulated over a part of its nominal.
    rig: Option<PathBuf>,
    /// Where the names of the simulated serial ports are put.
    #[arg(long, value_name = "DIR", requires = "rig")]
    ports: Option<PathBuf>,
    /// Recorded session to play back as its devices: every byte they sent, each link at a TCP port.
    #[arg(long, value_name = "SESSION")]
    session: Option<PathBuf>,
    /// Write the configuration of a station whose links lead to the simulated devices into this new file.
    #[arg(long, value_name = "FILE")]
    station: Option<PathBuf>,
    #[command(flatten)]
    part: PartArgs,
    /// How many times as fast as it was recorded (1 unless given), or max: as fast as it is taken. Of a station with a program: as the
    /// usual machine.
    #[arg(long)]
    speed: Option<Speed>,
}

pub(super) fn run(args: &SimulateArgs) -> Result<Exit, Failure> {
    if let Some(station) = args.station.as_ref().filter(|station| station.exists()) {
        return Err(format!("{} is there already", station.display()).into());
    }
    match (&args.rig, &args.session) {
        (Some(rig), _) => bench(rig, args),
        (None, Some(session)) => block_on(play(session, args)),
        // The parser asks for one of them.
        (None, None) => Ok(Exit::Done),
    }
}

fn bench(rig: &Path, args: &SimulateArgs) -> Result<Exit, Failure> {
    let name = rig.display().to_string();
    let text = toml_text(rig)?;
    if is_station(&text) {
        return block_on(simulate(rig, &args.part, args.speed, args.station.as_deref()));
    }
    if args.speed.is_some() {
        return Err(misused(format!(
            "--speed: expected --session or a station with a program, found {name}, a bench: its file says how fast it is"
        )));
    }
    if args.station.is_some() {
        return Err(misused(format!(
            "--station: expected the configuration of a station or --session, found {name}, a bench: its configuration is in config/examples"
        )));
    }
    if let Some(scene) = DriveScene::parse(&name, &text) {
        return drive(scene?);
    }
    if let Some(scene) = CmmScene::parse(&name, &text) {
        return serve_machine(scene?);
    }
    if let Some(scene) = ProfilerScene::parse(&name, &text) {
        return profile(scene?);
    }
    let scene = Scene::parse(&name, &text)?;
    let ports = match &args.ports {
        Some(folder) => folder.clone(),
        None => std::env::temp_dir().join(format!("asphera-rig-{}", std::process::id())),
    };
    tokio::runtime::Runtime::new()?.block_on(async {
        let rig = Rig::start(scene, &ports).await?;
        for listing in rig.listing() {
            print(&format!("{:<10} {:<14} {}\n", listing.name, listing.kind, listing.address));
        }
        interrupted().await?;
        Ok(Exit::Done)
    })
}

/// A bench whose stage obeys the station.
fn drive(scene: DriveScene) -> Result<Exit, Failure> {
    tokio::runtime::Runtime::new()?.block_on(async {
        let title = scene.title().to_owned();
        let rig = DriveRig::start(scene).await?;
        let [gauge, stage] = rig.addresses();
        print(&format!("{:<10} {:<14} {gauge}\n", "gauge", "lines, TCP"));
        print(&format!("{:<10} {:<14} {stage}\n", "stage", rig.stage_words()));
        say(&format!("{title}; Ctrl-C ends it"));
        interrupted().await?;
        Ok(Exit::Done)
    })
}

/// A bench whose machine runs the program of the station.
fn serve_machine(scene: CmmScene) -> Result<Exit, Failure> {
    tokio::runtime::Runtime::new()?.block_on(async {
        let title = scene.title().to_owned();
        let rig = CmmRig::start(scene).await?;
        print(&format!("{:<10} {:<14} {}\n", "cmm", "I++ DME, TCP", rig.address()));
        say(&format!("{title}; Ctrl-C ends it"));
        interrupted().await?;
        Ok(Exit::Done)
    })
}

/// A bench with a laser profiler over a stage.
fn profile(scene: ProfilerScene) -> Result<Exit, Failure> {
    tokio::runtime::Runtime::new()?.block_on(async {
        let title = scene.title().to_owned();
        let rig = ProfilerRig::start(scene, &[]).await?;
        let [commands, stream] = rig.addresses();
        print(&format!("{:<10} {:<14} {commands}\n", "profiler", "Keyence, TCP"));
        print(&format!("{:<10} {:<14} {stream}\n", "", "its stream"));
        say(&format!("{title}; Ctrl-C ends it"));
        interrupted().await?;
        Ok(Exit::Done)
    })
}

async fn play(session: &Path, args: &SimulateArgs) -> Result<Exit, Failure> {
    let playback = Playback::open(session, args.speed.unwrap_or(Speed::Times(1.0))).await?;
    for (name, kind, address) in playback.listing() {
        print(&format!("{name:<10} {kind:<14} {address}\n"));
    }
    if let Some(station) = &args.station {
        std::fs::write(station, playback.station_toml()?)
            .map_err(|error| format!("cannot write {}: {error}", station.display()))?;
    }
    let _links = playback.start();
    say("playing; Ctrl-C ends it");
    interrupted().await?;
    Ok(Exit::Done)
}
