//! The stage of a bench that obeys moves: a Zaber controller, or drives on a CAN bus.

use std::io;
use std::time::Duration;

use asphera_sim_cia402::{Drive, DriveSettings, SharedDrives};
use asphera_sim_zaber::{AxisSettings, SharedStage, Stage};
use tokio::io::{AsyncRead, AsyncWrite};

/// Kind of stage, as a scene names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StageKind {
    /// A Zaber controller with x and y, which was homed.
    Zaber,
    /// Drives after CiA 402 behind an slcan adapter: x is node 5 and y node 6. They were not homed.
    Drives,
}

/// Both axes of a bench. Clones are the same axes.
#[derive(Clone)]
pub(crate) enum Axes {
    Zaber(SharedStage),
    Drives { drives: SharedDrives, count_mm: f64 },
}

impl StageKind {
    pub(crate) const WORDS: [(&'static str, StageKind); 2] =
        [("zaber", StageKind::Zaber), ("cia402", StageKind::Drives)];
}

impl Axes {
    /// Axes with counts of so many µm and a travel from 0. `None` where the travel has too many counts.
    pub(crate) fn new(kind: StageKind, count_um: f64, travel_mm: f64) -> Option<Axes> {
        let count_mm = count_um * 1e-3;
        match kind {
            StageKind::Zaber => {
                let axis = AxisSettings { microstep_um: count_um, travel_mm, at_mm: 0.0 };
                Some(Axes::Zaber(SharedStage::new(Stage::new(1, &[axis, axis]))))
            }
            StageKind::Drives => {
                let counts = |mm: f64| {
                    let counts = (mm / count_mm).round();
                    (counts <= f64::from(i32::MAX)).then_some(counts as i32)
                };
                let travel = counts(travel_mm)?;
                // They count from where they were switched on.
                let drive = |node_id, share: f64| {
                    let at = counts(share * travel_mm)?;
                    let acceleration = counts(ACCELERATION_MM_S2)?.unsigned_abs();
                    Drive::new(DriveSettings { node_id, travel, at, acceleration }).ok()
                };
                let drives = SharedDrives::new(vec![drive(NODES[0], 0.3)?, drive(NODES[1], 0.4)?]);
                Some(Axes::Drives { drives, count_mm })
            }
        }
    }

    /// Time since they were switched on.
    pub(crate) fn now(&self) -> Duration {
        match self {
            Axes::Zaber(stage) => stage.now(),
            Axes::Drives { drives, .. } => drives.now(),
        }
    }

    /// True places in mm, from the end with the switch on.
    pub(crate) fn places_mm(&self) -> Vec<f64> {
        match self {
            Axes::Zaber(stage) => stage.places_mm(),
            Axes::Drives { drives, count_mm } => {
                drives.places().into_iter().map(|counts| counts * count_mm).collect()
            }
        }
    }

    /// Answers a connection to its end.
    pub(crate) async fn serve(
        &self,
        stream: impl AsyncRead + AsyncWrite + Unpin,
    ) -> io::Result<()> {
        match self {
            Axes::Zaber(stage) => stage.serve(stream).await,
            Axes::Drives { drives, .. } => asphera_sim_cia402::serve(drives, stream).await,
        }
    }
}

const NODES: [u8; 2] = [5, 6];
/// Of a drive, unless it is set anew.
const ACCELERATION_MM_S2: f64 = 500.0;
