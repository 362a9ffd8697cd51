//! A scene: part, machine, instruments and what goes wrong, checked.

mod check;
pub(crate) mod read;

use asphera_form::form_error::FormError;
use asphera_form::{Nominal, Parameter, Pose};
use asphera_link::Problem;
use asphera_settings::File;

use crate::fault::Scheduled;
use crate::motion::Motion;
use crate::{SceneError, Speed};

/// A scene: part, machine, instruments and what goes wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub(crate) name: String,
    pub(crate) title: String,
    pub(crate) seed: u64,
    pub(crate) speed: Speed,
    pub(crate) nominal: Nominal,
    pub(crate) semi_diameter_mm: f64,
    pub(crate) pose: Pose,
    pub(crate) form_error: FormError,
    pub(crate) free: Vec<Parameter>,
    pub(crate) tolerance: Limits,
    pub(crate) points: u64,
    pub(crate) rate_hz: f64,
    pub(crate) motion: Motion,
    pub(crate) noise_nm: f64,
    pub(crate) standoff_mm: f64,
    pub(crate) full_scale_um: f64,
    pub(crate) protocol: Protocol,
    pub(crate) intensity: f64,
    pub(crate) node_ids: Vec<u8>,
    pub(crate) thermal: Option<Thermal>,
    /// In the order in which they happen.
    pub(crate) faults: Vec<Scheduled>,
}

/// Limits of the nominal of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    /// Largest PV allowed, nm.
    pub(crate) pv_nm: Option<f64>,
    /// Largest RMS allowed, nm.
    pub(crate) rms_nm: Option<f64>,
}

/// Protocol of the probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Protocol {
    /// Commands and telegrams on a serial port.
    Dollar,
    /// Packets on TCP.
    Packets,
}

/// The thermometer: a slow sine about a mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thermal {
    pub(crate) unit_id: u8,
    pub(crate) mean_degc: f64,
    pub(crate) amplitude_degc: f64,
    pub(crate) period_s: f64,
}

impl Scene {
    /// Names of the built-in scenes, the default first.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// A built-in scene; `None` if there is none of that name.
    pub fn built_in(name: &str) -> Option<Scene> {
        let (name, text) = BUILT_IN.iter().find(|(known, _)| *known == name)?;
        Some(Scene::parse(name, text).expect("built-in scenes are parsed by a test"))
    }

    /// The text of a built-in scene, to start one's own from.
    pub fn built_in_toml(name: &str) -> Option<&'static str> {
        BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Reads a scene. `name` stands in errors and in the truth.
    ///
    /// # Errors
    ///
    /// All that is wrong, each with its line and key: keys and types first, ranges once all could be read.
    pub fn parse(name: &str, text: &str) -> Result<Scene, SceneError> {
        let unusable = |problems| SceneError::File { scene: name.to_owned(), problems };
        let file = File::parse(name, text).map_err(unusable)?;
        let root = file.root();
        let scene = read::scene(name, &root);
        for Problem { key, expected, found } in scene.iter().flat_map(Scene::problems) {
            root.problem(&key, expected, found);
        }
        drop(root);
        let mut scene = file.conclude(scene).map_err(unusable)?;
        // A stable sort: faults of one trigger happen in the order of the file.
        scene.faults.sort_by_key(|fault| fault.at_point);
        Ok(scene)
    }

    /// The scene with so many points, 1 to 10,000,000 and no more than the rotary encoder can
    /// count. Faults keep their share of the way: `at_point` is scaled along. A number that cannot
    /// be is refused by [`crate::Rig::start`].
    #[must_use]
    pub fn with_points(mut self, points: u64) -> Scene {
        for fault in &mut self.faults {
            let scaled = u128::from(fault.at_point) * u128::from(points) / u128::from(self.points);
            fault.at_point = u64::try_from(scaled).unwrap_or(u64::MAX);
        }
        self.points = points;
        self
    }

    /// The scene with another seed of all that is random.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Scene {
        self.seed = seed;
        self
    }

    /// The scene at another speed.
    #[must_use]
    pub fn with_speed(mut self, speed: Speed) -> Scene {
        self.speed = speed;
        self
    }

    /// The name it was read under.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it shows, in words.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Triggers of the scan.
    pub fn points(&self) -> u64 {
        self.points
    }
}

const BUILT_IN: [(&str, &str); 6] = [
    ("asphere", include_str!("scenes/asphere.toml")),
    ("asphere-unplugged", include_str!("scenes/asphere-unplugged.toml")),
    ("asphere-noise", include_str!("scenes/asphere-noise.toml")),
    ("sphere", include_str!("scenes/sphere.toml")),
    ("blade", include_str!("scenes/blade.toml")),
    ("ball", include_str!("scenes/ball.toml")),
];

#[cfg(test)]
mod tests;
