//! Who may ask: host, origin and token, and the headers every answer carries.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::extract::{ConnectInfo, Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::problem::Problem;
use super::server::Shared;
use super::token::Token;

/// Refuses requests under a foreign host name or from a foreign page (403), and adds the security
/// headers to every answer.
pub(super) async fn every(
    State(shared): State<Arc<Shared>>,
    request: Request,
    next: Next,
) -> Response {
    let api = request.uri().path().starts_with("/api");
    let uri_authority = request.uri().authority().cloned();
    let mut response =
        match check_site(request.headers(), uri_authority.as_ref(), &shared.allowed_hosts) {
            Ok(()) => next.run(request).await,
            Err(problem) => {
                tracing::warn!(%problem, "request refused");
                problem.into_response()
            }
        };
    add_headers(response.headers_mut(), api);
    response
}

/// Reads: from this machine free, from another one only with the token.
pub(super) async fn reader(
    State(shared): State<Arc<Shared>>,
    ConnectInfo(peer): ConnectInfo<SocketAddr>,
    request: Request,
    next: Next,
) -> Response {
    match check_reader(peer.ip(), request.headers(), &shared.token) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    }
}

/// Controls: only with the token.
pub(super) async fn controller(
    State(shared): State<Arc<Shared>>,
    request: Request,
    next: Next,
) -> Response {
    match check_token(request.headers(), &shared.token) {
        Ok(()) => next.run(request).await,
        Err(problem) => {
            tracing::warn!(path = request.uri().path(), "control refused: no valid token");
            problem.into_response()
        }
    }
}

fn check_site(
    headers: &HeaderMap,
    uri_authority: Option<&Authority>,
    allowed: &[String],
) -> Result<(), Problem> {
    let host = single(headers, &header::HOST)
        .and_then(|text| text.parse::<Authority>().ok())
        .filter(|host| !host.as_str().contains('@'))
        .ok_or_else(|| {
            Problem::new(StatusCode::FORBIDDEN, "the request names no host")
                .expected("one valid Host header")
        })?;
    if uri_authority.is_some_and(|uri| !uri.as_str().eq_ignore_ascii_case(host.as_str())) {
        return Err(Problem::new(StatusCode::FORBIDDEN, "the request names two hosts")
            .expected("the same host in the request line and the Host header")
            .found(host.as_str()));
    }
    if !is_trusted(host.host(), allowed) {
        return Err(Problem::new(StatusCode::FORBIDDEN, "unknown host name")
            .expected("localhost, an IP address or a name of the allow-list")
            .found(host.host())
            .hint("open the address printed at start, or add the name to the allowed hosts"));
    }
    if !headers.contains_key(header::ORIGIN) {
        return Ok(());
    }
    let origin = single(headers, &header::ORIGIN).unwrap_or("several");
    if is_same_site(origin, &host) {
        return Ok(());
    }
    Err(Problem::new(StatusCode::FORBIDDEN, "request from a foreign page")
        .expected(format!("an Origin of {host}"))
        .found(origin)
        .hint("a proxy must pass on the Host header of the browser"))
}

/// A name can be rebound to any address, an IP literal cannot.
fn is_trusted(host: &str, allowed: &[String]) -> bool {
    let literal = host.strip_prefix('[').and_then(|h| h.strip_suffix(']')).unwrap_or(host);
    literal.parse::<IpAddr>().is_ok()
        || host.eq_ignore_ascii_case("localhost")
        || allowed.iter().any(|name| name.eq_ignore_ascii_case(host))
}

/// Whether `origin` (RFC 6454 section 6.1: scheme, host, port) is the site `host`. The scheme does not count:
/// a proxy may add TLS in front of us.
fn is_same_site(origin: &str, host: &Authority) -> bool {
    let (rest, default_port) = match origin.split_once("://") {
        Some(("http", rest)) => (rest, 80),
        Some(("https", rest)) => (rest, 443),
        _ => return false,
    };
    let Ok(origin) = rest.parse::<Authority>() else { return false };
    !origin.as_str().contains('@')
        && origin.host().eq_ignore_ascii_case(host.host())
        && origin.port_u16().unwrap_or(default_port) == host.port_u16().unwrap_or(default_port)
}

fn check_reader(peer: IpAddr, headers: &HeaderMap, token: &Token) -> Result<(), Problem> {
    // An IPv4 client of an IPv6 socket has a mapped address.
    if peer.to_canonical().is_loopback() { Ok(()) } else { check_token(headers, token) }
}

