//! The five parts.

use std::sync::Arc;

use asphera_form::shape::{Nodes, SagGrid};
use asphera_form::{Nominal, Parameter};
use asphera_measure::{Part, design_spacing};
use asphera_plan::Aperture;

/// A simulated part, how it is judged, and what a scan is to reach.
pub struct Simulated {
    /// Its name in the table.
    pub name: &'static str,
    /// Design, limits of sampling and of figures.
    pub part: Part,
    /// The region that is scanned, as the design has it.
    pub aperture: Aperture,
    /// Height of the real part over a place, mm.
    height_mm: fn(&Part, f64, f64) -> Option<f64>,
    /// Standard deviation of the noise in nm, and its seed.
    pub noise_nm: f64,
    pub seed: u64,
    /// Spacing of the coarse scan in mm.
    pub coarse_mm: f64,
    /// Share of the aperture to be covered.
    pub coverage: f64,
    /// Largest standard uncertainty of the figure that is judged, nm.
    pub u_max_nm: f64,
}

impl Simulated {
    /// Points over the places, each with its noise.
    pub fn points(&self, places: &[[f64; 2]]) -> Vec<[f64; 3]> {
        let height = |&[x, y]: &[f64; 2]| {
            let z = (self.height_mm)(&self.part, x, y)?;
            Some([x, y, z + 1e-6 * self.noise_nm * noise(self.seed, [x, y])])
        };
        places.iter().filter_map(height).collect()
    }
}

/// All five, and an asphere as most are.
pub fn all() -> Vec<Simulated> {
    vec![
        steep_asphere(),
        freeform(),
        local_waviness(),
        clean_sphere(),
        failing(),
        moderate_asphere(),
    ]
}

/// An oblate asphere whose rim stands at 71°.
fn steep_asphere() -> Simulated {
    let part = parsed(
        "[surface]\nkind = \"asphere\"\nradius_mm = 10\nconic = 0.2\n\
         [aperture]\nshape = \"circle\"\nradius_mm = 8.7\n",
        0.05,
        600,
    );
    Simulated {
        name: "steep asphere",
        coarse_mm: coarse_mm(&part, 5),
        part,
        aperture: Aperture::Circle { radius_mm: 8.7 },
        height_mm: wavy,
        noise_nm: 10.0,
        seed: 1,
        coverage: 0.99,
        u_max_nm: 20.0,
    }
}

/// A square lens whose corners are drawn up.
fn freeform() -> Simulated {
    let part = parsed(
        "[surface]\nkind = \"xy\"\nradius_mm = 60\nnormalisation_radius_mm = 10\n\
         [[surface.terms]]\nx = 6\ny = 6\nmm = 10\n[[surface.terms]]\nx = 2\ny = 1\nmm = 0.1\n\
         [aperture]\nshape = \"rectangle\"\nwidth_mm = 16\nheight_mm = 16\n",
        0.1,
        600,
    );
    Simulated {
        name: "freeform",
        coarse_mm: coarse_mm(&part, 5),
        part,
        aperture: Aperture::Rectangle { width_mm: 16.0, height_mm: 16.0 },
        height_mm: wavy,
        noise_nm: 10.0,
        seed: 2,
        coverage: 0.99,
        u_max_nm: 20.0,
    }
}

/// The asphere of config/nominals: its rim stands at 41°.
fn moderate_asphere() -> Simulated {
    let part = parsed(
        "[surface]\nkind = \"asphere\"\nradius_mm = 11.65\nconic = -1.1\nA4 = 3.69067205091e-5\n\
         [aperture]\nshape = \"circle\"\nradius_mm = 9\n",
        0.05,
        600,
    );
    Simulated {
        name: "asphere of 41°",
        coarse_mm: coarse_mm(&part, 4),
        part,
        aperture: Aperture::Circle { radius_mm: 9.0 },
        seed: 6,
        ..steep_asphere()
    }
}

