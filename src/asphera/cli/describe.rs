//! `asphera describe`: listens to a device that no driver knows, and proposes its settings.

mod listen;

use std::path::PathBuf;

use asphera_link::{Capture, Channel, Family, Proposal, Reading, bytes_of};
use asphera_transport::{Endpoint, FlowControl, Parity, SerialSettings};
use clap::{ArgGroup, Args};

use super::exit::Exit;
use super::output::{Failure, print, say};
use super::serve::block_on;
use super::usage::misused;
use crate::config;
use crate::whole_file::write_bytes;
use asphera_report::words::{counted, unit};
use listen::Listener;

#[derive(Args)]
#[command(group(ArgGroup::new("device").required(true).args(["file", "serial", "tcp", "udp"])))]
pub(super) struct DescribeArgs {
    /// Bytes captured from a device.
    file: Option<PathBuf>,
    /// Serial port; `asphera ports` lists them.
    #[arg(long, value_name = "PORT")]
    serial: Option<String>,
    /// Line rate in baud.
    #[arg(long, default_value_t = 9600, requires = "serial")]
    baud_bd: u32,
    /// Parity.
    #[arg(long, default_value = "none", value_parser = ["none", "even", "odd"], requires = "serial")]
    parity: String,
    /// Two stop bits instead of one.
    #[arg(long, requires = "serial")]
    two_stop_bits: bool,
    /// Device at a TCP port.
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// Address and port to receive datagrams at: 0.0.0.0:50001.
    #[arg(long, value_name = "ADDRESS:PORT")]
    udp: Option<String>,
    /// Device that datagrams come from, and to which the question goes.
    #[arg(long, value_name = "HOST:PORT", requires = "udp")]
    peer: Option<String>,
    /// Question that the device must be asked; \r, \n, \t, \\ and \xHH stand for one byte each.
    #[arg(long, value_name = "BYTES", conflicts_with = "file")]
    ask: Option<String>,
    /// Time from one question to the next, ms.
    #[arg(long, value_name = "MS", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=60_000))]
    every_ms: u32,
    /// How long to listen, s.
    #[arg(long, value_name = "S", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=3600))]
    seconds: u32,
    /// Name of the link and of the device in the proposed tables.
    #[arg(long, default_value = "gauge")]
    name: String,
    /// Keep what was received in this new file.
    #[arg(long, value_name = "FILE")]
    keep: Option<PathBuf>,
}

/// Settings proposed by a family of drivers.
struct Proposed {
    family: Family,
    settings: String,
}

pub(super) fn run(args: &DescribeArgs) -> Result<Exit, Failure> {
    if args.name.is_empty()
        || !args.name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-')
    {
        return Err(misused(format!(
            "--name: expected letters, digits, _ and -, found {:?}",
            args.name
        )));
    }
    if let Some(keep) = args.keep.as_ref().filter(|keep| keep.exists()) {
        return Err(format!("{} is there already", keep.display()).into());
    }
    let ask = args.ask.as_deref().map(bytes_of).transpose();
    let ask = ask.map_err(|error| misused(format!("--ask: {error}")))?;
    match endpoint(args) {
        None => {
            let path = args.file.clone().unwrap_or_default();
            let received = std::fs::read(&path)
                .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
            let capture = Capture { received, asked: None };
            let proposed = proposed(&capture)?;
            print(&tables(args, None, &proposed));
            show(&proposed, &replayed(&proposed, &capture)?);
            Ok(Exit::Done)
        }
        Some(endpoint) => block_on(live(args, endpoint, ask)),
    }
}