fn check_token(headers: &HeaderMap, token: &Token) -> Result<(), Problem> {
    let candidate = single(headers, &header::AUTHORIZATION)
        .and_then(|value| value.split_once(' '))
        .filter(|(scheme, _)| scheme.eq_ignore_ascii_case("Bearer"))
        .map(|(_, token)| token.trim())
        .or_else(|| token_protocol(headers));
    match candidate {
        None => Err(Problem::new(StatusCode::UNAUTHORIZED, "this needs the token")
            .expected("Authorization: Bearer TOKEN")
            .hint("the token stands behind #token= in the address printed at start, unless ASPHERA_TOKEN or --token-file sets it")),
        Some(candidate) if token.matches(candidate) => Ok(()),
        // The candidate is not repeated: it may be the token of another station.
        Some(_) => Err(Problem::new(StatusCode::FORBIDDEN, "wrong token").hint(
            "a random token changes at every start of the daemon: use the address printed last",
        )),
    }
}

/// The token among the WebSocket subprotocols: the only header a page may choose for a WebSocket.
fn token_protocol(headers: &HeaderMap) -> Option<&str> {
    headers
        .get_all(header::SEC_WEBSOCKET_PROTOCOL)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .find_map(|protocol| protocol.trim().strip_prefix(TOKEN_PROTOCOL))
}

/// The value of a header that must stand once. Two different ones would let two readers disagree.
fn single<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let first = values.next()?;
    if values.next().is_some() { None } else { first.to_str().ok() }
}

/// Adds the security headers that an answer does not have.
pub(super) fn add_headers(headers: &mut HeaderMap, api: bool) {
    let cache = if api { "no-store" } else { "no-cache" };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, CONTENT_POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, cache),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ] {
        // A report has a policy of its own.
        headers.entry(name).or_insert(HeaderValue::from_static(value));
    }
}

/// Everything from this server and nothing else; no inline script or style, no frame, no form.
const CONTENT_POLICY: &str = "default-src 'self'; base-uri 'none'; object-src 'none'; \
                              frame-ancestors 'none'; form-action 'none'";

const TOKEN_PROTOCOL: &str = "asphera.token.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_literals_localhost_or_listed() {
        let allowed = ["station7.lab.example".to_owned()];
        for host in
            ["localhost", "LOCALHOST", "127.0.0.1", "[::1]", "192.168.1.20", "Station7.lab.example"]
        {
            assert!(is_trusted(host, &allowed), "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example",
            "127.0.0.1.nip.io",
            "0x7f.1",
            "",
            "localhost.",
        ] {
            assert!(!is_trusted(host, &allowed), "{host}");
        }
    }

    #[test]
    fn another_machine_reads_only_with_the_token() {
        let token = Token::parse("0123456789abcdef").unwrap();
        let ask = |peer: &str, header: Option<(HeaderName, &str)>| {
            let headers = header.map(|(name, value)| (name, value.parse().unwrap()));
            check_reader(peer.parse().unwrap(), &headers.into_iter().collect(), &token).is_ok()
        };
        for peer in ["127.0.0.1", "127.8.8.8", "::1", "::ffff:127.0.0.1"] {
            assert!(ask(peer, None), "{peer}");
        }
        for peer in ["192.168.1.9", "::ffff:10.0.0.1", "2001:db8::1", "0.0.0.0"] {
            assert!(!ask(peer, None), "{peer}");
            let bearer = |text| Some((header::AUTHORIZATION, text));
            assert!(ask(peer, bearer("Bearer 0123456789abcdef")), "{peer}");
            assert!(!ask(peer, bearer("Bearer 0123456789abcdeX")), "{peer}");
            let protocol = |text| Some((header::SEC_WEBSOCKET_PROTOCOL, text));
            assert!(ask(peer, protocol("asphera.snapshot.v1, asphera.token.0123456789abcdef")));
            assert!(!ask(peer, protocol("asphera.snapshot.v1, asphera.token.")), "{peer}");
            assert!(!ask(peer, protocol("asphera.snapshot.v1")), "{peer}");
        }
    }

    #[test]
    fn origin_is_the_host_with_its_port() {
        let same = |origin: &str, host: &str| is_same_site(origin, &host.parse().unwrap());
        assert!(same("http://localhost:8080", "localhost:8080"));
        assert!(same("http://[::1]:8080", "[::1]:8080"));
        assert!(same("http://10.0.0.3", "10.0.0.3:80"));
        assert!(same("https://lab.example", "lab.example"));
        assert!(!same("http://localhost:3000", "localhost:8080"));
        assert!(!same("http://localhost", "localhost:8080"));
        assert!(!same("http://127.0.0.1:8080", "localhost:8080"));
        assert!(!same("http://evil.example", "localhost:8080"));
        assert!(!same("http://localhost:8080@evil.example", "localhost:8080"));
        assert!(!same("null", "localhost:8080"));
        assert!(!same("file://", "localhost:8080"));
    }
}
