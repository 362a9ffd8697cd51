//! The simulators on their links, and the hands that do harm.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use asphera_sim_chrocodile as chrocodile;
use asphera_sim_cia406::{Bus, NodeConfig, Simulator as StageSimulator};
use asphera_sim_modbus as modbus;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep};

use crate::pace::Deadline;
use crate::port::Port;
use crate::scene::Protocol;
use crate::socket::{self, Socket};
use crate::{Fault, FaultError, Link, RigError, Scene, Trigger, thermal};

/// The bench of a scene. Its tasks end with it.
pub(crate) struct Bench {
    probe: chrocodile::Simulator,
    stage: StageSimulator,
    thermometer: Option<Thermometer>,
    probe_port: ProbePort,
    stage_port: Port,
    /// How many nodes the stage has.
    nodes: usize,
    intensity: f64,
    rate_hz: f64,
    /// Until when a fault, not the host, may have disarmed the devices.
    disturbed_until: Mutex<Option<Deadline>>,
    tasks: Mutex<JoinSet<()>>,
}

/// Where the probe is reached.
enum ProbePort {
    Serial(Port),
    Tcp(Socket),
}

/// Address of the probe.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ProbeAddress<'a> {
    /// Path of a serial port.
    Serial(&'a Path),
    /// Address and TCP port.
    Tcp(SocketAddr),
}

struct Thermometer {
    device: modbus::Device,
    socket: Socket,
}

impl Bench {
    /// Puts the bench up, its serial ports as names in `dir`.
    pub(crate) async fn start(scene: &Scene, dir: &Path) -> Result<Bench, RigError> {
        let port = |link: Link| {
            let path = dir.join(link.name());
            Port::new(path.clone()).map_err(|source| RigError::Port { path, source })
        };
        std::fs::create_dir_all(dir)
            .map_err(|source| RigError::Port { path: dir.to_owned(), source })?;
        let node = |&node_id: &u8| NodeConfig {
            node_id,
            position_step_nm: scene.motion.step_nm(),
            ..NodeConfig::default()
        };
        let bus = Bus::new(scene.node_ids.iter().map(node).collect())?;
        let stage = StageSimulator::new(bus);
        let full_scale_um = scene.full_scale_um;
        let instrument: chrocodile::Instrument = match scene.protocol {
            Protocol::Dollar => chrocodile::Device::new(full_scale_um).into(),
            Protocol::Packets => chrocodile::PacketDevice::new(full_scale_um, 1).into(),
        };
        let probe = chrocodile::Simulator::new(instrument, PROBE_QUEUE);
        let mut tasks = JoinSet::new();
        let thermometer = match scene.thermal {
            Some(thermal) => {
                let device = thermal::device(thermal, scene.seed);
                let served = socket::Thermometer { device: device.clone(), start: Instant::now() };
                let listening = Socket::listen(served).await;
                let (socket, serving) = listening.map_err(RigError::Listen)?;
                tasks.spawn(serving);
                Some(Thermometer { device, socket })
            }
            None => None,
        };
        let probe_port = match scene.protocol {
            Protocol::Dollar => ProbePort::Serial(port(Link::Probe)?),
            Protocol::Packets => {
                let listening = Socket::listen(socket::Probe(probe.clone())).await;
                let (socket, serving) = listening.map_err(RigError::Listen)?;
                tasks.spawn(serving);
                ProbePort::Tcp(socket)
            }
        };
        let stage_port = port(Link::Stage).inspect_err(|_| probe_port.remove())?;
        // A wire neither ends nor fails, so these run as long as the bench.
        if let ProbePort::Serial(port) = &probe_port {
            let (served, wire) = (probe.clone(), port.wire());
            tasks.spawn(async move {
                let ended = served.serve(wire).await;
                tracing::error!(?ended, "the probe's line has ended");
            });
        }
        let (served, wire) = (stage.clone(), stage_port.wire());
        tasks.spawn(async move {
            let ended = served.serve(wire).await;
            tracing::error!(?ended, "the stage's line has ended");
        });
        Ok(Bench {
            probe,
            stage,
            thermometer,
            probe_port,
            stage_port,
            nodes: scene.node_ids.len(),
            intensity: scene.intensity,
            rate_hz: scene.rate_hz,
            disturbed_until: Mutex::new(None),
            tasks: Mutex::new(tasks),
        })
    }

