//! TLS over real sockets of this machine, with certificates made for the test; peers are rustls and openssl.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair, date_time_ymd};
use tokio::net::TcpListener;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::server::WebPkiClientVerifier;
use tokio_rustls::rustls::{RootCertStore, ServerConfig};

use super::tests::{next, start};
use super::*;
use crate::{ClientCertificate, TlsSettings};

/// A certificate and its key in PEM files.
struct Certificate {
    certificate: PathBuf,
    key: PathBuf,
}

/// An issuer with a folder for the files of all that it issues.
struct Authority {
    folder: tempfile::TempDir,
    issuer: Issuer<'static, KeyPair>,
    own: Certificate,
}

fn written(folder: &Path, name: &str, certificate: &str, key: &KeyPair) -> Certificate {
    let file = |end: &str| folder.join(format!("{name}{end}"));
    std::fs::write(file(".pem"), certificate).unwrap();
    std::fs::write(file(".key"), key.serialize_pem()).unwrap();
    Certificate { certificate: file(".pem"), key: file(".key") }
}

impl Authority {
    fn new(name: &str) -> Authority {
        let folder = tempfile::tempdir().unwrap();
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params.distinguished_name.push(DnType::CommonName, name);
        let own = params.self_signed(&key).unwrap();
        let own = written(folder.path(), "ca", &own.pem(), &key);
        Authority { folder, issuer: Issuer::new(params, key), own }
    }

    fn issue(&self, name: &str, change: impl FnOnce(&mut CertificateParams)) -> Certificate {
        let key = KeyPair::generate().unwrap();
        let mut params = CertificateParams::new(vec![name.to_owned()]).unwrap();
        change(&mut params);
        let certificate = params.signed_by(&key, &self.issuer).unwrap();
        written(self.folder.path(), name, &certificate.pem(), &key)
    }

    fn trusted(&self) -> TlsSettings {
        TlsSettings { ca: Some(self.own.certificate.clone()), ..TlsSettings::default() }
    }
}

/// A server that sends back what it gets, with this certificate; of clients it wants one of `clients`.
async fn echo(server: &Certificate, clients: Option<&Authority>) -> SocketAddr {
    let chain = CertificateDer::pem_file_iter(&server.certificate).unwrap();
    let chain: Vec<_> = chain.collect::<Result<_, _>>().unwrap();
    let key = PrivateKeyDer::from_pem_file(&server.key).unwrap();
    let provider = Arc::new(default_provider());
    let builder = ServerConfig::builder_with_provider(provider.clone())
        .with_safe_default_protocol_versions()
        .unwrap();
    let builder = match clients {
        None => builder.with_no_client_auth(),
        Some(authority) => {
            let mut roots = RootCertStore::empty();
            roots.add(CertificateDer::from_pem_file(&authority.own.certificate).unwrap()).unwrap();
            let verifier = WebPkiClientVerifier::builder_with_provider(Arc::new(roots), provider);
            builder.with_client_cert_verifier(verifier.build().unwrap())
        }
    };
    let acceptor = TlsAcceptor::from(Arc::new(builder.with_single_cert(chain, key).unwrap()));
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            let acceptor = acceptor.clone();
            tokio::spawn(async move {
                let Ok(stream) = acceptor.accept(stream).await else { return };
                let (mut reader, mut writer) = tokio::io::split(stream);
                // The client may go at any time.
                let _ = tokio::io::copy(&mut reader, &mut writer).await;
            });
        }
    });
    address
}

fn link(port: u16, tls: TlsSettings) -> (Link, mpsc::Receiver<LinkEvent>) {
    start(Endpoint::Tls { address: format!("localhost:{port}"), tls })
}

async fn refusal(port: u16, tls: TlsSettings) -> String {
    let (_link, mut events) = link(port, tls);
    match next(&mut events).await {
        What::OpenFailed(words) => words,
        other => panic!("{other:?} instead of a refusal"),
    }
}

async fn echoed(port: u16, tls: TlsSettings) {
    let (link, mut events) = link(port, tls);
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    link.command(LinkCommand::Send { epoch: 1, bytes: b"$VER\r".to_vec() });
    assert_eq!(next(&mut events).await, What::Received(b"$VER\r".to_vec()));
}

#[tokio::test]
async fn bytes_go_both_ways_to_a_server_that_is_known() {
    let authority = Authority::new("plant");
    let server = authority.issue("localhost", |_| ());
    let address = echo(&server, None).await;
    echoed(address.port(), authority.trusted()).await;
    // The certificate itself may be trusted in place of its issuer, where it is none.
    let alone = TlsSettings { ca: Some(server.certificate), ..TlsSettings::default() };
    let words = refusal(address.port(), alone).await;
    assert!(words.contains("set ca to the certificate of its issuer"), "{words}");
}

