//! Links by TLS through the daemon, with certificates made for the test: rustls is the server.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use asphera_tests::{asphera, count, json, number, run};
use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair, date_time_ymd};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Runtime;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use toml_edit::{InlineTable, Value, value};

use crate::demo::timeless;
use crate::simulated_station::Simulated;

/// An issuer that writes all its certificates into one folder.
struct Authority<'a> {
    folder: &'a Path,
    issuer: Issuer<'static, KeyPair>,
}

impl Authority<'_> {
    fn new(folder: &Path) -> Authority<'_> {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let own = params.self_signed(&key).unwrap();
        std::fs::write(folder.join("ca.pem"), own.pem()).unwrap();
        Authority { folder, issuer: Issuer::new(params, key) }
    }

    fn issue(&self, name: &str, change: impl FnOnce(&mut CertificateParams)) -> [PathBuf; 2] {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
        change(&mut params);
        let certificate = params.signed_by(&key, &self.issuer).unwrap();
        let files = [".pem", ".key"].map(|end| self.folder.join(format!("{name}{end}")));
        std::fs::write(&files[0], certificate.pem()).unwrap();
        std::fs::write(&files[1], key.serialize_pem()).unwrap();
        files
    }
}

/// A server that speaks TLS and hands every connection on to a server that does not.
fn in_tls(runtime: &Runtime, [certificate, key]: &[PathBuf; 2], behind: String) -> SocketAddr {
    let chain = vec![CertificateDer::from_pem_file(certificate).unwrap()];
    let key = PrivateKeyDer::from_pem_file(key).unwrap();
    let config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_no_client_auth()
        .with_single_cert(chain, key)
        .unwrap();
    let acceptor = TlsAcceptor::from(Arc::new(config));
    let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).unwrap();
    let address = listener.local_addr().unwrap();
    runtime.spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            let (acceptor, behind) = (acceptor.clone(), behind.clone());
            tokio::spawn(async move {
                let Ok(mut stream) = acceptor.accept(stream).await else { return };
                let Ok(mut device) = TcpStream::connect(behind).await else { return };
                // Either side may go at any time.
                let _ = tokio::io::copy_bidirectional(&mut stream, &mut device).await;
            });
        }
    });
    address
}

fn table(entries: &[(&str, &Path)]) -> toml_edit::Item {
    let entry =
        |(key, path): &(&str, &Path)| ((*key).to_owned(), Value::from(path.display().to_string()));
    value(entries.iter().map(entry).collect::<InlineTable>())
}

/// Measures over TLS to a verdict; the replay, which needs no certificate, gives the same.
#[test]
fn a_station_measures_over_tls() {
    let folder = tempfile::tempdir().unwrap();
    let server = Authority::new(folder.path()).issue("server", |_| ());
    let options = ["--form-nm", "9000", "--noise-nm", "0", "--points", "4000"];
    let simulated = Simulated::start("config/examples/laser-sensor.toml", &options);
    let runtime = Runtime::new().unwrap();
    let ca = folder.path().join("ca.pem");
    simulated.change(|station| {
        let link = &mut station["link"]["counter"];
        let behind = link["address"].as_str().unwrap().to_owned();
        let address = in_tls(&runtime, &server, behind);
        link["address"] = value(format!("localhost:{}", address.port()));
        link["tls"] = table(&[("ca", &ca)]);
    });
    let (code, report) = simulated.measure();
    assert_eq!(code, 0, "{:#}", report["verdict"]);
    let pv_nm = number(&report, "/form/deviation/pv_nm");
    assert!((5000.0..=9300.0).contains(&pv_nm), "{pv_nm} nm");
    assert!(count(&report, "/points/used") > 3900, "{:#}", report["points"]);
    std::fs::remove_file(ca).unwrap();
    let session = simulated.session();
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!(timeless(replayed), timeless(report));
}

/// `check` names files that are missing, no PEM or expired, with their link; nothing is connected.
#[test]
fn check_names_certificates_that_cannot_be_used() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new(folder.path());
    let own = authority.issue("own", |_| ());
    let old = authority.issue("old", |params| params.not_after = date_time_ymd(2025, 3, 1));
    let ca = folder.path().join("ca.pem");
    std::fs::write(folder.path().join("text.pem"), "no certificate").unwrap();
    let checked = |entries: &[(&str, &Path)]| {
        let text = std::fs::read_to_string(
            asphera_tests::root().join("config/examples/laser-sensor.toml"),
        );
        let mut station: toml_edit::DocumentMut = text.unwrap().parse().unwrap();
        station["link"]["counter"]["tls"] = table(entries);
        let file = folder.path().join("station.toml");
        std::fs::write(&file, station.to_string()).unwrap();
        let output = std::process::Command::new(asphera())
            .args(["check", "--config"])
            .arg(file)
            .output()
            .unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(said).unwrap())
    };
    let (code, said) = checked(&[("ca", &ca), ("certificate", &own[0]), ("key", &own[1])]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("clock: host, as bytes are read"), "{said}");
    let none = folder.path().join("none.pem");
    let text = folder.path().join("text.pem");
    for (entries, file, found) in [
        (vec![("ca", &*none)], "none.pem", "No such file"),
        (vec![("ca", &*text)], "text.pem", "no certificate in it"),
        (vec![("ca", &*ca), ("certificate", &*old[0]), ("key", &*old[1])], "old.pem", "expired on"),
        (
            vec![("ca", &*ca), ("certificate", &*own[0]), ("key", &*none)],
            "none.pem",
            "No such file",
        ),
    ] {
        let (code, said) = checked(&entries);
        assert_eq!(code, Some(1), "{said}");
        for words in ["link.counter.tls", file, found] {
            assert!(said.contains(words), "{words}: {said}");
        }
    }
}
