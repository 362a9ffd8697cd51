//! The bus behind an slcan adapter on a byte stream.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asphera_link::{CanFrame, Nanos};
use asphera_slcan::{BEL, CR, Command, Decoder, Item, encode, encode_timestamped};
use rand_core::Rng;
use rand_pcg::Pcg32;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::{Notify, mpsc, watch};
use tokio::time::{Instant, sleep_until};

use crate::Bus;
use crate::adapter::Adapter;

/// A simulated bus behind an slcan adapter, one host at a time.
///
/// Clones are handles to the same bus: one serves the host, others move the nodes and do harm.
#[derive(Clone)]
pub struct Simulator {
    shared: Arc<Shared>,
}

/// Fate of the frames of a [`Simulator::sync`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Delivery {
    /// They are on their way to the host.
    Queued,
    /// No host is connected, or its channel is closed: nobody heard them.
    Unheard,
    /// They were lost in a silence.
    Silenced,
}

struct Shared {
    state: Mutex<State>,
    /// Timers of the bus have changed.
    retime: Notify,
    armed: watch::Sender<bool>,
    /// Counts the wishes to close the connection.
    close: watch::Sender<u64>,
    origin: Instant,
    participant: Option<Arc<dyn Participant>>,
}

/// Other devices of the bus, which are no nodes of CANopen.
pub trait Participant: Send + Sync {
    /// The adapter's channel was opened: a host begins.
    fn opened(&self);

    /// Takes a frame that the host sent, and gives the answers.
    fn receive(&self, frame: &CanFrame) -> Vec<CanFrame>;

    /// When [`Participant::timeout`] is to be called, if at all.
    fn due(&self) -> Option<Instant> {
        None
    }

    /// Frames that are sent by themselves now.
    fn timeout(&self) -> Vec<CanFrame> {
        Vec::new()
    }

    /// Places of the nodes now, in counts, for what they send by timer; nodes without one in the list stay where they are.
    fn positions(&self) -> Vec<i32> {
        Vec::new()
    }
}

struct State {
    bus: Bus,
    adapter: Adapter,
    /// To the writer of the present connection.
    line: Option<mpsc::Sender<Vec<u8>>>,
    silent_until: Option<Instant>,
    noise: Option<Noise>,
}

/// Bytes that will be put into the next lines, somewhere.
struct Noise {
    bytes: Vec<u8>,
    place: u64,
}

/// Batches of lines that may wait for the host before [`Simulator::sync`] waits too.
const QUEUE: usize = 64;

impl Simulator {
    /// Puts a bus behind an adapter whose channel is closed.
    pub fn new(bus: Bus) -> Simulator {
        Simulator::of(bus, None)
    }

    /// Puts a bus with other devices on it behind an adapter whose channel is closed.
    pub fn with_participant(bus: Bus, participant: Arc<dyn Participant>) -> Simulator {
        Simulator::of(bus, Some(participant))
    }

    fn of(bus: Bus, participant: Option<Arc<dyn Participant>>) -> Simulator {
        let (armed, _) = watch::channel(bus.armed());
        let adapter = Adapter::default();
        let state = State { bus, adapter, line: None, silent_until: None, noise: None };
        let shared = Shared {
            state: Mutex::new(state),
            retime: Notify::new(),
            armed,
            close: watch::channel(0).0,
            origin: Instant::now(),
            participant,
        };
        Simulator { shared: Arc::new(shared) }
    }

    /// Serves one host until it leaves, the stream fails or [`Simulator::close_connection`] is
    /// called. A host that comes while another is served takes its place in the queue of frames, so
    /// serve one after the other.
    ///
    /// The adapter answers CR to what it does and BEL to what it does not, as the manual of the
    /// Lawicel CAN232 has it: closing a closed channel is refused, and so is opening one without a
    /// bit rate. Frames it sends are acknowledged with CR.
    pub async fn serve(&self, stream: impl AsyncRead + AsyncWrite) -> io::Result<()> {
        let (reader, writer) = tokio::io::split(stream);
        let (line, lines) = mpsc::channel(QUEUE);
        let mut close = self.shared.close.subscribe();
        self.state().line = Some(line.clone());
        let ended = tokio::select! {
            ended = self.read(reader, &line) => ended,
            ended = write(writer, lines) => ended,
            _ = close.changed() => Ok(()),
        };
        let mut state = self.state();
        if state.line.as_ref().is_some_and(|present| present.same_channel(&line)) {
            state.line = None;
        }
        ended
    }

