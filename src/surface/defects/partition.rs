//! Partition of a surface by its curvature.
//!
//! A vertex belongs to a class by the signs of its principal curvatures, each of which is zero unless it
//! is larger than its uncertainty allows (P. J. Besl, R. C. Jain, IEEE Trans. Pattern Anal. 10 (1988)
//! 167-192, label surfaces so by mean and Gaussian curvature), or by the band in which its mean curvature
//! lies. Neighbours of one class are one region.

use asphera_geometry::{PointMm, Sets, Sum, VertexId};
use thiserror::Error;

use crate::curvature::{Adjacency, LocalShape, Undetermined};

/// What a vertex belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// Bends towards +z both ways, as z = x² + y².
    Concave,
    /// Bends towards -z both ways.
    Convex,
    /// Bends towards +z one way, towards -z the other.
    Saddle,
    /// Bends towards +z one way only, as far as can be told.
    Trough,
    /// Bends towards -z one way only, as far as can be told.
    Ridge,
    /// No curvature can be told from zero.
    Flat,
    /// The mean curvature lies in this of the bands, counted from 0.
    Band(u32),
    /// The curvatures are not known.
    Undetermined,
}

/// By what the surface is parted.
#[derive(Clone, Debug, PartialEq)]
pub enum Bands {
    /// By the signs of the principal curvatures. One counts as zero up to the larger of this many of its
    /// standard uncertainties and the least size.
    Signs {
        /// Standard uncertainties, 0 or more; they count where the shapes state them.
        uncertainties: f64,
        /// Least size in 1/mm, 0 or more.
        least_per_mm: f64,
    },
    /// By mean curvature: the borders of the bands in 1/mm, ascending. Band 0 lies below the first; a
    /// value on a border belongs to the band above.
    Mean(Vec<f64>),
}

/// Bands that are none.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BandsError {
    /// A number of standard uncertainties or a curvature is not usable.
    #[error("{0} is not finite and at least 0")]
    Negative(f64),
    /// Borders do not ascend, or are no numbers.
    #[error("border {index} of the bands, {per_mm}/mm, is not finite and above the one before")]
    Border {
        /// Index of the border.
        index: usize,
        /// Its value in 1/mm.
        per_mm: f64,
    },
}

/// Why there is no partition.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PartitionError {
    /// The bands are none.
    #[error(transparent)]
    Bands(#[from] BandsError),
    /// Points, shapes and adjacency are not of the same number.
    #[error("{points} points, {shapes} shapes, {adjacency} vertices with neighbours")]
    Numbers {
        /// How many points were given.
        points: usize,
        /// How many shapes.
        shapes: usize,
        /// How many vertices the adjacency has.
        adjacency: usize,
    },
    /// A triangle has a corner that is no point.
    #[error("triangle {triangle} has the corner {corner}, but there are {points} points")]
    Corner {
        /// Index of the triangle.
        triangle: usize,
        /// Its corner.
        corner: VertexId,
        /// How many points there are.
        points: usize,
    },
}

/// Neighbours of one class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvatureRegion {
    /// Their class.
    pub class: Class,
    /// Area in space in mm²: a third of every triangle for each of its corners.
    pub area_mm2: f64,
    /// How many vertices they are.
    pub vertices: u64,
    /// The smallest of their numbers.
    pub first: VertexId,
}

/// A surface, parted.
#[derive(Clone, Debug, PartialEq)]
pub struct Partition {
    /// The largest area first, of equal ones the smaller first vertex.
    pub regions: Vec<CurvatureRegion>,
    /// Area in space in mm² and number of vertices of each class that occurs, in their order.
    pub classes: Vec<(Class, f64, u64)>,
    of_vertex: Vec<Option<u32>>,
}

impl Partition {
    /// Index of the region of a vertex; `None` if there is no such vertex or it has no neighbours.
    pub fn region_of(&self, vertex: VertexId) -> Option<usize> {
        self.of_vertex.get(vertex as usize)?.map(|index| index as usize)
    }
}

impl Bands {
    fn check(&self) -> Result<(), BandsError> {
        match self {
            Bands::Signs { uncertainties, least_per_mm } => [*uncertainties, *least_per_mm]
                .into_iter()
                .find(|value| !(value.is_finite() && *value >= 0.0))
                .map_or(Ok(()), |value| Err(BandsError::Negative(value))),
            Bands::Mean(borders) => borders
                .iter()
                .enumerate()
                .find(|&(index, per_mm)| {
                    !per_mm.is_finite() || (index > 0 && borders[index - 1] >= *per_mm)
                })
                .map_or(Ok(()), |(index, &per_mm)| Err(BandsError::Border { index, per_mm })),
        }
    }

