//! The tables `link.NAME`.

use std::path::Path;
use std::time::Duration;

use asphera_cantext::socketcand::MAX_BUS_NAME;
use asphera_settings::Section;
use asphera_slcan::{BitRate, DataBitRate};
use asphera_transport::{
    Backoff, ClientCertificate, Endpoint, FileSettings, FlowControl, Parity, SerialSettings,
    TlsSettings,
};

use crate::station::Framing;

/// One link.
#[derive(Clone, Debug)]
pub struct LinkConfig {
    /// Name of its table.
    pub name: String,
    /// `serial`, `tcp`, `tcp-pair`, `udp`, `slcan-serial`, `slcan-tcp`, `socketcan`, `socketcand`, `candump` or `file`.
    pub kind: &'static str,
    /// Where it leads.
    pub endpoint: Endpoint,
    /// How its bytes are framed.
    pub framing: Framing,
    /// How long it waits before it opens again.
    pub backoff: Backoff,
    /// After this long without a reading the link is shown as stale.
    pub stale_after: Duration,
}

#[derive(Clone, Copy)]
enum Kind {
    Serial,
    Tcp,
    TcpPair,
    Udp,
    SlcanSerial,
    SlcanTcp,
    SocketCan,
    Socketcand,
    Candump,
    File,
}

const KINDS: [(&str, Kind); 10] = [
    ("serial", Kind::Serial),
    ("tcp", Kind::Tcp),
    ("tcp-pair", Kind::TcpPair),
    ("udp", Kind::Udp),
    ("slcan-serial", Kind::SlcanSerial),
    ("slcan-tcp", Kind::SlcanTcp),
    ("socketcan", Kind::SocketCan),
    ("socketcand", Kind::Socketcand),
    ("candump", Kind::Candump),
    ("file", Kind::File),
];

impl LinkConfig {
    /// Place that no two links may share: the address, and the bus where there are several behind it.
    pub(super) fn place(&self) -> String {
        match self.framing.bus() {
            Some(bus) => format!("{} {bus}", self.endpoint),
            None => self.endpoint.to_string(),
        }
    }
}

/// Reads one link; `index` tells its jitter from that of the others, `folder` is that of the files it names.
pub(super) fn read(
    name: String,
    index: usize,
    table: &Section<'_>,
    folder: &Path,
) -> Option<LinkConfig> {
    let kind = table.required_word("kind", &KINDS)?;
    let endpoint = match kind {
        Kind::Serial | Kind::SlcanSerial => serial(table),
        Kind::Tcp | Kind::SlcanTcp | Kind::Socketcand => tcp(table, folder),
        Kind::TcpPair => tcp_pair(table),
        Kind::Udp => udp(table),
        Kind::SocketCan => named(table, "interface", "a CAN interface, as can0")
            .map(|interface| Endpoint::SocketCan { interface, timestamps: timestamps(table) }),
        Kind::Candump => log(table, folder),
        Kind::File => file(table, folder),
    };
    let framing = match kind {
        Kind::Serial | Kind::Tcp => Some(Framing::Raw),
        Kind::TcpPair => Some(Framing::TwoStreams),
        Kind::Udp => Some(Framing::Datagrams),
        Kind::SlcanSerial | Kind::SlcanTcp => {
            let listen_only = table.or("listen_only", false);
            let timestamps = timestamps(table);
            let (bit_rate, data_bit_rate) = (bit_rate(table), data_bit_rate(table));
            bit_rate.zip(data_bit_rate).map(|(bit_rate, data_bit_rate)| Framing::Slcan {
                bit_rate,
                data_bit_rate,
                listen_only,
                timestamps,
            })
        }
        Kind::SocketCan => Some(Framing::CanRecords { timestamps: timestamps(table) }),
        Kind::Socketcand => bus(table).map(|bus| Framing::Socketcand { bus }),
        Kind::Candump => Some(Framing::Candump { interface: interface(table) }),
        Kind::File => Some(Framing::File),
    };
    let first_ms = table.within("reconnect_first_ms", 100, 1..=60_000u64);
    let max_ms = table.within("reconnect_max_ms", 1000, 1..=600_000u64);
    let backoff = Backoff::try_new(
        Duration::from_millis(first_ms),
        Duration::from_millis(max_ms),
        index as u64,
    );
    if let Err(error) = &backoff {
        table.problem("reconnect_max_ms", "at least reconnect_first_ms", error);
    }
    let stale_after =
        Duration::from_millis(table.within("stale_after_ms", 1000, 10..=3_600_000u64));
    table.finish();
    let kind = KINDS.iter().find(|(_, known)| *known as u8 == kind as u8)?.0;
    Some(LinkConfig {
        name,
        kind,
        endpoint: endpoint?,
        framing: framing?,
        backoff: backoff.ok()?,
        stale_after,
    })
}

