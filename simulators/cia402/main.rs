//! Simulated CiA 402 drives behind an slcan adapter on TCP.

use std::error::Error;
use std::net::SocketAddr;

use asphera_sim_cia402::{Drive, DriveSettings, SharedDrives, serve};
use clap::Parser;
use tokio::net::TcpListener;

/// Simulated CiA 402 drives behind an slcan adapter.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Address to listen on.
    #[arg(long, default_value = "127.0.0.1:0")]
    tcp: SocketAddr,
    /// Numbers of the nodes.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    nodes: Vec<u8>,
    /// Travel from the negative limit switch on, counts.
    #[arg(long, default_value_t = 50_000)]
    travel: i32,
    /// Place on the travel at power-on, counts.
    #[arg(long, default_value_t = 20_000)]
    at: i32,
    /// Acceleration after power-on, counts/s².
    #[arg(long, default_value_t = 200_000)]
    acceleration: u32,
}

#[tokio::main]
async fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { tcp, nodes, travel, at, acceleration } = Arguments::parse();
    let drive = |node_id: u8| Drive::new(DriveSettings { node_id, travel, at, acceleration });
    let shared = SharedDrives::new(nodes.into_iter().map(drive).collect::<Result<_, _>>()?);
    let listener = TcpListener::bind(tcp).await?;
    announce(&format!("slcan on tcp {}", listener.local_addr()?));
    loop {
        let (stream, _) = listener.accept().await?;
        stream.set_nodelay(true)?;
        // A host that breaks off is followed by the next one.
        let _ = serve(&shared, stream).await;
    }
}

#[expect(clippy::print_stdout, reason = "whoever starts the simulator waits for the address")]
fn announce(text: &str) {
    println!("{text}");
}
