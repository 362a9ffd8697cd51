//! TLS over TCP: certificates, and what is wrong with them in words for a person.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use thiserror::Error;
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::pki_types::ServerName;
use tokio_rustls::rustls::{
    AlertDescription, CertificateError, ClientConfig, Error as RustlsError, RootCertStore, crypto,
};

use crate::certificates::{ISSUERS, certificates, unusable};

/// How a server of TLS is known, and how it knows us.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TlsSettings {
    /// PEM file with the certificates of the issuers that are trusted; `None`: those that the system trusts.
    pub ca: Option<PathBuf>,
    /// Name or IP address that its certificate must have; `None`: the host of the address.
    pub server_name: Option<String>,
    /// Certificate by which the server knows us.
    pub client: Option<ClientCertificate>,
}

/// Certificate of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClientCertificate {
    /// PEM file with the certificate, and those between it and its issuer.
    pub certificate: PathBuf,
    /// PEM file with its private key, not encrypted.
    pub key: PathBuf,
}

/// Why a connection of TCP does not become one of TLS.
#[derive(Debug, Error)]
pub enum TlsError {
    /// A file of the settings cannot be used.
    #[error("cannot use {path}: expected a PEM file with {expected}: {found}")]
    File {
        /// The file.
        path: String,
        /// Content that it should have.
        expected: &'static str,
        /// What is wrong.
        found: String,
    },
    /// A certificate of a file is not valid now.
    #[error(
        "{path}: the certificate of {subject} {why}: renew it, and check the clock of this computer"
    )]
    Validity {
        /// The file.
        path: String,
        /// Its name in the certificate.
        subject: String,
        /// What is wrong, with the date.
        why: String,
    },
    /// The system trusts nobody.
    #[error("the system has no certificates of issuers: install ca-certificates, or set ca")]
    NoRoots,
    /// The certificate and the key of the client do not fit.
    #[error("certificate and key of tls cannot be used together: {0}")]
    Client(RustlsError),
    /// The host is neither a name nor an address.
    #[error("{0:?} is no name of a server: set server_name")]
    Name(String),
    /// The provider of ciphers has none for these versions.
    #[error("TLS cannot be set up: {0}")]
    Setup(RustlsError),
    /// The handshake failed.
    #[error("no TLS connection to {address}; {cure}")]
    Handshake {
        /// The address tried.
        address: String,
        /// Cure in words for a person.
        cure: String,
        /// What the other end said or did.
        source: io::Error,
    },
}

/// Makes a TLS connection of one of TCP, within a few seconds. Files are read anew, so that a renewed certificate counts.
pub(crate) async fn connect(
    stream: TcpStream,
    address: &str,
    settings: &TlsSettings,
) -> Result<TlsStream<TcpStream>, TlsError> {
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    let name = settings.server_name.as_deref().unwrap_or(host).to_owned();
    let server = ServerName::try_from(name.clone()).map_err(|_| TlsError::Name(name.clone()))?;
    let connector = TlsConnector::from(Arc::new(client(settings)?));
    let shaken = timeout(HANDSHAKE_TIMEOUT, connector.connect(server, stream)).await;
    shaken.unwrap_or_else(|_| Err(io::ErrorKind::TimedOut.into())).map_err(|source| {
        let cure = cure(&source, &name).unwrap_or_else(|| "check the port and its log".to_owned());
        TlsError::Handshake { address: address.to_owned(), cure, source }
    })
}

/// What a connection is made with, of files that are read now.
pub(crate) fn client(settings: &TlsSettings) -> Result<ClientConfig, TlsError> {
    let provider = Arc::new(crypto::ring::default_provider());
    let builder = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(TlsError::Setup)?
        .with_root_certificates(roots(settings.ca.as_deref())?);
    match settings.identity()? {
        Some((chain, key)) => builder.with_client_auth_cert(chain, key).map_err(TlsError::Client),
        None => Ok(builder.with_no_client_auth()),
    }
}

/// Issuers that are trusted.
fn roots(ca: Option<&Path>) -> Result<RootCertStore, TlsError> {
    let mut roots = RootCertStore::empty();
    let Some(ca) = ca else {
        // A store of the system may have certificates that nobody can use; the others count.
        roots.add_parsable_certificates(rustls_native_certs::load_native_certs().certs);
        return if roots.is_empty() { Err(TlsError::NoRoots) } else { Ok(roots) };
    };
    for certificate in certificates(ca, ISSUERS)? {
        roots.add(certificate).map_err(|error| unusable(ca, ISSUERS, &error))?;
    }
    Ok(roots)
}

/// Cure of a failure of TLS, in words for a person; `None` where the error is of another kind.
pub(crate) fn cure(error: &io::Error, name: &str) -> Option<String> {
    if error.kind() == io::ErrorKind::TimedOut {
        return Some("it says nothing in TLS: remove tls, or use its port for TLS".to_owned());
    }
    let error = error.get_ref()?.downcast_ref::<RustlsError>()?;
    Some(match error {
        RustlsError::InvalidMessage(_) => {
            "it does not speak TLS: remove tls, or use its port for TLS".to_owned()
        }
        RustlsError::InvalidCertificate(why) => of_certificate(why, name),
        RustlsError::AlertReceived(alert) => of_alert(*alert).to_owned(),
        _ => return None,
    })
}

fn of_certificate(why: &CertificateError, name: &str) -> String {
    match why {
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
            "its certificate has expired: renew it, and check the clocks of both computers".to_owned()
        }
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
            "its certificate is not valid yet: check the clocks of both computers".to_owned()
        }
        CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => {
            format!("its certificate is not for {name}: set server_name to a name that it has")
        }
        CertificateError::UnknownIssuer => {
            "nobody who is trusted issued its certificate: set ca to the certificate of its issuer".to_owned()
        }
        // A certificate that signed itself says of itself that it issues others.
        _ if format!("{why:?}").contains("CaUsedAsEndEntity") => {
            "its certificate is one of an issuer: make one for the server, with basicConstraints=CA:FALSE".to_owned()
        }
        _ => "its certificate cannot be trusted: make a new one".to_owned(),
    }
}

fn of_alert(alert: AlertDescription) -> &'static str {
    match alert {
        AlertDescription::CertificateRequired | AlertDescription::NoCertificate => {
            "it wants a certificate of this client: set certificate and key"
        }
        AlertDescription::CertificateExpired => {
            "the certificate of this client has expired: renew it"
        }
        AlertDescription::BadCertificate
        | AlertDescription::CertificateUnknown
        | AlertDescription::CertificateRevoked
        | AlertDescription::UnsupportedCertificate
        | AlertDescription::AccessDenied
        | AlertDescription::UnknownCA => {
            "it does not trust the certificate of this client: let an issuer that it trusts sign it"
        }
        AlertDescription::ProtocolVersion => "it speaks no TLS 1.2 or 1.3: update it",
        AlertDescription::HandshakeFailure => {
            "it has no cipher in common, or wants a certificate of this client: set certificate and key"
        }
        AlertDescription::UnrecognisedName => "it does not know this name: set server_name",
        _ => "see its log",
    }
}

const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(5);