/// Listens, proposes, and tries the proposal on the device itself.
async fn live(
    args: &DescribeArgs,
    endpoint: Endpoint,
    ask: Option<Vec<u8>>,
) -> Result<Exit, Failure> {
    let mut listener = Listener::open(endpoint.clone())?;
    let asked = ask.map(|ask| (ask, args.every_ms));
    let received = listener.hear(asked.clone(), args.seconds).await?;
    if let Some(keep) = &args.keep {
        write_bytes(keep, &received)?;
    }
    let proposed = proposed(&Capture { received, asked })?;
    print(&tables(args, Some(&endpoint), &proposed));
    say("trying it …");
    let driver = proposed.device()?.driver().map_err(unusable)?;
    let readings = listener.run(driver, args.seconds).await?;
    show(&proposed, &readings);
    Ok(Exit::Done)
}

fn endpoint(args: &DescribeArgs) -> Option<Endpoint> {
    if let Some(path) = &args.serial {
        let parity = match args.parity.as_str() {
            "even" => Parity::Even,
            "odd" => Parity::Odd,
            _ => Parity::None,
        };
        return Some(Endpoint::Serial(SerialSettings {
            path: path.clone(),
            baud_bd: args.baud_bd,
            parity,
            two_stop_bits: args.two_stop_bits,
            flow_control: FlowControl::None,
        }));
    }
    if let Some(address) = &args.tcp {
        return Some(Endpoint::Tcp { address: address.clone() });
    }
    let listen = args.udp.clone()?;
    Some(Endpoint::Udp { listen, peer: args.peer.clone() })
}

/// The first proposal of any family of drivers; its remarks go to stderr.
fn proposed(capture: &Capture) -> Result<Proposed, Failure> {
    let mut why = Vec::new();
    for (family, Proposal { settings, remarks }) in config::proposals(capture) {
        if let Some(settings) = settings {
            remarks.iter().for_each(|remark| say(remark));
            return Ok(Proposed { family, settings });
        }
        why.extend(remarks);
    }
    Err(why.join("; ").into())
}

impl Proposed {
    /// The settings, read as a configuration would be.
    fn device(&self) -> Result<Box<dyn asphera_link::DeviceSettings>, Failure> {
        Ok(self.family.parse("proposal", &self.settings)?)
    }
}

/// Readings that the proposed settings make of what was captured.
fn replayed(proposed: &Proposed, capture: &Capture) -> Result<Vec<Reading>, Failure> {
    let mut driver = proposed.device()?.driver().map_err(unusable)?;
    Ok(listen::replay(&mut *driver, &capture.received))
}

fn unusable(problems: Vec<asphera_link::Problem>) -> Failure {
    let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
    problems.join("; ").into()
}

/// The tables of a configuration: link, device, settings.
fn tables(args: &DescribeArgs, endpoint: Option<&Endpoint>, proposed: &Proposed) -> String {
    let name = &args.name;
    let mut text = String::new();
    if let Some(endpoint) = endpoint {
        text += &format!("[link.{name}]\nkind = \"{}\"\n", endpoint.kind());
        text += &match endpoint {
            Endpoint::Serial(serial) => {
                let stop_bits = if serial.two_stop_bits { "stop_bits = 2\n" } else { "" };
                format!(
                    "path = {:?}\nbaud_bd = {}\nparity = \"{}\"\n{stop_bits}",
                    serial.path, serial.baud_bd, args.parity
                )
            }
            Endpoint::Tcp { address } => format!("address = {address:?}\n"),
            Endpoint::Tls { address, .. } => format!("address = {address:?}\ntls = true\n"),
            Endpoint::TcpPair { address, second_port } => {
                format!("address = {address:?}\nsecond_port = {second_port}\n")
            }
            Endpoint::Udp { listen, peer } => {
                let peer = peer.as_ref().map(|peer| format!("peer = {peer:?}\n"));
                format!("listen = {listen:?}\n{}", peer.unwrap_or_default())
            }
            Endpoint::SocketCan { interface, .. } => format!("interface = {interface:?}\n"),
            Endpoint::CanLog { path, speed } => format!("file = {path:?}\nspeed = {speed}\n"),
            Endpoint::File(file) => format!("path = {:?}\n", file.path),
        };
        text.push('\n');
    }
    text +=
        &format!("[device.{name}]\ndriver = \"{}\"\nlink = \"{name}\"\n\n", proposed.family.name);
    text += &format!("[device.{name}.settings]\n");
    for line in proposed.settings.lines() {
        // Tables of the settings get the name of the device before theirs.
        text += &match (line.strip_prefix("[["), line.strip_prefix('[')) {
            (Some(table), _) => format!("[[device.{name}.settings.{table}"),
            (None, Some(table)) => format!("[device.{name}.settings.{table}"),
            (None, None) => line.to_owned(),
        };
        text.push('\n');
    }
    text
}

