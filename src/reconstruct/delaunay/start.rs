//! The first four points: they must span space.

use asphera_geometry::predicates::{orientation, orientation_in_space};

use super::NoDelaunay;
use crate::surface::Numbered;

/// Brings four points that span space to the front. The places must differ and be at least four.
pub(super) fn bring_forward(places: &mut [Numbered]) -> Result<(), NoDelaunay> {
    let count = places.len();
    let [a, b] = [places[0].0, places[1].0];
    let off_line = |point: &Numbered| {
        [[0, 1], [1, 2], [2, 0]].into_iter().any(|[x, y]| {
            let flat = |place: [f64; 3]| [place[x], place[y]];
            orientation(flat(a), flat(b), flat(point.0)).is_ne()
        })
    };
    let third = places.iter().position(off_line).ok_or(NoDelaunay::OnALine { places: count })?;
    places.swap(2, third);
    let c = places[2].0;
    let off_plane = |point: &Numbered| orientation_in_space(a, b, c, point.0).is_ne();
    let fourth = places.iter().position(off_plane).ok_or(NoDelaunay::InAPlane { places: count })?;
    places.swap(3, fourth);
    if orientation_in_space(a, b, c, places[3].0).is_lt() {
        places.swap(0, 1);
    }
    Ok(())
}
