//! A lens in a CT scanner: its volume, and what a measurement of both its faces must find.
//!
//! The lens is blurred by a Gaussian before it is sampled, as optics and detectors do: along z in closed form, across between columns with
//! heights at every half spacing. A voxel has the mean over its volume, and noise of its own, as from a seed and its number. The truth is
//! that of the surfaces, not of the voxels.
//!
//! Blurred after sampling, an edge would be skew by its place between the voxels. Its crossing would then go up and down by 0.01 spacings.

use asphera_form::artefact::{Artefact, ArtefactError};
use asphera_form::form_error::FormError;
use asphera_form::{Asphere, Nominal, Parameter, PointMm, Pose};
use serde::Serialize;
use thiserror::Error;

use crate::noise::standard_normal;
use crate::part::{Missed, settle};

/// A lens and how it is scanned.
#[derive(Clone, Debug, PartialEq)]
pub struct CtScene {
    /// Distance of neighbouring voxels, mm.
    pub spacing_mm: f64,
    /// Standard deviation of the blur, spacings.
    pub blur: f64,
    /// Standard deviation of the noise of a voxel, as a share of the contrast.
    pub noise: f64,
    /// Grey values of air and lens.
    pub levels: [f64; 2],
    /// Seed of the noise.
    pub seed: u64,
    /// Faces seen from +z and from −z.
    pub faces: [CtFace; 2],
    /// Radius of the rim, mm, along z about the origin.
    pub rim_mm: f64,
    /// Radius of the aperture of both faces, mm.
    pub aperture_mm: f64,
}

/// A face of the lens.
#[derive(Clone, Debug, PartialEq)]
pub struct CtFace {
    /// Its design, seen from outside.
    pub nominal: Nominal,
    /// From its own frame into that of the scanner.
    pub pose: Pose,
    /// What it has beside the design, along its normal.
    pub form_error: FormError,
}

/// A scan of the lens.
#[derive(Clone, Debug, PartialEq)]
pub struct CtVolume {
    /// Grey values, x fastest.
    pub values: Vec<u16>,
    /// Columns, rows and slices.
    pub size: [usize; 3],
    /// The place of the first voxel, mm.
    pub origin_mm: PointMm,
    /// Distance of neighbours, mm.
    pub spacing_mm: f64,
    /// What its faces are.
    pub truth: CtTruth,
}

/// What a measurement must find.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CtTruth {
    /// Spacing, mm.
    pub spacing_mm: f64,
    /// Standard deviation of the blur, mm.
    pub blur_mm: f64,
    /// Standard deviation of the noise, as a share of the contrast.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Root mean square and range of the deviation of both faces over the aperture, nm.
    pub rms_nm: [f64; 2],
    /// Range of it, nm.
    pub pv_nm: [f64; 2],
    /// Along the axis of the first face, mm.
    pub centre_thickness_mm: f64,
    /// Angle between that axis and the normal of the second face where it meets it, arcmin.
    pub wedge_arcmin: f64,
    /// Angle between the axes, arcmin.
    pub tilt_arcmin: f64,
    /// Distance of the vertex of the second face from the axis of the first, µm.
    pub decentre_um: f64,
}

/// Why there is no scan.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CtError {
    /// A number out of its range.
    #[error("{name} is {found}, expected {expected}")]
    Number {
        /// Which.
        name: &'static str,
        /// The number.
        found: f64,
        /// Allowed values.
        expected: &'static str,
    },
    /// The form error has no projection.
    #[error(transparent)]
    Artefact(#[from] ArtefactError),
    /// A face ends before the rim.
    #[error("a face of the lens ends at x {:.3}, y {:.3} mm, before the rim", at_mm[0], at_mm[1])]
    Ends {
        /// Where.
        at_mm: [f64; 2],
    },
}