    /// Waits until every triggered device is armed at once.
    pub(crate) async fn armed(&self) {
        loop {
            self.probe.wait_armed(true).await;
            self.stage.wait_armed().await;
            if self.probe.armed() && self.stage.armed() {
                return;
            }
        }
    }

    /// Waits until no triggered device is armed.
    pub(crate) async fn disarmed(&self) {
        while self.probe.armed() || self.stage.armed() {
            sleep(DISARMED_POLL).await;
        }
    }

    /// Whether the host has disarmed every device, and no fault did.
    pub(crate) fn is_left(&self) -> bool {
        let disturbed = *self.disturbed_until.lock().unwrap_or_else(PoisonError::into_inner);
        !self.probe.armed() && !self.stage.armed() && disturbed.is_none_or(Deadline::is_past)
    }

    /// Triggers every device. Waits while a host that is there does not read.
    ///
    /// The exposure count is `k` modulo 65536, as the device sends it, and the SYNC counter
    /// `k mod 240 + 1`: trigger 0 is exposure 0 and SYNC 1.
    pub(crate) async fn trigger(&self, k: u64, trigger: &Trigger) {
        let sample = chrocodile::Sample {
            exposure_count: k,
            start_ns: (k as f64 * 1e9 / self.rate_hz) as u64,
            encoder: [trigger.stop.rotary_counts, 0, 0, 0, 0],
            distance_um: Some(trigger.distance_um.into()),
            intensity: self.intensity,
            ..chrocodile::Sample::default()
        };
        let counter = (k % u64::from(SYNC_OVERFLOW)) as u8 + 1;
        let positions = &trigger.stop.stage_steps[..self.nodes];
        if self.probe.trigger(sample).await.is_err() {
            tracing::debug!(k, "the probe runs no more");
        }
        // What nobody hears is lost, as on a real bus.
        let _delivery = self.stage.sync(Some(counter), positions).await;
    }

    /// Lets a fault happen now. `seed` is that of its noise.
    pub(crate) fn fault(
        self: &Arc<Self>,
        link: Link,
        fault: Fault,
        seed: u64,
    ) -> Result<(), FaultError> {
        if !fault.suits(link) {
            return Err(FaultError::Unsuitable { link, kind: fault.kind() });
        }
        tracing::info!(%link, kind = fault.kind(), "fault");
        let recovered = Deadline::after(fault.outage() + RECOVERY);
        let mut disturbed = self.disturbed_until.lock().unwrap_or_else(PoisonError::into_inner);
        *disturbed = Some(disturbed.map_or(recovered, |until| until.max(recovered)));
        drop(disturbed);
        match link {
            Link::Probe => self.fault_probe(fault, seed),
            Link::Stage => self.fault_stage(fault, seed),
            Link::Thermal => {
                let thermometer = self.thermometer.as_ref().ok_or(FaultError::NoLink(link))?;
                self.fault_thermometer(thermometer, fault, seed);
            }
        }
        Ok(())
    }

    fn fault_probe(self: &Arc<Self>, fault: Fault, seed: u64) {
        match fault {
            Fault::Unplug { duration, restart } => {
                self.probe_port.unplug();
                let bench = self.clone();
                self.spawn(async move {
                    sleep(duration).await;
                    if restart {
                        bench.probe.fault(chrocodile::Fault::Restart);
                    }
                    bench.probe_port.plug();
                });
            }
            Fault::Silent { duration } => self.probe.fault(chrocodile::Fault::Silent(duration)),
            Fault::Noise { bytes } => {
                self.probe.fault(chrocodile::Fault::Inject { len: bytes, seed });
            }
            Fault::Drop => self.probe.fault(chrocodile::Fault::DropNext),
            Fault::Restart => self.probe.fault(chrocodile::Fault::Restart),
            // Refused by `Fault::suits`.
            Fault::Emergency { .. } => {}
        }
    }

