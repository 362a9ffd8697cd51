//! A configuration whose links lead to simulated devices.

use std::net::SocketAddr;

use toml_edit::{DocumentMut, Table, value};

/// Where a link is to lead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lead<'a> {
    /// `tcp`, `tcp-pair` or `slcan-tcp`.
    pub(super) kind: &'a str,
    /// A port of this computer.
    pub(super) address: SocketAddr,
    /// The second port of a `tcp-pair`.
    pub(super) second_port: Option<u16>,
    /// Whether a bus carries CAN FD.
    pub(super) carries_fd: bool,
}

impl Lead<'_> {
    /// A link of one port, without CAN FD.
    pub(super) fn plain(kind: &str, address: SocketAddr) -> Lead<'_> {
        Lead { kind, address, second_port: None, carries_fd: false }
    }
}

/// Lets a link lead elsewhere. What the link says of waiting stays.
pub(super) fn lead(document: &mut DocumentMut, link: &str, to: Lead<'_>) {
    let Some(table) = document["link"][link].as_table_like_mut() else { return };
    let mut led = Table::new();
    led.insert("kind", value(to.kind));
    led.insert("address", value(to.address.to_string()));
    if let Some(second_port) = to.second_port {
        led.insert("second_port", value(i64::from(second_port)));
    }
    if to.kind == "slcan-tcp" {
        let known = |key: &str| table.get(key).cloned();
        let bit_rate = known("bit_rate_bps").unwrap_or_else(|| value(BIT_RATE_BPS));
        led.insert("bit_rate_bps", bit_rate);
        let data_bit_rate = || to.carries_fd.then(|| value(DATA_BIT_RATE_BPS));
        if let Some(rate) = known("data_bit_rate_bps").or_else(data_bit_rate) {
            led.insert("data_bit_rate_bps", rate);
        }
        for key in ["listen_only", "timestamps"] {
            if let Some(known) = known(key) {
                led.insert(key, known);
            }
        }
    }
    for key in ["reconnect_first_ms", "reconnect_max_ms", "stale_after_ms"] {
        if let Some(known) = table.get(key) {
            led.insert(key, known.clone());
        }
    }
    table.clear();
    for (key, item) in led {
        table.insert(&key, item);
    }
}

/// Of a bus that had no adapter; simulated ones take any.
const BIT_RATE_BPS: i64 = 1_000_000;
const DATA_BIT_RATE_BPS: i64 = 2_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_leads_elsewhere_and_waits_as_before() {
        let text = "[link.pair]\nkind = \"tcp-pair\"\naddress = \"10.0.0.1:24691\"\nsecond_port = 24692\n[link.a]\n# Its port.\nkind = \"serial\"\npath = \"/dev/ttyUSB0\"\nbaud_bd = 9600\nstale_after_ms = 50\n\n\
                    [link.bus]\nkind = \"socketcan\"\ninterface = \"can0\"\n";
        let mut document: DocumentMut = text.parse().expect("TOML");
        let address = SocketAddr::from(([127, 0, 0, 1], 4001));
        lead(&mut document, "a", Lead::plain("tcp", address));
        let fd = Lead { carries_fd: true, ..Lead::plain("slcan-tcp", address) };
        lead(&mut document, "bus", fd);
        let pair = Lead { second_port: Some(4002), ..Lead::plain("tcp-pair", address) };
        lead(&mut document, "pair", pair);
        let led = document.to_string();
        let lines: Vec<&str> = led.lines().filter(|line| !line.is_empty()).collect();
        let expected = [
            "[link.pair]",
            "kind = \"tcp-pair\"",
            "address = \"127.0.0.1:4001\"",
            "second_port = 4002",
            "[link.a]",
            "kind = \"tcp\"",
            "address = \"127.0.0.1:4001\"",
            "stale_after_ms = 50",
            "[link.bus]",
            "kind = \"slcan-tcp\"",
            "address = \"127.0.0.1:4001\"",
            "bit_rate_bps = 1000000",
            "data_bit_rate_bps = 2000000",
        ];
        assert_eq!(lines, expected);
    }
}