impl CtScene {
    /// A moulded biconvex lens of two aspheres, its form error some micrometres, at 20 µm, blur of one voxel, noise of 2 %. Its sides
    /// are `scale` times those of a lens 6 mm wide.
    pub fn lens(scale: f64) -> CtScene {
        let face = |radius_mm: f64, conic: f64, a4: f64, pose: Pose, turn: f64| {
            let mut coefficients = [0.0; 9];
            coefficients[0] = a4 / scale.powi(3);
            let nominal =
                Nominal::Asphere(Asphere { radius_mm: radius_mm * scale, conic, coefficients });
            let mut form_error = FormError::typical(3.0 * scale);
            form_error.fringe_nm.iter_mut().for_each(|(_, height_nm)| *height_nm *= FORM * turn);
            form_error.ring.iter_mut().for_each(|ring| ring.height_nm *= FORM);
            CtFace { nominal, pose, form_error }
        };
        let arcmin = std::f64::consts::PI / (180.0 * 60.0);
        let front = Pose {
            tx_mm: 0.013,
            ty_mm: -0.021,
            tz_mm: 0.9 * scale + 0.0071,
            rx_rad: 21.0 * arcmin,
            ry_rad: -13.0 * arcmin,
            ..Pose::default()
        };
        let back = Pose {
            tx_mm: 0.025,
            ty_mm: -0.016,
            tz_mm: -0.9 * scale - 0.0042,
            rx_rad: std::f64::consts::PI + 24.0 * arcmin,
            ry_rad: -11.0 * arcmin,
            ..Pose::default()
        };
        CtScene {
            spacing_mm: 0.02,
            blur: 1.0,
            noise: 0.02,
            levels: [3000.0, 33_000.0],
            seed: 1,
            faces: [face(-9.0, -1.0, -2e-3, front, 1.0), face(-14.0, 0.0, 1.5e-3, back, -0.8)],
            rim_mm: 3.0 * scale,
            aperture_mm: 2.4 * scale,
        }
    }

    /// Scans the lens. Takes some seconds for 10⁷ voxels.
    ///
    /// # Errors
    ///
    /// A number out of its range, or a face that ends before the rim.
    pub fn scan(&self) -> Result<CtVolume, CtError> {
        self.check()?;
        let h_mm = self.spacing_mm;
        let artefacts = [self.artefact(0)?, self.artefact(1)?];
        let half = (self.rim_mm / h_mm).ceil() as usize + BESIDE;
        let side = 2 * half + 1;
        // Heights at the corners and middles of the columns.
        let nodes = 2 * side + 1;
        let node_mm = |index: usize| (index as f64 / 2.0 - 0.5 - half as f64) * h_mm;
        let mut heights: Vec<Option<[f64; 2]>> = Vec::with_capacity(nodes * nodes);
        for j in 0..nodes {
            for i in 0..nodes {
                let at_mm = [node_mm(i), node_mm(j)];
                heights.push(if at_mm[0].hypot(at_mm[1]) <= self.rim_mm {
                    Some([height(&artefacts[0], at_mm)?, height(&artefacts[1], at_mm)?])
                } else {
                    None
                });
            }
        }
        let known = || heights.iter().flatten();
        let top_mm = known().map(|[top, _]| *top).fold(f64::NEG_INFINITY, f64::max);
        let low_mm = known().map(|[_, low]| *low).fold(f64::INFINITY, f64::min);
        let slices = ((top_mm - low_mm) / h_mm).ceil() as usize + 2 * BESIDE;
        let size = [side, side, slices];
        let origin_mm =
            [-(half as f64) * h_mm, -(half as f64) * h_mm, low_mm - BESIDE as f64 * h_mm];
        let mut shares = vec![0.0_f64; side * side * slices];
        for y in 0..side {
            for x in 0..side {
                for (j, i) in (0..4).map(|quarter| (quarter / 2, quarter % 2)) {
                    let corners = [(0, 0), (0, 1), (1, 0), (1, 1)]
                        .map(|(b, a)| heights[(2 * y + j + b) * nodes + 2 * x + i + a]);
                    let [Some(a), Some(b), Some(c), Some(d)] = corners else { continue };
                    let mean = [0, 1].map(|face| (a[face] + b[face] + c[face] + d[face]) / 4.0);
                    let [top, low] = mean.map(|mm| (mm - origin_mm[2]) / h_mm);
                    fill(&mut shares[y * side + x..], side * side, [top, low], self.blur);
                }
            }
        }
        blur_across(&mut shares, size, self.blur);
        let [air, lens] = self.levels;
        let values = shares.iter().enumerate().map(|(index, share)| {
            let noise = self.noise * standard_normal(self.seed, index as u64);
            (air + (lens - air) * (share + noise)).round().clamp(0.0, 65_535.0) as u16
        });
        let values = values.collect();
        Ok(CtVolume { values, size, origin_mm, spacing_mm: h_mm, truth: self.truth(&artefacts) })
    }

