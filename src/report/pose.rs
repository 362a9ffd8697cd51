//! Where the part lies in the measured frame.

use serde::{Deserialize, Serialize};

/// A rigid motion from the part frame into the measured frame: `p' = Rz·Ry·Rx·p + t`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseFigures {
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

impl PoseFigures {
    /// Takes a place of the part frame into the measured frame, both in mm.
    pub fn to_measured(&self, part_mm: [f64; 3]) -> [f64; 3] {
        let [(sx, cx), (sy, cy), (sz, cz)] =
            [self.rx_rad, self.ry_rad, self.rz_rad].map(f64::sin_cos);
        let rotation = [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ];
        let shift_mm = [self.tx_mm, self.ty_mm, self.tz_mm];
        std::array::from_fn(|axis| {
            let [a, b, c] = rotation[axis];
            a * part_mm[0] + b * part_mm[1] + c * part_mm[2] + shift_mm[axis]
        })
    }
}
