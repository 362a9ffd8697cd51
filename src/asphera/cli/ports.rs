//! `asphera ports`.

use asphera_transport::{can_interfaces, serial_ports};

use super::exit::Exit;
use super::output::{Failure, print};

pub(super) fn run() -> Result<Exit, Failure> {
    let ports = serial_ports()?;
    let interfaces = can_interfaces();
    let mut text = String::new();
    for port in &ports {
        let device = if port.device == port.stable_name { "" } else { &port.device };
        let about = port.description.as_deref().unwrap_or_default();
        text.push_str(format!("serial     {}  {device}  {about}", port.stable_name).trim_end());
        text.push('\n');
    }
    for interface in &interfaces {
        text.push_str(&format!("socketcan  {}  {}\n", interface.name, interface.state));
    }
    if ports.is_empty() {
        text.push_str("no serial ports\n");
    }
    if interfaces.is_empty() {
        text.push_str(
            "no CAN interfaces (a serial CAN adapter is a serial port: kind \"slcan-serial\")\n",
        );
    }
    print(&text);
    Ok(Exit::Done)
}
