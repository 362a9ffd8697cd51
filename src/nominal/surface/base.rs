//! What several kinds share: the conic under a departure, and powers of the distance from the axis.

use std::sync::Arc;

use asphera_form::Nominal;
use asphera_form::shape::{Conic, ConicSection, EvenAsphere, Shape, Sum};
use asphera_settings::Section;

use super::told;

/// The conic of `radius_mm` and `conic`, or the plane of `base = "flat"`.
pub(super) fn base(surface: &Section<'_>) -> Option<ConicSection> {
    if is_flat(surface) {
        return Some(ConicSection::FLAT);
    }
    let radius_mm = surface.required("radius_mm");
    let conic = surface.or("conic", 0.0);
    told(surface, "radius_mm", ConicSection::new(radius_mm?, conic))
}

/// Whether the base is a plane. Then radius and conic constant have no place.
pub(super) fn is_flat(surface: &Section<'_>) -> bool {
    let is_flat = surface.word("base", false, &[("conic", false), ("flat", true)]);
    for key in ["radius_mm", "conic"] {
        if is_flat && surface.has(key) {
            surface.problem(key, "no such key where base is \"flat\"", "one");
        }
    }
    is_flat
}

/// The terms A2, A4 … as (order, coefficient in mm^(1−order)).
pub(super) fn even_powers(surface: &Section<'_>) -> Vec<(u8, f64)> {
    let (even, odd): (Vec<_>, Vec<_>) =
        surface.numbered("A").into_iter().partition(|(order, _)| order.is_multiple_of(2));
    for (order, _) in odd {
        let expected = format!("an even order, as A{} (odd-asphere takes odd ones)", order + 1);
        surface.problem(&format!("A{order}"), expected, format!("`A{order}`"));
    }
    even
}

/// What departs from a base, on it; alone where the base is flat and has no powers.
pub(super) fn on_base(
    surface: &Section<'_>,
    base: ConicSection,
    powers: &[(u8, f64)],
    departure: Arc<dyn Shape>,
) -> Option<Nominal> {
    let base: Arc<dyn Shape> = match (base.is_flat(), powers.is_empty()) {
        (true, true) => return Some(Nominal::Freeform(departure)),
        (false, true) => Arc::new(Conic::new(base)),
        (_, false) => Arc::new(told(surface, "kind", EvenAsphere::new(base, powers))?),
    };
    sum(surface, base, departure)
}

/// Two shapes, one on the other.
pub(super) fn sum(
    surface: &Section<'_>,
    base: Arc<dyn Shape>,
    departure: Arc<dyn Shape>,
) -> Option<Nominal> {
    let sum = told(surface, "kind", Sum::new(vec![base, departure]))?;
    Some(Nominal::Freeform(Arc::new(sum)))
}