#[tokio::test]
async fn a_server_under_another_name_is_known_by_server_name() {
    let authority = Authority::new("plant");
    let server = authority.issue("profiler.plant", |_| ());
    let address = echo(&server, None).await;
    let words = refusal(address.port(), authority.trusted()).await;
    assert!(
        words.contains(&format!("no TLS connection to localhost:{}", address.port())),
        "{words}"
    );
    assert!(words.contains("its certificate is not for localhost: set server_name"), "{words}");
    assert!(words.contains("profiler.plant"), "the names it has: {words}");
    let named = Some("profiler.plant".to_owned());
    echoed(address.port(), TlsSettings { server_name: named, ..authority.trusted() }).await;
    let wrong = TlsSettings { server_name: Some("a b".to_owned()), ..authority.trusted() };
    assert!(refusal(address.port(), wrong).await.contains("is no name of a server"));
}

#[tokio::test]
async fn certificates_that_cannot_be_trusted_name_their_cure() {
    let authority = Authority::new("plant");
    let expired = authority.issue("localhost", |params| {
        params.not_before = date_time_ymd(2019, 1, 1);
        params.not_after = date_time_ymd(2020, 1, 1);
    });
    let words = refusal(echo(&expired, None).await.port(), authority.trusted()).await;
    assert!(words.contains("its certificate has expired: renew it"), "{words}");

    let early = authority.issue("localhost", |params| {
        params.not_before = date_time_ymd(3000, 1, 1);
        params.not_after = date_time_ymd(3001, 1, 1);
    });
    let words = refusal(echo(&early, None).await.port(), authority.trusted()).await;
    assert!(words.contains("not valid yet: check the clocks"), "{words}");

    let other = Authority::new("another plant");
    let server = other.issue("localhost", |_| ());
    let words = refusal(echo(&server, None).await.port(), authority.trusted()).await;
    assert!(words.contains("nobody who is trusted issued its certificate: set ca"), "{words}");

    // As `openssl req -x509` makes them.
    let words = refusal(echo(&other.own, None).await.port(), other.trusted()).await;
    assert!(words.contains("with basicConstraints=CA:FALSE"), "{words}");
}

#[tokio::test]
async fn a_server_that_wants_to_know_its_client() {
    let authority = Authority::new("plant");
    let server = authority.issue("localhost", |_| ());
    let clients = Authority::new("stations");
    let port = echo(&server, Some(&clients)).await.port();
    let own = |from: &Certificate| {
        let (certificate, key) = (from.certificate.clone(), from.key.clone());
        TlsSettings { client: Some(ClientCertificate { certificate, key }), ..authority.trusted() }
    };
    echoed(port, own(&clients.issue("station", |_| ()))).await;
    // With TLS 1.3 the server says no after the handshake.
    for (settings, cure) in [
        (authority.trusted(), "set certificate and key"),
        (
            own(&authority.issue("stranger", |_| ())),
            "does not trust the certificate of this client",
        ),
    ] {
        let (_link, mut events) = link(port, settings);
        assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
        match next(&mut events).await {
            What::Closed(words) => assert!(words.contains(cure), "{words}"),
            other => panic!("{other:?} instead of a loss"),
        }
    }
}

#[tokio::test]
async fn a_port_without_tls_is_named() {
    let authority = Authority::new("plant");
    let talking = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let silent = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let ports = [&talking, &silent].map(|listener| listener.local_addr().unwrap().port());
    tokio::spawn(async move {
        while let Ok((mut stream, _)) = talking.accept().await {
            // The client goes when it understands nothing.
            let _ = stream.write_all(b"220 profiler ready\r\n").await;
        }
    });
    let words = refusal(ports[0], authority.trusted()).await;
    assert!(words.contains("it does not speak TLS: remove tls"), "{words}");
    let words = refusal(ports[1], authority.trusted()).await;
    assert!(words.contains("it says nothing in TLS: remove tls"), "{words}");
}

#[tokio::test]
async fn files_that_cannot_be_used_are_named() {
    let authority = Authority::new("plant");
    let server = authority.issue("localhost", |_| ());
    let port = echo(&server, None).await.port();
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let ca = |path: PathBuf| TlsSettings { ca: Some(path), ..TlsSettings::default() };
    let words = refusal(port, ca(folder.path().join("none.pem"))).await;
    assert!(
        words.contains("none.pem: expected a PEM file with certificates of issuers"),
        "{words}"
    );
    let words = refusal(port, ca(file("empty.pem", "no certificate\n"))).await;
    assert!(words.contains("empty.pem") && words.contains("no certificate in it"), "{words}");
    let client = ClientCertificate {
        certificate: server.certificate.clone(),
        key: file(
            "locked.key",
            "-----BEGIN ENCRYPTED PRIVATE KEY-----\nAAAA\n-----END ENCRYPTED PRIVATE KEY-----\n",
        ),
    };
    let words = refusal(port, TlsSettings { client: Some(client), ..authority.trusted() }).await;
    assert!(
        words.contains("locked.key: expected a PEM file with its private key, not encrypted"),
        "{words}"
    );
    let client = ClientCertificate {
        certificate: server.certificate.clone(),
        key: authority.own.key.clone(),
    };
    let words = refusal(port, TlsSettings { client: Some(client), ..authority.trusted() }).await;
    assert!(words.contains("cannot be used together"), "{words}");
}

