//! `rf627-sim`: a simulated line scanner that sends the profiles of a part to a host.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use asphera_sim_rf627::{Optics, Part, Scan, Scanner, send};
use clap::Parser;

/// Simulates an RF627 over a part that moves along y: a plane or a sphere, with waves.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Address and port of the host that listens.
    #[arg(long, default_value = "127.0.0.1:50001")]
    host: SocketAddr,
    /// Radius of the sphere in mm, negative for a dome; without it a plane.
    #[arg(long, allow_negative_numbers = true)]
    radius_mm: Option<f64>,
    /// Amplitude of the waves in µm.
    #[arg(long, default_value_t = 5.0)]
    wave_um: f64,
    /// Length of the waves in mm.
    #[arg(long, default_value_t = 4.0)]
    wave_length_mm: f64,
    /// How many profiles are measured.
    #[arg(long, default_value_t = 400)]
    profiles: u32,
    /// Points of a profile.
    #[arg(long, default_value_t = 640)]
    points: usize,
    /// Profiles a second.
    #[arg(long, default_value_t = 500.0, value_parser = positive)]
    rate_hz: f64,
    /// Distance from one profile to the next in mm, a step of the encoder.
    #[arg(long, default_value_t = 0.025)]
    step_mm: f64,
    /// Standard deviation of the noise in µm.
    #[arg(long, default_value_t = 1.0)]
    noise_um: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Time before the first profile in s.
    #[arg(long, default_value_t = 0.0)]
    delay_s: f64,
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let optics = Optics {
        points: arguments.points,
        rate_hz: arguments.rate_hz,
        noise_um: arguments.noise_um,
        ..Optics::default()
    };
    let scan = Scan {
        part: Part {
            radius_mm: arguments.radius_mm,
            wave_um: arguments.wave_um,
            wave_length_mm: arguments.wave_length_mm,
            half_width_mm: optics.line_mm,
        },
        first_y_mm: -0.5 * arguments.step_mm * f64::from(arguments.profiles.saturating_sub(1)),
        steps: 1,
        step_mm: arguments.step_mm,
        profiles: arguments.profiles,
    };
    let mut scanner = Scanner::new(optics, arguments.seed);
    let mut departures =
        scan.departures(&mut scanner, &[], arguments.seed).map_err(io::Error::other)?;
    let delay = Duration::try_from_secs_f64(arguments.delay_s).map_err(io::Error::other)?;
    departures.iter_mut().for_each(|departure| departure.at_ns += delay.as_nanos() as u64);
    send(&departures, arguments.host).await
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().map_err(|error| format!("{error}"))?;
    if value > 0.0 { Ok(value) } else { Err("expected more than 0".to_owned()) }
}
