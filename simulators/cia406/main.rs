//! Simulated CiA 406 encoders behind an slcan adapter, on TCP or a pseudo terminal.

use std::error::Error;
use std::net::SocketAddr;
use std::time::Duration;

use asphera_sim_cia406::{Bus, NodeConfig, Pty, Simulator, serve_tcp};
use clap::Parser;
use tokio::net::TcpListener;
use tokio::time::{MissedTickBehavior, interval};

/// Simulated CiA 406 encoders behind an slcan adapter.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Address to listen on; without it a pseudo terminal is made and its path printed.
    #[arg(long)]
    tcp: Option<SocketAddr>,
    /// Numbers of the nodes.
    #[arg(long, value_delimiter = ',', default_value = "1")]
    nodes: Vec<u8>,
    /// SYNCs a second while all nodes are started.
    #[arg(long, default_value_t = 100.0)]
    sync_hz: f64,
    /// Highest number of the SYNC counter, 2 to 240; 0 for SYNC without a counter.
    #[arg(long, default_value_t = 240)]
    sync_counter_overflow: u8,
    /// Counts each node moves between two SYNCs, times its place in the list.
    #[arg(long, default_value_t = 10)]
    counts_per_sync: i32,
}

#[tokio::main]
async fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let configs =
        arguments.nodes.iter().map(|&node_id| NodeConfig { node_id, ..NodeConfig::default() });
    let simulator = Simulator::new(Bus::new(configs.collect())?);
    // An interval of zero is none; a bus carries no SYNC every µs anyway.
    let period =
        Duration::try_from_secs_f64(1.0 / arguments.sync_hz)?.max(Duration::from_micros(1));
    tokio::select! {
        served = serve(&simulator, arguments.tcp) => served,
        () = trigger(&simulator, &arguments, period) => Ok(()),
    }
}

async fn serve(simulator: &Simulator, tcp: Option<SocketAddr>) -> Result<(), Box<dyn Error>> {
    match tcp {
        Some(address) => {
            let listener = TcpListener::bind(address).await?;
            announce(&format!("slcan on tcp {}", listener.local_addr()?));
            Ok(serve_tcp(simulator, &listener).await?)
        }
        None => {
            let mut pty = Pty::open()?;
            announce(&format!("slcan on {}", pty.path().unwrap_or_default()));
            Ok(pty.serve(simulator).await?)
        }
    }
}

/// Sends SYNCs while all nodes are started, and begins anew with 1 each time they are.
async fn trigger(simulator: &Simulator, arguments: &Arguments, period: Duration) {
    let overflow = i64::from(arguments.sync_counter_overflow);
    let mut ticks = interval(period);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        simulator.wait_armed().await;
        let mut cycle = 0_i64;
        while simulator.armed() {
            ticks.tick().await;
            let counter = (overflow > 0).then(|| (1 + cycle % overflow) as u8);
            let step = i64::from(arguments.counts_per_sync);
            let positions: Vec<i32> = (1..=arguments.nodes.len() as i64)
                .map(|place| (place * step).wrapping_mul(cycle) as i32)
                .collect();
            simulator.sync(counter, &positions).await;
            cycle += 1;
        }
    }
}

#[expect(clippy::print_stdout, reason = "the path is what whoever starts the simulator waits for")]
fn announce(text: &str) {
    println!("{text}");
}
