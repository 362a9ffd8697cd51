//! A simulated CHRocodile 2 over a wavy plane: on TCP at the address given, else on a pseudo-terminal.

use std::error::Error;
use std::net::SocketAddr;
use std::time::Duration;

use asphera_sim_chrocodile::{Device, Sample, Simulator, pty, tcp};

/// Full scale of the simulated probe in µm.
const FULL_SCALE_UM: f64 = 3000.0;

#[tokio::main(flavor = "current_thread")]
#[expect(clippy::print_stdout, reason = "the host has to be told where to connect")]
async fn main() -> Result<(), Box<dyn Error>> {
    let simulator = Simulator::new(Device::new(FULL_SCALE_UM), 64);
    tokio::spawn(expose(simulator.clone()));
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
async fn expose(simulator: Simulator) {
    let mut sample = Sample::default();
    loop {
        simulator.wait_armed(true).await;
        let period = Duration::from_secs_f64(1.0 / simulator.sample_rate_hz());
        tokio::time::sleep(period).await;
        sample.exposure_count += 1;
        sample.start_ns += period.as_nanos() as u64;
        sample.encoder[0] = sample.encoder[0].wrapping_add(1);
        let wave = (f64::from(sample.encoder[0]) * 0.01).sin();
        sample.distance_um = Some(FULL_SCALE_UM / 2.0 + 10.0 * wave);
        if simulator.trigger(sample).await.is_err() {
            return;
        }
    }
}
