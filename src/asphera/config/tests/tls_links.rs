//! Links that speak TLS.

use asphera_transport::{ClientCertificate, TlsSettings};

use super::*;

fn station(link: &str) -> Result<Config, Problems> {
    let text = read(&project("asphera.toml")).unwrap();
    let plain = "address = \"192.168.10.21:502\"";
    assert!(text.contains(plain));
    Config::parse("bench/asphera.toml", &text.replacen(plain, &format!("{plain}\n{link}"), 1))
}

fn endpoint(link: &str) -> Endpoint {
    station(link).unwrap().links[2].endpoint.clone()
}

fn keys(link: &str) -> Vec<String> {
    station(link).unwrap_err().0.into_iter().map(|problem| problem.key).collect()
}

#[test]
fn tls_is_a_word_or_a_table() {
    let address = "192.168.10.21:502".to_owned();
    assert_eq!(endpoint("tls = false"), Endpoint::Tcp { address: address.clone() });
    let tls = TlsSettings::default();
    assert_eq!(
        endpoint("tls = true"),
        Endpoint::Tls { address: address.clone(), tls: tls.clone() }
    );
    assert_eq!(endpoint("tls = {}"), Endpoint::Tls { address: address.clone(), tls });
    let text = read(&project("asphera.toml")).unwrap();
    let shown = text
        .lines()
        .find_map(|line| line.strip_prefix("# ").filter(|line| line.starts_with("tls = {")));
    let client = ClientCertificate {
        certificate: "bench/station.pem".into(),
        key: "bench/station.key".into(),
    };
    let tls = TlsSettings {
        ca: Some("bench/plant.pem".into()),
        server_name: Some("oven.plant".to_owned()),
        client: Some(client),
    };
    assert_eq!(endpoint(shown.unwrap()), Endpoint::Tls { address, tls });
}

#[test]
fn mistakes_of_tls_are_named() {
    assert_eq!(keys("tls = { certificate = \"a.pem\" }"), ["link.thermal.tls.key"]);
    assert_eq!(keys("tls = { key = \"a.key\" }"), ["link.thermal.tls.certificate"]);
    assert_eq!(keys("tls = { ca = \"\" }"), ["link.thermal.tls.ca"]);
    assert_eq!(keys("tls = { cert = \"a.pem\" }"), ["link.thermal.tls.cert"]);
    assert_eq!(keys("tls = 1"), ["link.thermal.tls"]);
    assert_eq!(
        keys(
            "tls = true\n[link.pair]\nkind = \"tcp-pair\"\naddress = \"h:1\"\nsecond_port = 2\ntls = true"
        ),
        ["link.pair.tls"]
    );
}
