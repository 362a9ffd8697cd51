//! A face: points on the surface of a body, with their errors.

use asphera_form::{Aperture, FitSettings, fit};
use asphera_geometry::PointMm;
use asphera_measure::{Along, Part};
use asphera_report::FaceFigures;
use asphera_volume::SizeError;
use thiserror::Error;

use crate::body::{Body, Skin};
use crate::edge::{Edge, NoEdge};
use crate::errors::Errors;
use crate::laying::{Found, Laid, find};
use crate::resolution::Response;
use crate::selection::{Place, STEEPEST_DEG, select};
use crate::unblur::Unblurred;
use asphera_geometry::vector::{Vector, dot};

/// The value of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// Halfway between the levels inside and outside of the face. The number finds the face at first.
    Halfway(f64),
    /// As stated.
    Stated(f64),
}

/// What is known of a scan beside its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The value of the surface.
    pub threshold: Threshold,
    /// Its standard uncertainty, grey values; without it from the levels.
    pub u_threshold: Option<f64>,
    /// The side from which the face is seen; without it the side on which the nominal fits best.
    pub along: Option<[f64; 3]>,
}

/// Why a body has no such face.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FaceError {
    /// Nothing reaches the threshold, or all does.
    #[error(
        "no surface: expected values below and above the threshold {threshold}, found values on one side alone"
    )]
    NoSurface {
        /// The threshold.
        threshold: f64,
    },
    /// No side of the surface can take the nominal.
    #[error(
        "no face of the surface fits the nominal: expected one whose normals are within {STEEPEST_DEG}° of the nominal's over its \
         aperture; found none of {sides}. Give --along nx,ny,nz, the side it is seen from"
    )]
    NoFace {
        /// The sides that were looked at.
        sides: &'static str,
    },
    /// The nominal says nothing of the surface.
    #[error(
        "the nominal has no design: expected a surface that says which face of the volume is meant, found kind = \"unknown\""
    )]
    NoDesign,
    /// The grey values about the face have no levels.
    #[error(
        "the face lies too near to the border of the volume, or to another face: expected {spacings} spacings of material and background \
         on either side of it"
    )]
    TooNear {
        /// Spacings wanted.
        spacings: u32,
    },
    /// Inside is not lighter than outside.
    #[error(
        "the grey values about the face do not rise into the material: expected lighter material, found {material} inside and {background} outside"
    )]
    Flat {
        /// Around the face.
        material: f64,
        /// Around the face.
        background: f64,
    },
    /// The volume is too large, or empty.
    #[error(transparent)]
    Size(#[from] SizeError),
}

/// A face of a body.
#[derive(Clone, Debug)]
pub struct Face {
    /// Points on it, corrected for blur, measured frame.
    pub points_mm: Vec<PointMm>,
    /// The direction from which it is seen: that of the projection.
    pub along: [f64; 3],
    /// What was found of it.
    pub figures: FaceFigures,
    errors: Errors,
    /// The middle of a face without a place of its own, in the frame of the projection.
    middle_mm: [f64; 2],
    across_mm: f64,
    /// By how much a fit rises where all points move out by 1 along their normals.
    rise: f64,
}

impl Body {
    /// The face that a nominal describes.
    ///
    /// # Errors
    ///
    /// When no side of the surface takes the nominal, or the values about it tell no edge.
    pub fn face(&self, part: &Part, settings: &Settings) -> Result<Face, FaceError> {
        if part.reference.is_some() {
            return Err(FaceError::NoDesign);
        }
        let h_mm = self.scan.lattice.least_mm();
        let margin_mm = MARGIN * h_mm;
        let (first, is_stated) = match settings.threshold {
            Threshold::Halfway(first) => (first, false),
            Threshold::Stated(value) => (value, true),
        };
        let mut skin = self.surface(first)?;
        let sides = if settings.along.is_some() { "the side given" } else { "the sides tried" };
        let found = find(&skin, part, settings.along, margin_mm);
        let Found { best: mut laid, other } = found.ok_or(FaceError::NoFace { sides })?;
        if laid.filled < LEAST_FILLED {
            return Err(FaceError::NoFace { sides });
        }
        let mut edge = self.edge(&skin, &laid)?;
        if !is_stated {
            for _ in 0..ROUNDS {
                skin = self.surface(edge.halfway())?;
                laid.selection = select(&skin, place(part, &laid), margin_mm, NEAR * h_mm);
                edge = self.edge(&skin, &laid)?;
            }
        }
        let u_levels = edge.uneven.hypot(edge.statistical);
        let u_threshold = settings.u_threshold.unwrap_or(u_levels);
        let along = self.along(&laid);
        let Unblurred { mut points_mm, largest_mm, noise_gain, response } =
            self.unblurred(&skin, part, &laid, (&edge, along));
        let found = points_mm.len();
        clear_border(&mut points_mm, part, &laid, CLEARED * h_mm);
        let on_border = (found - points_mm.len()) as u64;
        let density_per_mm2 = self.density_per_mm2(&skin, &laid, along);
        let errors = Errors::new(&edge, u_threshold, density_per_mm2, noise_gain);
        let mut reasons = reasons(&laid, other.as_ref(), &edge, skin.threshold, is_stated);
        reasons.extend(lost(response));
        let figures = FaceFigures {
            size: self.scan.size.map(|side| side as u64),
            spacing_mm: self.scan.lattice.spacing_mm(),
            threshold: skin.threshold,
            threshold_source: if is_stated { "stated" } else { "halfway" }.to_owned(),
            material: edge.material,
            background: edge.background,
            smoothing_mm: self.smoothing_mm,
            points: points_mm.len() as u64,
            apart: laid.selection.apart,
            steep: laid.selection.steep,
            on_border,
            filled: laid.filled.min(1.0),
            along: laid.plane.normal(),
            blur_um: 1e3 * edge.blur_mm2.sqrt(),
            slope_per_um: 1e-3 * edge.slope_per_mm,
            curvature_correction_nm: 1e6 * largest_mm,
            u_threshold,
            u_threshold_source: match settings.u_threshold {
                Some(_) => "stated",
                None => "levels over the face",
            }
            .to_owned(),
            u_shift_nm: 1e6 * errors.shift_mm,
            u_uneven_nm: 1e6 * errors.uneven_mm,
            uneven_length_mm: errors.uneven_length_mm,
            u_noise_nm: 1e6 * errors.noise_mm,
            noise_length_mm: errors.noise_length_mm,
            reasons,
            second: None,
        };
        Ok(Face {
            along: laid.plane.normal(),
            middle_mm: [laid.pose.tx_mm, laid.pose.ty_mm],
            across_mm: across_mm(&points_mm, &laid),
            rise: rise(&skin, &laid, along),
            points_mm,
            figures,
            errors,
        })
    }

