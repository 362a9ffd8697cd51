//! A recorded session from the devices' side: what they sent, byte for byte, when they had been asked.

use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use asphera_link::{Carries, Nanos};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep_until, timeout};
use toml_edit::DocumentMut;

use super::super::Speed;
use super::super::output::{Failure, say};
use super::super::source::session_at;
use super::haste::{allow_haste, refuse_haste};
use super::links::{Lead, lead};
use crate::config::Config;
use crate::session::{Session, What};

/// How long a client may take to say what the recording has before the playback goes on without.
const PATIENCE: Duration = Duration::from_secs(5);

/// A session whose links wait for clients.
pub(super) struct Playback {
    session: PathBuf,
    config: String,
    speed: Speed,
    links: Vec<PlayedLink>,
}

struct PlayedLink {
    name: String,
    /// Kind of link that a client is to use: `tcp` or `slcan-tcp`.
    kind: &'static str,
    listener: TcpListener,
    address: SocketAddr,
}

impl Playback {
    /// Opens a recording and a port for each of its links.
    ///
    /// Serial links are played over TCP: the bytes are the same. Fails for SocketCAN, socketcand and logs, which have no other end here, for
    /// devices whose datagrams would not come whole, for links of two connections, and for devices joined by time at another speed.
    pub(super) async fn open(session: &Path, speed: Speed) -> Result<Playback, Failure> {
        let session = &session_at(session)?;
        let recording = Session::open(session)?;
        let config = Config::parse("config.toml of the recording", recording.config_toml())?;
        refuse_haste(&config, speed)?;
        let mut links = Vec::new();
        for (index, link) in config.links.iter().enumerate() {
            refuse_unplayable(&config, index)?;
            let kind = match link.kind {
                "serial" | "tcp" | "udp" | "file" => "tcp",
                "slcan-serial" | "slcan-tcp" => "slcan-tcp",
                other => {
                    let found =
                        format!("{other}, whose frames cannot be played: use asphera replay");
                    return Err(format!(
                        "link {}: expected a serial line or a network, found {found}",
                        link.name
                    )
                    .into());
                }
            };
            let listener = TcpListener::bind("127.0.0.1:0").await?;
            let address = listener.local_addr()?;
            links.push(PlayedLink { name: link.name.clone(), kind, listener, address });
        }
        let config = recording.config_toml().to_owned();
        Ok(Playback { session: session.to_owned(), config, speed, links })
    }

    /// Name, kind and address of each link.
    pub(super) fn listing(&self) -> impl Iterator<Item = (&str, &str, SocketAddr)> {
        self.links.iter().map(|link| (link.name.as_str(), link.kind, link.address))
    }

    /// The recorded configuration, with its links leading here. Where they are played as fast as they are taken, it waits longer.
    pub(super) fn station_toml(&self) -> Result<String, Failure> {
        let mut document: DocumentMut = self.config.parse()?;
        for link in &self.links {
            lead(&mut document, &link.name, Lead::plain(link.kind, link.address));
        }
        if self.speed == Speed::Max {
            let changed = allow_haste(&mut document);
            if !changed.is_empty() {
                say(&format!(
                    "Links go as fast as they are taken: {} changed for that",
                    changed.join(", ")
                ));
            }
        }
        Ok(document.to_string())
    }

    /// Plays every link to whoever connects, from the beginning each time.
    pub(super) fn start(self) -> JoinSet<()> {
        let mut tasks = JoinSet::new();
        for (index, link) in self.links.into_iter().enumerate() {
            let (session, speed) = (self.session.clone(), self.speed);
            tasks.spawn(async move {
                let mut run = Run { session, speed, index, listener: link.listener };
                loop {
                    if let Err(error) = run.play().await {
                        say(&format!("link {} ends: {error}", link.name));
                        return;
                    }
                }
            });
        }
        tasks
    }
}

/// A stream cuts datagrams anywhere, and what came on two connections has no order for who plays one of them.
fn refuse_unplayable(config: &Config, link: usize) -> Result<(), Failure> {
    let mut devices = config.devices.iter().filter(|device| device.link == link);
    let found = devices.find_map(|device| match device.carries {
        Carries::Datagrams => Some(format!("datagrams of {}", device.name)),
        Carries::TwoStreams => Some(format!("two connections of {}", device.name)),
        Carries::Bytes | Carries::CanFrames => None,
    });
    match found {
        None => Ok(()),
        Some(found) => Err(format!(
            "link {}: expected bytes that may be cut anywhere, found {found}, which cannot be played: use asphera replay",
            config.links[link].name
        )
        .into()),
    }
}

