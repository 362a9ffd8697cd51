//! The routes and what each answers.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use asphera_report::{ControlError, Label, ResultFile, Snapshot};
use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::{DefaultBodyLimit, Path, State};
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router, middleware};
use serde_json::json;

use super::problem::Problem;
use super::server::{Shared, TextRoute};
use super::{assets, files, guard, query, stream};

/// All routes, without the checks of [`guard::every`].
pub(super) fn router(shared: &Arc<Shared>, texts: &[TextRoute]) -> Router {
    let mut reads = Router::new()
        .route("/api/v1/snapshot", get(snapshot))
        .route("/api/v1/stream", get(open_stream))
        .route("/api/v1/mesh.ply", get(mesh))
        .route("/api/v1/maps", get(maps))
        .route("/api/v1/contour", get(contour))
        .route("/api/v1/parts", get(parts))
        .route("/api/v1/volume", get(volume))
        .route("/api/v1/volume/slice", get(slice))
        .route("/api/v1/section", get(section))
        .route("/api/v1/form", get(form))
        .route("/api/v1/waypoints.csv", get(waypoints))
        .route("/api/v1/report", get(report))
        .route("/api/v1/sessions", get(sessions))
        .route("/api/v1/sessions/{id}/{file}", get(session_file))
        .route("/api/v1/links", get(links));
    for &TextRoute { path, content_type, text } in texts {
        let answer = async move |State(shared): State<Arc<Shared>>| {
            ([(header::CONTENT_TYPE, content_type)], text(&newest(&shared)))
        };
        reads = reads.route(path, get(answer));
    }
    let reads =
        reads.route_layer(middleware::from_fn_with_state(Arc::clone(shared), guard::reader));
    let controls = Router::new()
        .route("/api/v1/session/start", post(start))
        .route("/api/v1/session/stop", post(stop))
        .route("/api/v1/scan/arm", post(arm_scan))
        .route("/api/v1/scan/stop", post(halt_scan))
        .layer(DefaultBodyLimit::max(LABEL_BYTES))
        .route_layer(middleware::from_fn_with_state(Arc::clone(shared), guard::controller));
    Router::new()
        .route("/", get(index))
        .route("/assets/{*path}", get(asset))
        .route("/api/v1/health", get(health))
        .merge(reads)
        .merge(controls)
        .fallback(unknown)
        .method_not_allowed_fallback(wrong_method)
        .with_state(Arc::clone(shared))
}

async fn index() -> Response {
    assets::index().into_response()
}

async fn asset(Path(path): Path<String>) -> Response {
    match assets::find(&path) {
        Some(asset) => asset.into_response(),
        None => Problem::new(StatusCode::NOT_FOUND, "no such file of the page")
            .found(&path)
            .into_response(),
    }
}

/// Open to everyone who may connect: it tells a monitor that the daemon answers, and nothing measured.
async fn health(State(shared): State<Arc<Shared>>) -> Response {
    let snapshot = newest(&shared);
    Json(json!({
        "status": "ok",
        "version": env!("CARGO_PKG_VERSION"),
        "state": snapshot.state,
        "sequence": snapshot.sequence,
    }))
    .into_response()
}

async fn snapshot(State(shared): State<Arc<Shared>>) -> Response {
    let text = shared.encoder.encode(&newest(&shared));
    ([(header::CONTENT_TYPE, JSON)], Bytes::from(text)).into_response()
}

async fn links(State(shared): State<Arc<Shared>>) -> Response {
    let snapshot = newest(&shared);
    Json(json!({ "sequence": snapshot.sequence, "links": snapshot.links })).into_response()
}

async fn report(State(shared): State<Arc<Shared>>) -> Response {
    match shared.source.report() {
        Some(report) => {
            let name = files::disposition("attachment", "report.json", report.session.as_ref());
            ([(header::CONTENT_DISPOSITION, name)], Json(&*report)).into_response()
        }
        None => Problem::new(StatusCode::NOT_FOUND, "there is no report yet")
            .expected("a session that ended")
            .hint("/api/v1/snapshot has the running figures")
            .into_response(),
    }
}

async fn sessions(State(shared): State<Arc<Shared>>) -> Response {
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    Json(json!({ "sessions": shared.source.sessions().await })).into_response()
}

async fn session_file(
    State(shared): State<Arc<Shared>>,
    Path((id, name)): Path<(String, String)>,
) -> Response {
    let unknown = |found: &str| {
        let names: Vec<_> = ResultFile::ALL.iter().map(|file| file.name()).collect();
        Problem::new(StatusCode::NOT_FOUND, "there is no such file of a session")
            .expected(format!("a session of /api/v1/sessions and one of {}", names.join(", ")))
            .found(found)
            .hint("[output] of the configuration says which files a session leaves")
            .into_response()
    };
    let Some(of) = ResultFile::named(&name) else { return unknown(&name) };
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.session_file(id.clone(), of).await {
        Some(file) => files::answer(of, file.bytes, file.session.as_ref()),
        None => unknown(&format!("{id}/{name}")),
    }
}

