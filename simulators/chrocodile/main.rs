//! A simulated CHRocodile 2 over a wavy plane: on TCP at the address given, else on a pseudo-terminal. A second argument
//! is the number of points of a device on the packet protocol.

use std::error::Error;
use std::net::SocketAddr;
use std::time::Duration;

use asphera_sim_chrocodile::{
    Device, Exposure, Instrument, PacketDevice, Sample, Simulator, pty, tcp,
};

/// Full scale of the simulated probe in µm.
const FULL_SCALE_UM: f64 = 3000.0;

#[tokio::main(flavor = "current_thread")]
#[expect(clippy::print_stdout, reason = "the host has to be told where to connect")]
async fn main() -> Result<(), Box<dyn Error>> {
    let points = std::env::args().nth(2).map(|points| points.parse::<u16>()).transpose()?;
    let instrument: Instrument = match points {
        Some(points) => PacketDevice::new(FULL_SCALE_UM, points).into(),
        None => Device::new(FULL_SCALE_UM).into(),
    };
    let simulator = Simulator::new(instrument, 64);
    tokio::spawn(expose(simulator.clone(), points));
    if let Some(address) = std::env::args().nth(1) {
        let (bound, serving) = tcp(simulator, address.parse::<SocketAddr>()?).await?;
        println!("{bound}");
        Err(serving.await.into())
    } else {
        let pty = pty(simulator)?;
        println!("{}", pty.path().display());
        pty.run().await?;
        Ok(())
    }
}

/// Exposes at the rate the host has set, while it has the data started.
async fn expose(simulator: Simulator, points: Option<u16>) {
    let mut sample = Sample::default();
    loop {
        simulator.wait_armed(true).await;
        let period = Duration::from_secs_f64(1.0 / simulator.sample_rate_hz());
        tokio::time::sleep(period).await;
        let along = (f64::from(sample.encoder[0]) * 0.01).sin();
        sample.distance_um = Some(distance_um(along, 0.0));
        let line_um = points.map(|points| {
            (0..points).map(|point| Some(distance_um(along, f64::from(point)))).collect()
        });
        if simulator.expose(Exposure { sample, line_um }).await.is_err() {
            return;
        }
        sample.exposure_count += 1;
        sample.start_ns += period.as_nanos() as u64;
        sample.encoder[0] = sample.encoder[0].wrapping_add(1);
    }
}

/// Distance at a point across the line, while the wave along the scan has this phase.
fn distance_um(along: f64, across: f64) -> f64 {
    FULL_SCALE_UM / 2.0 + 10.0 * along * (across * 0.05).cos()
}
