//! The server without a port: bytes in, bytes out, for the fuzz targets and the test of their corpora.

use std::net::SocketAddr;
use std::sync::Arc;

use asphera_report::LiveStation;
use axum::Router;
use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex, split};
use tokio::sync::watch;

use super::connections::connection;
use super::server::{Limits, Shared, guarded};
use super::token::Token;

/// A server that is handed what a client sends.
pub struct InProcess {
    shared: Arc<Shared>,
    router: Router,
    limits: Limits,
}

impl InProcess {
    /// A server that serves `source` with the limits of a daemon, and no host name but the loopback ones.
    pub fn new(token: Token, source: impl LiveStation) -> InProcess {
        let limits = Limits::default();
        let (closing, _) = watch::channel(false);
        let shared = Shared::new(Arc::new(source), token, Vec::new(), limits, closing);
        InProcess { router: guarded(&shared, &[]), shared, limits }
    }

    /// All that the server answers to a client at `peer` that sends `request` and then nothing more. Returns
    /// when the server has closed the connection and ended its stream, if the client opened one. It needs a tokio
    /// runtime with time.
    pub async fn answer(&self, peer: SocketAddr, request: &[u8]) -> Vec<u8> {
        let (client, server) = duplex(BUFFER);
        let (mut reader, mut writer) = split(client);
        let closing = self.shared.closing.subscribe();
        let serving = connection(server, peer, self.router.clone(), self.limits, closing);
        let sending = async {
            // A server that closes early takes no more: what it answered counts.
            let _ = writer.write_all(request).await;
            let _ = writer.shutdown().await;
        };
        let mut answer = Vec::new();
        let receiving = async {
            // The same.
            let _ = reader.read_to_end(&mut answer).await;
        };
        tokio::join!(serving, sending, receiving);
        drop((reader, writer));
        let streams = u32::try_from(self.limits.streams).unwrap_or(u32::MAX);
        // The semaphore is never closed: every stream that ends gives its permit back.
        let _ = self.shared.streams.acquire_many(streams).await;
        answer
    }
}

/// Bytes on their way in either direction.
const BUFFER: usize = 64 * 1024;
