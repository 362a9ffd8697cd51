//! Heights at the vertices of a triangulation, with gaps.

use super::datum::{Datum, MeanPlane};
use super::surface::{LARGEST, Nodes, Support};
use super::{TextureError, Unknown};
use asphera_form::{NM_PER_MM, PointMm};

/// Heights in nm at scattered places that triangles join.
///
/// A vertex weighs a third of the projected area of each triangle around it whose three corners are all
/// measured; its height is thereby integrated exactly for a surface linear on each triangle.
///
/// Invariants: lists agree; corners exist; places and heights are finite; heights are 0 at gaps.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    places_mm: Vec<[f64; 2]>,
    heights_nm: Vec<f64>,
    measured: Vec<bool>,
    triangles: Vec<[u32; 3]>,
    areas_mm2: Vec<f64>,
    measured_mm2: f64,
    total_mm2: f64,
    datum: Datum,
}

impl Mesh {
    /// Points as x, y and height in mm, with triangles as indices of points in either sense.
    ///
    /// A point whose height is not finite is a gap; one whose place is not finite is a gap that no triangle
    /// has an area with; so is what lies beyond 1e54 mm. That triangles do not overlap is taken for granted.
    /// Fails if a triangle refers to a point there is not. `O(n)`.
    pub fn new(points: &[PointMm], triangles: &[[u32; 3]]) -> Result<Mesh, TextureError> {
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= points.len()) {
                return Err(TextureError::Corner { triangle, corner, points: points.len() });
            }
        }
        let near = |coordinate: f64| coordinate.abs() < LARGEST / NM_PER_MM;
        let placed: Vec<bool> = points.iter().map(|&[x, y, _]| near(x) && near(y)).collect();
        let place =
            |(&[x, y, _], &placed): (&PointMm, &bool)| if placed { [x, y] } else { [0.0; 2] };
        let heights = points.iter().zip(&placed);
        let heights: Vec<Option<f64>> = heights
            .map(|(p, &placed)| (placed && near(p[2])).then_some(p[2] * NM_PER_MM))
            .collect();
        let known = |corners: &&[u32; 3]| corners.iter().all(|&corner| placed[corner as usize]);
        let bare = Mesh {
            places_mm: points.iter().zip(&placed).map(place).collect(),
            heights_nm: Vec::new(),
            measured: Vec::new(),
            triangles: triangles.iter().filter(known).copied().collect(),
            areas_mm2: Vec::new(),
            measured_mm2: 0.0,
            total_mm2: 0.0,
            datum: Datum::AsGiven,
        };
        Ok(bare.with_heights(heights.into_iter()))
    }

    /// Triangulation kept, with other heights, `None` for a gap.
    pub(super) fn with_heights(&self, heights_nm: impl Iterator<Item = Option<f64>>) -> Mesh {
        let (heights_nm, measured): (Vec<f64>, Vec<bool>) =
            heights_nm.map(|height| (height.unwrap_or(0.0), height.is_some())).unzip();
        let mut areas_mm2 = vec![0.0; heights_nm.len()];
        let (mut measured_mm2, mut total_mm2) = (0.0, 0.0);
        for corners in &self.triangles {
            let area_mm2 = 0.5 * self.doubled_area(corners).abs();
            total_mm2 += area_mm2;
            if corners.iter().all(|&corner| measured[corner as usize]) {
                measured_mm2 += area_mm2;
                for &corner in corners {
                    areas_mm2[corner as usize] += area_mm2 / 3.0;
                }
            }
        }
        Mesh {
            places_mm: self.places_mm.clone(),
            heights_nm,
            measured,
            triangles: self.triangles.clone(),
            areas_mm2,
            measured_mm2,
            total_mm2,
            datum: Datum::AsGiven,
        }
    }

    /// How many vertices, gaps included.
    pub fn len(&self) -> usize {
        self.places_mm.len()
    }

    /// Whether there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.places_mm.is_empty()
    }

    /// Height that the heights are about.
    pub fn datum(&self) -> Datum {
        self.datum
    }

    /// Heights in nm in the order of the points; `None` for a gap.
    pub fn heights_nm(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        (0..self.len()).map(|i| self.at(i))
    }

    /// Height in nm of a vertex; `None` for a gap or where there is none.
    pub fn height_nm(&self, index: usize) -> Option<f64> {
        if index < self.len() { self.at(index) } else { None }
    }

    /// Area in mm² each vertex stands for, in the order of the points.
    pub fn areas_mm2(&self) -> &[f64] {
        &self.areas_mm2
    }

    /// The heights about another datum, the gaps as they are. `O(n)`.
    pub fn levelled(&self, datum: Datum) -> Mesh {
        let Ok(nodes) = self.nodes() else { return Mesh { datum, ..self.clone() } };
        let plane = MeanPlane::new(&nodes, datum);
        let left = (0..self.len()).map(|i| Some(self.at(i)? - plane.height_nm(self.places_mm[i])));
        Mesh { datum, ..self.with_heights(left) }
    }

    /// These heights less those of a mesh of the same vertices; a gap in either is a gap.
    pub(super) fn less(&self, other: &Mesh) -> Mesh {
        let pairs = self.heights_nm().zip(other.heights_nm());
        self.with_heights(pairs.map(|(own, other)| Some(own? - other?)))
    }

    /// The measured vertices that stand for an area.
    pub(super) fn nodes(&self) -> Result<Nodes, Unknown> {
        let given = self.len();
        let used: Vec<usize> = (0..given).filter(|&i| self.areas_mm2[i] > 0.0).collect();
        if used.is_empty() {
            return Err(Unknown::NoPoints { given });
        }
        let measured = self.measured_mm2 / self.total_mm2;
        Ok(Nodes {
            places_mm: used.iter().map(|&i| self.places_mm[i]).collect(),
            heights_nm: used.iter().map(|&i| self.heights_nm[i]).collect(),
            shares: used.iter().map(|&i| self.areas_mm2[i] / self.measured_mm2).collect(),
            support: Support { points: used.len(), measured, datum: self.datum },
        })
    }

    pub(super) fn places_mm(&self) -> &[[f64; 2]] {
        &self.places_mm
    }

    pub(super) fn at(&self, index: usize) -> Option<f64> {
        self.measured[index].then_some(self.heights_nm[index])
    }

    /// Triangles with three measured corners: places in mm and heights in nm.
    pub(super) fn whole_triangles(&self) -> impl Iterator<Item = [([f64; 2], f64); 3]> + '_ {
        let whole = |corners: &&[u32; 3]| corners.iter().all(|&i| self.measured[i as usize]);
        let corner = |i: u32| (self.places_mm[i as usize], self.heights_nm[i as usize]);
        self.triangles.iter().filter(whole).map(move |corners| corners.map(corner))
    }

    pub(super) fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    pub(super) fn total_mm2(&self) -> f64 {
        self.total_mm2
    }

    fn doubled_area(&self, corners: &[u32; 3]) -> f64 {
        let [a, b, c] = corners.map(|corner| self.places_mm[corner as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    }
}