    fn surface(&self, threshold: f64) -> Result<Skin, FaceError> {
        let skin = self.skin(threshold)?;
        if skin.places_mm.is_empty() {
            return Err(FaceError::NoSurface { threshold });
        }
        Ok(skin)
    }

    fn edge(&self, skin: &Skin, laid: &Laid) -> Result<Edge, FaceError> {
        let at = (&laid.plane, &laid.pose);
        Edge::across(self, skin, &laid.selection.vertices, at).map_err(|none| match none {
            NoEdge::TooNear => FaceError::TooNear { spacings: SPACINGS },
            NoEdge::Flat { material, background } => FaceError::Flat { material, background },
        })
    }

    /// The edges of the grid whose crossings are taken: where the face looks along one axis of the grid those along it alone, for they lie
    /// evenly over the face. All crossings are denser where a face is steep, and figures over points would count such places more.
    fn along(&self, laid: &Laid) -> Option<usize> {
        let axis = laid.plane.normal();
        let steps_mm = self.scan.lattice.steps_mm;
        let cosine = |step: Vector| dot(step, axis).abs() / dot(step, step).sqrt();
        let (along, most) = steps_mm
            .into_iter()
            .map(cosine)
            .enumerate()
            .fold((0, 0.0), |best, one| if one.1 > best.1 { one } else { best });
        (most >= ALONG_GRID).then_some(along)
    }

    /// Points taken on a mm² of the surface: of a normal n, the edges of the grid that a mm² of it crosses.
    fn density_per_mm2(&self, skin: &Skin, laid: &Laid, along: Option<usize>) -> f64 {
        let steps_mm = self.scan.lattice.steps_mm;
        let cell_mm3 = self.scan.lattice.cell_mm3();
        let (mut points, mut area_mm2) = (0.0, 0.0);
        for &vertex in &laid.selection.vertices {
            let normal = skin.normals[vertex as usize];
            let crossed = steps_mm.map(|step| dot(step, normal).abs());
            let all: f64 = crossed.iter().sum();
            // So much of the surface does each vertex stand for.
            area_mm2 += cell_mm3 / all;
            points += along.map_or(1.0, |along| crossed[along] / all);
        }
        points / area_mm2
    }
}

impl Face {
    /// The part with the errors of this face in its budget.
    #[must_use]
    pub fn part(&self, mut part: Part) -> Part {
        self.errors.add_to(&mut part, self.across_mm);
        if part.nominal.slides() != [false; 2] {
            part.centre_mm = self.middle_mm;
        }
        part
    }

    /// The projection of its points.
    pub fn projection(&self) -> Along {
        Along::direction(self.along).unwrap_or(Along::Z)
    }

    /// Standard uncertainty, mm, of the place of the whole face by its threshold, along its normals.
    pub fn shift_mm(&self) -> f64 {
        self.errors.shift_mm
    }

    /// The same of its height, as a fit with the shape held finds it.
    pub(crate) fn rise_mm(&self) -> f64 {
        self.rise * self.errors.shift_mm
    }

    /// Standard uncertainty, mm, of a point by noise before it is moved.
    #[cfg(test)]
    pub(crate) fn grey_noise_mm(&self) -> f64 {
        self.errors.grey_noise_mm
    }
}