    fn class(&self, shape: &LocalShape) -> Class {
        match self {
            Bands::Mean(borders) => {
                let mean_per_mm = shape.mean_per_mm();
                Class::Band(borders.partition_point(|&border| border <= mean_per_mm) as u32)
            }
            Bands::Signs { uncertainties, least_per_mm } => {
                let sign = |index: usize| {
                    let noise = shape.uncertainty.map_or(0.0, |u| u.curvatures_per_mm[index]);
                    let zero = (uncertainties * noise).max(*least_per_mm);
                    let curvature = shape.curvatures_per_mm[index];
                    i8::from(curvature > zero) - i8::from(curvature < -zero)
                };
                match (sign(0), sign(1)) {
                    (1, 1) => Class::Concave,
                    (-1, -1) => Class::Convex,
                    (1, -1) | (-1, 1) => Class::Saddle,
                    (1, 0) | (0, 1) => Class::Trough,
                    (-1, 0) | (0, -1) => Class::Ridge,
                    _ => Class::Flat,
                }
            }
        }
    }
}

/// Parts a surface by the shapes at its vertices, as [`crate::curvature::local_shapes`] gives them for
/// all of them.
///
/// Triangles of which a side joins no neighbours have no area here. Takes some 130 ns a point; the shapes
/// take far longer.
pub fn partition(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    adjacency: &Adjacency,
    shapes: &[Result<LocalShape, Undetermined>],
    bands: &Bands,
) -> Result<Partition, PartitionError> {
    bands.check()?;
    if shapes.len() != points.len() || adjacency.len() != points.len() {
        return Err(PartitionError::Numbers {
            points: points.len(),
            shapes: shapes.len(),
            adjacency: adjacency.len(),
        });
    }
    let areas_mm2 = areas_mm2(points, triangles, adjacency)?;
    let classes: Vec<Class> = shapes
        .iter()
        .map(|shape| shape.as_ref().map_or(Class::Undetermined, |shape| bands.class(shape)))
        .collect();
    let mut sets = Sets::new(points.len());
    for vertex in 0..points.len() {
        for &other in adjacency.neighbours(vertex as VertexId) {
            if (other as usize) < vertex && classes[vertex] == classes[other as usize] {
                sets.join(vertex, other as usize);
            }
        }
    }
    let mut of_vertex: Vec<Option<u32>> = vec![None; points.len()];
    let mut found: Vec<(CurvatureRegion, Sum)> = Vec::new();
    for vertex in 0..points.len() {
        if adjacency.neighbours(vertex as VertexId).is_empty() {
            continue;
        }
        // The smallest of a set is its root, and comes first.
        let root = sets.root(vertex);
        let index = *of_vertex[root].get_or_insert_with(|| {
            let region = CurvatureRegion {
                class: classes[root],
                area_mm2: 0.0,
                vertices: 0,
                first: root as VertexId,
            };
            found.push((region, Sum::default()));
            found.len() as u32 - 1
        });
        of_vertex[vertex] = Some(index);
        let (region, area) = &mut found[index as usize];
        region.vertices += 1;
        area.add(areas_mm2[vertex]);
    }
    for (region, area) in &mut found {
        region.area_mm2 = area.total();
    }
    Ok(ranked(found.into_iter().map(|(region, _)| region).collect(), of_vertex))
}

fn ranked(found: Vec<CurvatureRegion>, mut of_vertex: Vec<Option<u32>>) -> Partition {
    let mut order: Vec<usize> = (0..found.len()).collect();
    // A stable sort: those of equal area stay in the order of their first vertices.
    order.sort_by(|&p, &q| found[q].area_mm2.total_cmp(&found[p].area_mm2));
    let mut ranks = vec![0; found.len()];
    for (rank, &index) in order.iter().enumerate() {
        ranks[index] = rank as u32;
    }
    for index in of_vertex.iter_mut().flatten() {
        *index = ranks[*index as usize];
    }
    let mut classes: std::collections::BTreeMap<Class, (f64, u64)> =
        std::collections::BTreeMap::new();
    for region in &found {
        let (area_mm2, vertices) = classes.entry(region.class).or_default();
        *area_mm2 += region.area_mm2;
        *vertices += region.vertices;
    }
    Partition {
        regions: order.into_iter().map(|index| found[index]).collect(),
        classes: classes.into_iter().map(|(class, (area, count))| (class, area, count)).collect(),
        of_vertex,
    }
}

fn areas_mm2(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    adjacency: &Adjacency,
) -> Result<Vec<f64>, PartitionError> {
    let mut areas_mm2 = vec![0.0; points.len()];
    for (triangle, &corners) in triangles.iter().enumerate() {
        if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= points.len()) {
            return Err(PartitionError::Corner { triangle, corner, points: points.len() });
        }
        let [a, b, c] = corners;
        let near = adjacency.neighbours(a);
        if near.contains(&b) && near.contains(&c) && adjacency.neighbours(b).contains(&c) {
            let area_mm2 = asphera_geometry::Triangle::new(points, corners).area_mm2();
            if area_mm2.is_finite() {
                corners.iter().for_each(|&corner| areas_mm2[corner as usize] += area_mm2 / 3.0);
            }
        }
    }
    Ok(areas_mm2)
}
