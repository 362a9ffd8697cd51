//! A device on a byte stream, with exposures from one side and faults from another.

use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::{Mutex as AsyncMutex, Notify, mpsc, watch};
use tokio::time::{Instant, sleep_until};

use crate::{Error, Exposure, Instrument, Sample};

/// Something that happens to the link or the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The cable is pulled: bytes of both directions are lost for this long.
    Silent(Duration),
    /// Random bytes from a random place of the next telegram on, or before the next packet.
    Inject {
        /// How many.
        len: usize,
        /// What they and the place follow from.
        seed: u64,
    },
    /// Every bit of the next telegram or packet is inverted.
    CorruptNext,
    /// The next telegram or sample is lost.
    DropNext,
    /// Packets alone: data go on with another format, whose description is lost.
    LoseFormat,
    /// The connection is closed by the device; on a pseudo-terminal, [`Simulator::serve`] ends.
    Close,
    /// The device forgets its settings. The connection stays on the dollar protocol; packets end with it.
    Restart,
}

/// Why a connection is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The host closed it.
    ByHost,
    /// [`Fault::Close`].
    ByFault,
}

/// A simulated device that any task may trigger, damage and watch. Clones are the same device.
#[derive(Clone, Debug)]
pub struct Simulator {
    shared: Arc<Shared>,
    exposures: mpsc::Sender<Exposure>,
}

#[derive(Debug)]
struct Shared {
    device: Mutex<Instrument>,
    /// Locked by the connection that is served; there is one at a time.
    queue: AsyncMutex<mpsc::Receiver<Exposure>>,
    link: Mutex<LinkFaults>,
    changed: Notify,
    armed: watch::Sender<bool>,
}

#[derive(Debug, Default)]
struct LinkFaults {
    silent_until: Option<Instant>,
    close: bool,
}

impl Simulator {
    /// Runs a device; `queue` exposures (at least 1) may wait for the host to read.
    pub fn new(device: impl Into<Instrument>, queue: usize) -> Simulator {
        let (exposures, receiver) = mpsc::channel(queue.max(1));
        let shared = Shared {
            device: Mutex::new(device.into()),
            queue: AsyncMutex::new(receiver),
            link: Mutex::default(),
            changed: Notify::new(),
            armed: watch::Sender::new(false),
        };
        Simulator { shared: Arc::new(shared), exposures }
    }

    /// One exposure. Waits while the queue is full because the host does not read, or while no host
    /// is connected.
    pub async fn trigger(&self, sample: Sample) -> Result<(), Error> {
        self.expose(sample.into()).await
    }

    /// One exposure of all points, with the waits of [`Simulator::trigger`].
    pub async fn expose(&self, exposure: Exposure) -> Result<(), Error> {
        self.exposures.send(exposure).await.map_err(|_| Error::Stopped)
    }

    /// Whether a host is connected and has the data started.
    pub fn armed(&self) -> bool {
        *self.shared.armed.borrow()
    }

    /// Waits until [`Simulator::armed`] has this value.
    pub async fn wait_armed(&self, armed: bool) {
        let mut watch = self.shared.armed.subscribe();
        // The sender lives as long as `self`, so waiting cannot fail.
        let _ = watch.wait_for(|&now| now == armed).await;
    }

    /// Exposures that were not sent.
    pub fn dropped(&self) -> u64 {
        self.shared.device().dropped()
    }

    /// Exposures per second, as the host has chosen.
    pub fn sample_rate_hz(&self) -> f64 {
        self.shared.device().sample_rate_hz()
    }

    /// Makes something happen, now or with the next telegram.
    pub fn fault(&self, fault: Fault) {
        match fault {
            Fault::Silent(time) => self.shared.link().silent_until = Some(Instant::now() + time),
            Fault::Close => self.shared.link().close = true,
            Fault::Inject { len, seed } => self.shared.device().inject(len, seed),
            Fault::CorruptNext => self.shared.device().corrupt_next(),
            Fault::DropNext => self.shared.device().drop_next(),
            Fault::LoseFormat => self.shared.device().lose_format(),
            Fault::Restart => {
                let mut device = self.shared.device();
                device.restart();
                self.shared.link().close |= matches!(*device, Instrument::Packets(_));
            }
        }
        self.shared.changed.notify_one();
    }

    /// Serves one connection, from a device without settings to the end of the stream. A second
    /// connection waits for the first.
    pub async fn serve<S>(&self, mut stream: S) -> Result<Ended, Error>
    where
        S: AsyncRead + AsyncWrite + Unpin,
    {
        let mut queue = self.shared.queue.lock().await;
        self.shared.device().restart();
        self.shared.link().close = false;
        self.publish();
        let ended = self.pump(&mut stream, &mut queue).await;
        self.shared.armed.send_replace(false);
        ended
    }

    /// Loses every exposure, as a device without a host does; never ends. A connection waits for this to be dropped.
    pub async fn lose_exposures(&self) {
        let mut queue = self.shared.queue.lock().await;
        // A connection that was dropped could not say so.
        self.shared.armed.send_replace(false);
        while queue.recv().await.is_some() {
            self.shared.device().lose_exposure();
        }
    }

    async fn pump<S>(
        &self,
        stream: &mut S,
        queue: &mut mpsc::Receiver<Exposure>,
    ) -> Result<Ended, Error>
    where
        S: AsyncRead + AsyncWrite + Unpin,
    {
        let (mut reader, mut writer) = tokio::io::split(stream);
        let mut incoming = [0; 1024];
        let mut outgoing = Vec::new();
        loop {
            self.publish();
            let silent_until = self.silent_until();
            outgoing.extend(self.shared.device().transmit());
            if silent_until.is_some() {
                outgoing.clear();
            }
            if std::mem::take(&mut self.shared.link().close) {
                return Ok(Ended::ByFault);
            }
            tokio::select! {
                read = reader.read(&mut incoming) => match read {
                    Ok(0) => return Ok(Ended::ByHost),
                    Ok(len) if silent_until.is_none() => {
                        self.shared.device().receive(&incoming[..len]);
                    }
                    Ok(_) => {}
                    Err(error) => return Err(Error::Link(error)),
                },
                written = writer.write(&outgoing), if !outgoing.is_empty() => {
                    let len = written.map_err(Error::Link)?;
                    outgoing.drain(..len);
                }
                // While bytes wait to be written no exposure is taken: this is the back-pressure.
                Some(exposure) = queue.recv(), if outgoing.is_empty() => {
                    let mut device = self.shared.device();
                    device.expose(&exposure);
                    for _ in 1..device.batch() {
                        let Ok(exposure) = queue.try_recv() else { break };
                        device.expose(&exposure);
                    }
                }
                () = self.shared.changed.notified() => {}
                () = sleep_until(silent_until.unwrap_or_else(Instant::now)),
                    if silent_until.is_some() => {}
            }
        }
    }

    fn silent_until(&self) -> Option<Instant> {
        let mut link = self.shared.link();
        link.silent_until = link.silent_until.filter(|&until| until > Instant::now());
        link.silent_until
    }

    fn publish(&self) {
        let armed = self.shared.device().armed();
        self.shared.armed.send_if_modified(|now| std::mem::replace(now, armed) != armed);
    }
}

impl Shared {
    fn device(&self) -> MutexGuard<'_, Instrument> {
        self.device.lock().expect("no holder of the device panics")
    }

    fn link(&self) -> MutexGuard<'_, LinkFaults> {
        self.link.lock().expect("no holder of the faults panics")
    }
}