fn place<'a>(part: &'a Part, laid: &'a Laid) -> Place<'a> {
    Place { nominal: &part.nominal, aperture: &part.aperture, plane: &laid.plane, pose: &laid.pose }
}

/// Whether a vertex lies on an edge of the grid along that axis; all do without one.
pub(crate) fn is_taken(skin: &Skin, vertex: u32, along: Option<usize>) -> bool {
    along.is_none_or(|along| skin.surface.vertices[vertex as usize][along].fract() != 0.0)
}

/// Leaves out points within `by_mm` of the aperture's border. Whether such a point lies inside depends on noise, and a fit over others
/// decides it anew: a few of them could go in and out for ever.
fn clear_border(points_mm: &mut Vec<PointMm>, part: &Part, laid: &Laid, by_mm: f64) {
    if part.aperture == Aperture::None {
        return;
    }
    let laid_mm: Vec<PointMm> = points_mm.iter().map(|&point| laid.plane.to_plane(point)).collect();
    let settings = FitSettings {
        free: part.free.clone(),
        aperture: part.aperture.clone(),
        start: laid.pose,
        search: false,
        ..FitSettings::default()
    };
    let pose = fit(&laid_mm, &part.nominal, &settings).map_or(laid.pose, |found| found.pose);
    let (outer, inner) = (part.aperture.widened(by_mm), part.aperture.widened(-by_mm));
    let motion = pose.motion();
    let mut places = laid_mm.iter().map(|&point| motion.to_part(point));
    points_mm.retain(|_| {
        places.next().is_none_or(|[x, y, _]| !outer.contains(x, y) || inner.contains(x, y))
    });
}

/// The width of the face: of its aperture, or of its points.
fn across_mm(points_mm: &[PointMm], laid: &Laid) -> f64 {
    let [u, v, _] = laid.plane.axes();
    let side = |axis: Vector| {
        let first = (f64::INFINITY, f64::NEG_INFINITY);
        let along = points_mm.iter().map(|&point| dot(point, axis));
        let (low, high) = along.fold(first, |(low, high), at| (low.min(at), high.max(at)));
        high - low
    };
    side(u).max(side(v))
}

/// The height of a fit whose points all move out by 1: with c the cosines of their normals to the axis, Σc / Σc².
fn rise(skin: &Skin, laid: &Laid, along: Option<usize>) -> f64 {
    let axis = laid.plane.normal();
    let taken = laid.selection.vertices.iter().filter(|vertex| is_taken(skin, **vertex, along));
    let cosines = taken.map(|&vertex| dot(skin.normals[vertex as usize], axis));
    let (sum, squares) = cosines.fold((0.0, 0.0), |(sum, squares), c| (sum + c, squares + c * c));
    sum / squares
}

/// The waves that blur takes from the form, in words.
fn lost(response: Response) -> Option<String> {
    let [one_mm, five_mm] = [0.01, 0.05].map(|share| response.least_mm(share));
    (one_mm > 0.0).then(|| {
        format!(
            "form in waves shorter than {one_mm:.3} mm loses more than 1 % of its height to the blur, shorter than {five_mm:.3} mm more than \
             5 %; no u counts that"
        )
    })
}

/// What must be known of the face.
fn reasons(
    laid: &Laid,
    other: Option<&Laid>,
    edge: &Edge,
    threshold: f64,
    is_stated: bool,
) -> Vec<String> {
    let mut reasons = Vec::new();
    if let Some(other) = other.filter(|other| other.rms_mm < ALIKE * laid.rms_mm) {
        let [x, y, z] = other.plane.normal();
        reasons.push(format!(
            "the face seen from {x:.2},{y:.2},{z:.2} fits the nominal nearly as well: --along nx,ny,nz chooses"
        ));
    }
    let share = (threshold - edge.background) / (edge.material - edge.background);
    if is_stated && (share - 0.5).abs() > OFF_HALFWAY {
        reasons.push(format!(
            "the threshold lies at {:.0} % between background and material: the correction for curvature holds at 50 %",
            100.0 * share
        ));
    }
    if laid.selection.steep > 0 {
        reasons.push(format!(
            "{} points near the face stand steeper than {STEEPEST_DEG}° to the nominal and are left out",
            laid.selection.steep
        ));
    }
    reasons
}

/// Spacings by which the face goes beyond its aperture: its border is then sampled too.
const MARGIN: f64 = 2.0;
/// Spacings on either side of the border of the aperture that are left out.
const CLEARED: f64 = 0.1;
/// Spacings within which a vertex is near the nominal.
const NEAR: f64 = 4.0;
/// Rounds in which threshold and levels find each other.
const ROUNDS: usize = 2;
/// Cosine of the angle to an axis of the grid up to which a face looks along it: 26°.
const ALONG_GRID: f64 = 0.9;
/// A face that fills less of its aperture is none.
const LEAST_FILLED: f64 = 0.3;
/// Spacings of material and background that an edge needs.
const SPACINGS: u32 = 14;
/// A face that fits nearly as well as another.
const ALIKE: f64 = 1.5;
/// A threshold this far from halfway is said.
const OFF_HALFWAY: f64 = 0.03;
