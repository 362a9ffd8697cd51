//! A configuration whose links lead to simulated devices.

use std::net::SocketAddr;

use toml_edit::{DocumentMut, Table, value};

/// Lets a link lead to a port of this computer. `kind` is `tcp` or `slcan-tcp`. What the link says of waiting stays.
pub(super) fn lead(document: &mut DocumentMut, link: &str, kind: &str, address: SocketAddr) {
    let Some(table) = document["link"][link].as_table_like_mut() else { return };
    let mut led = Table::new();
    led.insert("kind", value(kind));
    led.insert("address", value(address.to_string()));
    let bit_rate = table.get("bit_rate_bps").cloned();
    if kind == "slcan-tcp" {
        led.insert("bit_rate_bps", bit_rate.unwrap_or_else(|| value(BIT_RATE_BPS)));
        if let Some(known) = table.get("listen_only") {
            led.insert("listen_only", known.clone());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_leads_elsewhere_and_waits_as_before() {
        let text = "[link.a]\n# Its port.\nkind = \"serial\"\npath = \"/dev/ttyUSB0\"\nbaud_bd = 9600\nstale_after_ms = 50\n\n\
                    [link.bus]\nkind = \"socketcan\"\ninterface = \"can0\"\n";
        let mut document: DocumentMut = text.parse().expect("TOML");
        let address = SocketAddr::from(([127, 0, 0, 1], 4001));
        lead(&mut document, "a", "tcp", address);
        lead(&mut document, "bus", "slcan-tcp", address);
        let led = document.to_string();
        let lines: Vec<&str> = led.lines().filter(|line| !line.is_empty()).collect();
        let expected = [
            "[link.a]",
            "kind = \"tcp\"",
            "address = \"127.0.0.1:4001\"",
            "stale_after_ms = 50",
            "[link.bus]",
            "kind = \"slcan-tcp\"",
            "address = \"127.0.0.1:4001\"",
            "bit_rate_bps = 1000000",
        ];
        assert_eq!(lines, expected);
    }
}