    fn check(&self) -> Result<(), CtError> {
        let above_0 = [
            (self.spacing_mm, "spacing in mm"),
            (self.rim_mm, "radius of the rim in mm"),
            (self.aperture_mm, "radius of the aperture in mm"),
        ];
        for (found, name) in above_0 {
            if !(found.is_finite() && found > 0.0) {
                return Err(CtError::Number { name, found, expected: "a number above 0" });
            }
        }
        let voxels = self.rim_mm / self.spacing_mm;
        if voxels > MOST_RADIUS {
            let (name, expected) = ("radius of the rim in voxels", "at most 1000");
            return Err(CtError::Number { name, found: voxels, expected });
        }
        for (found, name) in [(self.blur, "blur in spacings"), (self.noise, "noise")] {
            if !(found.is_finite() && found >= 0.0) {
                return Err(CtError::Number { name, found, expected: "a number not below 0" });
            }
        }
        Ok(())
    }

    /// A face with its form error, which moves no fit over the aperture.
    fn artefact(&self, face: usize) -> Result<Artefact<impl Fn(f64, f64) -> f64 + use<>>, CtError> {
        let CtFace { nominal, pose, form_error } = self.faces[face].clone();
        let error_mm = move |x_mm: f64, y_mm: f64| form_error.height_nm(x_mm, y_mm) * 1e-6;
        Ok(Artefact::new(nominal, pose, &Parameter::RIGID, &self.places(), error_mm)?)
    }

    /// Places of the aperture, evenly.
    fn places(&self) -> Vec<[f64; 2]> {
        let at = |step: i32| f64::from(step) / f64::from(PLACES) * self.aperture_mm;
        let all = (-PLACES..=PLACES).flat_map(|j| (-PLACES..=PLACES).map(move |i| [at(i), at(j)]));
        all.filter(|[x, y]| x.hypot(*y) <= self.aperture_mm).collect()
    }

    fn truth<E: Fn(f64, f64) -> f64>(&self, artefacts: &[Artefact<E>; 2]) -> CtTruth {
        let figures = artefacts.each_ref().map(|of| {
            let places = self.places();
            let deviations = places.iter().filter_map(|&[x, y]| of.deviation_mm(x, y));
            let first = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
            let (count, squares, low, high) =
                deviations.fold(first, |(count, squares, low, high), mm| {
                    (count + 1.0, squares + mm * mm, mm.min(low), mm.max(high))
                });
            [(squares / count).sqrt() * 1e6, (high - low) * 1e6]
        });
        let [front, back] = &self.faces;
        let vertex = front.pose.to_measured([0.0; 3]);
        let axis = direction(&front.pose, [0.0, 0.0, 1.0]);
        // Down the axis of the front to the back: halving.
        let at = |along: f64| [0, 1, 2].map(|i| vertex[i] - along * axis[i]);
        let beyond = |along: f64| {
            let [x, y, z] = back.pose.to_part(at(along));
            z > back.nominal.sag_mm(x.hypot(y))
        };
        let (mut low, mut high) = (0.0, 4.0 * self.rim_mm);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if beyond(middle) { high = middle } else { low = middle }
        }
        let [x, y, _] = back.pose.to_part(at(low));
        let [p, q] = back.nominal.gradient(x, y);
        let normal = direction(&back.pose, [-p, -q, 1.0]);
        let back_vertex = back.pose.to_measured([0.0; 3]);
        let from = [0, 1, 2].map(|i| back_vertex[i] - vertex[i]);
        CtTruth {
            spacing_mm: self.spacing_mm,
            blur_mm: self.blur * self.spacing_mm,
            noise: self.noise,
            seed: self.seed,
            rms_nm: figures.map(|[rms, _]| rms),
            pv_nm: figures.map(|[_, pv]| pv),
            centre_thickness_mm: low,
            wedge_arcmin: angle(axis, normal.map(|side| -side)) * ARCMIN,
            tilt_arcmin: angle(axis, direction(&back.pose, [0.0, 0.0, -1.0])) * ARCMIN,
            decentre_um: 1e3 * length(cross(from, axis)),
        }
    }
}

/// The height of a face over a place of the scanner.
fn height<E: Fn(f64, f64) -> f64>(of: &Artefact<E>, at_mm: [f64; 2]) -> Result<f64, CtError> {
    let ends = CtError::Ends { at_mm };
    let mut places =
        [of.pose().to_part([at_mm[0], at_mm[1], of.pose().tz_mm])].map(|[x, y, _]| [x, y]);
    settle(of, &[at_mm], &mut places).map_err(|missed| match missed {
        Missed::At(_) => ends,
        Missed::Artefact(error) => CtError::Artefact(error),
    })?;
    let [[x, y]] = places;
    of.point_mm(x, y).map(|point| point[2]).ok_or(ends)
}