    fn fault_stage(self: &Arc<Self>, fault: Fault, seed: u64) {
        match fault {
            Fault::Unplug { duration, restart } => {
                self.stage_port.unplug();
                let bench = self.clone();
                self.spawn(async move {
                    sleep(duration).await;
                    if restart {
                        bench.restart_stage().await;
                    }
                    bench.stage_port.plug();
                });
            }
            Fault::Silent { duration } => self.stage.silence(duration),
            Fault::Noise { bytes } => self.stage.inject_noise(bytes, seed),
            Fault::Emergency { code, register } => {
                let stage = self.stage.clone();
                self.spawn(async move { stage.emergency(0, code, register).await });
            }
            Fault::Drop => self.stage.drop_next_tpdo(0),
            Fault::Restart => {
                let bench = self.clone();
                self.spawn(async move { bench.restart_stage().await });
            }
        }
    }

    fn fault_thermometer(self: &Arc<Self>, thermometer: &Thermometer, fault: Fault, seed: u64) {
        match fault {
            Fault::Unplug { duration, .. } => {
                thermometer.socket.unplug();
                let bench = self.clone();
                self.spawn(async move {
                    sleep(duration).await;
                    if let Some(thermometer) = &bench.thermometer {
                        thermometer.socket.plug();
                    }
                });
            }
            Fault::Silent { duration } => thermometer.device.fall_silent(duration),
            Fault::Noise { bytes } => {
                let noise = (0..bytes as u64)
                    .map(|place| (crate::noise::uniform(seed, place) * 256.0) as u8)
                    .collect();
                thermometer.device.fail_next(modbus::Fault::Noise(noise));
            }
            Fault::Drop => thermometer.device.fail_next(modbus::Fault::Silent),
            // Refused by `Fault::suits`.
            Fault::Emergency { .. } | Fault::Restart => {}
        }
    }

    async fn restart_stage(&self) {
        for node in 0..self.nodes {
            self.stage.reboot(node).await;
        }
    }

    /// Runs a task as long as the bench is up.
    pub(crate) fn spawn(&self, task: impl Future<Output = ()> + Send + 'static) {
        let mut tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner);
        // What has ended is let go.
        while tasks.try_join_next().is_some() {}
        tasks.spawn(task);
    }

    /// Ends every task and takes the ports away.
    pub(crate) fn stop(&self) {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner).abort_all();
        self.probe_port.remove();
        self.stage_port.remove();
    }

    /// Where the probe is reached.
    pub(crate) fn probe_address(&self) -> ProbeAddress<'_> {
        match &self.probe_port {
            ProbePort::Serial(port) => ProbeAddress::Serial(port.path()),
            ProbePort::Tcp(socket) => ProbeAddress::Tcp(socket.address()),
        }
    }

    /// Path of the stage's port.
    pub(crate) fn stage_path(&self) -> &Path {
        self.stage_port.path()
    }

    /// Address of the thermometer, if there is one.
    pub(crate) fn thermal_address(&self) -> Option<SocketAddr> {
        self.thermometer.as_ref().map(|thermometer| thermometer.socket.address())
    }
}

impl ProbePort {
    fn unplug(&self) {
        match self {
            ProbePort::Serial(port) => port.unplug(),
            ProbePort::Tcp(socket) => socket.unplug(),
        }
    }

    fn plug(&self) {
        match self {
            ProbePort::Serial(port) => port.plug(),
            ProbePort::Tcp(socket) => socket.plug(),
        }
    }

    /// Takes the name of a serial port away; a TCP port ends with its task.
    fn remove(&self) {
        if let ProbePort::Serial(port) = self {
            port.remove();
        }
    }
}

/// Highest number of the SYNC counter.
pub(crate) const SYNC_OVERFLOW: u8 = 240;

/// Exposures that may wait for the host, as many as batches of frames may on the stage's line: the
/// two links stay together.
const PROBE_QUEUE: usize = 64;

/// How soon it is seen that a host has disarmed all.
const DISARMED_POLL: Duration = Duration::from_millis(20);

/// How long a host may take to set all devices up again after a fault.
const RECOVERY: Duration = Duration::from_secs(10);
