//! A Keyence LJ-X8000 or LJ-V7000 laser profiler: commands at one port, profiles at another.

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

use asphera_keyence::Settings;
use asphera_link::Channel;
use asphera_sim_keyence::{Controller, Optics, accept};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;

use crate::connection::QUEUE;
use crate::showing::Showing;
use crate::sight::Sight;

/// Distance of points, mm: 400 of them on 20 mm.
pub(crate) fn pitch_mm() -> f64 {
    f64::from(Optics::default().pitch_10nm) / PER_MM
}

/// Smallest and largest height, mm. Its steps are 0.08 µm.
pub(crate) fn range_mm() -> (f64, f64) {
    let half_mm = Optics::default().half_range_mm;
    (-half_mm, half_mm)
}

/// The profiler at work.
pub(crate) struct Profiler {
    device: usize,
    encoder: Option<usize>,
    sight: Sight,
    controller: Mutex<Controller>,
    /// To the connection. While the host does not read, the scan waits.
    sent: mpsc::Sender<Vec<u8>>,
}

impl Profiler {
    /// A profiler, and its profiles.
    pub(crate) fn new(
        device: usize,
        settings: &Settings,
        channels: &[Channel],
        sight: Sight,
    ) -> (Profiler, mpsc::Receiver<Vec<u8>>) {
        let (sent, queue) = mpsc::channel(QUEUE);
        let optics = Optics { series: settings.series, ..Optics::default() };
        let controller = Controller::new(optics, 0);
        let controller = match &settings.serial {
            Some(serial) => controller.with_serial(serial),
            None => controller,
        };
        let encoder = channels.iter().position(|channel| channel.name == ENCODER);
        (Profiler { device, encoder, sight, controller: Mutex::new(controller), sent }, queue)
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.controller().is_streaming()
    }

    /// Sends one profile, where a host wants it. Triggers count from the beginning of the scan.
    pub(crate) async fn trigger(&self, trigger: u64, showing: &Showing) {
        // The connection ends with the stand.
        let Ok(permit) = self.sent.reserve().await else { return };
        let mut controller = self.controller();
        if !controller.is_streaming() {
            return;
        }
        if trigger == 0 {
            controller.restart();
        }
        let values = showing.at(self.device, trigger);
        let count = self.encoder.and_then(|encoder| values.get(encoder)).copied().unwrap_or(0.0);
        let first_mm = f64::from(controller.optics().layout().x_start_10nm) / PER_MM;
        let height = |x_mm: f64| {
            let point = ((x_mm - first_mm) / pitch_mm()).round().max(0.0) as usize;
            self.sight.height_mm(trigger, point, x_mm)
        };
        permit.send(controller.measure(count.round() as i32, height));
    }

    /// Serves one host after the other.
    pub(crate) async fn serve(
        &self,
        commands: TcpListener,
        streams: TcpListener,
        mut queue: mpsc::Receiver<Vec<u8>>,
    ) {
        loop {
            let (client, stream) = match accept(&commands, &streams).await {
                Ok(both) => both,
                Err(error) => {
                    tracing::warn!(%error, "a simulated device takes no connections");
                    return;
                }
            };
            // A host that goes away in the middle of a profile is no trouble of the device.
            drop(self.talk(client, stream, &mut queue).await);
            self.controller().disconnected();
            // What nobody took is lost.
            while queue.try_recv().is_ok() {}
        }
    }

    async fn talk(
        &self,
        mut commands: TcpStream,
        mut stream: TcpStream,
        queue: &mut mpsc::Receiver<Vec<u8>>,
    ) -> io::Result<()> {
        commands.set_nodelay(true)?;
        stream.set_nodelay(true)?;
        let (mut asked, mut said) = ([0; 1024], [0; 64]);
        loop {
            tokio::select! {
                read = commands.read(&mut asked) => match read? {
                    0 => return Ok(()),
                    len => {
                        let answers = self.controller().receive(&asked[..len]);
                        commands.write_all(&answers).await?;
                    }
                },
                // Nobody says anything there; an end is an end.
                read = stream.read(&mut said) => if read? == 0 { return Ok(()) },
                Some(profile) = queue.recv() => stream.write_all(&profile).await?,
            }
        }
    }

    fn controller(&self) -> MutexGuard<'_, Controller> {
        // Whoever panicked left whole values.
        self.controller.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Channel of the encoder's count.
const ENCODER: &str = "encoder";
/// Steps of lengths in its messages in a mm.
const PER_MM: f64 = 1e5;