    /// Moves each node to its position, in counts, and sends one SYNC. Waits while the host does not
    /// read; what the host cannot hear happens on the bus all the same.
    pub async fn sync(&self, counter: Option<u8>, positions: &[i32]) -> Delivery {
        self.put(|bus| bus.sync(counter, positions)).await
    }

    /// Puts frames of other devices on the bus. Waits while the host does not read.
    pub async fn transmit(&self, frames: &[CanFrame]) -> Delivery {
        self.put(|_| frames.to_vec()).await
    }

    async fn put(&self, happen: impl FnOnce(&mut Bus) -> Vec<CanFrame>) -> Delivery {
        let line = self.state().line.clone();
        let permit = match &line {
            Some(line) => line.reserve().await.ok(),
            None => None,
        };
        let mut state = self.state();
        let frames = happen(&mut state.bus);
        let Some(permit) = permit.filter(|_| state.adapter.open) else {
            return Delivery::Unheard;
        };
        let Some(lines) = self.lines(&mut state, &frames) else {
            return Delivery::Silenced;
        };
        permit.send(lines);
        Delivery::Queued
    }

    /// Whether a host is connected and has opened the channel.
    pub fn is_open(&self) -> bool {
        let state = self.state();
        state.line.is_some() && state.adapter.open
    }

    /// Whether every node is operational with its TPDO on.
    pub fn armed(&self) -> bool {
        self.state().bus.armed()
    }

    /// Waits until every node is operational with its TPDO on.
    pub async fn wait_armed(&self) {
        let mut armed = self.shared.armed.subscribe();
        // The sender lives in `self`: waiting cannot fail.
        let _ = armed.wait_for(|&armed| armed).await;
    }

    /// Sets where a node is, in counts, and how fast it moves, in velocity steps.
    pub fn set_motion(&self, node: usize, position: i32, velocity: i16) {
        self.state().bus.set_motion(node, position, velocity);
    }

    /// From now on, for this long, all that the adapter says is lost.
    pub fn silence(&self, duration: Duration) {
        self.state().silent_until = Some(Instant::now() + duration);
    }

    /// Puts `count` random bytes somewhere into the next lines. The same seed gives the same bytes
    /// in the same place.
    pub fn inject_noise(&self, count: usize, seed: u64) {
        let mut random = Pcg32::new(seed, 0x0A02_BDBF_7BB3_C0A7);
        let mut bytes = vec![0; count];
        random.fill_bytes(&mut bytes);
        self.state().noise = Some(Noise { bytes, place: random.next_u64() });
    }

    /// The next TPDO of a node gets lost.
    ///
    /// # Panics
    ///
    /// Here and below, if there is no such node.
    pub fn drop_next_tpdo(&self, node: usize) {
        self.state().bus.drop_next_tpdo(node);
    }

    /// Gives a node an error, or none with code and register 0; it sends its emergency.
    pub async fn emergency(&self, node: usize, code: u16, register: u8) {
        let frame = self.state().bus.emergency(node, code, register);
        self.send(&[frame]).await;
    }

    /// Powers a node off and on; it sends its boot-up.
    pub async fn reboot(&self, node: usize) {
        let frame = self.state().bus.reboot(node);
        self.shared.retime.notify_one();
        self.publish_armed();
        self.send(&[frame]).await;
    }

    /// Ends the present connection.
    pub fn close_connection(&self) {
        self.shared.close.send_modify(|wishes| *wishes += 1);
    }

    async fn read(
        &self,
        mut reader: impl AsyncRead + Unpin,
        line: &mpsc::Sender<Vec<u8>>,
    ) -> io::Result<()> {
        let mut decoder = Decoder::new();
        let mut buffer = [0; 4096];
        loop {
            let due = self.state().bus.poll_timeout().map(|at| self.instant(at));
            let participant = self.shared.participant.as_ref();
            let due =
                participant.and_then(|participant| participant.due()).into_iter().chain(due).min();
            tokio::select! {
                count = reader.read(&mut buffer) => {
                    let count = count?;
                    if count == 0 {
                        return Ok(());
                    }
                    let mut bytes = &buffer[..count];
                    while !bytes.is_empty() {
                        if let Some(item) = decoder.decode(&mut bytes) {
                            let said = self.take(item);
                            if line.send(said).await.is_err() {
                                return Ok(());
                            }
                        }
                    }
                }
                () = until(due) => {
                    let frames = self.timeout();
                    self.send(&frames).await;
                }
                () = self.shared.retime.notified() => {}
            }
        }
    }

