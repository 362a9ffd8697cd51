//! What can go wrong with a scene and on a bench.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::{Link, PlanError};

/// Why there is no scene.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The text is no TOML, a key is missing or unknown, or a value has the wrong type.
    #[error("scene {scene} cannot be read")]
    Syntax {
        /// Name of the scene.
        scene: String,
        /// Where, and what was expected.
        #[source]
        source: Box<toml::de::Error>,
    },
    /// A value that cannot be.
    #[error("scene {scene}: {key}: expected {expected}, found {found}")]
    Value {
        /// Name of the scene.
        scene: String,
        /// The key with its tables: `part.pose.rx_rad`.
        key: String,
        /// What would do.
        expected: String,
        /// What is there.
        found: String,
    },
}

/// Why there is no bench.
#[derive(Debug, Error)]
pub enum RigError {
    /// The scan cannot be computed; a scene whose numbers were changed after it was read is looked
    /// at again.
    #[error("the scan cannot be computed")]
    Plan(#[from] PlanError),
    /// The computation of the scan was cut off.
    #[error("the computation of the scan was cut off")]
    Interrupted,
    /// A port cannot be made.
    #[error("no port {}", path.display())]
    Port {
        /// The port's name.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// No TCP port for the thermometer.
    #[error("no TCP port on 127.0.0.1 for the thermometer")]
    Listen(#[source] io::Error),
    /// The numbers of the nodes cannot be together on a bus.
    #[error("the nodes of the stage cannot be on one bus")]
    Bus(#[from] asphera_sim_cia406::BusError),
}

/// Why a fault cannot happen.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum FaultError {
    /// Not to such a link.
    #[error("fault {kind} cannot happen to the link {link}")]
    Unsuitable {
        /// The link.
        link: Link,
        /// The fault's word.
        kind: &'static str,
    },
    /// The scene has no such link.
    #[error("the scene has no link {0}")]
    NoLink(Link),
}