/// How many readings there were, and the last of them.
fn show(proposed: &Proposed, readings: &[Reading]) {
    let channels = proposed.device().map_or_else(|_| Vec::new(), |device| device.channels());
    say(&match readings.last() {
        None => "no reading came of it: compare with the manual".to_owned(),
        Some(last) => {
            let readings = counted(readings.len() as u64, "reading");
            format!("{readings} with it, the last: {}", values(&channels, last))
        }
    });
}

fn values(channels: &[Channel], reading: &Reading) -> String {
    let value = |(channel, value): (&Channel, Option<f64>)| match value {
        Some(value) => format!("{} {value}{}", channel.name, unit(&channel.unit.to_string())),
        None => format!("{} missing", channel.name),
    };
    let mut texts: Vec<String> = channels.iter().zip(reading.values.iter()).map(value).collect();
    texts.extend(reading.flags.names().map(str::to_owned));
    texts.join(", ")
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: DescribeArgs,
    }

    fn args(words: &[&str]) -> DescribeArgs {
        Line::try_parse_from([&["describe"], words].concat()).map(|line| line.args).unwrap()
    }

    #[test]
    fn one_device_is_named() {
        for words in [
            &[][..],
            &["a.bin", "--tcp", "h:1"],
            &["--serial", "a", "--udp", "b:1"],
            &["--peer", "a:1"],
        ] {
            assert!(Line::try_parse_from([&["describe"], words].concat()).is_err(), "{words:?}");
        }
        assert_eq!(
            endpoint(&args(&["--tcp", "h:1"])),
            Some(Endpoint::Tcp { address: "h:1".into() })
        );
        assert_eq!(endpoint(&args(&["a.bin"])), None);
    }

    /// The proposed tables are a part of a configuration that is read without a problem.
    #[test]
    fn proposed_tables_belong_to_a_configuration() {
        let received = b"\nx 1.5 2.5 0.25 mm\nx 1.5 2.6 0.26 mm\nx 1.5 2.7 0.27 mm\n".to_vec();
        let capture = Capture { received, asked: None };
        let proposed = proposed(&capture).unwrap();
        let args = args(&["--tcp", "localhost:7000", "--name", "arm"]);
        let tables = tables(&args, endpoint(&args).as_ref(), &proposed);
        let text = format!(
            "[station]\nname = \"arm\"\n{tables}\n[sync]\ndevices = [\"arm\"]\n[kinematics]\nkind = \"cartesian\"\n\
             x = {{ device = \"arm\", channel = \"value2\" }}\ny = {{ device = \"arm\", channel = \"value3\" }}\n\
             z = {{ device = \"arm\", channel = \"value4\" }}\n[nominal]\nfile = \"flat.toml\"\n"
        );
        // The unit of the first two is for a person to set.
        let text = text.replace("unit = \"1\"", "unit = \"mm\"");
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("station.toml");
        std::fs::write(&file, text).unwrap();
        std::fs::write(folder.path().join("flat.toml"), "[surface]\nkind = \"plane\"\n").unwrap();
        let config = config::Config::load(&file).unwrap();
        assert_eq!((config.links.len(), config.devices[0].channels.len()), (1, 3));
        let readings = replayed(&proposed, &capture).unwrap();
        assert_eq!(readings.len(), 3);
        assert_eq!(
            values(&config.devices[0].channels, &readings[2]),
            "value2 1.5 mm, value3 2.7 mm, value4 0.27 mm"
        );
    }
}