    /// Frames that are sent by timer now.
    fn timeout(&self) -> Vec<CanFrame> {
        let participant = self.shared.participant.as_ref();
        let positions = participant.map(|participant| participant.positions()).unwrap_or_default();
        let mut frames = self.state().bus.timeout_at(self.now(), &positions);
        frames.extend(participant.map(|participant| participant.timeout()).unwrap_or_default());
        frames
    }

    /// Does what one line asks; gives what the adapter says to it.
    fn take(&self, item: Item) -> Vec<u8> {
        let now = self.now();
        let mut state = self.state();
        let mut said = Vec::new();
        let done = match item {
            Item::Frame(frame, _) if state.adapter.open && !state.adapter.listen_only => {
                said.push(CR);
                let mut answers = state.bus.receive(now, &frame);
                if let Some(participant) = &self.shared.participant {
                    answers.extend(participant.receive(&frame));
                }
                said.extend(self.lines(&mut state, &answers).unwrap_or_default());
                true
            }
            Item::Ok => {
                said.push(CR);
                true
            }
            Item::Command(command) => {
                let done = state.adapter.command(command, &mut said);
                let begins = done && matches!(command, Command::Open | Command::Listen);
                if let Some(participant) = self.shared.participant.as_ref().filter(|_| begins) {
                    participant.opened();
                }
                done
            }
            _ => false,
        };
        if !done {
            said = vec![BEL];
        }
        if state.is_silent() {
            said.clear();
        }
        drop(state);
        self.publish_armed();
        said
    }

    /// The lines of frames as the host is to get them, or none in a silence.
    fn lines(&self, state: &mut State, frames: &[CanFrame]) -> Option<Vec<u8>> {
        if state.is_silent() {
            return None;
        }
        let mut lines = Vec::new();
        for frame in frames {
            if state.adapter.timestamps {
                let time_ms = self.now().as_nanos() / 1_000_000;
                encode_timestamped(frame, time_ms, &mut lines);
            } else {
                encode(frame, &mut lines);
            }
        }
        if !lines.is_empty()
            && let Some(noise) = state.noise.take()
        {
            let place = (noise.place % lines.len() as u64) as usize;
            lines.splice(place..place, noise.bytes);
        }
        Some(lines)
    }

    async fn send(&self, frames: &[CanFrame]) {
        let line = self.state().line.clone();
        let Some(line) = line else { return };
        let Ok(permit) = line.reserve().await else { return };
        let mut state = self.state();
        if state.adapter.open
            && let Some(lines) = self.lines(&mut state, frames)
        {
            permit.send(lines);
        }
    }

    fn publish_armed(&self) {
        let armed = self.armed();
        self.shared.armed.send_if_modified(|was| std::mem::replace(was, armed) != armed);
    }

    fn now(&self) -> Nanos {
        Nanos::ZERO + self.shared.origin.elapsed()
    }

    fn instant(&self, at: Nanos) -> Instant {
        self.shared.origin + at.since(Nanos::ZERO)
    }

    /// The state. A panic while it was held cannot leave it half-changed in a way that matters to a
    /// simulator, so poison is ignored.
    fn state(&self) -> MutexGuard<'_, State> {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn is_silent(&mut self) -> bool {
        if self.silent_until.is_some_and(|until| until <= Instant::now()) {
            self.silent_until = None;
        }
        self.silent_until.is_some()
    }
}

async fn until(due: Option<Instant>) {
    match due {
        Some(due) => sleep_until(due).await,
        None => std::future::pending().await,
    }
}

async fn write(
    mut writer: impl AsyncWrite + Unpin,
    mut lines: mpsc::Receiver<Vec<u8>>,
) -> io::Result<()> {
    let mut waiting = Vec::with_capacity(QUEUE);
    while lines.recv_many(&mut waiting, QUEUE).await > 0 {
        let bytes = waiting.concat();
        waiting.clear();
        writer.write_all(&bytes).await?;
        writer.flush().await?;
    }
    Ok(())
}
