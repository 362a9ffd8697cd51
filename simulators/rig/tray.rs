//! A tray of lenses, a flat and rings, scanned from above: its points, and what lies where.
//!
//! Places of a part are random over its aperture, as from a seed and their numbers, and so is the noise along z. The form error of a
//! part moves no fit over its own points, so the truth of its deviation is exact.

mod scanner;

use std::f64::consts::PI;

use asphera_form::artefact::{Artefact, ArtefactError};
use asphera_form::form_error::FormError;
use asphera_form::{Aperture, Asphere, Nominal, Parameter, PointMm, Pose};
use serde::Serialize;

pub use self::scanner::TrayScan;
use self::scanner::turned;
use crate::noise::{standard_normal, uniform};

/// A tray and how it is scanned.
#[derive(Clone, Debug)]
pub struct TrayScene {
    /// Kinds of parts: the library.
    pub kinds: Vec<TrayKind>,
    /// What lies where.
    pub parts: Vec<TrayPart>,
    /// Points on a mm² of a part.
    pub density_per_mm2: f64,
    /// Standard deviation of the noise along z, nm.
    pub noise_nm: f64,
    /// Grains of dust, of four points each.
    pub grains: usize,
    /// Seed of places and noise.
    pub seed: u64,
}

/// A kind of part.
#[derive(Clone, Debug)]
pub struct TrayKind {
    /// Its name.
    pub name: &'static str,
    /// Its design, seen from outside.
    pub nominal: Nominal,
    /// The region of its face.
    pub aperture: Aperture,
    /// Range of its form error in the order of 200 nm, as a factor.
    pub form: f64,
}

/// A part on the tray.
#[derive(Clone, Copy, Debug)]
pub struct TrayPart {
    /// The number of its kind.
    pub kind: usize,
    /// From its own frame into that of the tray.
    pub pose: Pose,
}

/// A scan of a tray.
#[derive(Clone, Debug)]
pub struct Tray {
    /// The points, one part after the other, dust last; x y z in mm.
    pub points_mm: Vec<PointMm>,
    /// What lies there.
    pub truth: TrayTruth,
}

/// What must be found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrayTruth {
    /// The parts in the order of the points.
    pub parts: Vec<TrayPartTruth>,
    /// Points of dust.
    pub dust_points: usize,
    /// Standard deviation of the noise along z, nm.
    pub noise_nm: f64,
    /// Seed of places and noise.
    pub seed: u64,
}

/// What must be found of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrayPartTruth {
    /// The name of its kind.
    pub name: String,
    /// Where its vertex lies on the tray, mm.
    pub place_mm: PointMm,
    /// The angle between its axis and that of the tray, degrees.
    pub tilt_deg: f64,
    /// Its points.
    pub points: usize,
    /// Holes that it has.
    pub loops: usize,
    /// Root mean square of its deviation at its points, without noise, nm.
    pub rms_nm: f64,
    /// Range of it, nm.
    pub pv_nm: f64,
}

