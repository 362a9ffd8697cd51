//! `zaber-sim`: a simulated stage with two axes on a TCP port.

use std::io;
use std::net::SocketAddr;

use asphera_sim_zaber::{AxisSettings, Fault, SharedStage, Stage};
use clap::Parser;
use tokio::net::TcpListener;

/// Simulates a Zaber controller with linear axes that obey moves.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Address and port on which it answers.
    #[arg(long, default_value = "127.0.0.1:55550")]
    listen: SocketAddr,
    /// Address of the device on its line.
    #[arg(long, default_value_t = 1)]
    address: u8,
    /// How many axes it has.
    #[arg(long, default_value_t = 2)]
    axes: usize,
    /// Microstep size in µm.
    #[arg(long, default_value_t = 0.2)]
    microstep_um: f64,
    /// Travel of each axis in mm.
    #[arg(long, default_value_t = 50.0)]
    travel_mm: f64,
    /// It has no reference until it is homed.
    #[arg(long)]
    not_homed: bool,
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let axis = AxisSettings {
        microstep_um: arguments.microstep_um,
        travel_mm: arguments.travel_mm,
        at_mm: 0.0,
    };
    let stage = SharedStage::new(Stage::new(arguments.address, &vec![axis; arguments.axes]));
    if arguments.not_homed {
        stage.fault(Fault::NotHomed);
    }
    let listener = TcpListener::bind(arguments.listen).await?;
    loop {
        let (stream, _) = listener.accept().await?;
        let stage = stage.clone();
        // A client that goes away in the middle of an answer is no trouble of the stage.
        tokio::spawn(async move { stage.serve(stream).await });
    }
}
