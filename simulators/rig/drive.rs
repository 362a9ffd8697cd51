//! A bench whose stage obeys moves: a Zaber controller or CANopen drives with x and y, and a gauge over the part on it.

use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use asphera_sim_cia402::SharedDrives;
use asphera_sim_zaber::SharedStage;
use asphera_stand::serve_hosts;
use tokio::io::AsyncWriteExt as _;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep_until};

use crate::axes::{Axes, StageKind};
use crate::noise::standard_normal;
use crate::scene::read::{self, Part};
use crate::{RigError, SceneError};

/// Part, gauge and stage of such a bench.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveScene {
    title: String,
    seed: u64,
    part: Part,
    gauge: GaugeScene,
    stage: StageScene,
}

#[derive(Clone, Debug, PartialEq)]
struct GaugeScene {
    listen: SocketAddr,
    rate_hz: f64,
    noise_nm: f64,
}

#[derive(Clone, Debug, PartialEq)]
struct StageScene {
    kind: StageKind,
    listen: SocketAddr,
    microstep_um: f64,
    travel_mm: f64,
    /// Where the axis of the part is, stage frame, mm.
    centre_mm: [f64; 2],
}

impl DriveScene {
    /// Reads a scene; `None` where the file has no table `gauge` and is another scene. `name` stands in errors.
    ///
    /// # Errors
    ///
    /// All that is wrong, each with its line and key.
    pub fn parse(name: &str, text: &str) -> Option<Result<DriveScene, SceneError>> {
        read::scene_with("gauge", name, text, scene)
    }

    /// What it shows, in words.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The scene on ports of 127.0.0.1 that are free.
    #[must_use]
    pub fn on_free_ports(mut self) -> DriveScene {
        let any = SocketAddr::from(([127, 0, 0, 1], 0));
        (self.gauge.listen, self.stage.listen) = (any, any);
        self
    }
}

fn scene(root: &asphera_settings::Section<'_>) -> Option<DriveScene> {
    let (title, seed) = (root.required("title"), root.required("seed"));
    let part = read::part(&root.section("part"));
    let gauge = root.section("gauge");
    let gauge_listen = address(&gauge);
    let gauge_scene =
        (gauge.within("rate_hz", 200.0, 1.0..=2000.0), gauge.within("noise_nm", 10.0, 0.0..=1e6));
    gauge.finish();
    let stage = root.section("stage");
    let stage_listen = address(&stage);
    let kind = stage.word("kind", StageKind::Zaber, &StageKind::WORDS);
    let microstep_um = stage.within("microstep_um", 0.1, 1e-4..=1000.0);
    let travel_mm: f64 = stage.within("travel_mm", 50.0, 0.1..=2000.0);
    let centre: Vec<f64> = stage.or("centre_mm", vec![0.5 * travel_mm; 2]);
    if centre.len() != 2 || !centre.iter().all(|mm| (0.0..=travel_mm).contains(mm)) {
        stage.problem("centre_mm", "two numbers within the travel, mm", format!("{centre:?}"));
        return None;
    }
    if Axes::new(kind, microstep_um, travel_mm).is_none() {
        stage.problem("microstep_um", "a travel of at most 2³¹ counts", microstep_um);
    }
    stage.finish();
    Some(DriveScene {
        title: title?,
        seed: seed?,
        part: part?,
        gauge: GaugeScene {
            listen: gauge_listen?,
            rate_hz: gauge_scene.0,
            noise_nm: gauge_scene.1,
        },
        stage: StageScene {
            kind,
            listen: stage_listen?,
            microstep_um,
            travel_mm,
            centre_mm: [centre[0], centre[1]],
        },
    })
}

pub(crate) fn address(table: &asphera_settings::Section<'_>) -> Option<SocketAddr> {
    let text: String = table.required("listen")?;
    let address = text.parse();
    if address.is_err() {
        table.problem("listen", "address:port", format!("{text:?}"));
    }
    address.ok()
}

