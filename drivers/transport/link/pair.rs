//! Two connections to one device, as one link.

use asphera_link::Connection;
use tokio::io::AsyncReadExt as _;
use tracing::trace;

use super::{End, Hex, READ_BYTES, What, Worker};
use crate::stream::Bytes;

impl Worker {
    /// Serves both until one of them ends. What comes on each keeps its order; between the two the order of reading counts.
    pub(super) async fn serve_pair(&mut self, [first, mut second]: [Box<dyn Bytes>; 2]) -> End {
        let (mut reader, mut writer) = tokio::io::split(first);
        let mut buffers = [(); 2].map(|()| vec![0; READ_BYTES]);
        loop {
            let [of_first, of_second] = &mut buffers;
            let (connection, buffer, read) = tokio::select! {
                read = reader.read(of_first) => (Connection::First, of_first, read),
                read = second.read(of_second) => (Connection::Second, of_second, read),
                command = self.commands.recv() => match self.write(command, &mut writer).await {
                    Some(end) => return end,
                    None => continue,
                },
            };
            let name = match connection {
                Connection::First => "first",
                Connection::Second => "second",
            };
            let bytes = match read {
                Ok(0) => {
                    return End::Closed(format!("the other end closed the {name} connection"));
                }
                Ok(count) => &buffer[..count],
                Err(error) => {
                    let why = format!("reading the {name} connection failed: {error}");
                    return End::Closed(why);
                }
            };
            trace!(link = self.settings.index, name, bytes = %Hex(bytes), "received");
            let received = What::Received(connection.chunk(bytes));
            if let Some(end) = self.tell_and_write(received, &mut writer).await {
                return end;
            }
        }
    }
}
