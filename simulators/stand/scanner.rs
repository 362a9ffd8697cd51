//! An RF627 laser line scanner: profiles over UDP to the port at which the station listens.

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use asphera_link::Channel;
use asphera_rf627::Settings;
use asphera_sim_rf627::{Optics, Scanner as Device};
use tokio::time::Instant;

use crate::showing::Showing;
use crate::sight::Sight;

/// Optics of the simulated scanner: 640 points on 10 mm, a range of 10 mm.
fn optics(settings: &Settings) -> Optics {
    let default = Optics::default();
    Optics { serial: settings.serial.unwrap_or(default.serial), ..default }
}

/// Distance of points, mm.
pub(crate) fn pitch_mm() -> f64 {
    let Optics { line_mm, points, .. } = Optics::default();
    line_mm / points as f64
}

/// Smallest and largest height, mm. Its steps are 0.6 µm.
pub(crate) fn range_mm() -> (f64, f64) {
    let Optics { z_range_mm, range_steps, .. } = Optics::default();
    (f64::from(z_range_mm) / f64::from(range_steps), z_range_mm.into())
}

/// The scanner at work.
pub(crate) struct Scanner {
    device: usize,
    step: Option<usize>,
    sight: Sight,
    host: SocketAddr,
    socket: UdpSocket,
    state: Mutex<State>,
}

struct State {
    scanner: Device,
    standoff_mm: f64,
    /// When the port of the host was looked for, and whether somebody was there.
    looked: Option<(Instant, bool)>,
}

impl Scanner {
    /// The scanner of a host that listens at a port of this computer.
    pub(crate) fn new(
        device: usize,
        settings: &Settings,
        channels: &[Channel],
        sight: Sight,
        listen: SocketAddr,
    ) -> std::io::Result<Scanner> {
        let optics = optics(settings);
        let state = State {
            scanner: Device::new(optics, 0),
            standoff_mm: optics.standoff_mm,
            looked: None,
        };
        let host = match listen.is_ipv4() {
            true => SocketAddr::from(([127, 0, 0, 1], listen.port())),
            false => SocketAddr::from((std::net::Ipv6Addr::LOCALHOST, listen.port())),
        };
        let socket = UdpSocket::bind(SocketAddr::new(host.ip(), 0))?;
        let step = channels.iter().position(|channel| channel.name == STEP);
        Ok(Scanner { device, step, sight, host, socket, state: Mutex::new(state) })
    }

    /// Whether a host listens: its port is taken. Asked often, it looks rarely, for it takes the port itself to see that.
    pub(crate) fn is_armed(&self) -> bool {
        let mut state = self.state();
        if let Some((_, is_there)) = state.looked.filter(|(when, _)| when.elapsed() < LOOK) {
            return is_there;
        }
        let taken = UdpSocket::bind(self.host).err();
        let is_there = taken.is_some_and(|error| error.kind() == ErrorKind::AddrInUse);
        state.looked = Some((Instant::now(), is_there));
        is_there
    }

    /// Sends one profile.
    pub(crate) fn trigger(&self, trigger: u64, showing: &Showing) {
        let values = showing.at(self.device, trigger);
        let step = self.step.and_then(|step| values.get(step)).copied().unwrap_or(0.0);
        let mut state = self.state();
        let standoff_mm = state.standoff_mm;
        let pitch_mm = pitch_mm();
        let height = |x_mm: f64| {
            let point =
                (x_mm / pitch_mm + 0.5 * self.sight.points() as f64).round().max(0.0) as usize;
            let shown_mm = self.sight.height_mm(trigger, point, x_mm)?;
            // The scanner shows how far below its standoff the part lies.
            Some(standoff_mm - shown_mm)
        };
        // Steps count modulo 2³².
        let step = (step as i64).rem_euclid(1 << 32) as u32;
        match state.scanner.measure(step, height) {
            Ok(datagram) => {
                // Of a host that went away the next look tells.
                drop(self.socket.send_to(&datagram, self.host));
            }
            Err(error) => tracing::warn!(%error, "a profile cannot be sent"),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Whoever panicked left whole values.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Channel of the encoder's count.
const STEP: &str = "step";
/// Between two looks for the host.
const LOOK: Duration = Duration::from_millis(200);
