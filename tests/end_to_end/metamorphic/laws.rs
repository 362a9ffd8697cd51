//! How each number of a report changes with the part.

/// A change of a part: turned, then scaled, then shifted; or only its points in another order.
#[derive(Clone, Copy)]
pub(super) struct Change {
    pub(super) shuffled: bool,
    pub(super) turn: Turn,
    /// Every length times this. A power of two costs no digits.
    pub(super) scale: f64,
    pub(super) shift_mm: [f64; 3],
}

/// A motion that keeps a raster a raster.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Turn {
    Not,
    /// By 90° about z: x becomes y.
    Quarter,
    /// x becomes -x.
    Mirror,
}

impl Change {
    pub(super) const NONE: Change =
        Change { shuffled: false, turn: Turn::Not, scale: 1.0, shift_mm: [0.0; 3] };

    /// A place of the measured frame.
    pub(super) fn place_mm(&self, place_mm: [f64; 3]) -> [f64; 3] {
        let turned = self.direction(place_mm);
        [0, 1, 2].map(|axis| turned[axis] * self.scale + self.shift_mm[axis])
    }

    /// A direction, and a place of the part frame but for the scale.
    pub(super) fn direction(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self.turn {
            Turn::Not => [x, y, z],
            Turn::Quarter => [-y, x, z],
            Turn::Mirror => [-x, y, z],
        }
    }

    /// A small rotation vector, which a mirror turns the other way.
    pub(super) fn rotation(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self.turn {
            Turn::Not => [x, y, z],
            Turn::Quarter => [-y, x, z],
            Turn::Mirror => [x, -y, -z],
        }
    }

    /// An orientation in the plane in degrees, 0 to 180.
    pub(super) fn orientation_deg(&self, deg: f64) -> f64 {
        match self.turn {
            Turn::Not => deg,
            Turn::Quarter => (deg + 90.0).rem_euclid(180.0),
            Turn::Mirror => (180.0 - deg).rem_euclid(180.0),
        }
    }

    /// A pair of Zernike terms cos mφ and sin mφ, m > 0.
    pub(super) fn zernike(&self, m: i32, [cos, sin]: [f64; 2]) -> [f64; 2] {
        match (self.turn, m.rem_euclid(4)) {
            (Turn::Not, _) | (Turn::Quarter, 0) => [cos, sin],
            (Turn::Quarter, 1) => [-sin, cos],
            (Turn::Quarter, 2) => [-cos, -sin],
            (Turn::Quarter, _) => [sin, -cos],
            (Turn::Mirror, even) if even % 2 == 0 => [cos, -sin],
            (Turn::Mirror, _) => [-cos, sin],
        }
    }
}

/// Power of the scale by which a number changes, from the unit in its key or in `unit` beside it; `None` for a number
/// whose name has no unit and which is in no list.
pub(super) fn power_of_length(key: &str, unit: Option<&str>) -> Option<i32> {
    if let Some(unit) = unit {
        return UNITS.iter().find(|(name, _)| *name == unit).map(|(_, power)| *power);
    }
    if SETTINGS.contains(&key) {
        return Some(0);
    }
    SUFFIXES
        .iter()
        .find(|(suffix, _)| key.ends_with(suffix))
        .map(|(_, power)| *power)
        .or_else(|| PURE_NUMBERS.contains(&key).then_some(0))
}

/// Settings that have a unit and stay what they are, whatever the part.
const SETTINGS: &[&str] = &["min_height_nm"];

/// Units as figures and parameters write them.
const UNITS: [(&str, i32); 13] = [
    ("urad", 0),
    ("", 0),
    ("1", 0),
    ("%", 0),
    ("nm", 1),
    ("mm", 1),
    ("µm", 1),
    ("1/mm", -1),
    ("mm^-3", -3),
    ("rad", 0),
    ("µrad", 0),
    ("°", 0),
    ("mm²", 2),
];

/// Units as names of keys end with them, the longer before the shorter.
const SUFFIXES: [(&str, i32); 13] = [
    ("_nm2_mm2", 4),
    ("_nm_per_mm2", -1),
    ("_per_mm", -1),
    ("_um3", 3),
    ("_mm2", 2),
    ("_mm", 1),
    ("_nm", 1),
    ("_urad", 0),
    ("_rad", 0),
    ("_deg", 0),
    ("_p", 0),
    ("_sigmas", 0),
    ("_ratio", 0),
];

/// Counts, shares and other numbers without a unit.
const PURE_NUMBERS: &[&str] = &[
    "received",
    "used",
    "outside_aperture",
    "duplicates",
    "lost",
    "missing",
    "vertices",
    "triangles",
    "edges",
    "hull",
    "walls",
    "spikes",
    "places",
    "measurements",
    "epsilon_target",
    "epsilon_max",
    "epsilon_p99",
    "rho_target",
    "rho_max",
    "coverage",
    "overdense_fraction",
    "next_more",
    "islands",
    "holes",
    "as_of_points",
    "points",
    "significance",
    "defects_more",
    "false_expected",
    "lower",
    "points_unknown",
    "concave",
    "convex",
    "saddle",
    "trough",
    "ridge",
    "flat",
    "dof",
    "share",
    "ratio",
    "p",
    "k",
    "draws",
    "seed",
    "index",
    "n",
    "m",
    "indeterminate",
    "covered",
    "measured",
    "patches",
    "number",
    "asked",
    "bridged",
    "contacts",
    "hollow_share",
];
