//! Certificates and keys in PEM files, and what is wrong with them.

use std::path::Path;

use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use x509_parser::certificate::X509Certificate;
use x509_parser::prelude::FromDer as _;

use crate::tls::{TlsError, TlsSettings, client};

/// Content that the files should have.
pub(crate) const ISSUERS: &str = "certificates of issuers";
const OWN: &str = "the certificate of this client";
const KEY: &str = "its private key, not encrypted";

impl TlsSettings {
    /// Everything that is wrong with the files at this time, in seconds since 1970 (UTC): missing, no PEM, expired or not valid yet, a key of
    /// another certificate. Of several issuers one that is valid will do. Without files nothing is.
    pub fn file_problems(&self, unix_s: i64) -> Vec<TlsError> {
        let mut problems = Vec::new();
        if let Some(ca) = &self.ca {
            match certificates(ca, ISSUERS) {
                Ok(issuers) => {
                    let mut found: Vec<_> =
                        issuers.iter().map(|one| validity(ca, one, unix_s)).collect();
                    if found.iter().all(Result::is_err) {
                        problems.extend(found.drain(..1).filter_map(Result::err));
                    }
                }
                Err(error) => problems.push(error),
            }
        }
        if let Some(own) = &self.client {
            match certificates(&own.certificate, OWN) {
                Ok(chain) => {
                    let expired = chain.iter().map(|one| validity(&own.certificate, one, unix_s));
                    problems.extend(expired.filter_map(Result::err));
                }
                Err(error) => problems.push(error),
            }
            problems.extend(private_key(&own.key).err());
        }
        if problems.is_empty() && (self.ca.is_some() || self.client.is_some()) {
            // What is left: a certificate that nothing can be made of, and a key of another one.
            problems.extend(client(self).err());
        }
        problems
    }

    /// The certificate of this client with those between it and its issuer, and its key; `None` where it has none.
    pub(crate) fn identity(
        &self,
    ) -> Result<Option<(Vec<CertificateDer<'static>>, PrivateKeyDer<'static>)>, TlsError> {
        let Some(own) = &self.client else { return Ok(None) };
        Ok(Some((certificates(&own.certificate, OWN)?, private_key(&own.key)?)))
    }
}

/// All certificates of a file, at least one.
pub(crate) fn certificates(
    path: &Path,
    expected: &'static str,
) -> Result<Vec<CertificateDer<'static>>, TlsError> {
    let all: Result<Vec<_>, _> = CertificateDer::pem_file_iter(path).and_then(Iterator::collect);
    let all = all.map_err(|error| unusable(path, expected, &error))?;
    if all.is_empty() {
        return Err(unusable(path, expected, &"no certificate in it"));
    }
    Ok(all)
}

fn private_key(path: &Path) -> Result<PrivateKeyDer<'static>, TlsError> {
    PrivateKeyDer::from_pem_file(path).map_err(|error| unusable(path, KEY, &error))
}

pub(crate) fn unusable(path: &Path, expected: &'static str, found: &impl ToString) -> TlsError {
    TlsError::File { path: path.display().to_string(), expected, found: found.to_string() }
}

/// Whether a certificate of a file is valid at a time.
fn validity(path: &Path, certificate: &CertificateDer<'_>, unix_s: i64) -> Result<(), TlsError> {
    let (_, certificate) = X509Certificate::from_der(certificate).map_err(|_| {
        unusable(path, "X.509 certificates", &"another content between the PEM lines")
    })?;
    let validity = certificate.validity();
    let found = match (validity.not_before, validity.not_after) {
        (_, until) if until.timestamp() < unix_s => ("expired on", until),
        (from, _) if from.timestamp() > unix_s => ("is not valid before", from),
        _ => return Ok(()),
    };
    Err(TlsError::Validity {
        path: path.display().to_string(),
        subject: certificate.subject().to_string(),
        why: format!("{} {}", found.0, found.1),
    })
}
