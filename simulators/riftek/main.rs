//! `riftek-sim`: a simulated RF60x laser sensor over a wave, for one host after the other.

use std::f64::consts::TAU;
use std::io;
use std::time::Duration;

use asphera_riftek::{Mode, Settings};
use asphera_sim_riftek::Sensor;
use clap::Parser;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{MissedTickBehavior, interval};

/// Simulates an RF60x over a wave about the middle of its range. It streams, and answers questions.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Address and port at which hosts connect, as to a terminal server.
    #[arg(long, default_value = "127.0.0.1:4002")]
    listen: String,
    /// Measuring range in mm.
    #[arg(long, default_value_t = 10)]
    range_mm: u16,
    /// Network address, 1 to 127.
    #[arg(long, default_value_t = 1)]
    address: u8,
    /// Amplitude of the wave in µm.
    #[arg(long, default_value_t = 50.0)]
    wave_um: f64,
    /// Measurements in one wave.
    #[arg(long, default_value_t = 200)]
    wave_length: u64,
    /// Measurements a second, 1 to 9400.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=9400))]
    rate_hz: u32,
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let settings = Settings {
        address: arguments.address,
        mode: Mode::Stream { silence_ms: 0 },
        range_mm: arguments.range_mm,
        serial: None,
        timeout_ms: 200,
        late_limit_ms: 400,
    };
    if let Some(problem) = settings.problems().first() {
        return Err(io::Error::other(problem.to_string()));
    }
    let mut sensor = Sensor::new(&settings);
    let listener = TcpListener::bind(&arguments.listen).await?;
    loop {
        let (stream, _) = listener.accept().await?;
        // A host that goes away makes room for the next.
        drop(serve(stream, &mut sensor, &arguments).await);
        sensor.disconnected();
    }
}

async fn serve(
    mut stream: TcpStream,
    sensor: &mut Sensor,
    arguments: &Arguments,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let mut due = interval(Duration::from_secs(1) / arguments.rate_hz);
    due.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let (mut asked, mut count) = ([0; 256], 0_u64);
    loop {
        tokio::select! {
            read = stream.read(&mut asked) => match read? {
                0 => return Ok(()),
                len => {
                    let answers = sensor.receive(&asked[..len]);
                    stream.write_all(&answers).await?;
                }
            },
            _ = due.tick() => {
                count += 1;
                let phase = TAU * count as f64 / arguments.wave_length.max(1) as f64;
                let middle_mm = 0.5 * f64::from(arguments.range_mm);
                sensor.measure(Some(middle_mm + 1e-3 * arguments.wave_um * phase.sin()));
                if let Some(bytes) = sensor.stream() {
                    stream.write_all(&bytes).await?;
                }
            }
        }
    }
}
