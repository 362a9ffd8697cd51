//! The mesh in space of a set of points, and its proof.

use std::collections::BTreeMap;

use asphera_geometry::vector::{Vector, cross, dot, minus, plus, unit};
use asphera_geometry::{PointMm, Sets, admit};
use asphera_reconstruct::{LeftOut, LocalSurface, Proof, SurfaceByPlace, local, prove};
use rayon::prelude::*;

use super::shape::Laid;

/// Points meshed in space. They stand in the order of their coordinates, each place once, so that nothing depends on the order
/// in which they came.
#[derive(Clone, Debug)]
pub(super) struct Meshed {
    pub(super) points_mm: Vec<PointMm>,
    pub(super) facets: Vec<[u32; 3]>,
    pub(super) proof: Proof,
    /// Points that no facet uses, by reason.
    pub(super) left_out: BTreeMap<String, u64>,
    /// Points at the place of another.
    pub(super) duplicates: u64,
    /// Points beyond the range of places.
    pub(super) rejected: u64,
    /// For each facet the number of the part it belongs to.
    pub(super) part_of: Vec<u32>,
}

impl Meshed {
    /// Meshes points.
    ///
    /// # Errors
    ///
    /// Why they cannot be, in words.
    pub(super) fn of(points_mm: &[PointMm]) -> Result<Meshed, String> {
        let mut places: Vec<PointMm> =
            points_mm.iter().filter_map(|&point| admit(point).ok()).collect();
        let rejected = points_mm.len() - places.len();
        places.par_sort_unstable_by(|a, b| {
            a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(a[2].total_cmp(&b[2]))
        });
        let before = places.len();
        places.dedup();
        let duplicates = before - places.len();
        let surface = local(&places).map_err(|error| error.to_string())?;
        Meshed::proven(SurfaceByPlace { points_mm: places, surface, duplicates, rejected })
    }

    /// The mesh of points that were meshed while they arrived: that of [`Meshed::of`], bit for bit.
    ///
    /// # Errors
    ///
    /// Why it cannot be proven, in words.
    pub(super) fn of_surface(surface: &LocalSurface) -> Result<Meshed, String> {
        Meshed::proven(surface.by_place())
    }

    fn proven(found: SurfaceByPlace) -> Result<Meshed, String> {
        let SurfaceByPlace { points_mm: places, surface: made, duplicates, rejected } = found;
        let proof = prove(&places, &made.facets).map_err(|error| error.to_string())?;
        let mut left_out = BTreeMap::new();
        for (_, why) in &made.left_out {
            *left_out.entry(word(*why).to_owned()).or_default() += 1;
        }
        let part_of = parts(places.len(), &made.facets);
        Ok(Meshed {
            points_mm: places,
            facets: made.facets,
            proof,
            left_out,
            duplicates: duplicates as u64,
            rejected: rejected as u64,
            part_of,
        })
    }

    /// Twice the area of a facet, along its normal.
    pub(super) fn double_area(&self, facet: [u32; 3]) -> Vector {
        let [a, b, c] = facet.map(|corner| self.points_mm[corner as usize]);
        cross(minus(b, a), minus(c, a))
    }

    /// Turns each part of a surface with two sides so that its facets look out of a shape.
    pub(super) fn turn_out_of(&mut self, laid: &Laid) {
        let parts = self.part_of.iter().max().map_or(0, |most| *most as usize + 1);
        let mut sums = vec![0.0; parts];
        for (&facet, &part) in self.facets.iter().zip(&self.part_of) {
            let places = facet.map(|corner| self.points_mm[corner as usize]);
            let middle = [0, 1, 2].map(|axis| places.iter().map(|at| at[axis]).sum::<f64>() / 3.0);
            let (_, out) = laid.off(middle);
            sums[part as usize] += dot(self.double_area(facet), out);
        }
        for (facet, &part) in self.facets.iter_mut().zip(&self.part_of) {
            if sums[part as usize] < 0.0 {
                facet.swap(1, 2);
            }
        }
    }

    /// Unit normals of the vertices, by area; none of a vertex without a facet.
    pub(super) fn normals(&self) -> Vec<Option<Vector>> {
        let mut sums = vec![[0.0; 3]; self.points_mm.len()];
        for &facet in &self.facets {
            let normal = self.double_area(facet);
            for corner in facet {
                sums[corner as usize] = plus(sums[corner as usize], 1.0, normal);
            }
        }
        sums.into_iter().map(unit).collect()
    }

    /// Points that are vertices.
    pub(super) fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.points_mm.len()];
        for &corner in self.facets.as_flattened() {
            used[corner as usize] = true;
        }
        used
    }
}

/// For each facet its part, numbered by the first of its facets.
fn parts(points: usize, facets: &[[u32; 3]]) -> Vec<u32> {
    let mut sets = Sets::new(points);
    for &[a, b, c] in facets {
        sets.join(a as usize, b as usize);
        sets.join(b as usize, c as usize);
    }
    let mut numbers: BTreeMap<usize, u32> = BTreeMap::new();
    facets
        .iter()
        .map(|facet| {
            let next = numbers.len() as u32;
            *numbers.entry(sets.root(facet[0] as usize)).or_insert(next)
        })
        .collect()
}

fn word(why: LeftOut) -> &'static str {
    match why {
        LeftOut::NoPlace => "no place",
        LeftOut::Duplicate => "duplicate",
        LeftOut::NoPlane => "no tangent plane",
        LeftOut::Pruned | LeftOut::NoFace | LeftOut::Folding | LeftOut::NoFacet => "no facet",
        LeftOut::Noise => "noise",
        LeftOut::Disagreement => "corners disagree",
    }
}
