//! What can go wrong with a scene and on a bench.

use std::io;
use std::path::PathBuf;

use asphera_link::Problem;
use asphera_settings::Problems;
use thiserror::Error;

use crate::{Link, PlanError};

/// Why there is no scene.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file cannot be used.
    #[error("scene {scene} cannot be used:\n{problems}")]
    File {
        /// Name of the scene.
        scene: String,
        /// All that is wrong with it.
        problems: Problems,
    },
    /// Numbers that were changed after the scene was read cannot be.
    #[error("scene {scene} cannot be played: {}", list(.problems))]
    Values {
        /// Name of the scene.
        scene: String,
        /// All that is wrong, under the keys of a scene's file; never empty.
        problems: Vec<Problem>,
    },
}

fn list(problems: &[Problem]) -> String {
    problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("; ")
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
    /// No TCP port for a gauge or a stage.
    #[error("no TCP port for the bench; another one may run")]
    Tcp(#[source] io::Error),
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