/// One link, played once.
struct Run {
    session: PathBuf,
    speed: Speed,
    index: usize,
    listener: TcpListener,
}

/// A client that is connected.
struct Client {
    writer: OwnedWriteHalf,
    /// Bytes it sent so far; closed when it left.
    heard: watch::Receiver<u64>,
    /// When the recording's opening of this connection would have been.
    began: Instant,
    opened: Nanos,
    /// Bytes the recorded station had sent by now.
    expected: u64,
}

impl Run {
    /// Plays all connections of the recording. Ends when the client leaves before its time, or after the end.
    async fn play(&mut self) -> Result<(), Failure> {
        let mut entries = Session::open(&self.session)?.entries();
        let (mut client, mut was_opened): (Option<Client>, bool) = (None, false);
        // What cannot be read of the recording is passed over: it is lacking here as it is in a replay.
        while let Some(entry) = tokio::task::block_in_place(|| next(&mut entries)) {
            match entry.what {
                What::Opened { link } if link == self.index => {
                    was_opened = true;
                    let (stream, _) = self.listener.accept().await?;
                    client = Some(Client::new(stream, entry.at)?);
                }
                What::Sent { link, bytes } if link == self.index => {
                    if let Some(client) = &mut client
                        && !client.listen(bytes.len() as u64, entry.at, self.speed).await
                    {
                        return Ok(());
                    }
                }
                What::Received { link, bytes } if link == self.index => {
                    if let Some(client) = &mut client
                        && !client.send(&bytes, entry.at, self.speed).await
                    {
                        return Ok(());
                    }
                }
                What::Closed { link, .. } if link == self.index => drop(client.take()),
                _ => {}
            }
        }
        match client {
            // The device stays connected until the client has had enough.
            Some(mut client) => while client.heard.changed().await.is_ok() {},
            None if was_opened => {}
            // Nobody ever answered there, and nobody does now.
            None => std::future::pending().await,
        }
        Ok(())
    }
}

fn next(entries: &mut crate::session::Entries) -> Option<crate::session::Entry> {
    entries.find_map(Result::ok)
}

impl Client {
    fn new(stream: TcpStream, opened: Nanos) -> io::Result<Client> {
        stream.set_nodelay(true)?;
        let (reader, writer) = stream.into_split();
        let (told, heard) = watch::channel(0);
        tokio::spawn(count(reader, told));
        Ok(Client { writer, heard, began: Instant::now(), opened, expected: 0 })
    }

    /// Waits until the client sent as many bytes as the recorded station had. Whether it is still there.
    async fn listen(&mut self, bytes: u64, at: Nanos, speed: Speed) -> bool {
        self.expected += bytes;
        let expected = self.expected;
        match timeout(PATIENCE, self.heard.wait_for(|heard| *heard >= expected)).await {
            Ok(Err(_left)) => return false,
            Ok(Ok(_)) => {}
            Err(_) => {
                say("the client did not say what the recorded station said; the playback goes on");
            }
        }
        // What follows was an answer: it comes as long after the question as it did.
        let began = Instant::now().checked_sub(self.since_opening(at, speed));
        self.began = began.map_or(self.began, |began| self.began.max(began));
        true
    }

    /// Sends what the device sent, when it did. Whether the client is still there.
    async fn send(&mut self, bytes: &[u8], at: Nanos, speed: Speed) -> bool {
        if self.heard.has_changed().is_err() {
            return false;
        }
        sleep_until(self.began + self.since_opening(at, speed)).await;
        self.writer.write_all(bytes).await.is_ok()
    }

    fn since_opening(&self, at: Nanos, speed: Speed) -> Duration {
        match speed {
            Speed::Times(times) => at.since(self.opened).div_f64(times),
            Speed::Max => Duration::ZERO,
        }
    }
}

/// Counts what a client sends until it leaves.
async fn count(mut reader: OwnedReadHalf, told: watch::Sender<u64>) {
    let mut buffer = vec![0; 4096];
    while let Ok(len @ 1..) = reader.read(&mut buffer).await {
        told.send_modify(|heard| *heard += len as u64);
    }
}