async fn mesh(State(shared): State<Arc<Shared>>) -> Response {
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.mesh_ply().await {
        Some(ply) => {
            let snapshot = newest(&shared);
            files::answer(ResultFile::Mesh, ply, snapshot.session.as_ref())
        }
        None => no_mesh().into_response(),
    }
}

async fn maps(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    let Some(maps) = shared.source.maps().await else {
        return Problem::new(StatusCode::NOT_FOUND, "there are no maps of the sampling yet")
            .expected("a session with some thousand points")
            .into_response();
    };
    let text = serde_json::to_string(&*maps).expect("maps consist of numbers and strings");
    // Of the content, so that no other daemon's maps are taken for these.
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    let tag = format!("\"{:016x}\"", hasher.finish());
    if headers.get(header::IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes()) {
        return (StatusCode::NOT_MODIFIED, [(header::ETAG, tag)]).into_response();
    }
    ([(header::CONTENT_TYPE, JSON.to_owned()), (header::ETAG, tag)], text).into_response()
}

async fn contour(State(shared): State<Arc<Shared>>) -> Response {
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.contour().await {
        Some(contour) => Json(&*contour).into_response(),
        None => Problem::new(StatusCode::NOT_FOUND, "there is no contour yet")
            .expected("a session with a hundred points, or one that ended")
            .hint("the table [contour] of the configuration asks for one")
            .into_response(),
    }
}

async fn parts(State(shared): State<Arc<Shared>>) -> Response {
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.parts().await {
        Some(parts) => Json(&*parts).into_response(),
        None => Problem::new(StatusCode::NOT_FOUND, "there are no parts yet")
            .expected("a session with points, or one that ended")
            .hint("the table [parts] of the configuration asks for them")
            .into_response(),
    }
}

async fn volume(State(shared): State<Arc<Shared>>) -> Response {
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.volume().await {
        Some(volume) => Json(&*volume).into_response(),
        None => no_volume().into_response(),
    }
}

async fn slice(State(shared): State<Arc<Shared>>, uri: Uri) -> Response {
    let query = uri.query().unwrap_or_default();
    let request = match query::slice(query) {
        Ok(request) => request,
        Err(problem) => return problem.into_response(),
    };
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.volume_slice(request).await {
        Some(Ok(slice)) => Json(slice).into_response(),
        Some(Err(error)) => {
            Problem::new(StatusCode::BAD_REQUEST, error.to_string()).found(query).into_response()
        }
        None => no_volume().into_response(),
    }
}

fn no_volume() -> Problem {
    Problem::new(StatusCode::NOT_FOUND, "no volume was measured here")
        .expected("the page of a measured volume")
        .hint("asphera measure VOLUME --nominal FILE --listen ADDR shows one")
}

async fn section(State(shared): State<Arc<Shared>>, uri: Uri) -> Response {
    let request = match query::section(uri.query().unwrap_or_default()) {
        Ok(request) => request,
        Err(problem) => return problem.into_response(),
    };
    match shared.source.section(request).await {
        Some(Ok(report)) => Json(report).into_response(),
        Some(Err(error)) => Problem::new(StatusCode::BAD_REQUEST, error.to_string())
            .found(uri.query().unwrap_or_default())
            .into_response(),
        None => no_mesh().into_response(),
    }
}

/// The deviation with terms taken out, to look at; without any, as fitted.
async fn form(State(shared): State<Arc<Shared>>, uri: Uri) -> Response {
    let terms = match query::form(uri.query().unwrap_or_default()) {
        Ok(terms) => terms,
        Err(problem) => return problem.into_response(),
    };
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.without(terms).await {
        Some(Ok(view)) => Json(view).into_response(),
        Some(Err(error)) => Problem::new(StatusCode::CONFLICT, error.to_string())
            .expected("a deviation at more places than terms")
            .into_response(),
        None => Problem::new(StatusCode::NOT_FOUND, "there is no deviation yet")
            .expected("a session with a fit")
            .into_response(),
    }
}

fn no_mesh() -> Problem {
    Problem::new(StatusCode::NOT_FOUND, "there is no mesh yet")
        .expected("a session with at least one point")
}

async fn waypoints(State(shared): State<Arc<Shared>>) -> Response {
    let _turn = shared.meshes.acquire().await.expect("this semaphore is never closed");
    match shared.source.waypoints().await {
        Some(waypoints) => {
            let headers = [
                (header::CONTENT_TYPE, "text/csv; charset=utf-8"),
                (header::CONTENT_DISPOSITION, "attachment; filename=\"waypoints.csv\""),
            ];
            (headers, waypoints.csv).into_response()
        }
        None => Problem::new(StatusCode::NOT_FOUND, "nothing is known of the sampling yet")
            .expected("a session with some thousand points, or one that ended")
            .into_response(),
    }
}

