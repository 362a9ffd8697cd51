//! The tray under a line scanner that moves along y.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::net::SocketAddr;
use std::path::Path;

use asphera_form::artefact::{Artefact, ArtefactError};
use asphera_form::{Aperture, Pose};
use asphera_sim_rf627::{Departure, Optics, Scanner};

use super::{DUST, TrayScene, reach_mm};
use crate::noise::uniform;

/// A part as the scanner sees it: lengths in mm.
struct Lying {
    artefact: Artefact<Box<dyn Fn(f64, f64) -> f64>>,
    aperture: Aperture,
    pose: Pose,
}

/// Where the scanner goes. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrayScan {
    /// Points of a profile.
    pub across: usize,
    /// Profiles.
    pub profiles: u32,
    /// Steps of the encoder from one profile to the next.
    pub steps: u32,
}

impl TrayScan {
    /// Distance of profiles.
    pub fn pitch_mm(&self) -> f64 {
        f64::from(self.steps) * STEP_MM
    }
}

impl TrayScene {
    /// A scan with about the density of the scene along y, and as near to that across as a profile allows.
    pub fn line_scan(&self) -> TrayScan {
        let pitch_mm = self.density_per_mm2.sqrt().recip();
        let steps = (pitch_mm / STEP_MM).round().max(1.0);
        TrayScan {
            across: ((LINE_MM / pitch_mm) as usize).clamp(64, MOST_ACROSS),
            profiles: (LENGTH_MM / (steps * STEP_MM)).ceil() as u32,
            steps: steps as u32,
        }
    }

    /// The datagrams of the scanner, `rate_hz` profiles a second.
    ///
    /// # Errors
    ///
    /// A part whose design ends inside its aperture.
    pub fn departures(&self, rate_hz: f64) -> Result<Vec<Departure>, ArtefactError> {
        let scan = self.line_scan();
        let parts: Vec<Lying> =
            (0..self.parts.len()).map(|number| self.lying(number)).collect::<Result<_, _>>()?;
        let optics = Optics {
            x_range_mm: 200,
            z_range_mm: HEIGHT_MM as u16,
            points: scan.across,
            line_mm: LINE_MM,
            standoff_mm: HEIGHT_MM,
            noise_um: 1e-3 * self.noise_nm,
            rate_hz,
            ..Optics::default()
        };
        let mut scanner = Scanner::new(optics, self.seed);
        let mut departures = Vec::new();
        for profile in 0..scan.profiles {
            let y_mm = FIRST_MM + f64::from(profile * scan.steps) * STEP_MM;
            let height = |x_mm: f64| self.height_mm(&parts, x_mm + MIDDLE_MM, y_mm);
            // A profile has no more points than a datagram takes.
            let Ok(datagram) = scanner.measure(profile * scan.steps, height) else { break };
            let at_ns = u64::from(profile) * scanner.period_ns();
            departures.push(Departure { at_ns, datagram });
        }
        Ok(departures)
    }

    /// The configuration of a station that measures it: it listens for the scanner at `scanner`, and finds the designs in `library`.
    pub fn station_toml(
        &self,
        scanner: SocketAddr,
        [recordings, library]: [&Path; 2],
        listen: SocketAddr,
    ) -> String {
        let scan = self.line_scan();
        let mut text = String::new();
        let quoted = |path: &Path| toml::Value::String(path.display().to_string()).to_string();
        // Writing into a String cannot fail.
        let _ = write!(
            text,
            "[station]\nname = \"tray under a line scanner\"\n\
             [link.scanner]\nkind = \"udp\"\nlisten = \"{scanner}\"\n\
             [device.scanner]\ndriver = \"rf627\"\nlink = \"scanner\"\n\
             [sync]\ndevices = [\"scanner\"]\n\
             [kinematics]\nkind = \"line\"\n\
             across = {{ device = \"scanner\", offset_mm = {MIDDLE_MM:?} }}\n\
             along = {{ device = \"scanner\", channel = \"step\", mm_per_count = {STEP_MM:?}, offset_mm = {FIRST_MM:?} }}\n\
             height = {{ offset_mm = {HEIGHT_MM:?}, reverse = true }}\n\
             [nominal]\ndefects = false\n[nominal.sampling]\ncoverage_min = 0.5\n[nominal.surface]\nkind = \"plane\"\n[nominal.fit]\nfree = [\"tz\", \"rx\", \"ry\"]\n\
             [parts]\naxis = \"y\"\ntau_mm = {:?}\nlibrary = {}\n\
             [scan]\npoints = {}\nidle_s = 3\n[session]\ndir = {}\n[publish]\nlisten = \"{listen}\"\n",
            6.0 * scan.pitch_mm(),
            quoted(library),
            scan.profiles,
            quoted(recordings),
        );
        text
    }

