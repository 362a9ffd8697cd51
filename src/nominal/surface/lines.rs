//! Surfaces with two directions of their own: cylinder, biconic, toroid, grazing mirrors.

use asphera_form::Nominal;
use asphera_form::shape::{Biconic, ConicSection, Cylinder, Mirror, Toroid};
use asphera_settings::{FromItem, Section};
use toml_edit::Item;

use super::base::{base, even_powers};
use super::{freeform, told};

/// `kind = "cylinder"`: what is straight along one of the axes x and y.
pub(super) fn cylinder(surface: &Section<'_>) -> Option<Nominal> {
    let is_along_x = surface.required_word("straight_along", &[("y", false), ("x", true)]);
    let is_circular = !surface.has("conic") && !surface.has("base");
    let terms = even_powers(surface);
    let section = base(surface);
    let (is_along_x, section) = (is_along_x?, section?);
    if is_along_x {
        return freeform(surface, "kind", Toroid::unrotated(section, &terms));
    }
    let made = if is_circular && terms.is_empty() {
        Cylinder::new(section.radius_mm())
    } else {
        Cylinder::acylinder(section, &terms)
    };
    freeform(surface, "kind", made)
}

/// `kind = "biconic"`: a direction without a radius is flat, one of the two must have one.
pub(super) fn biconic(surface: &Section<'_>) -> Option<Nominal> {
    if !surface.has("radius_x_mm") && !surface.has("radius_y_mm") {
        surface.problem("radius_x_mm", "radius_x_mm, radius_y_mm, or both", "neither");
        return None;
    }
    let section = |radius: &str, conic: &str| {
        if !surface.has(radius) {
            if surface.has(conic) {
                surface.problem(conic, format!("no such key without {radius}"), "one");
            }
            return Some(ConicSection::FLAT);
        }
        let radius_mm = surface.get(radius);
        let conic = surface.or(conic, 0.0);
        told(surface, radius, ConicSection::new(radius_mm?, conic))
    };
    let (x, y) = (section("radius_x_mm", "conic_x"), section("radius_y_mm", "conic_y"));
    Some(Nominal::Freeform(std::sync::Arc::new(Biconic::new(x?, y?))))
}

/// `kind = "toroid"`: a curve over y turned about an axis parallel to y.
pub(super) fn toroid(surface: &Section<'_>) -> Option<Nominal> {
    let rotation_radius_mm = surface.required("rotation_radius_mm");
    let terms = even_powers(surface);
    let section = base(surface);
    freeform(surface, "kind", Toroid::new(rotation_radius_mm?, section?, &terms))
}

/// `kind = "mirror"`: a mirror that images a source at p into an image at q under a grazing angle.
pub(super) fn mirror(surface: &Section<'_>) -> Option<Nominal> {
    let is_cylinder =
        surface.required_word("figure", &[("cylindrical", true), ("revolved", false)]);
    let source: Option<Distance> = surface.required("source_mm");
    let image: Option<Distance> = surface.required("image_mm");
    let grazing_rad = surface.required("grazing_rad");
    let (Distance(source_mm), Distance(image_mm)) = (source?, image?);
    let made = if is_cylinder? {
        Mirror::cylindrical(source_mm, image_mm, grazing_rad?)
    } else {
        Mirror::revolved(source_mm, image_mm, grazing_rad?)
    };
    freeform(surface, "kind", made)
}

/// A distance in mm, infinite for parallel light.
struct Distance(f64);

impl FromItem for Distance {
    const EXPECTED: &'static str = "a distance in mm, or \"infinite\" for parallel light";

    fn from_item(item: &Item) -> Option<Distance> {
        if item.as_str() == Some("infinite") {
            return Some(Distance(f64::INFINITY));
        }
        f64::from_item(item).map(Distance)
    }
}