/// A bench at work. Dropped, it takes its ports away.
pub struct DriveRig {
    axes: Axes,
    gauge: Arc<Gauge>,
    addresses: [SocketAddr; 2],
    gauge_task: JoinSet<()>,
    /// Empty while its plug is out.
    stage_task: JoinSet<()>,
}

impl DriveRig {
    /// Puts the bench up, on the current tokio runtime.
    ///
    /// # Errors
    ///
    /// When a port cannot be had.
    pub async fn start(scene: DriveScene) -> Result<DriveRig, RigError> {
        let listen = |address: SocketAddr| async move {
            TcpListener::bind(address)
                .await
                .map_err(|error| io::Error::new(error.kind(), format!("{address}: {error}")))
        };
        let gauge_port = listen(scene.gauge.listen).await.map_err(RigError::Tcp)?;
        let stage_port = listen(scene.stage.listen).await.map_err(RigError::Tcp)?;
        let local = |port: &TcpListener| port.local_addr().map_err(RigError::Tcp);
        let addresses = [local(&gauge_port)?, local(&stage_port)?];
        let StageScene { kind, microstep_um, travel_mm, .. } = scene.stage;
        let axes = Axes::new(kind, microstep_um, travel_mm).ok_or_else(|| {
            let error = "the travel of the stage has more than 2³¹ counts: set microstep_um";
            RigError::Tcp(io::Error::new(io::ErrorKind::InvalidInput, error))
        })?;
        let gauge = Arc::new(Gauge { scene, axes: axes.clone() });
        let measured = Arc::clone(&gauge);
        let mut gauge_task = JoinSet::new();
        gauge_task.spawn(serve_hosts(gauge_port, move |stream| {
            let gauge = Arc::clone(&measured);
            async move { gauge.send(stream).await }
        }));
        let mut rig = DriveRig { axes, gauge, addresses, gauge_task, stage_task: JoinSet::new() };
        rig.answer(stage_port);
        Ok(rig)
    }

    /// The stage's plug is pulled: its connections end, and its port refuses others.
    pub async fn unplug_stage(&mut self) {
        self.stage_task.shutdown().await;
    }

    /// The plug is in again, at the same port. To be called within the tokio runtime of the rig.
    ///
    /// # Errors
    ///
    /// When the port is not free any more.
    pub async fn plug_stage(&mut self) -> Result<(), RigError> {
        let port = TcpListener::bind(self.addresses[1]).await.map_err(RigError::Tcp)?;
        self.answer(port);
        Ok(())
    }

    fn answer(&mut self, port: TcpListener) {
        let axes = self.axes.clone();
        self.stage_task.spawn(serve_hosts(port, move |stream| {
            let axes = axes.clone();
            async move { axes.serve(stream).await }
        }));
    }

    /// The Zaber stage, to let something happen to it and to see what it received; `None` where the bench has drives.
    pub fn stage(&self) -> Option<&SharedStage> {
        match &self.axes {
            Axes::Zaber(stage) => Some(stage),
            Axes::Drives { .. } => None,
        }
    }

    /// The drives; `None` where the bench has a Zaber stage.
    pub fn drives(&self) -> Option<&SharedDrives> {
        match &self.axes {
            Axes::Zaber(_) => None,
            Axes::Drives { drives, .. } => Some(drives),
        }
    }

    /// Protocol of the stage, in words.
    pub fn stage_words(&self) -> &'static str {
        match &self.axes {
            Axes::Zaber(_) => "Zaber, TCP",
            Axes::Drives { .. } => "CiA 402, slcan on TCP",
        }
    }

    /// Where gauge and stage answer.
    pub fn addresses(&self) -> [SocketAddr; 2] {
        self.addresses
    }

    /// Height of the part in mm over a place of its frame, (x, y) in mm, without noise; `None` beside it.
    pub fn height_mm(&self, place_mm: [f64; 2]) -> Option<f64> {
        self.gauge.height_mm(place_mm)
    }
}

