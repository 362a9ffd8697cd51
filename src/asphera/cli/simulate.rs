//! `asphera simulate`: the simulators of a bench alone.

use std::path::PathBuf;

use asphera_rig::{Rig, Scene};
use clap::Args;

use super::exit::Exit;
use super::output::{Failure, print};
use super::serve::interrupted;

#[derive(Args)]
pub(super) struct SimulateArgs {
    /// The bench.
    rig: PathBuf,
    /// Where the names of the simulated serial ports are put.
    #[arg(long, value_name = "DIR")]
    ports: Option<PathBuf>,
}

pub(super) fn run(args: &SimulateArgs) -> Result<Exit, Failure> {
    let name = args.rig.display().to_string();
    let text = std::fs::read_to_string(&args.rig)
        .map_err(|error| format!("cannot read {name}: {error}"))?;
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
