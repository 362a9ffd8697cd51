//! A running bench.

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tokio::sync::watch;

use crate::bench::{Bench, ProbeAddress};
use crate::fault::Scheduled;
use crate::pace::{Absence, Pace};
use crate::{
    Fault, FaultError, Link, Plan, RigError, Scene, StationOptions, Trigger, Truth, station,
};

/// A running bench. Dropped, it takes its ports away.
pub struct Rig {
    scene: Scene,
    truth: Truth,
    bench: Arc<Bench>,
    progress: Arc<Progress>,
}

/// Where a device of the bench can be reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listing {
    /// Name of the link: `probe`, `stage`, `thermal`.
    pub name: &'static str,
    /// What is there, in words.
    pub kind: &'static str,
    /// Path of a serial port, or address and TCP port.
    pub address: String,
}

#[derive(Debug)]
struct Progress {
    triggers: AtomicU64,
    finished: watch::Sender<bool>,
}

impl Rig {
    /// Computes the scan of a scene, puts the bench up, and lets the scan begin when the host has
    /// armed every triggered device: the probe's data started, the stage's nodes operational with
    /// their position switched on. When the host has disarmed all and arms them again, another scan
    /// begins, the same.
    ///
    /// The serial ports are the names `probe` and `stage` in `dir`, which is made if there is none.
    /// They are symbolic links that stay the same when the ports behind them change. To be called
    /// within a tokio runtime.
    ///
    /// # Errors
    ///
    /// A scene that cannot be played, or a port that cannot be made.
    pub async fn start(scene: Scene, dir: &Path) -> Result<Rig, RigError> {
        let planned = tokio::task::spawn_blocking({
            let scene = scene.clone();
            move || Plan::new(&scene)
        });
        let (triggers, truth) = planned.await.map_err(|_| RigError::Interrupted)??.into_parts();
        let bench = Arc::new(Bench::start(&scene, dir).await?);
        let progress =
            Arc::new(Progress { triggers: AtomicU64::new(0), finished: watch::Sender::new(false) });
        bench.spawn(scans(bench.clone(), scene.clone(), triggers, progress.clone()));
        Ok(Rig { scene, truth, bench, progress })
    }

    /// The scene that is played.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What a host that makes no mistake must find.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Triggers done so far, of the scan that began last.
    pub fn progress(&self) -> u64 {
        self.progress.triggers.load(Ordering::Relaxed)
    }

    /// Waits until every trigger of a scan has been handed to the simulators. The bench stays up.
    pub async fn finished(&self) {
        // The sender lives in `self`: waiting cannot fail.
        let _ = self.progress.finished.subscribe().wait_for(|&finished| finished).await;
    }

    /// Lets a fault happen now. To be called within the tokio runtime of the rig.
    ///
    /// # Errors
    ///
    /// A fault that cannot happen to the link.
    pub fn fault(&self, link: Link, fault: Fault) -> Result<(), FaultError> {
        self.bench.fault(link, fault, noise_seed(&self.scene, self.progress()))
    }

    /// Where the devices can be reached.
    pub fn listing(&self) -> Vec<Listing> {
        let serial = |link: Link, kind, path: &Path| Listing {
            name: link.name(),
            kind,
            address: path.display().to_string(),
        };
        let stage = match self.scene.node_ids.len() {
            1 => "CiA 406 transducer on an slcan adapter, serial",
            _ => "CiA 406 transducers on an slcan adapter, serial",
        };
        let probe = match self.bench.probe_address() {
            ProbeAddress::Serial(path) => serial(Link::Probe, "CHRocodile 2, serial", path),
            ProbeAddress::Tcp(address) => Listing {
                name: Link::Probe.name(),
                kind: "CHRocodile 2, packets over TCP",
                address: address.to_string(),
            },
        };
        let mut listing = vec![probe, serial(Link::Stage, stage, self.bench.stage_path())];
        listing.extend(self.bench.thermal_address().map(|address| Listing {
            name: Link::Thermal.name(),
            kind: "thermometer, Modbus TCP",
            address: address.to_string(),
        }));
        listing
    }

    /// The daemon's whole configuration for this bench and its part.
    pub fn station_toml(&self, options: &StationOptions) -> String {
        let ports = station::Ports {
            probe: self.bench.probe_address(),
            stage: self.bench.stage_path(),
            thermal: self.bench.thermal_address(),
        };
        station::toml(&self.scene, &ports, options)
    }
}

impl fmt::Debug for Rig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Rig")
            .field("scene", &self.scene.name)
            .field("progress", &self.progress)
            .field("listing", &self.listing())
            .finish_non_exhaustive()
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.bench.stop();
    }
}

/// Plays the scan whenever the host has armed every device: again from its first trigger when the host has disarmed them since.
async fn scans(bench: Arc<Bench>, scene: Scene, triggers: Vec<Trigger>, progress: Arc<Progress>) {
    loop {
        bench.armed().await;
        tracing::info!(scene = scene.name, points = scene.points, "a scan begins");
        if scan(&bench, &scene, &triggers, &progress).await {
            tracing::info!(scene = scene.name, points = scene.points, "the scan is done");
            progress.finished.send_replace(true);
        } else {
            tracing::info!(scene = scene.name, "the scan was given up: the host has disarmed all");
        }
        bench.disarmed().await;
    }
}

/// Plays the scan, trigger by trigger. Whether it came to its end: a host that stops a session in its middle wants no more of it.
async fn scan(
    bench: &Arc<Bench>,
    scene: &Scene,
    triggers: &[Trigger],
    progress: &Progress,
) -> bool {
    let mut faults = scene.faults.iter().peekable();
    let mut pace = Pace::new(scene.speed, scene.rate_hz);
    let mut left = Absence::default();
    for (k, trigger) in (0..).zip(triggers) {
        pace.due(k).await;
        while let Some(Scheduled { link, fault, .. }) = faults.next_if(|next| next.at_point <= k) {
            // Whether it suits was checked with the scene.
            if let Err(error) = bench.fault(*link, *fault, noise_seed(scene, k)) {
                tracing::error!(%error, "a fault of the scene cannot happen");
            }
        }
        if left.is_long(bench.is_left()) {
            return false;
        }
        bench.trigger(k, trigger).await;
        progress.triggers.store(k + 1, Ordering::Relaxed);
    }
    true
}

/// The seed of noise at a trigger: the same for the same scene.
fn noise_seed(scene: &Scene, k: u64) -> u64 {
    scene.seed.rotate_left(32) ^ k
}
