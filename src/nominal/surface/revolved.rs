//! Surfaces of revolution: sphere, conic, aspheres in powers and in Forbes' polynomials.

use asphera_form::shape::{ConicSection, EvenAsphere, OddAsphere, Projection, QAsphere};
use asphera_form::{Asphere, Nominal};
use asphera_settings::Section;

use super::base::{base, even_powers, is_flat};
use super::{freeform, told};

/// `kind = "sphere"`.
pub(super) fn sphere(surface: &Section<'_>) -> Option<Nominal> {
    let nominal = Nominal::Sphere { radius_mm: surface.required("radius_mm")? };
    told(surface, "radius_mm", nominal.validate())?;
    Some(nominal)
}

/// `kind = "conic"`: an asphere without terms.
pub(super) fn conic(surface: &Section<'_>) -> Option<Nominal> {
    let radius_mm = surface.required("radius_mm");
    let conic = surface.required("conic");
    told(surface, "radius_mm", Asphere::new(radius_mm?, conic?, &[])).map(Nominal::Asphere)
}

/// `kind = "asphere"`: even powers. Those of ISO 10110-12, r⁴ to r²⁰ over a conic, are followed in the meridian; with an r² term, higher
/// orders or a flat base it is a freeform.
pub(super) fn asphere(surface: &Section<'_>) -> Option<Nominal> {
    let terms = even_powers(surface);
    let is_standard = !is_flat(surface) && terms.iter().all(|(order, _)| (4..=20).contains(order));
    if is_standard {
        let radius_mm = surface.required("radius_mm");
        let conic = surface.or("conic", 0.0);
        return told(surface, "kind", Asphere::new(radius_mm?, conic, &terms))
            .map(Nominal::Asphere);
    }
    freeform(surface, "kind", EvenAsphere::new(base(surface)?, &terms))
}

/// `kind = "odd-asphere"`: powers of every order from 1 on.
pub(super) fn odd_asphere(surface: &Section<'_>) -> Option<Nominal> {
    let terms = surface.numbered("A");
    freeform(surface, "kind", OddAsphere::new(base(surface)?, &terms))
}

/// `kind = "q-bfs"`.
pub(super) fn q_bfs(surface: &Section<'_>) -> Option<Nominal> {
    let projection = surface.required_word(
        "projection",
        &[
            ("conic-normal", Projection::ConicNormal),
            ("sphere-normal", Projection::SphereNormal),
            ("axis", Projection::Axis),
        ],
    );
    let Forbes { base, radius_mm, coefficients_mm } = forbes(surface);
    let made = QAsphere::bfs(base?, radius_mm?, projection?, &coefficients_mm?);
    freeform(surface, "kind", made)
}

/// `kind = "q-con"`.
pub(super) fn q_con(surface: &Section<'_>) -> Option<Nominal> {
    let Forbes { base, radius_mm, coefficients_mm } = forbes(surface);
    freeform(surface, "kind", QAsphere::con(base?, radius_mm?, &coefficients_mm?))
}

/// What both of Forbes' aspheres have, as far as it can be used.
struct Forbes {
    base: Option<ConicSection>,
    radius_mm: Option<f64>,
    coefficients_mm: Option<Vec<f64>>,
}

fn forbes(surface: &Section<'_>) -> Forbes {
    Forbes {
        base: base(surface),
        radius_mm: surface.required("normalisation_radius_mm"),
        coefficients_mm: surface.required("coefficients_mm"),
    }
}
