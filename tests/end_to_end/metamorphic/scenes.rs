//! Small parts with form error, noise and a pit, and their reports.

use asphera_tests::{json, run};
use serde_json::Value;

use super::laws::Change;

/// A kind of part.
pub(super) struct Scene {
    pub(super) name: &'static str,
    /// Heights of the design in mm, over x and y in mm.
    sag_mm: fn(f64, f64) -> f64,
    /// Half the sides of the field of points, mm.
    half_mm: [f64; 2],
    /// The tables `[surface]`, `[aperture]`, `[fit]`; lengths times the scale. Where the aperture does not lie where the
    /// surface does, about a place in mm.
    nominal: fn(f64, [f64; 2]) -> String,
    /// Radius and its standard uncertainty of the ball whose centres the points are, mm.
    tip_mm: Option<[f64; 2]>,
}

pub(super) const SCENES: [Scene; 5] = [
    Scene {
        name: "asphere",
        sag_mm: |x, y| {
            let r2 = x * x + y * y;
            r2 / RADIUS_MM / (1.0 + (1.0 + 0.1 * r2 / RADIUS_MM.powi(2)).sqrt()) + A4 * r2 * r2
        },
        half_mm: [6.6, 6.6],
        nominal: |scale, _| {
            format!(
                "[surface]\nkind = \"asphere\"\nradius_mm = {}\nconic = -1.1\nA4 = {}\n\
                 [aperture]\nshape = \"circle\"\nradius_mm = {}\n",
                RADIUS_MM * scale,
                A4 / scale.powi(3),
                6.0 * scale
            )
        },
        tip_mm: None,
    },
    Scene {
        name: "sphere, radius free",
        sag_mm: |x, y| {
            let r2 = x * x + y * y;
            r2 / 50.0 / (1.0 + (1.0 - r2 / 2500.0).sqrt())
        },
        half_mm: [6.6, 6.6],
        nominal: |scale, _| {
            format!(
                "[surface]\nkind = \"sphere\"\nradius_mm = {}\n[aperture]\nshape = \"circle\"\nradius_mm = {}\n\
                 [fit]\nfree = [\"tx\", \"ty\", \"tz\", \"radius\"]\n",
                50.0 * scale,
                6.0 * scale
            )
        },
        tip_mm: None,
    },
    Scene {
        name: "plane without an aperture",
        sag_mm: |_, _| 0.0,
        half_mm: [6.5, 5.0],
        nominal: |_, _| "[surface]\nkind = \"plane\"\n".to_owned(),
        tip_mm: None,
    },
    Scene {
        name: "plane with an aperture",
        sag_mm: |_, _| 0.0,
        half_mm: [5.5, 5.5],
        nominal: |scale, [x_mm, y_mm]| {
            format!(
                "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = {}\n\
                 centre_mm = [{x_mm:?}, {y_mm:?}]\n",
                5.0 * scale
            )
        },
        tip_mm: None,
    },
    Scene {
        name: "sphere under a ball tip",
        // Centres of the ball lie on a sphere that is narrower by its radius.
        sag_mm: |x, y| 50.0 - ((50.0 - TIP_MM) * (50.0 - TIP_MM) - x * x - y * y).sqrt(),
        half_mm: [6.4, 6.4],
        nominal: |scale, _| {
            format!(
                "[surface]\nkind = \"sphere\"\nradius_mm = {}\n[aperture]\nshape = \"circle\"\nradius_mm = {}\n",
                50.0 * scale,
                6.0 * scale
            )
        },
        tip_mm: Some([TIP_MM, 2e-3]),
    },
];

const RADIUS_MM: f64 = 11.65;
const TIP_MM: f64 = 0.5;
const A4: f64 = 3.69e-5;
/// Points along either side.
const SIDE: u32 = 45;

/// The points of a scene, as measured, and how its lengths were scaled.
pub(super) struct Part<'a> {
    scene: &'a Scene,
    points_mm: Vec<[f64; 3]>,
    scale: f64,
    centre_mm: [f64; 2],
    pose_held: bool,
}