impl fmt::Debug for DriveRig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tasks = self.gauge_task.len() + self.stage_task.len();
        f.debug_struct("DriveRig")
            .field("addresses", &self.addresses)
            .field("tasks", &tasks)
            .finish_non_exhaustive()
    }
}

/// The gauge over the part that the stage moves.
struct Gauge {
    scene: DriveScene,
    axes: Axes,
}

impl Gauge {
    /// Sends a line for each reading: its time in µs, and the height in mm.
    async fn send(&self, mut stream: TcpStream) -> io::Result<()> {
        let period = Duration::from_secs_f64(1.0 / self.scene.gauge.rate_hz);
        let mut due = Instant::now();
        let mut k = 0;
        loop {
            sleep_until(due).await;
            due += period;
            let micros = self.axes.now().as_micros();
            let [x0, y0] = self.scene.stage.centre_mm;
            let places = self.axes.places_mm();
            let height_mm = self.height_mm([places[0] - x0, places[1] - y0]);
            let noise_mm = self.scene.gauge.noise_nm * 1e-6 * standard_normal(self.scene.seed, k);
            // Beside the part it shows what is beyond its range.
            let shown_mm = height_mm.map_or(BESIDE_MM, |height_mm| height_mm + noise_mm);
            stream.write_all(format!("{micros},{shown_mm:+.7}\r\n").as_bytes()).await?;
            k += 1;
        }
    }

    fn height_mm(&self, place_mm: [f64; 2]) -> Option<f64> {
        self.scene.part.height_mm(place_mm)
    }
}

/// Height that no part has.
const BESIDE_MM: f64 = 99.0;

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = include_str!("scenes/stage.toml");

    /// Why a changed scene cannot be used.
    fn wrong(from: &str, to: &str) -> String {
        assert!(SCENE.contains(from), "{from}");
        let scene = DriveScene::parse("stage", &SCENE.replacen(from, to, 1));
        scene.expect("a scene with a gauge").expect_err("a mistake").to_string()
    }

    #[test]
    fn mistakes_are_named_and_other_scenes_left_to_others() {
        assert!(DriveScene::parse("stage", SCENE).is_some_and(|scene| scene.is_ok()));
        assert!(DriveScene::parse("sphere", include_str!("scenes/sphere.toml")).is_none());
        for (from, to, key) in [
            ("centre_mm = [25.0, 25.0]", "centre_mm = [25.0, 51.0]", "stage.centre_mm"),
            ("127.0.0.1:7731", "gauge", "gauge.listen"),
            ("rate_hz = 500.0", "rate_hz = 0", "gauge.rate_hz"),
            ("microstep_um", "microstep_mm", "stage.microstep_mm"),
            ("seed = 1", "", "seed"),
        ] {
            let said = wrong(from, to);
            assert!(said.contains(key), "{to}: {said}");
        }
    }

    /// A plane turned by 0.1 mrad about x, at 31.2 µm, with power of 400 nm: −400 nm in the middle, +400 nm at the edge of 12 mm.
    #[tokio::test]
    async fn the_gauge_meets_the_part_where_the_stage_is() {
        let scene = DriveScene::parse("stage", SCENE).expect("a gauge").expect("sound");
        let mut scene = scene.on_free_ports();
        scene.part.form_error.fringe_nm.truncate(1);
        let rig = DriveRig::start(scene).await.expect("free ports");
        let near = |place: [f64; 2], expected_mm: f64| {
            let found_mm = rig.height_mm(place).expect("on the part");
            assert!((found_mm - expected_mm).abs() < 1e-7, "{place:?}: {found_mm}");
        };
        near([0.0, 0.0], 0.0312 - 400e-6);
        near([12.0 - 1e-9, 0.0], 0.0312 + 400e-6);
        near([0.0, 6.0], 0.0312 + 6.0e-4 - 200e-6);
        assert_eq!(rig.height_mm([9.0, 9.0]), None);
    }
}
