//! The aperture of a part as the region of a plan.

use asphera_form::Aperture as PartAperture;
use asphera_plan::Aperture;

/// Region that a path over a part covers, of an outline the box about the vertex that holds it; `None` for a part without
/// an aperture.
pub(crate) fn plan_aperture(aperture: &PartAperture) -> Option<Aperture> {
    Some(match *aperture {
        PartAperture::Circle { radius_mm } => Aperture::Circle { radius_mm },
        PartAperture::Rectangle { width_mm, height_mm } => {
            Aperture::Rectangle { width_mm, height_mm }
        }
        PartAperture::Annulus { inner_mm, outer_mm } => Aperture::Annulus { inner_mm, outer_mm },
        PartAperture::Outline { .. } => {
            let [width_mm, height_mm] = aperture.half_extents_mm()?.map(|half_mm| 2.0 * half_mm);
            Aperture::Rectangle { width_mm, height_mm }
        }
        PartAperture::None => return None,
    })
}