impl TrayScene {
    /// Eight parts in cells of 40 mm, turned and up to 2° aslant: three kinds of lenses, one of them twice, a flat, a ring, and two
    /// lenses of one kind that touch; dust between them.
    pub fn lenses(seed: u64) -> TrayScene {
        let asphere = Asphere {
            radius_mm: -22.0,
            conic: -1.1,
            coefficients: [-1e-5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        let disc = |radius_mm: f64| Aperture::Circle { radius_mm };
        let kind = |name, nominal, aperture, form| TrayKind { name, nominal, aperture, form };
        let kinds = vec![
            kind("convex-asphere", Nominal::Asphere(asphere), disc(10.0), 6.0),
            kind("convex-sphere", Nominal::Sphere { radius_mm: -40.0 }, disc(12.5), 4.0),
            kind("concave-sphere", Nominal::Sphere { radius_mm: 60.0 }, disc(9.0), 3.0),
            kind("flat", Nominal::Plane, disc(11.0), 2.0),
            kind("ring", Nominal::Plane, Aperture::Annulus { inner_mm: 5.0, outer_mm: 10.5 }, 0.0),
        ];
        let draw = |number: u64| 2.0 * uniform(seed ^ LAYING, number) - 1.0;
        let mut parts = Vec::new();
        for (cell, kind) in [2, 0, 4, 1, 3, 1].into_iter().enumerate() {
            let of_part = |which: u64| draw(6 * cell as u64 + which);
            let pose = Pose {
                tx_mm: 40.0 * (cell % 4) as f64 + 6.0 * of_part(0),
                ty_mm: 40.0 * (cell / 4) as f64 + 6.0 * of_part(1),
                tz_mm: 3.0 + of_part(2),
                rx_rad: MOST_TILT * of_part(3),
                ry_rad: MOST_TILT * of_part(4),
                rz_rad: PI * of_part(5),
            };
            parts.push(TrayPart { kind, pose });
        }
        let [x, y] = [PI * draw(1000), PI * draw(1001)];
        for sign in [-1.0, 1.0] {
            let aside_mm = sign * (10.0 + TOUCHING_MM);
            let pose = Pose {
                tx_mm: 100.0 + aside_mm * x.cos(),
                ty_mm: 55.0 + aside_mm * x.sin(),
                tz_mm: 3.0,
                rz_rad: y,
                ..Pose::default()
            };
            parts.push(TrayPart { kind: 0, pose });
        }
        TrayScene { kinds, parts, density_per_mm2: 10.0, noise_nm: 300.0, grains: 6, seed }
    }

    /// The same with about so many points in all.
    #[must_use]
    pub fn with_points(self, points: u64) -> TrayScene {
        let area_mm2: f64 =
            self.parts.iter().map(|part| self.kinds[part.kind].aperture.area_mm2()).sum();
        TrayScene { density_per_mm2: points as f64 / area_mm2, ..self }
    }

    /// Scans the tray.
    ///
    /// # Errors
    ///
    /// A part whose design ends inside its aperture.
    pub fn scan(&self) -> Result<Tray, ArtefactError> {
        let (mut points_mm, mut parts) = (Vec::new(), Vec::new());
        for (number, part) in self.parts.iter().enumerate() {
            let (points, truth) = self.part(number as u64, part)?;
            points_mm.extend(points);
            parts.push(truth);
        }
        let draw = |number: usize| uniform(self.seed ^ DUST, number as u64);
        let dust_points = POINTS_OF_GRAIN * self.grains;
        for point in 0..dust_points {
            // Between the two rows of cells.
            let x_mm = -18.0 + 156.0 * draw(point / POINTS_OF_GRAIN);
            let [a, b, c] = [1, 2, 3].map(|which| draw(1000 * which + point));
            points_mm.push([x_mm + 0.2 * a, 20.0 + 0.2 * b, 0.1 * c]);
        }
        let truth = TrayTruth { parts, dust_points, noise_nm: self.noise_nm, seed: self.seed };
        Ok(Tray { points_mm, truth })
    }

    /// The points of a part on the tray, and its truth.
    fn part(
        &self,
        number: u64,
        part: &TrayPart,
    ) -> Result<(Vec<PointMm>, TrayPartTruth), ArtefactError> {
        let kind = &self.kinds[part.kind];
        let TrayKind { name, nominal, aperture, .. } = kind;
        let places = self.places(number, aperture);
        let error_mm = self.error_mm(number, kind);
        let artefact =
            Artefact::new(nominal.clone(), part.pose, &Parameter::RIGID, &places, error_mm)?;
        let (mut points, mut deviations_mm) = (Vec::new(), Vec::new());
        for (index, &[x_mm, y_mm]) in places.iter().enumerate() {
            let there = artefact.point_mm(x_mm, y_mm).zip(artefact.deviation_mm(x_mm, y_mm));
            let ([x, y, z], deviation_mm) =
                there.ok_or(ArtefactError::OutsideDomain { x_mm, y_mm })?;
            let noise = standard_normal(self.seed ^ NOISE, number * STREAM + index as u64);
            points.push([x, y, z + 1e-6 * self.noise_nm * noise]);
            deviations_mm.push(deviation_mm);
        }
        let mean_square =
            deviations_mm.iter().map(|mm| mm * mm).sum::<f64>() / deviations_mm.len().max(1) as f64;
        let (low, high) = (deviations_mm.iter())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &mm| {
                (mm.min(low), mm.max(high))
            });
        let axis = part.pose.rotation().map(|row| row[2]);
        let truth = TrayPartTruth {
            name: (*name).to_owned(),
            place_mm: part.pose.to_measured([0.0; 3]),
            tilt_deg: axis[0].hypot(axis[1]).atan2(axis[2].abs()).to_degrees(),
            points: points.len(),
            loops: usize::from(matches!(aperture, Aperture::Annulus { .. })),
            rms_nm: 1e6 * mean_square.sqrt(),
            pv_nm: 1e6 * (high - low),
        };
        Ok((points, truth))
    }

    /// The form error of a part in mm, in its own frame.
    fn error_mm(&self, number: u64, kind: &TrayKind) -> impl Fn(f64, f64) -> f64 + use<> {
        let form = kind.form;
        let mut error = FormError::typical(reach_mm(&kind.aperture));
        error.ring.iter_mut().for_each(|ring| ring.height_nm *= form);
        let turned = turned(uniform(self.seed ^ LAYING, 2000 + number));
        move |x_mm, y_mm| {
            let [x_mm, y_mm] = turned(x_mm, y_mm);
            form * error.height_nm(x_mm, y_mm) * 1e-6
        }
    }

    /// Places of a part in its own frame, x y in mm, at random over its aperture.
    fn places(&self, number: u64, aperture: &Aperture) -> Vec<[f64; 2]> {
        let radius_mm = reach_mm(aperture);
        let count = (self.density_per_mm2 * aperture.area_mm2()).round() as usize;
        let draw = |index: u64| uniform(self.seed, number * STREAM + index);
        let all = (0..)
            .map(|index: u64| [0, 1].map(|axis| radius_mm * (2.0 * draw(2 * index + axis) - 1.0)));
        all.filter(|[x, y]| aperture.contains(*x, *y)).take(count).collect()
    }
}

/// How far a part reaches from its vertex, mm; all have an aperture.
fn reach_mm(aperture: &Aperture) -> f64 {
    aperture.reach_mm().unwrap_or(0.0)
}

/// The largest turn about x and about y, rad.
const MOST_TILT: f64 = 0.025;
/// Half the gap between lenses that touch, mm.
const TOUCHING_MM: f64 = 0.01;
/// Points of a grain of dust.
const POINTS_OF_GRAIN: usize = 4;
/// Numbers that a part may draw.
const STREAM: u64 = 1 << 40;
/// Streams of random numbers beside that of the places.
const LAYING: u64 = 0x6C61_7969_6E67;
const DUST: u64 = 0x6475_7374;
const NOISE: u64 = 0x6E_6F69_7365;

#[cfg(test)]
mod tests {
    use super::*;

