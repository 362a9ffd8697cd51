//! The CAN interface: down, up, gone, back, slow.

use std::process::Command;

/// A virtual CAN interface that is ours alone.
pub(crate) struct Interface {
    name: String,
}

impl Interface {
    pub(crate) fn new(name: String) -> Interface {
        Interface { name }
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn down(&self) -> Result<(), String> {
        run("ip", &["link", "set", &self.name, "down"])
    }

    pub(crate) fn up(&self) -> Result<(), String> {
        run("ip", &["link", "set", &self.name, "up"])
    }

    /// As when a USB adapter is pulled.
    pub(crate) fn remove(&self) -> Result<(), String> {
        run("ip", &["link", "del", &self.name])
    }

    pub(crate) fn add(&self) -> Result<(), String> {
        run("ip", &["link", "add", &self.name, "type", "vcan"])
    }

    /// Largest frame that it carries, in bytes: 16 for classic frames, 72 for those of CAN FD.
    pub(crate) fn set_mtu(&self, bytes: u8) -> Result<(), String> {
        self.down()?;
        run("ip", &["link", "set", &self.name, "mtu", &bytes.to_string()])?;
        self.up()
    }

    /// Gives the interface the transmit queue of a real one: 10 frames, drained at this rate.
    pub(crate) fn slow(&self, rate: &str) -> Result<(), String> {
        let netem = ["netem", "rate", rate, "limit", "10"];
        run("tc", &[&["qdisc", "add", "dev", &self.name, "root"][..], &netem].concat())
    }

    pub(crate) fn fast(&self) -> Result<(), String> {
        run("tc", &["qdisc", "del", "dev", &self.name, "root"])
    }
}

fn run(program: &str, arguments: &[&str]) -> Result<(), String> {
    let told = || format!("{program} {}", arguments.join(" "));
    let output = Command::new(program)
        .args(arguments)
        .output()
        .map_err(|error| format!("{} did not run: {error}", told()))?;
    if output.status.success() {
        return Ok(());
    }
    let words = String::from_utf8_lossy(&output.stderr).trim().replace('\n', "; ");
    Err(format!("{} failed: {words}", told()))
}
