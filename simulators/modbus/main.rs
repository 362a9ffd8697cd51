//! `modbus-sim`: a simulated Baumer OM20 on a TCP port or a serial line.

use std::io::{self, Write as _};
use std::net::SocketAddr;

use asphera_sim_modbus::{Device, Pty, Sine, serve_tcp};
use clap::Parser;
use tokio::net::TcpListener;

/// Simulates a Baumer OM20 distance sensor that looks at a surface going to and fro.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Serve Modbus TCP at this address; without it Modbus RTU on a new pseudo-terminal (no parity).
    #[arg(long)]
    tcp: Option<SocketAddr>,
    /// Address of the device.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=247))]
    unit: u8,
    /// Mean distance in mm.
    #[arg(long, default_value_t = 70.0)]
    mean_mm: f64,
    /// Amplitude of the motion in mm.
    #[arg(long, default_value_t = 5.0)]
    amplitude_mm: f64,
    /// Period of the motion in s.
    #[arg(long, default_value_t = 10.0)]
    period_s: f64,
    /// Standard deviation of the noise in µm.
    #[arg(long, default_value_t = 2.0)]
    noise_um: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[tokio::main]
async fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let sine = Sine {
        mean_mm: arguments.mean_mm,
        amplitude_mm: arguments.amplitude_mm,
        period_s: arguments.period_s,
        noise_um: arguments.noise_um,
        seed: arguments.seed,
    };
    let device = Device::om20(arguments.unit, sine.distance_mm());
    match arguments.tcp {
        Some(address) => {
            let listener = TcpListener::bind(address).await?;
            writeln!(io::stdout(), "{}", listener.local_addr()?)?;
            serve_tcp(listener, device).await
        }
        None => {
            let pty = Pty::open()?;
            writeln!(io::stdout(), "{}", pty.path().display())?;
            pty.serve(device).await
        }
    }
}
