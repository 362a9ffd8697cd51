//! The design surface of a nominal file: the table `[surface]`, one file a family of kinds.
//!
//! A plane, a sphere and an even asphere without r² have a kernel of their own, by the distance from the axis; every other surface is a
//! freeform. Of an unknown surface the file says how the points make one.

mod base;
mod grid;
mod lines;
mod revolved;
mod series;
mod unknown;

use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;

use asphera_form::shape::{Conic, ConicSection, EvenAsphere, OffAxis, Shape, ShapeError};
use asphera_form::{Nominal, ReferenceSettings, provisional};
use asphera_settings::Section;

/// Content of `[surface]`.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// The surface.
    pub(super) nominal: Nominal,
    /// Whether it is of revolution about z, so that a turn about z changes nothing.
    pub(super) is_round: bool,
    /// Whether its heights come from a file, which may lack some.
    pub(super) has_gaps: bool,
    /// How the points make the surface, where no design is known. The nominal then stands in for it.
    pub(super) reference: Option<ReferenceSettings>,
}

/// Reads the table. `folder` is that of the nominal file, from which the files it names are found.
pub(super) fn read(surface: &Section<'_>, folder: &Path) -> Option<Surface> {
    let kind = surface.required_word("kind", &KINDS)?;
    if kind == Kind::Unknown {
        if surface.has("off_axis") {
            let expected = "no such table: an unknown surface has no piece of its own";
            surface.problem("off_axis", expected, "one");
        }
        let reference = Some(unknown::unknown(surface));
        return Some(Surface {
            nominal: provisional().0,
            is_round: false,
            has_gaps: false,
            reference,
        });
    }
    let nominal = match kind {
        Kind::Plane => Some(Nominal::Plane),
        Kind::Sphere => revolved::sphere(surface),
        Kind::Conic => revolved::conic(surface),
        Kind::Asphere => revolved::asphere(surface),
        Kind::OddAsphere => revolved::odd_asphere(surface),
        Kind::QBfs => revolved::q_bfs(surface),
        Kind::QCon => revolved::q_con(surface),
        Kind::Cylinder => lines::cylinder(surface),
        Kind::Biconic => lines::biconic(surface),
        Kind::Toroid => lines::toroid(surface),
        Kind::Mirror => lines::mirror(surface),
        Kind::Zernike => series::zernike(surface),
        Kind::Q2d => series::q2d(surface),
        Kind::Chebyshev => series::chebyshev(surface),
        Kind::Legendre => series::legendre(surface),
        Kind::Xy => series::xy(surface),
        Kind::Grid => grid::grid(surface, folder),
        Kind::Unknown => None,
    };
    let section = surface.section("off_axis");
    let has_section = section.is_present();
    let nominal = if has_section { off_axis(&section, nominal) } else { nominal };
    section.finish();
    let is_round = kind.is_round() && !has_section;
    Some(Surface { nominal: nominal?, is_round, has_gaps: kind == Kind::Grid, reference: None })
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Plane,
    Sphere,
    Conic,
    Asphere,
    OddAsphere,
    QBfs,
    QCon,
    Cylinder,
    Biconic,
    Toroid,
    Mirror,
    Zernike,
    Q2d,
    Chebyshev,
    Legendre,
    Xy,
    Grid,
    Unknown,
}

impl Kind {
    fn is_round(self) -> bool {
        matches!(
            self,
            Kind::Plane
                | Kind::Sphere
                | Kind::Conic
                | Kind::Asphere
                | Kind::OddAsphere
                | Kind::QBfs
                | Kind::QCon
        )
    }
}

const KINDS: [(&str, Kind); 18] = [
    ("asphere", Kind::Asphere),
    ("sphere", Kind::Sphere),
    ("plane", Kind::Plane),
    ("conic", Kind::Conic),
    ("odd-asphere", Kind::OddAsphere),
    ("q-bfs", Kind::QBfs),
    ("q-con", Kind::QCon),
    ("cylinder", Kind::Cylinder),
    ("biconic", Kind::Biconic),
    ("toroid", Kind::Toroid),
    ("mirror", Kind::Mirror),
    ("zernike", Kind::Zernike),
    ("q-2d", Kind::Q2d),
    ("chebyshev", Kind::Chebyshev),
    ("legendre", Kind::Legendre),
    ("xy", Kind::Xy),
    ("grid", Kind::Grid),
    ("unknown", Kind::Unknown),
];

/// The piece of `parent` that `[surface.off_axis]` cuts out.
fn off_axis(section: &Section<'_>, parent: Option<Nominal>) -> Option<Nominal> {
    let (dx_mm, dy_mm) = (section.required("dx_mm"), section.required("dy_mm"));
    let axes = section.required_word("axes", &[("normal", true), ("parallel", false)]);
    let (parent, is_normal) = (shape_of(&parent?)?, axes?);
    let made = if is_normal {
        OffAxis::tilted(parent, dx_mm?, dy_mm?)
    } else {
        OffAxis::parallel(parent, dx_mm?, dy_mm?)
    };
    freeform(section, "dx_mm", made)
}

/// The surface of which the middle of the aperture lies at `centre_mm`: where it has a vertex, its piece about that place,
/// so that places count from there. Along a direction in which it slides, and of an unknown one, the points are what
/// the place is of.
pub(super) fn about(
    surface: Surface,
    aperture: &Section<'_>,
    centre_mm: [f64; 2],
) -> Option<Surface> {
    if let Some(reference) = surface.reference {
        if reference.centre_mm.is_some() {
            let expected = "either surface.centre_mm or aperture.centre_mm";
            aperture.problem("centre_mm", expected, "both");
        }
        let reference = ReferenceSettings { centre_mm: Some(centre_mm), ..reference };
        return Some(Surface { reference: Some(reference), ..surface });
    }
    if surface.nominal.slides().contains(&true) || centre_mm == [0.0; 2] {
        return Some(surface);
    }
    let [dx_mm, dy_mm] = centre_mm;
    let piece = OffAxis::parallel(shape_of(&surface.nominal)?, dx_mm, dy_mm);
    Some(Surface { nominal: freeform(aperture, "centre_mm", piece)?, ..surface })
}

/// The shape of any nominal.
fn shape_of(nominal: &Nominal) -> Option<Arc<dyn Shape>> {
    let shape: Arc<dyn Shape> = match nominal {
        Nominal::Plane => Arc::new(Conic::plane()),
        Nominal::Sphere { radius_mm } => Arc::new(Conic::sphere(*radius_mm).ok()?),
        Nominal::Asphere(asphere) => {
            let base = ConicSection::new(asphere.radius_mm, asphere.conic).ok()?;
            let terms: Vec<(u8, f64)> = (4..=20)
                .step_by(2)
                .filter_map(|order| Some((order, asphere.coefficient(order)?)))
                .filter(|(_, value)| *value != 0.0)
                .collect();
            Arc::new(EvenAsphere::new(base, &terms).ok()?)
        }
        Nominal::Freeform(shape) => Arc::clone(shape),
    };
    Some(shape)
}

/// A shape that could be made, as a nominal; else the reason as a problem with `key`.
fn freeform<S: Shape + 'static>(
    section: &Section<'_>,
    key: &str,
    made: Result<S, ShapeError>,
) -> Option<Nominal> {
    Some(Nominal::Freeform(Arc::new(told(section, key, made)?)))
}

/// The value, or its error as a problem with `key`.
fn told<T, E: Display>(section: &Section<'_>, key: &str, made: Result<T, E>) -> Option<T> {
    made.map_err(|error| section.problem(key, "values that make a surface", error)).ok()
}

#[cfg(test)]
mod tests;