    fn parted(tray: &Tray) -> Vec<&[PointMm]> {
        let mut rest = &tray.points_mm[..];
        let parts = tray.truth.parts.iter().map(|part| {
            let (points, others) = rest.split_at(part.points);
            rest = others;
            points
        });
        parts.collect()
    }

    /// The distance of a point from a sphere is elementary; so the deviations come back from the points by another way.
    #[test]
    fn points_lie_on_their_designs_but_for_the_deviation() {
        let scene = TrayScene { noise_nm: 0.0, ..TrayScene::lenses(3) };
        let tray = scene.scan().unwrap();
        for ((part, points), truth) in scene.parts.iter().zip(parted(&tray)).zip(&tray.truth.parts)
        {
            let off_mm = |point: &PointMm| {
                let [x, y, z] = part.pose.to_part(*point);
                match scene.kinds[part.kind].nominal {
                    Nominal::Plane => Some(z),
                    Nominal::Sphere { radius_mm } => {
                        let from = x.hypot(y).hypot(z - radius_mm);
                        Some(if radius_mm < 0.0 { from + radius_mm } else { radius_mm - from })
                    }
                    _ => None,
                }
            };
            let Some(all) = points.iter().map(off_mm).collect::<Option<Vec<f64>>>() else {
                continue;
            };
            let rms_nm =
                1e6 * (all.iter().map(|mm| mm * mm).sum::<f64>() / all.len() as f64).sqrt();
            assert!(
                (rms_nm - truth.rms_nm).abs() < 1e-3 * truth.rms_nm + 1e-3,
                "{rms_nm} {truth:?}"
            );
        }
    }

    #[test]
    fn parts_lie_apart_but_for_those_that_touch() {
        for seed in 0..20 {
            let scene = TrayScene::lenses(seed);
            for (at, one) in scene.parts.iter().enumerate() {
                for other in &scene.parts[..at] {
                    let [a, b] =
                        [one, other].map(|part| reach_mm(&scene.kinds[part.kind].aperture));
                    let [dx, dy] =
                        [one.pose.tx_mm - other.pose.tx_mm, one.pose.ty_mm - other.pose.ty_mm];
                    let gap_mm = dx.hypot(dy) - a - b;
                    let touch = at == 7 && (gap_mm - 2.0 * TOUCHING_MM).abs() < 1e-9;
                    assert!(touch || gap_mm > 2.0, "{seed}: {gap_mm}");
                }
            }
        }
    }

    #[test]
    fn a_seed_gives_the_same_tray_again_and_another_seed_another() {
        let scan = |seed| TrayScene::lenses(seed).with_points(4000).scan().unwrap();
        let (one, again, other) = (scan(1), scan(1), scan(2));
        assert_eq!((&one.points_mm, &one.truth), (&again.points_mm, &again.truth));
        assert_ne!(one.points_mm, other.points_mm);
        let points = one.points_mm.len() - one.truth.dust_points;
        assert!((3990..=4010).contains(&points), "{points}");
        assert_eq!(one.truth.parts.iter().filter(|part| part.loops == 1).count(), 1);
    }
}