async fn open_stream(
    State(shared): State<Arc<Shared>>,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    let upgrade = match upgrade {
        Ok(upgrade) => upgrade,
        Err(rejection) => {
            return Problem::new(rejection.status(), "this address is a WebSocket")
                .expected("a WebSocket upgrade (RFC 6455)")
                .found(&rejection.body_text())
                .hint("/api/v1/snapshot answers to a plain GET")
                .into_response();
        }
    };
    match Arc::clone(&shared.streams).try_acquire_owned() {
        Ok(permit) => stream::accept(upgrade, shared, permit),
        Err(_) => Problem::new(StatusCode::SERVICE_UNAVAILABLE, "too many streams are open")
            .expected(format!("at most {}", shared.limits.streams))
            .hint("close pages that are not looked at")
            .into_response(),
    }
}

async fn start(State(shared): State<Arc<Shared>>, body: Result<Bytes, BytesRejection>) -> Response {
    let label = match body.map_err(unread).and_then(|body| label(&body)) {
        Ok(label) => label,
        Err(problem) => return problem.into_response(),
    };
    // In a task of its own: a browser that hangs up must not leave a session half started.
    let source = Arc::clone(&shared.source);
    controlled("start", tokio::spawn(async move { source.start(label).await }).await)
}

/// Why a body was not read.
fn unread(rejection: BytesRejection) -> Problem {
    let status = rejection.status();
    let problem = Problem::new(status, "the body of the request could not be read");
    match status {
        StatusCode::PAYLOAD_TOO_LARGE => problem.expected(format!("at most {LABEL_BYTES} bytes")),
        _ => problem.found(&rejection.body_text()),
    }
}

/// What the body of a start says of the part; an empty one says nothing.
fn label(body: &[u8]) -> Result<Label, Problem> {
    if body.is_empty() {
        return Ok(Label::default());
    }
    let refused = |why: String| {
        Problem::new(StatusCode::BAD_REQUEST, format!("the label cannot be used: {why}"))
            .expected("a JSON object with part, serial and operator, each a text or left out")
            .found(&String::from_utf8_lossy(body))
    };
    let label: Label = serde_json::from_slice(body).map_err(|error| refused(error.to_string()))?;
    label.tidied().map_err(refused)
}

async fn stop(State(shared): State<Arc<Shared>>) -> Response {
    let source = Arc::clone(&shared.source);
    controlled("stop", tokio::spawn(async move { source.stop().await }).await)
}

async fn arm_scan(State(shared): State<Arc<Shared>>) -> Response {
    let source = Arc::clone(&shared.source);
    controlled("arm", tokio::spawn(async move { source.arm_scan().await }).await)
}

/// The halt is on its way before anything is waited for.
async fn halt_scan(State(shared): State<Arc<Shared>>) -> Response {
    let source = Arc::clone(&shared.source);
    controlled("halt", tokio::spawn(async move { source.halt_scan().await }).await)
}

fn controlled(
    command: &'static str,
    outcome: Result<Result<(), ControlError>, tokio::task::JoinError>,
) -> Response {
    match outcome {
        Ok(Ok(())) => {
            tracing::info!(command, "command over the network carried out");
            StatusCode::NO_CONTENT.into_response()
        }
        Ok(Err(ControlError { conflict: true, message })) => {
            Problem::new(StatusCode::CONFLICT, message).into_response()
        }
        Ok(Err(ControlError { conflict: false, message })) => {
            tracing::error!(command, %message, "command over the network failed");
            Problem::new(StatusCode::INTERNAL_SERVER_ERROR, message).into_response()
        }
        Err(error) => {
            tracing::error!(command, %error, "command over the network broke off");
            Problem::new(StatusCode::INTERNAL_SERVER_ERROR, format!("the {command} broke off"))
                .hint("see the daemon's log")
                .into_response()
        }
    }
}

async fn unknown(uri: Uri) -> Response {
    Problem::new(StatusCode::NOT_FOUND, "no such address")
        .found(uri.path())
        .hint("the page is at /, the interface under /api/v1/")
        .into_response()
}

async fn wrong_method(method: Method, uri: Uri) -> Response {
    let is_control =
        ["/api/v1/session/", "/api/v1/scan/"].iter().any(|of| uri.path().starts_with(of));
    let expected = if is_control { "POST" } else { "GET or HEAD" };
    let problem = Problem::new(StatusCode::METHOD_NOT_ALLOWED, "wrong method for this address")
        .expected(expected)
        .found(method.as_str());
    // RFC 9110 section 15.5.6: a 405 lists the methods that are allowed.
    let allow = if expected == "POST" { "POST" } else { "GET, HEAD" };
    ([(header::ALLOW, allow)], problem).into_response()
}

fn newest(shared: &Shared) -> Arc<Snapshot> {
    shared.source.snapshot()
}

const JSON: &str = "application/json";
/// A label has three entries of at most 120 characters.
const LABEL_BYTES: usize = 4096;
