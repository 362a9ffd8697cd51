//! `optoncdt-sim`: a simulated optoNCDT laser sensor that streams a wave to one host after the other.

use std::f64::consts::TAU;
use std::io;
use std::time::Duration;

use asphera_optoncdt::{Extra, Series, Settings};
use asphera_sim_optoncdt::{Measurement, Sensor};
use clap::Parser;
use tokio::io::AsyncWriteExt as _;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, sleep_until};

/// Simulates an ILD1420 with counter and time stamp in each block, over a wave about the middle of its range.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Address and port at which hosts connect, as to a terminal server.
    #[arg(long, default_value = "127.0.0.1:4001")]
    listen: String,
    /// Measuring range in mm.
    #[arg(long, default_value_t = 10.0)]
    range_mm: f64,
    /// Amplitude of the wave in µm.
    #[arg(long, default_value_t = 50.0)]
    wave_um: f64,
    /// Measurements in one wave.
    #[arg(long, default_value_t = 200)]
    wave_length: u64,
    /// Measurements a second, 1 to 4000.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=4000))]
    rate_hz: u64,
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> io::Result<()> {
    let arguments = Arguments::parse();
    let extras = vec![Extra::Counter, Extra::Timestamp];
    let (range_mm, triggered) = (arguments.range_mm, false);
    let settings = Settings { series: Series::Plain, range_mm, extras, triggered, silence_ms: 0 };
    if let Some(problem) = settings.problems().first() {
        return Err(io::Error::other(problem.to_string()));
    }
    let sensor = Sensor::new(&settings);
    let listener = TcpListener::bind(&arguments.listen).await?;
    let start = Instant::now();
    loop {
        let (stream, _) = listener.accept().await?;
        // A host that goes away makes room for the next.
        drop(send(stream, &sensor, &arguments, start).await);
    }
}

/// Sends blocks until the host goes away. The counter and the clock run on meanwhile.
async fn send(
    mut stream: TcpStream,
    sensor: &Sensor,
    arguments: &Arguments,
    start: Instant,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let period = Duration::from_secs(1) / u32::try_from(arguments.rate_hz).unwrap_or(1);
    let mut count = (start.elapsed().as_nanos() / period.as_nanos()) as u64;
    loop {
        count += 1;
        let at = period.mul_f64(count as f64);
        sleep_until(start + at).await;
        let phase = TAU * count as f64 / arguments.wave_length.max(1) as f64;
        let distance_mm = 0.5 * arguments.range_mm + 1e-3 * arguments.wave_um * phase.sin();
        let clock_ns = at.as_nanos() as u64;
        let measurement = Measurement { distance_mm: Some(distance_mm), count, clock_ns };
        stream.write_all(&sensor.block(measurement)).await?;
    }
}
