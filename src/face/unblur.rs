//! The points of a face, moved back from where blur puts them.

use asphera_geometry::PointMm;
use asphera_measure::Part;
use rayon::prelude::*;

use crate::body::{Body, Skin};
use crate::edge::Edge;
use crate::face::is_taken;
use crate::flattening::{Bent, Sheet};
use crate::laying::Laid;
use crate::resolution::Response;
use asphera_geometry::vector::{Vector, plus};

/// Points of a face without what blur does to them.
pub(crate) struct Unblurred {
    pub(crate) points_mm: Vec<PointMm>,
    /// How far the point that was moved farthest was moved, with its sign.
    pub(crate) largest_mm: f64,
    /// By how much that lets the variance of the noise of a point grow.
    pub(crate) noise_gain: f64,
    /// What waves of the form keep of their height.
    pub(crate) response: Response,
}

/// A point before it is moved.
struct Blurred {
    place_mm: PointMm,
    normal: Vector,
    /// Mean curvature of the design, and the place with its deviation; `None` where the design ends.
    on_design: Option<(f64, Bent)>,
}

impl Body {
    /// The points of a face on the edges of the grid along that axis, or on all.
    ///
    /// An edge blurred by a Gaussian of variance σ² obeys the heat equation: its value halfway moves towards the centre of curvature
    /// by σ²·H, H the mean curvature. That is the curvature of the design, and half the Laplacian of the deviation from it.
    pub(crate) fn unblurred(
        &self,
        skin: &Skin,
        part: &Part,
        laid: &Laid,
        (edge, along): (&Edge, Option<usize>),
    ) -> Unblurred {
        let blurred: Vec<Blurred> = laid
            .selection
            .vertices
            .par_iter()
            .filter(|vertex| is_taken(skin, **vertex, along))
            .map(|&vertex| self.blurred(skin, part, laid, vertex))
            .collect();
        let bent = blurred.iter().filter_map(|point| Some(point.on_design?.1)).collect();
        let reach_mm =
            (REACH * edge.blur_mm2.sqrt()).max(LEAST_REACH * self.scan.lattice.least_mm());
        let sheet = Sheet::new(bent, reach_mm);
        let mut laplacians = sheet.laplacians_per_mm().into_iter();
        let mut largest_mm = 0.0_f64;
        let moved = blurred.iter().map(|point| {
            let curvature_per_mm = point.on_design.map_or(0.0, |(of_design, _)| {
                of_design + 0.5 * TAKEN * laplacians.next().unwrap_or(0.0)
            });
            let by_mm = -edge.blur_mm2 * curvature_per_mm;
            if by_mm.abs() > largest_mm.abs() {
                largest_mm = by_mm;
            }
            plus(point.place_mm, by_mm, point.normal)
        });
        let points_mm = moved.collect();
        let noise_gain = sheet.noise_gain(0.5 * TAKEN * edge.blur_mm2, edge.noise_length_mm);
        let blur_mm = edge.blur_mm2.sqrt();
        let response = Response { blur_mm, reach_mm, taken: TAKEN };
        Unblurred { points_mm, largest_mm, noise_gain, response }
    }

    fn blurred(&self, skin: &Skin, part: &Part, laid: &Laid, vertex: u32) -> Blurred {
        let own = skin.surface.vertices[vertex as usize];
        let grey = self.grey(skin.threshold);
        let place_mm = self.scan.lattice.place_mm(grey.refined(own).unwrap_or(own));
        let at = laid.pose.motion().to_part(laid.plane.to_plane(place_mm));
        let on_design = part.nominal.jet(at[0], at[1]).map(|jet| {
            let [p, q] = jet.gradient;
            let long = (1.0 + p * p + q * q).sqrt();
            let normal = [-p / long, -q / long, 1.0 / long];
            let bent = Bent { place_mm: at, normal, deviation_mm: (at[2] - jet.z_mm) / long };
            (mean_curvature_per_mm(jet.gradient, jet.hessian_per_mm), bent)
        });
        Blurred { place_mm, normal: skin.normals[vertex as usize], on_design }
    }
}

/// Mean curvature, 1/mm: positive where a surface bends towards the side it is seen from.
fn mean_curvature_per_mm([p, q]: [f64; 2], [r, s, t]: [f64; 3]) -> f64 {
    let squared = 1.0 + p * p + q * q;
    ((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * squared * squared.sqrt())
}

/// Reach of the paraboloids, standard deviations of the blur, and spacings at least.
const REACH: f64 = 4.0;
const LEAST_REACH: f64 = 5.0;
/// What a paraboloid takes of the Laplacian of a wave as long as four reaches, (2π/4)²/16, and the next term of the heat equation, as a
/// factor. Longer waves are flattened less: a fifth more of that is below 0.4 % of them.
const TAKEN: f64 = 1.2;
