//! One host after the other at the port of a device that talks in bytes.

use std::io;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;

use crate::port::next_host;

/// A device that talks in bytes.
pub(crate) trait Talker: Sync {
    /// A host has come.
    fn connected(&self);

    /// Takes bytes of the host and gives the answers.
    fn hear(&self, bytes: &[u8]) -> Vec<u8>;

    /// The host has gone.
    fn disconnected(&self);
}

/// Serves one host after the other with answers and what is in the queue. What is sent to nobody is lost.
pub(crate) async fn serve(
    talker: &impl Talker,
    port: TcpListener,
    mut queue: mpsc::Receiver<Vec<u8>>,
) {
    loop {
        let host = tokio::select! {
            host = next_host(&port) => host,
            Some(_) = queue.recv() => continue,
        };
        let Some(stream) = host else { return };
        talker.connected();
        // A host that goes away in the middle of a frame is no trouble of the device.
        drop(talk(talker, stream, &mut queue).await);
        talker.disconnected();
    }
}

async fn talk(
    talker: &impl Talker,
    mut stream: TcpStream,
    queue: &mut mpsc::Receiver<Vec<u8>>,
) -> io::Result<()> {
    let mut buffer = [0; 1024];
    loop {
        tokio::select! {
            read = stream.read(&mut buffer) => match read? {
                0 => return Ok(()),
                len => {
                    let answers = talker.hear(&buffer[..len]);
                    stream.write_all(&answers).await?;
                }
            },
            Some(frame) = queue.recv() => stream.write_all(&frame).await?,
        }
    }
}

/// Frames that may wait for a host that does not read.
pub(crate) const QUEUE: usize = 64;
