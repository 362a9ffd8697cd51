//! A simulated CiA 406 node with a CAN socket of its own.

use std::time::Duration;

use asphera_link::{CanFrame, Nanos};
use asphera_sim_cia406::{Bus, NodeConfig};
use socketcan::tokio::CanSocket;
use socketcan::{EmbeddedFrame as _, Id, StandardId};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, sleep_until};

/// A running node. It opens its socket again whenever it loses it, and keeps its state over that.
pub(crate) struct SimulatedNode {
    positions: mpsc::UnboundedSender<(u8, i32)>,
    /// Whether the node is operational with its TPDO on.
    pub(crate) armed: watch::Receiver<bool>,
    task: JoinHandle<()>,
}

impl SimulatedNode {
    pub(crate) fn spawn(interface: &str, config: NodeConfig) -> Result<SimulatedNode, String> {
        let bus = Bus::new(vec![config]).map_err(|error| error.to_string())?;
        let (positions, wanted) = mpsc::unbounded_channel();
        let (tell_armed, armed) = watch::channel(false);
        let worker = Worker {
            interface: interface.to_owned(),
            bus,
            wanted,
            armed: tell_armed,
            origin: Instant::now(),
        };
        Ok(SimulatedNode { positions, armed, task: tokio::spawn(worker.run()) })
    }

    /// Moves the node to this position, in counts, and sends a SYNC with this counter.
    pub(crate) fn sync(&self, counter: u8, position: i32) {
        // The task ends with the handle only.
        let _ = self.positions.send((counter, position));
    }
}

impl Drop for SimulatedNode {
    fn drop(&mut self) {
        self.task.abort();
    }
}

struct Worker {
    interface: String,
    bus: Bus,
    wanted: mpsc::UnboundedReceiver<(u8, i32)>,
    armed: watch::Sender<bool>,
    origin: Instant,
}

impl Worker {
    async fn run(mut self) {
        loop {
            if let Ok(socket) = CanSocket::open(&self.interface) {
                while self.step(&socket).await.is_ok() {}
            }
            sleep(Duration::from_millis(20)).await;
        }
    }

    async fn step(&mut self, socket: &CanSocket) -> std::io::Result<()> {
        let due = self.bus.poll_timeout().map(|at| self.origin + at.since(Nanos::ZERO));
        let frames = tokio::select! {
            frame = socket.read_frame() => match translate(&frame?) {
                Some(frame) => self.bus.receive(self.now(), &frame),
                None => Vec::new(),
            },
            Some((counter, position)) = self.wanted.recv() => {
                self.bus.sync(Some(counter), &[position])
            }
            () = sleep_until(due.unwrap_or(self.origin)), if due.is_some() => {
                self.bus.timeout(self.now())
            }
        };
        for frame in frames {
            let asphera_link::CanId::Standard(id) = frame.id() else { continue };
            let sent =
                StandardId::new(id).and_then(|id| socketcan::CanFrame::new(id, frame.data()));
            socket.write_frame(sent.ok_or(std::io::ErrorKind::InvalidData)?).await?;
        }
        self.armed.send_if_modified(|armed| std::mem::replace(armed, self.bus.armed()) != *armed);
        Ok(())
    }

    fn now(&self) -> Nanos {
        Nanos::ZERO + self.origin.elapsed()
    }
}

/// CANopen has standard data frames only.
fn translate(frame: &socketcan::CanFrame) -> Option<CanFrame> {
    let (socketcan::CanFrame::Data(frame), Id::Standard(id)) = (frame, frame.id()) else {
        return None;
    };
    CanFrame::data_frame(asphera_link::CanId::Standard(id.as_raw()), frame.data()).ok()
}
