//! Alpha shapes (H. Edelsbrunner, E. P. Mücke 1994, doi:10.1145/174462.156635), general form, exact.
//!
//! A facet is of the shape where an empty ball of diameter α has its corners on the sphere. It is *regular* between a tetrahedron
//! within the bound and one beyond, *singular* where both are beyond, its own smallest ball is empty and within. Seed 002
//! counts α as a diameter, as here; CGAL's alpha is the square of the radius.

use asphera_geometry::PointMm;
use asphera_geometry::predicates::{compare_facet_circle, compare_sphere, in_facet_ball};
use rayon::prelude::*;
use thiserror::Error;

use crate::delaunay::{Delaunay, NoDelaunay};
use crate::surface::{LeftOut, Reconstruction, of_vertices};

/// The standing of a facet in an alpha shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AlphaStanding {
    /// No tetrahedron at it is within the bound, but its own smallest ball is, and empty.
    Singular,
    /// One tetrahedron at it is within the bound.
    Regular,
    /// Both tetrahedra at it are within the bound: inside the shape.
    Interior,
}

/// Why there is no alpha shape.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AlphaError {
    /// A diameter that is none.
    #[error(
        "alpha: expected a diameter from 0 to 1e12 mm, found {found}; give the diameter of the ball, as a few point spacings"
    )]
    Diameter {
        /// The value given.
        found: f64,
    },
    /// Points without a triangulation.
    #[error(transparent)]
    NoDelaunay(#[from] NoDelaunay),
}

/// An alpha shape.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaShape {
    /// Singular and regular facets as a surface.
    pub surface: Reconstruction,
    /// How many facets are singular.
    pub singular: usize,
    /// How many are regular.
    pub regular: usize,
    /// Tetrahedra within the bound.
    pub tetrahedra: usize,
}

/// The alpha shape of points for balls of a diameter.
///
/// # Errors
///
/// A diameter that is not from 0 to 1e12 mm, points that do not span space.
pub fn alpha_shape(points_mm: &[PointMm], diameter_mm: f64) -> Result<AlphaShape, AlphaError> {
    let delaunay = Delaunay::new(points_mm)?;
    let facets = alpha_facets(&delaunay, diameter_mm)?;
    let count = |wanted| facets.iter().filter(|(_, standing)| *standing == wanted).count();
    let (singular, regular) = (count(AlphaStanding::Singular), count(AlphaStanding::Regular));
    let within = tetrahedra_within(&delaunay, diameter_mm).iter().filter(|&&within| within).count();
    let shown = facets.iter().filter(|(_, standing)| *standing != AlphaStanding::Interior);
    let facets = shown.map(|&(facet, _)| facet).collect();
    let surface = of_vertices(points_mm, &delaunay, facets, LeftOut::NoFacet);
    Ok(AlphaShape { surface, singular, regular, tetrahedra: within })
}

impl Delaunay {
    /// Facets of the alpha shape for balls of a diameter, by the numbers of the points as they came, in ascending order.
    ///
    /// # Errors
    ///
    /// A diameter that is not from 0 to 1e12 mm.
    pub fn alpha_facets(
        &self,
        diameter_mm: f64,
    ) -> Result<Vec<([u32; 3], AlphaStanding)>, AlphaError> {
        let mut facets = alpha_facets(self, diameter_mm)?;
        for (facet, _) in &mut facets {
            *facet = facet.map(|corner| self.ids[corner as usize]);
            facet.sort_unstable();
        }
        facets.sort_unstable();
        Ok(facets)
    }
}

fn tetrahedra_within(delaunay: &Delaunay, diameter_mm: f64) -> Vec<bool> {
    (0..delaunay.tetrahedra as u32)
        .into_par_iter()
        .map(|cell| compare_sphere(delaunay.places(cell), diameter_mm).is_le())
        .collect()
}

fn alpha_facets(
    delaunay: &Delaunay,
    diameter_mm: f64,
) -> Result<Vec<([u32; 3], AlphaStanding)>, AlphaError> {
    if !(0.0..=asphera_geometry::RANGE_MM).contains(&diameter_mm) {
        return Err(AlphaError::Diameter { found: diameter_mm });
    }
    let within = tetrahedra_within(delaunay, diameter_mm);
    let is_within = |cell: u32| within.get(cell as usize).copied().unwrap_or(false);
    let standing = |cell: u32, slot: usize| {
        let other = delaunay.neighbours[cell as usize][slot];
        match (is_within(cell), is_within(other)) {
            (true, true) => Some(AlphaStanding::Interior),
            (false, false) => {
                let places = delaunay.facet(cell, slot).map(|corner| delaunay.place(corner));
                let is_singular = compare_facet_circle(places, diameter_mm).is_le()
                    && has_empty_ball(delaunay, cell, slot);
                is_singular.then_some(AlphaStanding::Singular)
            }
            _ => Some(AlphaStanding::Regular),
        }
    };
    let facets: Vec<(u32, usize)> = delaunay.facets().collect();
    Ok(facets
        .into_par_iter()
        .filter_map(|(cell, slot)| {
            standing(cell, slot).map(|standing| (delaunay.facet(cell, slot), standing))
        })
        .collect())
}

/// Whether the smallest ball about a facet has no point inside (a Gabriel facet).
pub(crate) fn has_empty_ball(delaunay: &Delaunay, cell: u32, slot: usize) -> bool {
    let other = delaunay.neighbours[cell as usize][slot];
    let places = delaunay.facet(cell, slot).map(|corner| delaunay.place(corner));
    let apexes = [(cell, slot), (other, delaunay.slot_toward(other, cell))];
    apexes.into_iter().filter(|&(cell, _)| !delaunay.is_outside(cell)).all(|(cell, slot)| {
        let apex = delaunay.corners[cell as usize][slot];
        in_facet_ball(places, delaunay.place(apex)).is_le()
    })
}