/// A name that must be there and say something.
fn named(table: &Section<'_>, key: &str, expected: &str) -> Option<String> {
    let name: String = table.required(key)?;
    if name.trim().is_empty() {
        table.problem(key, expected, "an empty text");
        return None;
    }
    Some(name)
}

fn serial(table: &Section<'_>) -> Option<Endpoint> {
    let path = named(table, "path", "a port, as /dev/serial/by-id/…");
    let baud_bd = table.within("baud_bd", 115_200, 300..=4_000_000u32);
    let parity = [("none", Parity::None), ("even", Parity::Even), ("odd", Parity::Odd)];
    let parity = table.word("parity", Parity::None, &parity);
    let two_stop_bits = table.within("stop_bits", 1, 1..=2u8) == 2;
    let flow = [("none", FlowControl::None), ("hardware", FlowControl::Hardware)];
    let flow_control = table.word("flow_control", FlowControl::None, &flow);
    Some(Endpoint::Serial(SerialSettings {
        path: path?,
        baud_bd,
        parity,
        two_stop_bits,
        flow_control,
    }))
}

fn tcp(table: &Section<'_>, folder: &Path) -> Option<Endpoint> {
    let address = address(table, "address");
    if table.is_bool("tls") || !table.has("tls") {
        let address = address?;
        return Some(match table.or("tls", false) {
            true => Endpoint::Tls { address, tls: TlsSettings::default() },
            false => Endpoint::Tcp { address },
        });
    }
    let section = table.section("tls");
    let tls = tls(&section, folder);
    section.finish();
    Some(Endpoint::Tls { address: address?, tls: tls? })
}

/// Files are read when the link opens: a recording is replayed without them.
fn tls(table: &Section<'_>, folder: &Path) -> Option<TlsSettings> {
    let file = |key: &str, expected: &str| match table.has(key) {
        true => named(table, key, expected).map(|file| Some(folder.join(file))),
        false => Some(None),
    };
    let ca = file("ca", "a PEM file with certificates of issuers");
    let certificate = file("certificate", "a PEM file with the certificate of this client");
    let key = file("key", "a PEM file with its private key");
    let server_name = match table.has("server_name") {
        true => named(table, "server_name", "the name that the server's certificate has").map(Some),
        false => Some(None),
    };
    let client = match (certificate?, key?) {
        (Some(certificate), Some(key)) => Some(ClientCertificate { certificate, key }),
        (None, None) => None,
        (Some(_), None) => {
            table.problem("key", "the PEM file with the key of the certificate", "nothing");
            return None;
        }
        (None, Some(_)) => {
            table.problem("certificate", "the PEM file with the certificate of the key", "nothing");
            return None;
        }
    };
    Some(TlsSettings { ca: ca?, server_name: server_name?, client })
}

fn tcp_pair(table: &Section<'_>) -> Option<Endpoint> {
    let address = address(table, "address");
    let second_port: Option<u16> = table.required("second_port");
    Some(Endpoint::TcpPair { address: address?, second_port: second_port? })
}

