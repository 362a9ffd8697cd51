//! One look at points meshed in space: mesh, fit, sampling, form. The same points give the same bits, whatever their order.

use asphera_geometry::PointMm;
use asphera_report::{BorderFigures, MeshFigures, ReconstructionFigures, SamplingFigures};
use asphera_surface::Plane;
use asphera_surface::noise::NoiseEstimate;

use super::feature_size::FeatureSize;
use super::fit::{ShapeFit, Wanted as WantedFit};
use super::form::Formed;
use super::meshed::Meshed;
use super::noise::noise;
use super::openings::{Opening, openings};
use super::sampled::{self, Sampled};
use super::shape::Shape;
use crate::Part;
use crate::errors::Errors;
use crate::sampling::Wanted;

/// What every look begins with: mesh, fit, noise and local feature size.
pub(super) struct Footing {
    pub(super) meshed: Meshed,
    /// The shape laid into the points, or why there is none.
    pub(super) fit: Result<ShapeFit, String>,
    pub(super) noise: Result<NoiseEstimate, String>,
    /// Standard deviation of the noise along the normal: as given, or as estimated.
    pub(super) sigma_mm: Option<f64>,
    pub(super) size: Result<FeatureSize, String>,
    /// Points that are vertices.
    pub(super) vertices: usize,
}

impl Footing {
    /// Meshes points, and lays the shape of a part into them. A noise that is given need not be estimated.
    ///
    /// # Errors
    ///
    /// Why there is no mesh, in words.
    pub(super) fn of(
        points_mm: &[PointMm],
        part: Option<&Part>,
        sigma_mm: Option<f64>,
    ) -> Result<Footing, String> {
        Ok(Footing::of_mesh(Meshed::of(points_mm)?, part, sigma_mm))
    }

    fn of_mesh(mut meshed: Meshed, part: Option<&Part>, sigma_mm: Option<f64>) -> Footing {
        let fit = part.ok_or_else(|| "there is no nominal".to_owned()).and_then(|part| {
            let (shape, free_radius) = Shape::of(part)?;
            let Meshed { points_mm, facets, .. } = &meshed;
            WantedFit { points_mm, facets, shape, free_radius }.fit()
        });
        let laid = fit.as_ref().ok().map(|fit| fit.laid);
        if let Some(laid) = laid.as_ref().filter(|_| meshed.proof.is_oriented) {
            meshed.turn_out_of(laid);
        }
        let normals = meshed.normals();
        let noise = match sigma_mm {
            Some(_) => Err("it was given".to_owned()),
            None => noise(&meshed, &normals, laid.as_ref()),
        };
        let estimated_mm = noise.as_ref().ok().map(|found| found.noise.sigma_mm());
        let sigma_mm = sigma_mm.or(estimated_mm);
        let vertices = meshed.used().iter().filter(|used| **used).count();
        let spacing_mm = (meshed.proof.area_mm2 / vertices.max(1) as f64).sqrt();
        let size = FeatureSize::of(&meshed, &normals, laid.as_ref(), sigma_mm, spacing_mm);
        Footing { meshed, fit, noise, sigma_mm, size, vertices }
    }
}

/// All that one look tells.
#[derive(Clone, Debug)]
pub(super) struct SpaceAssessment {
    pub(super) meshed: Meshed,
    pub(super) openings: Vec<Opening>,
    pub(super) sampling: SamplingFigures,
    /// The form, or why there is none.
    pub(super) formed: Result<Formed, String>,
    pub(super) mesh: MeshFigures,
}

impl SpaceAssessment {
    /// Looks at points. Without a part nothing is fitted. `reason` says why they are meshed in space.
    ///
    /// # Errors
    ///
    /// Why there is no mesh, in words.
    pub(super) fn at(
        points_mm: &[PointMm],
        part: Option<&Part>,
        wanted: Wanted,
        reason: &str,
    ) -> Result<SpaceAssessment, String> {
        Ok(SpaceAssessment::of_mesh(Meshed::of(points_mm)?, points_mm.len(), part, wanted, reason))
    }

    /// Looks at so many points that are meshed.
    pub(super) fn of_mesh(
        meshed: Meshed,
        points: usize,
        part: Option<&Part>,
        wanted: Wanted,
        reason: &str,
    ) -> SpaceAssessment {
        let Footing { meshed, fit, noise, size, vertices, .. } =
            Footing::of_mesh(meshed, part, None);
        let laid = fit.as_ref().ok().map(|fit| fit.laid);
        let openings = openings(&meshed, laid.as_ref());
        let look = sampled::Sampling {
            meshed: &meshed,
            wanted,
            laid: laid.as_ref(),
            openings: &openings,
            noise: &noise,
            size: &size,
            as_of_points: points as u64,
        };
        let Sampled { figures: sampling, covered } = look.sampled();
        let formed = fit.and_then(|fit| {
            let part = part.ok_or("there is no nominal")?;
            let mut errors = Errors::new(part);
            let noise_nm = sampling.noise_in_rms_nm();
            if !crate::errors::has_correlated(part) {
                errors.look(part, &[], &Plane::XY, noise_nm);
            }
            Formed::of(&meshed, fit, &covered, part, &errors)
                .ok_or_else(|| "there is no point".to_owned())
        });
        let mesh = MeshFigures {
            vertices: vertices as u64,
            triangles: meshed.proof.facets as u64,
            edges: meshed.proof.edges as u64,
            area_mm2: Some(meshed.proof.area_mm2),
            reconstruction: Some(reconstruction(&meshed, &openings, &sampling, reason)),
            ..MeshFigures::default()
        };
        SpaceAssessment { meshed, openings, sampling, formed, mesh }
    }
}

fn reconstruction(
    meshed: &Meshed,
    openings: &[Opening],
    sampling: &SamplingFigures,
    reason: &str,
) -> ReconstructionFigures {
    let proof = &meshed.proof;
    let border = |opening: &Opening| BorderFigures {
        edges: opening.edges as u64,
        length_mm: opening.length_mm,
        at_mm: opening.at_mm,
        area_mm2: opening.area_mm2,
        approach: opening.approach,
        is_gap: opening.is_gap,
    };
    let listed = openings.len().min(ReconstructionFigures::LISTED);
    ReconstructionFigures {
        method: "local".to_owned(),
        reason: reason.to_owned(),
        facets: proof.facets as u64,
        left_out: meshed.left_out.clone(),
        components: proof.components as u64,
        closed: proof.is_closed,
        manifold: proof.is_manifold,
        orientable: proof.is_orientable,
        genus: proof.genus,
        betti: proof.betti,
        border_loops: openings[..listed].iter().map(border).collect(),
        border_loops_more: (openings.len() - listed) as u64,
        nonmanifold_edges: proof.nonmanifold_edges.count as u64,
        singular_vertices: proof.singular_vertices.count as u64,
        self_intersections: proof.self_intersections.count as u64,
        degenerate_facets: proof.degenerate_facets.count as u64,
        area_mm2: proof.area_mm2,
        volume_mm3: proof.volume_mm3.map(f64::abs),
        epsilon_max: sampling.epsilon_max.filter(|epsilon| epsilon.is_finite()),
        epsilon_bound: None,
        guarantee: GUARANTEE.to_owned(),
        as_of_points: sampling.as_of_points,
    }
}

const GUARANTEE: &str = "no theorem: what is written here is proven of this mesh, not of the surface between its points";
