//! A scene as its TOML file has it: every table and key, nothing checked but the types.
//!
//! `scenes/asphere.toml` says what each key means.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::Link;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Document {
    pub(crate) title: String,
    pub(crate) seed: u64,
    pub(crate) part: PartTable,
    pub(crate) fit: FitTable,
    #[serde(default)]
    pub(crate) tolerance: ToleranceTable,
    pub(crate) scan: ScanTable,
    pub(crate) probe: ProbeTable,
    pub(crate) stage: StageTable,
    pub(crate) thermal: Option<ThermalTable>,
    #[serde(default)]
    pub(crate) fault: Vec<FaultTable>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PartTable {
    pub(crate) surface: SurfaceTable,
    pub(crate) semi_diameter_mm: f64,
    #[serde(default)]
    pub(crate) pose: PoseTable,
    pub(crate) form_error: Option<FormErrorTable>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum SurfaceTable {
    Asphere {
        radius_mm: f64,
        #[serde(default)]
        conic: f64,
        #[serde(default)]
        coefficients: BTreeMap<String, f64>,
    },
    Sphere {
        radius_mm: f64,
    },
    Plane {},
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct PoseTable {
    pub(crate) tx_mm: f64,
    pub(crate) ty_mm: f64,
    pub(crate) tz_mm: f64,
    pub(crate) rx_rad: f64,
    pub(crate) ry_rad: f64,
    pub(crate) rz_rad: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FormErrorTable {
    #[serde(default)]
    pub(crate) fringe: Vec<FringeTable>,
    pub(crate) ring: Option<RingTable>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FringeTable {
    pub(crate) index: u8,
    pub(crate) height_nm: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RingTable {
    pub(crate) radius_mm: f64,
    pub(crate) width_mm: f64,
    pub(crate) height_nm: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FitTable {
    pub(crate) free: Vec<String>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ToleranceTable {
    pub(crate) pv_nm: Option<f64>,
    pub(crate) rms_nm: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub(crate) enum ScanTable {
    Spiral { points: u64, rate_hz: f64, radius_mm: f64, counts_per_turn: u32 },
    Raster { points: u64, rate_hz: f64, half_width_mm: f64 },
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProbeTable {
    pub(crate) noise_nm: f64,
    pub(crate) standoff_mm: f64,
    pub(crate) full_scale_um: f64,
    pub(crate) intensity: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageTable {
    pub(crate) node_ids: Vec<u8>,
    pub(crate) step_nm: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ThermalTable {
    pub(crate) unit_id: u8,
    pub(crate) mean_degc: f64,
    pub(crate) amplitude_degc: f64,
    pub(crate) period_s: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FaultTable {
    pub(crate) link: Link,
    pub(crate) at_point: u64,
    pub(crate) kind: String,
    pub(crate) duration_s: Option<f64>,
    pub(crate) restart: Option<bool>,
    pub(crate) bytes: Option<usize>,
    pub(crate) code: Option<u16>,
    pub(crate) register: Option<u8>,
}
