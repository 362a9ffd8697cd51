//! A byte stream in memory: what tokio-modbus reads and writes instead of a port.

use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

/// One end is the library's (`AsyncRead`, `AsyncWrite`), the other the driver's ([`Pipe::feed`],
/// [`Pipe::drain`]). Reading from an empty pipe waits for ever and wakes nobody: the driver polls by
/// hand after each [`Pipe::feed`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Pipe(Arc<Mutex<Bytes>>);

#[derive(Debug, Default)]
struct Bytes {
    to_library: VecDeque<u8>,
    from_library: Vec<u8>,
}

impl Pipe {
    /// Gives the library bytes to read.
    pub(crate) fn feed(&self, bytes: &[u8]) {
        self.lock().to_library.extend(bytes);
    }

    /// Takes what the library wrote.
    pub(crate) fn drain(&self) -> Vec<u8> {
        std::mem::take(&mut self.lock().from_library)
    }

    fn lock(&self) -> MutexGuard<'_, Bytes> {
        // Each critical section leaves the bytes whole, so a poisoned lock is still good.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl AsyncRead for Pipe {
    fn poll_read(
        self: Pin<&mut Self>,
        _: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let mut bytes = self.lock();
        if bytes.to_library.is_empty() {
            return Poll::Pending;
        }
        let len = into.remaining().min(bytes.to_library.len());
        let (head, tail) = bytes.to_library.as_slices();
        let first = len.min(head.len());
        into.put_slice(&head[..first]);
        into.put_slice(&tail[..len - first]);
        bytes.to_library.drain(..len);
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for Pipe {
    fn poll_write(
        self: Pin<&mut Self>,
        _: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.lock().from_library.extend_from_slice(bytes);
        Poll::Ready(Ok(bytes.len()))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}
