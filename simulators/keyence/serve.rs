//! One client on both ports, in real time.

use std::io;
use std::time::Duration;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Instant, sleep_until};

use crate::{Controller, Scan};

/// Waits for a client that connects to both ports, that of the commands first. One that goes away before the second is forgotten.
///
/// # Errors
///
/// When the network fails.
pub async fn accept(
    commands: &TcpListener,
    streams: &TcpListener,
) -> io::Result<(TcpStream, TcpStream)> {
    loop {
        let (client, _) = commands.accept().await?;
        let mut said = [0];
        let gone = async {
            while client.peek(&mut said).await.is_ok_and(|len| len > 0) {
                // It asks before it has connected to both: the answer comes when it has.
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        };
        tokio::select! {
            stream = streams.accept() => return Ok((client, stream?.0)),
            () = gone => {}
        }
    }
}

/// Answers the commands of a client, and streams the scan to it while it wants that. It ends when one of the connections does.
///
/// A scan that was stopped by command, or is complete, begins anew with the next start.
///
/// # Errors
///
/// When the network fails.
pub async fn serve(
    mut commands: TcpStream,
    mut stream: TcpStream,
    controller: &mut Controller,
    scan: &mut Scan,
) -> io::Result<()> {
    commands.set_nodelay(true)?;
    stream.set_nodelay(true)?;
    let (mut asked, mut said) = ([0; 1024], [0; 64]);
    let mut due: Option<Instant> = None;
    loop {
        let pace = async {
            match due {
                Some(due) => sleep_until(due).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            read = commands.read(&mut asked) => {
                let len = read?;
                if len == 0 {
                    break;
                }
                let was_streaming = controller.is_streaming();
                let answers = controller.receive(&asked[..len]);
                if controller.was_stopped() {
                    scan.rewind(controller);
                }
                if controller.is_streaming() && !was_streaming {
                    if scan.is_complete() {
                        scan.rewind(controller);
                    }
                    due = Some(Instant::now());
                }
                commands.write_all(&answers).await?;
            }
            // Nobody says anything there; an end is an end.
            read = stream.read(&mut said) => if read? == 0 { break },
            () = pace => {
                due = due.map(|due| due + Duration::from_nanos(scan.period_ns()));
                let Some(bytes) = scan.advance(controller) else { break };
                stream.write_all(&bytes).await?;
            }
        }
        due = due.filter(|_| controller.is_streaming() && !scan.is_complete());
    }
    controller.disconnected();
    Ok(())
}
