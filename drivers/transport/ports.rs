//! What there is to connect to, by names that survive unplugging.

use std::fs;
use std::path::Path;

/// A serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialPort {
    /// The name to put into a configuration: the link under `/dev/serial/by-id` where there is one.
    pub stable_name: String,
    /// The device it stands for now: `/dev/ttyUSB0`.
    pub device: String,
    /// Maker, product and serial number, where USB tells them.
    pub description: Option<String>,
}

/// A CAN interface of the kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CanInterface {
    /// Its name: `can0`.
    pub name: String,
    /// Its state as the kernel says: `up`, `down`, `unknown`.
    pub state: String,
}

/// The serial ports there are, sorted by stable name.
///
/// # Errors
///
/// When the system cannot list its ports.
pub fn serial_ports() -> Result<Vec<SerialPort>, serialport::Error> {
    let names = by_id(Path::new("/dev/serial/by-id"));
    let mut ports: Vec<SerialPort> = serialport::available_ports()?
        .into_iter()
        .map(|port| SerialPort {
            stable_name: names
                .iter()
                .find(|(_, device)| *device == port.port_name)
                .map_or_else(|| port.port_name.clone(), |(name, _)| name.clone()),
            description: match port.port_type {
                serialport::SerialPortType::UsbPort(usb) => Some(
                    [usb.manufacturer, usb.product, usb.serial_number]
                        .into_iter()
                        .flatten()
                        .collect::<Vec<_>>()
                        .join(" "),
                ),
                _ => None,
            },
            device: port.port_name,
        })
        .collect();
    ports.sort_by(|a, b| a.stable_name.cmp(&b.stable_name));
    Ok(ports)
}

/// The CAN interfaces there are, sorted by name; empty where the kernel has no CAN.
pub fn can_interfaces() -> Vec<CanInterface> {
    interfaces(Path::new("/sys/class/net"))
}

/// Links and the devices they lead to.
fn by_id(dir: &Path) -> Vec<(String, String)> {
    entries(dir)
        .filter_map(|path| {
            let device = fs::canonicalize(&path).ok()?;
            Some((path.display().to_string(), device.display().to_string()))
        })
        .collect()
}

fn interfaces(dir: &Path) -> Vec<CanInterface> {
    let mut found: Vec<CanInterface> = entries(dir)
        .filter(|path| read(&path.join("type")).as_deref() == Some(ARPHRD_CAN))
        .filter_map(|path| {
            Some(CanInterface {
                name: path.file_name()?.to_str()?.to_owned(),
                state: read(&path.join("operstate")).unwrap_or_else(|| "unknown".to_owned()),
            })
        })
        .collect();
    found.sort_by(|a, b| a.name.cmp(&b.name));
    found
}

fn entries(dir: &Path) -> impl Iterator<Item = std::path::PathBuf> {
    fs::read_dir(dir).into_iter().flatten().flatten().map(|entry| entry.path())
}

fn read(path: &Path) -> Option<String> {
    Some(fs::read_to_string(path).ok()?.trim().to_owned())
}

/// Hardware type of CAN interfaces in `<linux/if_arp.h>`.
const ARPHRD_CAN: &str = "280";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn can_interfaces_are_told_by_their_hardware_type() {
        let net = tempfile::tempdir().unwrap();
        for (name, kind, state) in
            [("vcan0", "280\n", "up\n"), ("eth0", "1\n", "up\n"), ("can1", "280\n", "")]
        {
            let dir = net.path().join(name);
            fs::create_dir(&dir).unwrap();
            fs::write(dir.join("type"), kind).unwrap();
            fs::write(dir.join("operstate"), state).unwrap();
        }
        let names: Vec<_> =
            interfaces(net.path()).into_iter().map(|can| (can.name, can.state)).collect();
        assert_eq!(names, [("can1".into(), String::new()), ("vcan0".into(), "up".into())]);
        assert_eq!(interfaces(&net.path().join("absent")), []);
    }

    #[test]
    fn by_id_leads_to_the_device() {
        let dir = tempfile::tempdir().unwrap();
        let device = dir.path().join("ttyUSB0");
        fs::write(&device, "").unwrap();
        fs::create_dir(dir.path().join("by-id")).unwrap();
        let link = dir.path().join("by-id/usb-FTDI-1234");
        std::os::unix::fs::symlink(&device, &link).unwrap();
        let device = fs::canonicalize(device).unwrap();
        assert_eq!(
            by_id(&dir.path().join("by-id")),
            [(link.display().to_string(), device.display().to_string())]
        );
    }
}