/// A sphere of 100 mm with a patch of waves, 2 mm long and 60 µm high, as its design says.
fn local_waviness() -> Simulated {
    let height = |[x, y]: [f64; 2]| {
        let from = (x - 4.0).hypot(y - 2.0);
        let patch = (-(from / 2.5).powi(4)).exp();
        100.0 - (1e4 - x * x - y * y).sqrt() + 0.03 * patch * (std::f64::consts::PI * x).cos()
    };
    let nodes = Nodes {
        x_min_mm: -11.0,
        y_min_mm: -11.0,
        step_x_mm: 0.1,
        step_y_mm: 0.1,
        nx: 221,
        ny: 221,
    };
    let places = (0..221 * 221).map(|k| [k % 221, k / 221].map(|k| 0.1 * f64::from(k) - 11.0));
    let heights: Vec<f64> = places.map(height).collect();
    let sphere = "[surface]\nkind = \"sphere\"\nradius_mm = 100\n[aperture]\nshape = \"circle\"\nradius_mm = 10\n";
    let mut part = parsed(sphere, 0.1, 600);
    part.nominal = Nominal::Freeform(Arc::new(SagGrid::new(nodes, &heights).unwrap()));
    part.free = Parameter::POSE.to_vec();
    Simulated {
        name: "local waviness",
        coarse_mm: coarse_mm(&part, 6),
        part,
        aperture: Aperture::Circle { radius_mm: 10.0 },
        height_mm: wavy,
        noise_nm: 10.0,
        seed: 3,
        coverage: 0.99,
        u_max_nm: 20.0,
    }
}

fn clean_sphere() -> Simulated {
    let part = parsed(SPHERE, 0.02, 600);
    Simulated {
        name: "clean sphere",
        coarse_mm: coarse_mm(&part, 4),
        part,
        aperture: Aperture::Circle { radius_mm: 8.0 },
        height_mm: |part, x, y| part.nominal.height_mm(x, y),
        noise_nm: 10.0,
        seed: 4,
        coverage: 0.99,
        u_max_nm: 20.0,
    }
}

fn failing() -> Simulated {
    Simulated {
        name: "part that fails",
        part: parsed(SPHERE, 0.02, 200),
        height_mm: |part, x, y| {
            Some(part.nominal.height_mm(x, y)? + 1e-3 * (0.5 * x).sin() * (0.4 * y).cos())
        },
        seed: 5,
        ..clean_sphere()
    }
}

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 30\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 8\n";

/// The design with a form error of some 300 nm from peak to valley.
fn wavy(part: &Part, x: f64, y: f64) -> Option<f64> {
    Some(part.nominal.height_mm(x, y)? + 150e-6 * (0.5 * x).sin() * (0.4 * y + 0.3).cos())
}

fn parsed(design: &str, epsilon: f64, pv_nm: u32) -> Part {
    let text = format!(
        "{design}[sampling]\nepsilon_limit = {epsilon}\ngap_limit_mm = 3\ncoverage_min = 0.99\n[tolerance]\npv_nm = {pv_nm}\n"
    );
    asphera_nominal::parse("part.toml", &text).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

/// The spacing from which so many levels lead to the one the design needs where it needs the finest.
fn coarse_mm(part: &Part, levels: u8) -> f64 {
    planned_mm(part) * (0.5 * f64::from(levels)).exp2()
}

/// The spacing the design needs, as `asphera plan --from-epsilon` plans it.
pub fn planned_mm(part: &Part) -> f64 {
    design_spacing(part, part.epsilon_limit.unwrap()).unwrap().spacing_mm
}

/// Standard normal, by the place alone: SplitMix64 and Box and Muller.
fn noise(seed: u64, place: [f64; 2]) -> f64 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let state = place.iter().fold(mix(seed.wrapping_add(0x9E37_79B9_7F4A_7C15)), |state, mm| {
        // To a tenth of a nanometre, so that a place is the same however it was reached.
        mix(state ^ ((1e7 * mm).round() as i64 as u64)).wrapping_add(0x9E37_79B9_7F4A_7C15)
    });
    let unit = |state: u64| ((mix(state) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
    let angle = std::f64::consts::TAU * unit(state.wrapping_add(1));
    (-2.0 * unit(state).ln()).sqrt() * angle.cos()
}
