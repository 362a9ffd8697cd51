//! A bench with a laser profiler: a part on a stage whose encoder the profiler counts.

use std::fmt;
use std::io;
use std::net::SocketAddr;

use asphera_sim_keyence::{Controller, Fault, Optics, Scan, ScanSettings, Surface, accept, serve};
use tokio::net::TcpListener;
use tokio::task::JoinSet;

use crate::drive::address;
use crate::scene::read::{self, Part};
use crate::{RigError, SceneError};

/// Part, profiler and stage of such a bench.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfilerScene {
    title: String,
    seed: u64,
    part: Part,
    listen: SocketAddr,
    stream_port: u16,
    optics: Optics,
    stage: Stage,
}

/// Way of the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stage {
    first_mm: f64,
    count_um: f64,
    counts: i32,
    profiles: u32,
    rate_hz: f64,
}

impl ProfilerScene {
    /// Reads a scene; `None` where the file has no table `profiler` and is another scene. `name` stands in errors.
    ///
    /// # Errors
    ///
    /// All that is wrong, each with its line and key.
    pub fn parse(name: &str, text: &str) -> Option<Result<ProfilerScene, SceneError>> {
        read::scene_with("profiler", name, text, scene)
    }

    /// What it shows, in words.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The scene on ports of 127.0.0.1 that are free.
    #[must_use]
    pub fn on_free_ports(mut self) -> ProfilerScene {
        self.listen = SocketAddr::from(([127, 0, 0, 1], 0));
        self.stream_port = 0;
        self
    }

    /// Height of the part in mm over a place (x, y) in mm; `None` beside it.
    pub fn height_mm(&self, place_mm: [f64; 2]) -> Option<f64> {
        self.part.height_mm(place_mm)
    }

    fn scan(&self, faults: &[(u32, Fault)]) -> Scan {
        let part = self.part.clone();
        let settings = ScanSettings {
            surface: Surface::new(move |place_mm| part.height_mm(place_mm)),
            first_y_mm: self.stage.first_mm,
            steps: self.stage.counts,
            step_mm: 1e-3 * self.stage.count_um,
            profiles: self.stage.profiles,
            rate_hz: self.stage.rate_hz,
        };
        Scan::new(settings, faults)
    }
}

fn scene(root: &asphera_settings::Section<'_>) -> Option<ProfilerScene> {
    let (title, seed) = (root.required("title"), root.required("seed"));
    let part = read::part(&root.section("part"));
    let profiler = root.section("profiler");
    let listen = address(&profiler);
    let stream_port = profiler.or("stream_port", 24692);
    let optics = Optics {
        points: profiler.within("points", 400, 1..=3200u16),
        pitch_10nm: 100 * i32::from(profiler.within("pitch_um", 50, 1..=1000u16)),
        half_range_mm: profiler.within("half_range_mm", 5.0, 0.01..=500.0),
        noise_um: profiler.within("noise_um", 0.5, 0.0..=1000.0),
        ..Optics::default()
    };
    profiler.finish();
    let stage = root.section("stage");
    let stage_scene = Stage {
        first_mm: stage.within("first_mm", 0.0, -1e4..=1e4),
        count_um: stage.within("count_um", 1.0, 1e-3..=1e4),
        counts: stage.within("counts", 50, 1..=1_000_000u32).cast_signed(),
        profiles: stage.within("profiles", 400, 1..=1_000_000u32),
        rate_hz: stage.within("rate_hz", 200.0, 0.1..=16_000.0),
    };
    stage.finish();
    Some(ProfilerScene {
        title: title?,
        seed: seed?,
        part: part?,
        listen: listen?,
        stream_port,
        optics,
        stage: stage_scene,
    })
}

/// A bench at work. Dropped, it takes its ports away.
pub struct ProfilerRig {
    addresses: [SocketAddr; 2],
    task: JoinSet<()>,
}

impl ProfilerRig {
    /// Puts the bench up, on the current tokio runtime. `faults` name the profiles they happen to, counted from 0.
    ///
    /// # Errors
    ///
    /// When a port cannot be had.
    pub async fn start(
        scene: ProfilerScene,
        faults: &[(u32, Fault)],
    ) -> Result<ProfilerRig, RigError> {
        let listen = |at: SocketAddr| async move {
            let named = |error: io::Error| io::Error::new(error.kind(), format!("{at}: {error}"));
            TcpListener::bind(at).await.map_err(named).map_err(RigError::Tcp)
        };
        let commands = listen(scene.listen).await?;
        let streams = listen(SocketAddr::new(scene.listen.ip(), scene.stream_port)).await?;
        let local = |port: &TcpListener| port.local_addr().map_err(RigError::Tcp);
        let addresses = [local(&commands)?, local(&streams)?];
        let mut scan = scene.scan(faults);
        let mut controller = Controller::new(scene.optics, scene.seed);
        let mut task = JoinSet::new();
        task.spawn(async move {
            loop {
                let (client, stream) = match accept(&commands, &streams).await {
                    Ok(both) => both,
                    Err(error) => {
                        tracing::warn!(%error, "the bench takes no connections");
                        return;
                    }
                };
                // A client that goes away in the middle of a profile is no trouble of the bench.
                drop(serve(client, stream, &mut controller, &mut scan).await);
                controller.disconnected();
            }
        });
        Ok(ProfilerRig { addresses, task })
    }

    /// Addresses of commands and stream.
    pub fn addresses(&self) -> [SocketAddr; 2] {
        self.addresses
    }
}

impl fmt::Debug for ProfilerRig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (addresses, tasks) = (self.addresses, self.task.len());
        f.debug_struct("ProfilerRig")
            .field("addresses", &addresses)
            .field("tasks", &tasks)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = include_str!("scenes/profiler.toml");

    #[test]
    fn mistakes_are_named_and_other_scenes_left_to_others() {
        assert!(ProfilerScene::parse("profiler", SCENE).is_some_and(|scene| scene.is_ok()));
        assert!(ProfilerScene::parse("cmm", include_str!("scenes/cmm.toml")).is_none());
        for (from, to, key) in [
            ("127.0.0.1:24691", "profiler", "profiler.listen"),
            ("points = 400", "points = 4000", "profiler.points"),
            ("profiles = 400", "profiles = 0", "stage.profiles"),
            ("noise_um", "noise_nm", "profiler.noise_nm"),
            ("seed = 1", "", "seed"),
        ] {
            assert!(SCENE.contains(from), "{from}");
            let scene = ProfilerScene::parse("profiler", &SCENE.replacen(from, to, 1));
            let said = scene.expect("a scene with a profiler").expect_err("a mistake").to_string();
            assert!(said.contains(key), "{to}: {said}");
        }
    }
}
