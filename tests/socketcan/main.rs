//! The SocketCAN link, the CiA 406 driver and a simulated node on a CAN interface of a real kernel.
//!
//! ```text
//! socketcan [INTERFACE]        vcan0 if none is named
//! ```
//!
//! It takes the interface down, removes it and adds it again, so it needs root and a virtual interface
//! (`vcan`) that nobody else uses; `tests/socketcan/vm` gives it a small virtual machine of its own.
//! One line for each check goes to standard output: `PASS`, `FAIL` or `SKIP`, a colon, what was seen. The exit
//! status is 1 if a check failed.

mod flexible;
mod frames;
mod interface;
mod node;
mod report;
mod station;
mod times;

use std::process::ExitCode;

use interface::Interface;
use report::Report;

#[tokio::main]
async fn main() -> ExitCode {
    let interface = Interface::new(std::env::args().nth(1).unwrap_or_else(|| "vcan0".to_owned()));
    let mut report = Report::default();
    frames::missing_interface(&mut report).await;
    frames::listed(&interface, &mut report);
    frames::round_trips(&interface, &mut report).await;
    flexible::round_trips(&interface, &mut report).await;
    flexible::refused(&interface, &mut report).await;
    times::late_reader(&interface, &mut report).await;
    times::no_controller(&interface, &mut report).await;
    frames::bus_errors(&interface, &mut report).await;
    frames::full_queue(&interface, &mut report).await;
    frames::stalled_queue(&interface, &mut report).await;
    frames::down_while_silent(&interface, &mut report).await;
    frames::nobody_reads(&interface, &mut report).await;
    station::measures_and_comes_back(&interface, &mut report).await;
    report.finish()
}