/// Adds a quarter of a column of material from the second height up to the first, in voxels, blurred along z by a Gaussian of `sigma`.
fn fill(shares: &mut [f64], slice: usize, [top, low]: [f64; 2], sigma: f64) {
    let reach = REACH * sigma + 1.0;
    let (first, last) = ((low - reach).floor().max(0.0) as usize, (top + reach).max(0.0) as usize);
    for k in first..=last {
        // Voxel k reaches from k − 1/2 to k + 1/2.
        let (from, to) = (k as f64 - 0.5, k as f64 + 0.5);
        let below = |height: f64| ramp(height - from, sigma) - ramp(height - to, sigma);
        if let Some(share) = shares.get_mut(k * slice) {
            *share += 0.25 * (below(top) - below(low));
        }
    }
}

/// The integral, from far below up to `at`, of a step from 0 to 1 that a Gaussian of `sigma` blurs.
fn ramp(at: f64, sigma: f64) -> f64 {
    if sigma == 0.0 {
        return at.max(0.0);
    }
    let u = at / sigma;
    let bell = (-0.5 * u * u).exp() / std::f64::consts::TAU.sqrt();
    at * 0.5 * libm::erfc(-u / std::f64::consts::SQRT_2) + sigma * bell
}

/// Blurs along x and y by a Gaussian, out to [`REACH`] standard deviations. Beyond the volume is air.
fn blur_across(shares: &mut [f64], size: [usize; 3], sigma: f64) {
    if sigma == 0.0 {
        return;
    }
    let reach = (REACH * sigma).ceil() as i64;
    let weights: Vec<f64> =
        (-reach..=reach).map(|at| (-0.5 * (at as f64 / sigma).powi(2)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    for axis in 0..2 {
        let stride: usize = size[..axis].iter().product();
        let long = size[axis];
        let mut line = vec![0.0; long];
        for start in (0..shares.len()).filter(|index| (index / stride).is_multiple_of(long)) {
            for (at, value) in line.iter_mut().enumerate() {
                *value = shares[start + at * stride];
            }
            if line.iter().all(|value| *value == 0.0) {
                continue;
            }
            for at in 0..long {
                let near = (-reach..=reach).zip(&weights).filter_map(|(step, weight)| {
                    let from = usize::try_from(at as i64 + step).ok()?;
                    line.get(from).map(|value| value * weight)
                });
                shares[start + at * stride] = near.sum::<f64>() / sum;
            }
        }
    }
}

fn direction(pose: &Pose, part: [f64; 3]) -> [f64; 3] {
    pose.rotation().map(|row| row[0] * part[0] + row[1] * part[1] + row[2] * part[2])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: [f64; 3]) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}

fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    length(cross(a, b)).atan2(cosine)
}

/// Times the typical form error of 0.2 µm: a moulded lens.
const FORM: f64 = 40.0;
/// Standard deviations at which a Gaussian ends.
const REACH: f64 = 5.0;
/// Voxels beside the lens.
const BESIDE: usize = 18;
/// Places of the aperture from its middle to its border.
const PLACES: i32 = 100;
const MOST_RADIUS: f64 = 1000.0;
const ARCMIN: f64 = 60.0 * 180.0 / std::f64::consts::PI;

#[cfg(test)]
mod tests {
    use super::*;