impl<'a> Part<'a> {
    /// A raster with jitter, form error of long and middle waves, noise of 2 nm, one pit.
    pub(super) fn new(scene: &'a Scene) -> Part<'a> {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let [half_x, half_y] = scene.half_mm;
        let mut points_mm = Vec::new();
        for row in 0..SIDE {
            for column in 0..SIDE {
                let mut place = |index: u32, half: f64| {
                    let steps = f64::from(index) + 0.2 * random.within_one();
                    half * (2.0 * steps / f64::from(SIDE - 1) - 1.0)
                };
                let (x, y) = (place(column, half_x), place(row, half_y));
                let noise_nm = (0..12).map(|_| random.within_one()).sum::<f64>();
                let pit_nm = if (x - 2.1).hypot(y + 1.3) < 0.55 { -150.0 } else { 0.0 };
                let nm = form_nm(x / 6.0, y / 6.0) + noise_nm + pit_nm;
                points_mm.push([x, y, (scene.sag_mm)(x, y) + 1e-6 * nm]);
            }
        }
        Part { scene, points_mm, scale: 1.0, centre_mm: [0.0; 2], pose_held: false }
    }

    /// The part after a change.
    pub(super) fn changed(mut self, change: &Change) -> Part<'a> {
        for point in &mut self.points_mm {
            *point = change.place_mm(*point);
        }
        if change.shuffled {
            let mut random = Random(0x9e37_79b9_7f4a_7c15);
            for last in (1..self.points_mm.len()).rev() {
                let other = (random.next() % (last as u64 + 1)) as usize;
                self.points_mm.swap(last, other);
            }
        }
        self.scale *= change.scale;
        let [x_mm, y_mm, _] = change.place_mm([self.centre_mm[0], self.centre_mm[1], 0.0]);
        self.centre_mm = [x_mm, y_mm];
        self
    }

    /// The part where it lies: the fit changes nothing.
    pub(super) fn held(mut self) -> Part<'a> {
        self.pose_held = true;
        self
    }

    /// Every second of the points, from the first or the second on.
    pub(super) fn every_second(mut self, from: usize) -> Part<'a> {
        self.points_mm = self.points_mm.into_iter().skip(from).step_by(2).collect();
        self
    }

    /// What `asphera measure` reports of the part.
    pub(super) fn report(&self) -> Value {
        let folder = tempfile::tempdir().unwrap();
        let points = folder.path().join("part.xyz");
        let rows = self.points_mm.iter().map(|[x, y, z]| format!("{x} {y} {z}\n"));
        std::fs::write(&points, rows.collect::<String>()).unwrap();
        let nominal = folder.path().join("nominal.toml");
        let fit = if self.pose_held { "[fit]\nfree = []\n" } else { "" };
        let text = (self.scene.nominal)(self.scale, self.centre_mm) + fit + &judging(self.scale);
        std::fs::write(&nominal, text).unwrap();
        let [points, nominal] = [&points, &nominal].map(|path| path.to_str().unwrap());
        let tip =
            self.scene.tip_mm.map(|lengths_mm| lengths_mm.map(|mm| (mm * self.scale).to_string()));
        let mut arguments = vec!["measure", points, "--nominal", nominal, "--json"];
        if let Some([radius, u]) = &tip {
            arguments.extend(["--tip-centre", "--tip-radius", radius, "--tip-u-radius", u]);
        }
        json(&run(arguments))
    }
}

/// Limits and figures, every length times the scale.
fn judging(scale: f64) -> String {
    let lengths = |names: &[(&str, f64)]| {
        names
            .iter()
            .map(|(name, value)| format!("{name} = {}\n", value * scale))
            .collect::<String>()
    };
    format!(
        "[tolerance]\n{}[figures]\nminimum_zone = true\npsd = true\nzernike_terms = 36\nq_terms = 8\n{}\
         [figures.texture]\n{}[uncertainty]\n{}[sampling]\n{}[partition]\nflat_below_per_mm = {}\n",
        lengths(&[
            ("pv_nm", 900.0),
            ("rms_nm", 100.0),
            ("a_nm", 800.0),
            ("b_nm", 600.0),
            ("c_nm", 300.0),
            ("rmst_nm", 100.0),
            ("rmsi_nm", 90.0),
            ("rmsa_nm", 90.0),
            ("pvr_nm", 700.0),
        ]),
        lengths(&[("slope_length_mm", 0.5)]),
        lengths(&[("s_mm", 1.2), ("l_mm", 4.0)]),
        lengths(&[("noise_nm", 2.0)]),
        lengths(&[("gap_limit_mm", 0.5)]),
        1e-6 / scale
    )
}

/// Form error in nm over places in shares of 6 mm.
fn form_nm(u: f64, v: f64) -> f64 {
    let r2 = u * u + v * v;
    120.0 * (u * u - v * v)
        + 80.0 * u * v
        + 60.0 * (3.0 * r2 - 2.0) * u
        + 40.0 * (6.0 * r2 * r2 - 6.0 * r2 + 1.0)
        + 15.0 * (9.0 * u + 1.0).cos() * (7.0 * v).sin()
}

/// Marsaglia's xorshift64 (Journal of Statistical Software 8, 2003, 14), written out so that parts stay the same.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// A number between -1 and 1.
    fn within_one(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
