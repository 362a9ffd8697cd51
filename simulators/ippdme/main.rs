//! `ippdme-sim`: a simulated coordinate measuring machine on a TCP port, over a plane or a bowl.

use std::io;
use std::net::SocketAddr;

use asphera_sim_ippdme::{Machine, MachineSettings, Probe, SharedMachine, Surface};
use clap::Parser;
use tokio::net::TcpListener;

/// Simulates a coordinate measuring machine that serves I++ DME.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Address and port on which it answers.
    #[arg(long, default_value = "127.0.0.1:1294")]
    listen: SocketAddr,
    /// Radius of the bowl that is measured, in mm; a plane without it.
    #[arg(long)]
    bowl_radius_mm: Option<f64>,
    /// Radius of the probe's ball in mm.
    #[arg(long, default_value_t = 1.0)]
    ball_radius_mm: f64,
    /// Standard deviation of the noise along z, nm.
    #[arg(long, default_value_t = 300.0)]
    noise_nm: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let surface = match arguments.bowl_radius_mm {
        None => Surface::new(|_| Some(0.0)),
        Some(radius) => Surface::new(move |[x, y]| {
            let square = radius * radius - x * x - y * y;
            (square > 0.0).then(|| radius - square.sqrt())
        }),
    };
    let machine = SharedMachine::new(Machine::new(MachineSettings {
        probe: Probe { surface, radius_mm: arguments.ball_radius_mm },
        noise_nm: arguments.noise_nm,
        seed: arguments.seed,
        ..MachineSettings::usual()
    }));
    let listener = TcpListener::bind(arguments.listen).await?;
    loop {
        // A server has one client at a time.
        let (stream, _) = listener.accept().await?;
        stream.set_nodelay(true)?;
        // A client that goes away in the middle of an answer is no trouble of the machine.
        drop(machine.serve(stream).await);
    }
}
