//! A bench whose machine runs programs: a coordinate measuring machine over a part.

use std::fmt;
use std::io;
use std::net::SocketAddr;

use asphera_sim_ippdme::{Machine, MachineSettings, Probe, SharedMachine, Surface};
use asphera_stand::serve_hosts;
use tokio::net::TcpListener;
use tokio::task::JoinSet;

use crate::drive::address;
use crate::scene::read::{self, Part};
use crate::{RigError, SceneError};

/// Part and machine of such a bench.
#[derive(Clone, Debug, PartialEq)]
pub struct CmmScene {
    title: String,
    seed: u64,
    part: Part,
    listen: SocketAddr,
    ball_radius_mm: f64,
    noise_nm: f64,
    speed_mm_s: f64,
    touch_mm_s: f64,
    scan_mm_s: f64,
}

impl CmmScene {
    /// Reads a scene; `None` where the file has no table `cmm` and is another scene. `name` stands in errors.
    ///
    /// # Errors
    ///
    /// All that is wrong, each with its line and key.
    pub fn parse(name: &str, text: &str) -> Option<Result<CmmScene, SceneError>> {
        read::scene_with("cmm", name, text, scene)
    }

    /// What it shows, in words.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The scene on a port of 127.0.0.1 that is free.
    #[must_use]
    pub fn on_free_port(mut self) -> CmmScene {
        self.listen = SocketAddr::from(([127, 0, 0, 1], 0));
        self
    }

    /// Probe over the part, in the frame of the part, which is that of the machine.
    pub fn probe(&self) -> Probe {
        let part = self.part.clone();
        let surface = Surface::new(move |place_mm| part.height_mm(place_mm));
        Probe { surface, radius_mm: self.ball_radius_mm }
    }
}

fn scene(root: &asphera_settings::Section<'_>) -> Option<CmmScene> {
    let (title, seed) = (root.required("title"), root.required("seed"));
    let part = read::part(&root.section("part"));
    let cmm = root.section("cmm");
    let listen = address(&cmm);
    let ball_radius_mm = cmm.within("ball_radius_mm", 1.0, 0.0..=50.0);
    let noise_nm = cmm.within("noise_nm", 300.0, 0.0..=1e6);
    let speed = |key, usual| cmm.within(key, usual, 0.01..=1e4);
    let (speed_mm_s, touch_mm_s) = (speed("speed_mm_s", 100.0), speed("touch_mm_s", 10.0));
    let scan_mm_s = speed("scan_mm_s", 20.0);
    cmm.finish();
    Some(CmmScene {
        title: title?,
        seed: seed?,
        part: part?,
        listen: listen?,
        ball_radius_mm,
        noise_nm,
        speed_mm_s,
        touch_mm_s,
        scan_mm_s,
    })
}

/// A bench at work. Dropped, it takes its port away.
pub struct CmmRig {
    machine: SharedMachine,
    address: SocketAddr,
    /// Empty while its plug is out.
    task: JoinSet<()>,
}

impl CmmRig {
    /// Puts the bench up, on the current tokio runtime.
    ///
    /// # Errors
    ///
    /// When the port cannot be had.
    pub async fn start(scene: CmmScene) -> Result<CmmRig, RigError> {
        let listen = scene.listen;
        let named = |error: io::Error| io::Error::new(error.kind(), format!("{listen}: {error}"));
        let port = TcpListener::bind(listen).await.map_err(named).map_err(RigError::Tcp)?;
        let address = port.local_addr().map_err(RigError::Tcp)?;
        let machine = SharedMachine::new(Machine::new(MachineSettings {
            probe: scene.probe(),
            noise_nm: scene.noise_nm,
            seed: scene.seed,
            speed_mm_s: scene.speed_mm_s,
            touch_mm_s: scene.touch_mm_s,
            scan_mm_s: scene.scan_mm_s,
            ..MachineSettings::usual()
        }));
        let mut rig = CmmRig { machine, address, task: JoinSet::new() };
        rig.answer(port);
        Ok(rig)
    }

    fn answer(&mut self, port: TcpListener) {
        let machine = self.machine.clone();
        self.task.spawn(serve_hosts(port, move |stream| {
            let machine = machine.clone();
            async move { machine.serve(stream).await }
        }));
    }

    /// The plug is pulled: the connection ends, and the port refuses others.
    pub async fn unplug(&mut self) {
        self.task.shutdown().await;
    }

    /// The plug is in again, at the same port. To be called within the tokio runtime of the rig.
    ///
    /// # Errors
    ///
    /// When the port is not free any more.
    pub async fn plug(&mut self) -> Result<(), RigError> {
        let port = TcpListener::bind(self.address).await.map_err(RigError::Tcp)?;
        self.answer(port);
        Ok(())
    }

    /// The machine, to let something happen to it and to see what it received.
    pub fn machine(&self) -> &SharedMachine {
        &self.machine
    }

    /// Address on which the machine answers.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl fmt::Debug for CmmRig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tasks = self.task.len();
        f.debug_struct("CmmRig")
            .field("address", &self.address)
            .field("tasks", &tasks)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = include_str!("scenes/cmm.toml");

    #[test]
    fn mistakes_are_named_and_other_scenes_left_to_others() {
        assert!(CmmScene::parse("cmm", SCENE).is_some_and(|scene| scene.is_ok()));
        assert!(CmmScene::parse("stage", include_str!("scenes/stage.toml")).is_none());
        for (from, to, key) in [
            ("127.0.0.1:1294", "machine", "cmm.listen"),
            ("ball_radius_mm = 1.0", "ball_radius_mm = -1.0", "cmm.ball_radius_mm"),
            ("noise_nm", "noise_mm", "cmm.noise_mm"),
            ("seed = 1", "", "seed"),
        ] {
            assert!(SCENE.contains(from), "{from}");
            let scene = CmmScene::parse("cmm", &SCENE.replacen(from, to, 1));
            let said = scene.expect("a scene with a machine").expect_err("a mistake").to_string();
            assert!(said.contains(key), "{to}: {said}");
        }
    }

    /// A plane at 0.0312 mm, turned by 0.1 mrad about x, under a ball of 1 mm: its centre lies 1 mm higher along the normal.
    #[test]
    fn the_ball_rests_on_the_part() {
        let mut scene = CmmScene::parse("cmm", SCENE).expect("a machine").expect("sound");
        scene.part.form_error.fringe_nm.clear();
        let probe = scene.probe();
        let near = |place: [f64; 2], expected_mm: f64| {
            let found_mm = probe.centre_mm(place).expect("on the part");
            assert!((found_mm - expected_mm).abs() < 1e-7, "{place:?}: {found_mm}");
        };
        let lift_mm = 1.0 / 1e-4_f64.cos();
        near([0.0, 0.0], 0.0312 + lift_mm);
        near([3.0, 6.0], 0.0312 + 6e-4 + lift_mm);
        assert_eq!(probe.centre_mm([30.0, 30.0]), None);
    }
}