/// The process of an openssl; it ends with the test.
struct Openssl(Child);

impl Drop for Openssl {
    fn drop(&mut self) {
        // It may have ended; then there is nothing to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A peer that shares no code with this one, with TLS 1.2 and 1.3 and a client that it knows.
#[tokio::test(flavor = "multi_thread")]
async fn openssl_is_understood() {
    let is_there = Command::new("openssl").arg("version").output();
    if is_there.is_err() {
        return skipped("openssl is not installed");
    }
    let authority = Authority::new("plant");
    let server = authority.issue("localhost", |_| ());
    let own = authority.issue("station", |_| ());
    for version in ["-tls1_2", "-tls1_3"] {
        let mut peer = Openssl(
            Command::new("openssl")
                .args(["s_server", "-accept", "127.0.0.1:0", version, "-Verify", "1"])
                .arg("-verify_return_error")
                .arg("-CAfile")
                .arg(&authority.own.certificate)
                .arg("-cert")
                .arg(&server.certificate)
                .arg("-key")
                .arg(&server.key)
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .spawn()
                .unwrap(),
        );
        let mut lines = BufReader::new(peer.0.stdout.take().unwrap()).lines();
        let accept = lines
            .find_map(|line| line.ok()?.strip_prefix("ACCEPT ")?.rsplit_once(':')?.1.parse().ok());
        let client =
            ClientCertificate { certificate: own.certificate.clone(), key: own.key.clone() };
        let settings = TlsSettings { client: Some(client), ..authority.trusted() };
        let (link, mut events) = link(accept.unwrap(), settings);
        assert_eq!(next(&mut events).await, What::Opened { epoch: 1 }, "{version}");
        let mut stdin = peer.0.stdin.take().unwrap();
        stdin.write_all(b"1.2345\n").unwrap();
        assert_eq!(next(&mut events).await, What::Received(b"1.2345\n".to_vec()));
        link.command(LinkCommand::Send { epoch: 1, bytes: b"from the link\n".to_vec() });
        assert!(lines.any(|line| line.is_ok_and(|line| line.ends_with("from the link"))));
        drop(peer);
        assert!(matches!(next(&mut events).await, What::Closed(_)));
    }
}

/// Says that a test was skipped, and why.
fn skipped(why: &str) {
    eprintln!("skipped: {why}");
}

/// Files that a check can find out, each by its name: missing, no PEM, another PEM, expired, not valid yet, a foreign key.
#[test]
fn a_check_names_files_that_cannot_be_used() {
    let authority = Authority::new("plant");
    let folder = authority.folder.path().to_owned();
    // 2026-11-27.
    let now_s = 1_795_737_600;
    let words = |tls: &TlsSettings| -> Vec<String> {
        tls.file_problems(now_s).iter().map(ToString::to_string).collect()
    };
    assert!(words(&TlsSettings::default()).is_empty());
    assert!(words(&authority.trusted()).is_empty());
    std::fs::write(folder.join("text.pem"), "no certificate\n").unwrap();
    let expired = authority.issue("old", |params| params.not_after = date_time_ymd(2025, 3, 1));
    let early = authority.issue("early", |params| params.not_before = date_time_ymd(2027, 1, 2));
    let fine = authority.issue("fine", |_| ());
    let client = |certificate: &Path, key: &Path| {
        let (certificate, key) = (certificate.to_owned(), key.to_owned());
        let client = Some(ClientCertificate { certificate, key });
        TlsSettings { client, ..authority.trusted() }
    };
    assert!(words(&client(&fine.certificate, &fine.key)).is_empty());
    let missing = TlsSettings { ca: Some(folder.join("missing.pem")), ..TlsSettings::default() };
    let text = TlsSettings { ca: Some(folder.join("text.pem")), ..TlsSettings::default() };
    for (tls, file, found) in [
        (missing, "missing.pem", "No such file"),
        (text, "text.pem", "no certificate in it"),
        (client(&expired.certificate, &expired.key), "old.pem", "expired on Mar  1"),
        (client(&early.certificate, &early.key), "early.pem", "is not valid before Jan  2"),
        (client(&fine.certificate, &folder.join("none.key")), "none.key", "No such file"),
        (client(&fine.certificate, &fine.certificate), "fine.pem", "its private key"),
        (client(&fine.certificate, &expired.key), "", "cannot be used together"),
    ] {
        let words = words(&tls);
        let [words] = &words[..] else { panic!("{file}: {words:?}") };
        assert!(words.contains(file) && words.contains(found), "{file}: {words}");
    }
}
