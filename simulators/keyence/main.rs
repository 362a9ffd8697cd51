//! `keyence-sim`: a simulated laser profiler on two TCP ports, over a plane or a sphere with waves.

use std::f64::consts::TAU;
use std::io;
use std::net::IpAddr;

use asphera_keyence::wire::Series;
use asphera_sim_keyence::{Controller, Optics, Scan, ScanSettings, Surface, accept, serve};
use clap::Parser;
use tokio::net::TcpListener;

/// Simulates an LJ-X8000 or LJ-V7000 over a part that moves along y.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Address on which it answers.
    #[arg(long, default_value = "127.0.0.1")]
    address: IpAddr,
    /// Port of the commands.
    #[arg(long, default_value_t = 24691)]
    port: u16,
    /// Port of the stream.
    #[arg(long, default_value_t = 24692)]
    stream_port: u16,
    /// Whether it is an LJ-V7000.
    #[arg(long)]
    lj_v7000: bool,
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
    #[arg(long, default_value_t = 800, value_parser = clap::value_parser!(u16).range(1..=3200))]
    points: u16,
    /// Distance of points in µm.
    #[arg(long, default_value_t = 25, value_parser = clap::value_parser!(i32).range(1..=1000))]
    pitch_um: i32,
    /// Profiles a second, above 0.
    #[arg(long, default_value_t = 500.0, value_parser = positive)]
    rate_hz: f64,
    /// Distance from one profile to the next in mm, a count of the encoder.
    #[arg(long, default_value_t = 0.025)]
    step_mm: f64,
    /// Standard deviation of the noise in µm.
    #[arg(long, default_value_t = 0.5)]
    noise_um: f64,
    /// Seed of the noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let optics = Optics {
        series: if arguments.lj_v7000 { Series::LjV7000 } else { Series::LjX8000 },
        points: arguments.points,
        pitch_10nm: 100 * arguments.pitch_um,
        noise_um: arguments.noise_um,
        ..Optics::default()
    };
    let mut controller = Controller::new(optics, arguments.seed);
    let scan = ScanSettings {
        surface: surface(&arguments),
        first_y_mm: -0.5 * arguments.step_mm * f64::from(arguments.profiles.saturating_sub(1)),
        steps: 1,
        step_mm: arguments.step_mm,
        profiles: arguments.profiles,
        rate_hz: arguments.rate_hz,
    };
    let mut scan = Scan::new(scan, &[]);
    let commands = TcpListener::bind((arguments.address, arguments.port)).await?;
    let streams = TcpListener::bind((arguments.address, arguments.stream_port)).await?;
    loop {
        // A controller has one client at a time.
        let (client, stream) = accept(&commands, &streams).await?;
        // A client that goes away in the middle of a profile is no trouble of the controller.
        drop(serve(client, stream, &mut controller, &mut scan).await);
        controller.disconnected();
    }
}

fn surface(arguments: &Arguments) -> Surface {
    let (radius_mm, wave_mm) = (arguments.radius_mm, 1e-3 * arguments.wave_um);
    let length_mm = arguments.wave_length_mm;
    Surface::new(move |[x, y]| {
        let r2 = x * x + y * y;
        let shape_mm = match radius_mm {
            None => 0.0,
            // Free of cancellation; beyond the equator there is no part.
            Some(radius) if r2 < radius * radius => {
                r2 / (radius + (radius * radius - r2).sqrt() * radius.signum())
            }
            Some(_) => return None,
        };
        let wave = |place: f64| (TAU * place / length_mm).sin();
        Some(shape_mm + wave_mm * wave(x) * wave(y))
    })
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().map_err(|error| format!("{error}"))?;
    if value > 0.0 { Ok(value) } else { Err("expected more than 0".to_owned()) }
}
