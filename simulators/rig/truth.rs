//! What a host that makes no mistake must find, under the names of the daemon's report.

use std::collections::BTreeMap;

use asphera_form::{Figures, Nominal, Parameter, Pose};
use serde::Serialize;

/// The truth of a scan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Truth {
    /// Name of the scene.
    pub scene: String,
    /// Seed of its noise.
    pub seed: u64,
    /// Points of the scan.
    pub points: u64,
    /// Standard deviation of the probe's noise along z, in nm.
    pub noise_nm: f64,
    /// What is to be compared with `form` of the report.
    pub form: FormTruth,
    /// The part itself.
    pub part: PartTruth,
}

/// Nominal, pose and deviation of the measured points.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormTruth {
    /// The design surface in words.
    pub nominal: String,
    /// What the fit must find.
    pub fit: FitTruth,
    /// What the measured points really had under the true pose: the part's form error and the
    /// noise realised at each point, both along the normal, and the rounding of the telegram. Like
    /// is compared with like: the host sees these points and no others. A fit over all of them
    /// differs by what the noise moves it, about σ/√N.
    pub deviation: DeviationTruth,
}

/// What the fit must find.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FitTruth {
    /// Names of the free parameters.
    pub free: Vec<String>,
    /// The free parameters by name.
    pub parameters: BTreeMap<String, ParameterTruth>,
    /// From the part frame into the machine's frame: `p' = Rz·Ry·Rx·p + t`.
    pub pose: PoseTruth,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterTruth {
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// A rigid motion, as the report writes it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseTruth {
    /// Shift along x in mm.
    pub tx_mm: f64,
    /// Shift along y in mm.
    pub ty_mm: f64,
    /// Shift along z in mm.
    pub tz_mm: f64,
    /// Rotation about x in rad.
    pub rx_rad: f64,
    /// Rotation about y in rad.
    pub ry_rad: f64,
    /// Rotation about z in rad.
    pub rz_rad: f64,
}

/// The part without the instrument.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartTruth {
    /// Its form error alone at the places measured.
    pub deviation: DeviationTruth,
}

/// Deviation along the normal of the nominal, positive on the +z side, over all points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DeviationTruth {
    /// Range.
    pub pv_nm: f64,
    /// Root mean square.
    pub rms_nm: f64,
    /// Largest.
    pub max_nm: f64,
    /// Smallest.
    pub min_nm: f64,
    /// Where the largest is, part frame, mm.
    pub at_max_mm: [f64; 3],
    /// Where the smallest is, part frame, mm.
    pub at_min_mm: [f64; 3],
}

impl FitTruth {
    pub(crate) fn new(free: &[Parameter], pose: &Pose, nominal: &Nominal) -> FitTruth {
        let parameters = free.iter().filter_map(|parameter| {
            let value = parameter.value(pose, nominal)?;
            let unit = parameter.unit(nominal)?;
            Some((parameter.name(nominal), ParameterTruth { value, unit }))
        });
        FitTruth {
            free: free.iter().map(ToString::to_string).collect(),
            parameters: parameters.collect(),
            pose: PoseTruth {
                tx_mm: pose.tx_mm,
                ty_mm: pose.ty_mm,
                tz_mm: pose.tz_mm,
                rx_rad: pose.rx_rad,
                ry_rad: pose.ry_rad,
                rz_rad: pose.rz_rad,
            },
        }
    }
}

impl From<Figures> for DeviationTruth {
    fn from(figures: Figures) -> DeviationTruth {
        DeviationTruth {
            pv_nm: figures.pv_nm,
            rms_nm: figures.rms_nm,
            max_nm: figures.max_nm,
            min_nm: figures.min_nm,
            at_max_mm: figures.at_max_mm,
            at_min_mm: figures.at_min_mm,
        }
    }
}