    /// The volume of a scan without blur and noise is that of the lens, found by another way: rings about the axis.
    #[test]
    fn voxels_add_up_to_the_lens() {
        let still = |face: &CtFace, turn: f64| {
            let pose = Pose { tz_mm: face.pose.tz_mm, rx_rad: turn, ..Pose::default() };
            let mut form_error = face.form_error.clone();
            form_error.fringe_nm.clear();
            form_error.ring = None;
            CtFace { pose, form_error, ..face.clone() }
        };
        let mut scene = CtScene { blur: 0.0, noise: 0.0, ..CtScene::lens(0.25) };
        scene.faces = [still(&scene.faces[0], 0.0), still(&scene.faces[1], std::f64::consts::PI)];
        let scan = scene.scan().unwrap();
        let [air, lens] = scene.levels;
        let shares: f64 =
            scan.values.iter().map(|&value| (f64::from(value) - air) / (lens - air)).sum();
        let found_mm3 = shares * scene.spacing_mm.powi(3);
        let rings = 20_000;
        let width_mm = scene.rim_mm / f64::from(rings);
        let truth_mm3: f64 = (0..rings)
            .map(|ring| {
                let r_mm = (f64::from(ring) + 0.5) * width_mm;
                let [front, back] = &scene.faces;
                let [top, low] = [front.nominal.sag_mm(r_mm), -back.nominal.sag_mm(r_mm)];
                let high_mm = (front.pose.tz_mm + top) - (back.pose.tz_mm + low);
                std::f64::consts::TAU * r_mm * width_mm * high_mm
            })
            .sum();
        // The rim is cut to quarters of a column.
        assert!((found_mm3 / truth_mm3 - 1.0).abs() < 0.02, "{found_mm3} {truth_mm3}");
        // Along the axis, where no rim is.
        let middle = scan.size[0] / 2;
        let column = |z: usize| scan.values[(z * scan.size[1] + middle) * scan.size[0] + middle];
        let long: f64 =
            (0..scan.size[2]).map(|z| (f64::from(column(z)) - air) / (lens - air)).sum();
        let truth = scene.faces[0].pose.tz_mm - scene.faces[1].pose.tz_mm;
        // The mean sag over the column, and what chords over half a spacing take off besides.
        let bend: f64 =
            scene.faces.iter().filter_map(|face| face.nominal.radius_mm()).map(|r| 1.0 / r).sum();
        let sag_mm = bend * scene.spacing_mm.powi(2) * (1.0 / 12.0 + 1.0 / 24.0);
        assert!((long * scene.spacing_mm - truth - sag_mm).abs() < 2e-6, "{long} {truth} {sag_mm}");
        assert!((scan.truth.centre_thickness_mm - truth).abs() < 1e-12);
        assert!(scan.truth.wedge_arcmin < 1e-9 && scan.truth.decentre_um < 1e-9);
    }

    #[test]
    fn blur_keeps_the_sum_and_widens_by_its_variance() {
        let mut shares = vec![0.0; 31 * 31 * 31];
        shares[(15 * 31 + 15) * 31 + 15] = 1.0;
        blur_across(&mut shares, [31; 3], 1.3);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let along = |index: usize| [index % 31, index / 31 % 31, index / 961];
        for (axis, expected) in [(0, 1.69), (1, 1.69), (2, 0.0)] {
            let second: f64 = shares
                .iter()
                .enumerate()
                .map(|(index, share)| share * (along(index)[axis] as f64 - 15.0).powi(2))
                .sum();
            assert!((second - expected).abs() < 1e-4 * 1.69, "{second}");
        }
    }

    /// A slab between 10.3 and 17.85 keeps its thickness and its middle; the fall at an edge has the variance of blur and voxel.
    #[test]
    fn a_column_is_blurred_before_it_is_sampled() {
        for sigma in [0.0, 1.0, 1.7] {
            let mut shares = vec![0.0; 40];
            for _ in 0..4 {
                fill(&mut shares, 1, [17.85, 10.3], sigma);
            }
            let sum: f64 = shares.iter().sum();
            assert!((sum - 7.55).abs() < 1e-5, "{sum}");
            let first = |(k, share): (usize, &f64)| k as f64 * share;
            let middle = shares.iter().enumerate().map(first).sum::<f64>() / sum;
            assert!((middle - 14.075).abs() < 1e-5 || sigma == 0.0, "{middle}");
        }
        // A long one: moments of its fall, which would not depend on where it lies if blur came after sampling.
        for top in [20.0, 20.21, 20.5, 20.79] {
            let mut shares = vec![0.0; 45];
            for _ in 0..4 {
                fill(&mut shares, 1, [top, 2.0], 1.0);
            }
            let fall = |power: i32| -> f64 {
                (12..40)
                    .map(|k| (shares[k] - shares[k + 1]) * (k as f64 + 0.5 - top).powi(power))
                    .sum()
            };
            assert!(fall(1).abs() < 1e-4, "{}", fall(1));
            assert!(fall(3).abs() < 2e-3, "{top}: {}", fall(3));
        }
    }

    #[test]
    fn the_truth_is_that_of_the_scene() {
        let scene = CtScene::lens(0.25);
        let truth = scene.scan().unwrap().truth;
        assert!((truth.tilt_arcmin - 3.0_f64.hypot(2.0)).abs() < 0.1, "{truth:?}");
        assert!(truth.rms_nm.iter().all(|rms| (300.0..2000.0).contains(rms)), "{truth:?}");
        assert_eq!(scene.scan().unwrap(), scene.scan().unwrap());
        let refused = CtScene { spacing_mm: 1e-6, ..scene.clone() }.scan();
        assert!(matches!(refused, Err(CtError::Number { .. })));
        let refused = CtScene { rim_mm: f64::NAN, ..scene }.scan();
        assert!(matches!(refused, Err(CtError::Number { .. })));
    }
}
