//! A socket of UDP.

use std::io;

use socket2::SockRef;
use tokio::net::UdpSocket;

use crate::stream::OpenError;

/// A socket that receives datagrams, and sends some if it knows where to.
#[derive(Debug)]
pub(crate) struct Datagrams {
    socket: UdpSocket,
    knows_peer: bool,
}

impl Datagrams {
    /// Binds to `listen`; with a peer only its datagrams are received.
    pub(crate) async fn open(listen: &str, peer: Option<&str>) -> Result<Datagrams, OpenError> {
        let udp = |source| OpenError::Udp { address: listen.to_owned(), source };
        let socket = UdpSocket::bind(listen).await.map_err(udp)?;
        // Nothing holds a sender back: what comes while nobody reads is lost where the buffer ends. The kernel grants
        // no more than `net.core.rmem_max`; with less the link works too.
        let _ = SockRef::from(&socket).set_recv_buffer_size(BUFFER_BYTES);
        if let Some(peer) = peer {
            let unknown = |source| OpenError::Peer { peer: peer.to_owned(), source };
            socket.connect(peer).await.map_err(unknown)?;
        }
        Ok(Datagrams { socket, knows_peer: peer.is_some() })
    }

    /// Receives the next datagram; its length.
    pub(crate) async fn receive(&self, buffer: &mut [u8]) -> io::Result<usize> {
        self.socket.recv(buffer).await
    }

    /// Sends one datagram.
    pub(crate) async fn send(&self, bytes: &[u8]) -> io::Result<()> {
        if !self.knows_peer {
            let why = "a udp link without peer cannot send: set peer to the address and port of the device";
            return Err(io::Error::new(io::ErrorKind::NotConnected, why));
        }
        self.socket.send(bytes).await.map(|_| ())
    }
}

/// Bytes that may wait unread: seconds of a line scanner.
const BUFFER_BYTES: usize = 8 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn datagrams_come_whole_and_go_to_the_peer_alone() {
        let device = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let stranger = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let peer = device.local_addr().unwrap().to_string();
        let port = Datagrams::open("127.0.0.1:0", Some(&peer)).await.unwrap();
        let at = port.socket.local_addr().unwrap();
        port.send(b"M\r").await.unwrap();
        let mut buffer = [0; 100];
        let (len, from) = device.recv_from(&mut buffer).await.unwrap();
        assert_eq!((&buffer[..len], from), (&b"M\r"[..], at));
        stranger.send_to(b"wrong", at).await.unwrap();
        device.send_to(b"1.5\r\n", at).await.unwrap();
        device.send_to(b"2.5\r\n", at).await.unwrap();
        let mut received = Vec::new();
        for _ in 0..2 {
            let len = port.receive(&mut buffer).await.unwrap();
            received.push(buffer[..len].to_vec());
        }
        assert_eq!(received, [b"1.5\r\n".to_vec(), b"2.5\r\n".to_vec()]);
    }

    /// Linux counts the administration of a buffer, too, and gives twice what was asked for (socket(7)).
    #[tokio::test]
    async fn as_much_may_wait_as_the_kernel_allows() {
        let port = Datagrams::open("127.0.0.1:0", None).await.unwrap();
        let granted = SockRef::from(&port.socket).recv_buffer_size().unwrap();
        let most = std::fs::read_to_string("/proc/sys/net/core/rmem_max").unwrap();
        let most: usize = most.trim().parse().unwrap();
        assert_eq!(granted, 2 * most.min(BUFFER_BYTES));
    }

    #[tokio::test]
    async fn a_port_in_use_and_a_missing_peer_are_named() {
        let open = Datagrams::open("127.0.0.1:0", None).await.unwrap();
        let error = open.send(b"M").await.unwrap_err();
        assert!(error.to_string().contains("set peer"));
        let at = open.socket.local_addr().unwrap().to_string();
        let error = Datagrams::open(&at, None).await.unwrap_err();
        assert!(error.to_string().contains(&at) && error.to_string().contains("ss -lunp"));
    }
}