fn udp(table: &Section<'_>) -> Option<Endpoint> {
    let listen = address(table, "listen");
    let peer = if table.has("peer") { Some(address(table, "peer")?) } else { None };
    Some(Endpoint::Udp { listen: listen?, peer })
}

/// Host and port.
fn address(table: &Section<'_>, key: &str) -> Option<String> {
    let address: String = table.required(key)?;
    let is_host = |host: &str| {
        !host.is_empty() && !host.contains(|sign: char| sign == '/' || sign.is_whitespace())
    };
    let port = address.rsplit_once(':').filter(|(host, _)| is_host(host));
    if port.is_none_or(|(_, port)| port.parse::<u16>().is_err()) {
        table.problem(key, "host:port, as 192.168.1.5:502", format!("{address:?}"));
        return None;
    }
    Some(address)
}

/// A log and its pace.
fn log(table: &Section<'_>, folder: &Path) -> Option<Endpoint> {
    let file = named(table, "file", "a log that candump -l wrote, as bus.log");
    let speed = table.within("speed", 1.0, 0.01..=1000.0);
    Some(Endpoint::CanLog { path: folder.join(file?), speed })
}

/// A file, a FIFO or the standard input.
fn file(table: &Section<'_>, folder: &Path) -> Option<Endpoint> {
    let path = named(table, "path", "a file, a FIFO, or \"-\" for the standard input");
    let follow = table.or("follow", false);
    let from_end = if follow || !table.has("from") {
        table.word("from", follow, &[("begin", false), ("end", true)]) && follow
    } else {
        let found = "a file that is read from its beginning to its end";
        table.problem("from", "follow = true beside it", found);
        // The key is known, whatever it says.
        table.get::<String>("from");
        false
    };
    let path = path?;
    if path == "-" && follow {
        table.problem("follow", "false: a pipe ends when its writer does", "true");
        return None;
    }
    let path = if path == "-" { path.into() } else { folder.join(path) };
    Some(Endpoint::File(FileSettings { path, follow, from_end }))
}

/// Whether frames have the times of the clock of an adapter or controller.
fn timestamps(table: &Section<'_>) -> bool {
    table.or("timestamps", false)
}

/// Interface whose frames are taken of a log; without the key those of all.
fn interface(table: &Section<'_>) -> Option<String> {
    if !table.has("interface") {
        return None;
    }
    named(table, "interface", "an interface of the log, as can0")
}

/// A bus that a server can be asked for.
fn bus(table: &Section<'_>) -> Option<String> {
    let expected = format!("a bus of the server with 1 to {MAX_BUS_NAME} signs, as can0");
    let bus = named(table, "bus", &expected)?;
    let is_name = bus.len() <= MAX_BUS_NAME
        && bus.bytes().all(|byte| byte.is_ascii_graphic() && !b"<>".contains(&byte));
    if !is_name {
        table.problem("bus", expected, format!("{bus:?}"));
    }
    is_name.then_some(bus)
}

fn bit_rate(table: &Section<'_>) -> Option<BitRate> {
    let bits_per_s = table.required("bit_rate_bps")?;
    BitRate::from_bits_per_s(bits_per_s)
        .inspect_err(|error| table.problem("bit_rate_bps", "a bit rate of slcan adapters", error))
        .ok()
}

/// Bit rate of the data of CAN FD; inner `None`: the adapter carries classic frames alone.
#[expect(clippy::option_option, reason = "outer: unusable; inner: none asked for")]
fn data_bit_rate(table: &Section<'_>) -> Option<Option<DataBitRate>> {
    const KEY: &str = "data_bit_rate_bps";
    if !table.has(KEY) {
        return Some(None);
    }
    DataBitRate::from_bits_per_s(table.required(KEY)?)
        .inspect_err(|error| table.problem(KEY, "a data bit rate of slcan adapters", error))
        .ok()
        .map(Some)
}