    fn lying(&self, number: usize) -> Result<Lying, ArtefactError> {
        let part = &self.parts[number];
        let kind = &self.kinds[part.kind];
        let places = self.places(number as u64, &kind.aperture);
        let error_mm: Box<dyn Fn(f64, f64) -> f64> = Box::new(self.error_mm(number as u64, kind));
        let artefact = Artefact::new(
            kind.nominal.clone(),
            part.pose,
            &asphera_form::Parameter::RIGID,
            &places,
            error_mm,
        )?;
        Ok(Lying { artefact, aperture: kind.aperture.clone(), pose: part.pose })
    }

    /// The surface over a place of the tray; `None` between the parts.
    fn height_mm(&self, parts: &[Lying], x_mm: f64, y_mm: f64) -> Option<f64> {
        let found = parts.iter().find_map(|part| part.height_mm(x_mm, y_mm));
        found.or_else(|| {
            let draw = |number: usize| uniform(self.seed ^ DUST, number as u64);
            (0..self.grains).find_map(|grain| {
                let [dx, dy] = [x_mm - (-18.0 + 156.0 * draw(grain)), y_mm - 20.0];
                (dx.abs() < GRAIN_MM && dy.abs() < GRAIN_MM).then_some(0.1)
            })
        })
    }
}

impl Lying {
    fn height_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let (dx, dy) = (x_mm - self.pose.tx_mm, y_mm - self.pose.ty_mm);
        if dx.hypot(dy) > reach_mm(&self.aperture) + 1.0 {
            return None;
        }
        // The place of the part that stands over this one: the tray sees parts at small angles, so steps shrink fast.
        let turn = self.pose.rotation();
        let back = |dx: f64, dy: f64| {
            [turn[0][0] * dx + turn[1][0] * dy, turn[0][1] * dx + turn[1][1] * dy]
        };
        let [mut u, mut v] = back(dx, dy);
        for _ in 0..STEPS {
            let [x, y, _] = self.artefact.point_mm(u, v)?;
            let [du, dv] = back(x_mm - x, y_mm - y);
            (u, v) = (u + du, v + dv);
        }
        if !self.aperture.contains(u, v) {
            return None;
        }
        self.artefact.point_mm(u, v).map(|[_, _, z]| z)
    }
}

/// Places of a part turned by a share of a whole turn.
pub(super) fn turned(turn: f64) -> impl Fn(f64, f64) -> [f64; 2] {
    let (sin, cos) = (TAU * turn).sin_cos();
    move |x_mm, y_mm| [cos * x_mm - sin * y_mm, sin * x_mm + cos * y_mm]
}

/// A step of the encoder.
const STEP_MM: f64 = 0.01;
/// Length of the laser line, and the x of its middle.
const LINE_MM: f64 = 164.0;
const MIDDLE_MM: f64 = 60.0;
/// Where the scan begins, and how far it goes.
const FIRST_MM: f64 = -25.0;
const LENGTH_MM: f64 = 106.0;
/// Measuring range in z, from the tray up.
const HEIGHT_MM: f64 = 10.0;
/// Points of a profile that a datagram takes.
const MOST_ACROSS: usize = 640;
/// Half the side of a grain of dust.
const GRAIN_MM: f64 = 0.3;
/// Each step takes off a factor of the tilt, 0.04 at most.
const STEPS: usize = 6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scanner_meets_the_parts_where_they_lie() {
        let scene = TrayScene { noise_nm: 0.0, ..TrayScene::lenses(3) };
        let tray = scene.scan().unwrap();
        let parts: Vec<Lying> =
            (0..scene.parts.len()).map(|number| scene.lying(number).unwrap()).collect();
        let mut first = 0;
        for part in &tray.truth.parts {
            for &[x, y, z] in tray.points_mm[first..first + part.points].iter().step_by(97) {
                let found = scene.height_mm(&parts, x, y).unwrap();
                assert!((found - z).abs() < 1e-9, "{}: {found} for {z}", part.name);
            }
            first += part.points;
        }
        assert_eq!(scene.height_mm(&parts, 60.0, 25.0), None);
        let scan = scene.line_scan();
        let sent = scene.departures(100.0).unwrap();
        assert_eq!(sent.len() as u32, scan.profiles);
        assert!(scan.across > 500 && scan.pitch_mm() < 0.35, "{scan:?}");
    }
}
