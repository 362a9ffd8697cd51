//! One WebSocket: every new snapshot, the newest wins.
//!
//! Flow control: behind every snapshot goes a ping that carries its sequence, and the next snapshot
//! is sent only after the pong (RFC 6455 section 5.5.3: every client answers by itself). A client
//! that is slow to read therefore has at most one snapshot on the way, whatever the buffers of the
//! system in between, and sees the newest one next. What it missed it sees by `sequence`.
//!
//! While nothing is new, `{"format":"asphera.alive/1","sequence":…}` says so at intervals: a page can
//! tell a quiet station from a broken wire.

use std::sync::Arc;
use std::time::Duration;

use asphera_report::{LiveStation, Snapshot};
use axum::Error;
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, WebSocketUpgrade, close_code};
use axum::http::HeaderValue;
use axum::response::Response;
use tokio::sync::{OwnedSemaphorePermit, watch};
use tokio::time::{Instant, sleep_until, timeout};

use super::server::{Limits, Shared};

/// Answers the upgrade and runs the stream in a task of its own; `permit` lives as long as it does.
pub(super) fn accept(
    mut upgrade: WebSocketUpgrade,
    shared: Arc<Shared>,
    permit: OwnedSemaphorePermit,
) -> Response {
    // Never the token's protocol: an answer must not repeat it.
    if upgrade.requested_protocols().any(|name| name.as_bytes() == PROTOCOL.as_bytes()) {
        upgrade.set_selected_protocol(HeaderValue::from_static(PROTOCOL));
    }
    upgrade
        .max_message_size(MESSAGE_MAX)
        .max_frame_size(MESSAGE_MAX)
        .on_failed_upgrade(|error| tracing::debug!(%error, "WebSocket upgrade failed"))
        .on_upgrade(|socket| async move {
            match run(socket, &shared).await {
                End::TooSlow { sequence } => {
                    tracing::info!(sequence, "stream closed: its client was too slow");
                }
                End::Client | End::Server => tracing::debug!("stream ended"),
            }
            drop(permit);
        })
}

/// Where the client stands.
enum Phase {
    /// It has all that was sent; at `alive_at` it hears that there is nothing new.
    Ready { alive_at: Instant },
    /// A snapshot is on its way; at `give_up_at` the client counts as gone.
    Unanswered { sequence: u64, give_up_at: Instant },
}

/// Why a stream ended.
enum End {
    /// The client closed it or went away.
    Client,
    /// The daemon or its station ended.
    Server,
    /// The client did not receive a snapshot in time.
    TooSlow { sequence: u64 },
}

async fn run(mut socket: WebSocket, shared: &Shared) -> End {
    let limits = shared.limits;
    let mut sent = None;
    let mut closing = shared.closing.subscribe();
    let mut phase = ready(&limits);
    let end = loop {
        let wake_at = match phase {
            Phase::Ready { alive_at } => alive_at,
            Phase::Unanswered { give_up_at, .. } => give_up_at,
        };
        phase = tokio::select! {
            () = ended(&mut closing) => break End::Server,
            message = socket.recv() => match (message, phase) {
                (None | Some(Err(_) | Ok(Message::Close(_))), _) => break End::Client,
                (Some(Ok(Message::Pong(payload))), Phase::Unanswered { sequence, .. })
                    if payload[..] == sequence.to_be_bytes() => ready(&limits),
                (Some(Ok(_)), phase) => phase,
            },
            snapshot = newer(&*shared.source, sent), if matches!(phase, Phase::Ready { .. }) => {
                let Some(snapshot) = snapshot else { break End::Server };
                let sequence = snapshot.sequence;
                sent = Some(sequence);
                match send_snapshot(&mut socket, shared, &snapshot).await {
                    Ok(()) => Phase::Unanswered { sequence, give_up_at: after(limits.answer_ms) },
                    Err(end) => break end,
                }
            }
            () = sleep_until(wake_at) => match phase {
                Phase::Unanswered { sequence, .. } => break End::TooSlow { sequence },
                Phase::Ready { .. } => {
                    let sequence = shared.source.snapshot().sequence;
                    match send(&mut socket, Message::Text(alive(sequence)), &limits).await {
                        Some(Ok(())) => ready(&limits),
                        Some(Err(_)) => break End::Client,
                        None => break End::TooSlow { sequence },
                    }
                }
            },
        };
    };
    let frame = match end {
        End::Client => None,
        End::Server => Some((close_code::AWAY, "the station ends")),
        End::TooSlow { .. } => Some((close_code::POLICY, "too slow to read the snapshots")),
    };
    if let Some((code, reason)) = frame {
        let frame = CloseFrame { code, reason: Utf8Bytes::from_static(reason) };
        // A courtesy: whoever does not take it is cut off.
        let closing = socket.send(Message::Close(Some(frame)));
        let _ = timeout(Duration::from_millis(CLOSE_MS), closing).await;
    }
    end
}

/// Resolves when the shutdown begins, or when nobody is left to begin it.
async fn ended(closing: &mut watch::Receiver<bool>) {
    let _ = closing.wait_for(|closing| *closing).await;
}

async fn send_snapshot(
    socket: &mut WebSocket,
    shared: &Shared,
    snapshot: &Arc<Snapshot>,
) -> Result<(), End> {
    let text = Message::Text(shared.encoder.encode(snapshot));
    let ping = Message::Ping(snapshot.sequence.to_be_bytes().to_vec().into());
    for message in [text, ping] {
        match send(socket, message, &shared.limits).await {
            Some(Ok(())) => {}
            Some(Err(_)) => return Err(End::Client),
            None => return Err(End::TooSlow { sequence: snapshot.sequence }),
        }
    }
    Ok(())
}

/// `None` where the client did not take the message in time.
async fn send(
    socket: &mut WebSocket,
    message: Message,
    limits: &Limits,
) -> Option<Result<(), Error>> {
    timeout(Duration::from_millis(limits.answer_ms), socket.send(message)).await.ok()
}

/// The first snapshot beside the one that was sent last; `None` when the station ends.
async fn newer(station: &dyn LiveStation, sent: Option<u64>) -> Option<Arc<Snapshot>> {
    match sent {
        None => Some(station.snapshot()),
        Some(sequence) => station.snapshot_after(sequence).await,
    }
}

fn ready(limits: &Limits) -> Phase {
    Phase::Ready { alive_at: after(limits.alive_ms) }
}

fn after(ms: u64) -> Instant {
    Instant::now() + Duration::from_millis(ms)
}

fn alive(sequence: u64) -> Utf8Bytes {
    format!("{{\"format\":\"asphera.alive/1\",\"sequence\":{sequence}}}").into()
}

/// The subprotocol a client may ask for, beside the one that carries its token.
const PROTOCOL: &str = "asphera.snapshot.v1";

/// Clients have nothing to say beyond control frames.
const MESSAGE_MAX: usize = 4096;

const CLOSE_MS: u64 = 500;
