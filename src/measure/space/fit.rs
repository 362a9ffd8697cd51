//! The orthogonal least-squares fit of a shape to a part as a whole, by Gauss and Newton.
//!
//! The start needs no guess. A sphere begins at the algebraic one about the middle of the points. A cylinder begins along each of
//! the three axes of the facets' normals, for its own normals lie across it; the best of the three fits counts. A plane begins
//! at the one of least spread.

use asphera_geometry::PointMm;
use asphera_geometry::vector::{Vector, cross, dot, length, minus, plus, unit};
use rayon::prelude::*;

use super::matrix::{MOST, Normal, eigenvectors};
use super::shape::{Laid, Shape, across};

/// A fit.
#[derive(Clone, Debug)]
pub(super) struct ShapeFit {
    pub(super) laid: Laid,
    /// Variances of the unknowns over that of a point: of a sphere those of its centre; then that of the radius where it is free.
    pub(super) variances: [f64; MOST],
    /// How many unknowns there are.
    pub(super) unknowns: usize,
    pub(super) iterations: u32,
    pub(super) converged: bool,
}

/// Points and facets of a part, and the shape that is wanted.
pub(super) struct Wanted<'a> {
    pub(super) points_mm: &'a [PointMm],
    pub(super) facets: &'a [[u32; 3]],
    pub(super) shape: Shape,
    pub(super) free_radius: bool,
}

impl Wanted<'_> {
    /// The fit.
    ///
    /// # Errors
    ///
    /// Why there is none, in words.
    pub(super) fn fit(&self) -> Result<ShapeFit, String> {
        let unknowns = self.unknowns();
        if self.points_mm.len() < unknowns {
            return Err(format!(
                "expected at least {unknowns} points for this shape, found {}",
                self.points_mm.len()
            ));
        }
        let middle_mm = self.middle_mm();
        let extent_mm = self
            .points_mm
            .iter()
            .fold(0.0_f64, |most, point| most.max(length(minus(*point, middle_mm))));
        let starts = self.starts(middle_mm);
        let fits = starts.into_iter().filter_map(|start| self.refined(start, extent_mm));
        let best = fits.reduce(|best, next| if next.0 < best.0 { next } else { best });
        best.map(|(_, fit)| fit)
            .ok_or_else(|| "the points do not determine where the shape lies".to_owned())
    }

    fn unknowns(&self) -> usize {
        let of_place = match self.shape {
            Shape::Plane | Shape::Sphere { .. } => 3,
            Shape::Cylinder { .. } => 4,
        };
        of_place + usize::from(self.free_radius && self.shape != Shape::Plane)
    }

    fn middle_mm(&self) -> PointMm {
        let first = self.points_mm[0];
        let sums = summed(self.points_mm, |point, sums: &mut [f64; MOST]| {
            let way = minus(*point, first);
            (0..3).for_each(|axis| sums[axis] += way[axis]);
        });
        let count = self.points_mm.len() as f64;
        [0, 1, 2].map(|axis| first[axis] + sums[axis] / count)
    }

    fn starts(&self, middle_mm: PointMm) -> Vec<Laid> {
        let laid = |centre_mm: PointMm, axis: Vector| Laid { shape: self.shape, centre_mm, axis };
        match self.shape {
            Shape::Plane => {
                let spread = spread(self.points_mm.iter().map(|point| minus(*point, middle_mm)));
                let mut normal = eigenvectors(spread)[0];
                if dot(self.area_vector(), normal) < 0.0 {
                    normal = normal.map(|side| -side);
                }
                vec![laid(middle_mm, normal)]
            }
            Shape::Sphere { .. } => {
                let centre = algebraic(self.points_mm, middle_mm, None).unwrap_or(middle_mm);
                vec![laid(centre, [0.0, 0.0, 1.0])]
            }
            Shape::Cylinder { .. } => {
                let normals = self.facets.iter().map(|facet| self.double_area(facet));
                eigenvectors(spread(normals))
                    .into_iter()
                    .map(|axis| {
                        let centre = algebraic(self.points_mm, middle_mm, Some(axis));
                        laid(centre.unwrap_or(middle_mm), toward(axis))
                    })
                    .collect()
            }
        }
    }

    fn double_area(&self, facet: &[u32; 3]) -> Vector {
        let [a, b, c] = facet.map(|corner| self.points_mm[corner as usize]);
        cross(minus(b, a), minus(c, a))
    }

    fn area_vector(&self) -> Vector {
        self.facets.iter().fold([0.0; 3], |sum, facet| plus(sum, 1.0, self.double_area(facet)))
    }

    /// The fit from a start with its sum of squares; `None` where the points do not determine it.
    fn refined(&self, start: Laid, extent_mm: f64) -> Option<(f64, ShapeFit)> {
        let unknowns = self.unknowns();
        let mut laid = start;
        let mut sums = self.sums(&laid, extent_mm);
        for iteration in 1..=MOST_ITERATIONS {
            let (step, variances) = sums.solved(unknowns)?;
            let mut share = 1.0;
            let (next, next_sums) = loop {
                let next = self.moved(&laid, &step.map(|value| share * value), extent_mm)?;
                let found = self.sums(&next, extent_mm);
                if found.squares <= sums.squares || share < LEAST_SHARE {
                    break (next, found);
                }
                share *= 0.5;
            };
            let motion = step.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let is_better = next_sums.squares < sums.squares;
            if is_better {
                (laid, sums) = (next, next_sums);
            }
            // Rounding ends the descent where the step itself does not.
            if motion <= STILL * extent_mm || !is_better {
                let converged = motion <= NEARLY_STILL * extent_mm;
                let iterations = iteration;
                let fit = ShapeFit { laid, variances, unknowns, iterations, converged };
                return Some((sums.squares, fit));
            }
        }
        let (_, variances) = sums.solved(unknowns)?;
        let (iterations, converged) = (MOST_ITERATIONS, false);
        Some((sums.squares, ShapeFit { laid, variances, unknowns, iterations, converged }))
    }

    /// Derivatives of the distances: by shifts, by tilts in mm at the extent, by the radius.
    fn sums(&self, laid: &Laid, extent_mm: f64) -> Normal {
        let [u, v] = across(laid.axis);
        let per_extent = 1.0 / extent_mm.max(f64::MIN_POSITIVE);
        let radius_column = if self.free_radius { -1.0 } else { 0.0 };
        let chunks: Vec<Normal> = self
            .points_mm
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut normal = Normal::default();
                for &place in chunk {
                    let (off_mm, out) = laid.off(place);
                    let way = minus(place, laid.centre_mm);
                    let row = match laid.shape {
                        Shape::Plane => {
                            [-1.0, dot(way, u) * per_extent, dot(way, v) * per_extent, 0.0, 0.0]
                        }
                        Shape::Sphere { .. } => [-out[0], -out[1], -out[2], radius_column, 0.0],
                        Shape::Cylinder { .. } => {
                            let along = dot(way, laid.axis) * per_extent;
                            let [a, b] = [-dot(out, u), -dot(out, v)];
                            [a, b, a * along, b * along, radius_column]
                        }
                    };
                    normal.add(&row, off_mm);
                }
                normal
            })
            .collect();
        chunks.iter().fold(Normal::default(), |mut all, chunk| {
            all.join(chunk);
            all
        })
    }

    fn moved(&self, laid: &Laid, step: &[f64; MOST], extent_mm: f64) -> Option<Laid> {
        let [u, v] = across(laid.axis);
        let tilted =
            |a: f64, b: f64| unit(plus(plus(laid.axis, a / extent_mm, u), b / extent_mm, v));
        let grown = |by: f64| {
            let by = if self.free_radius { by } else { 0.0 };
            laid.shape.with_radius(laid.shape.radius_mm() + by)
        };
        let moved = match laid.shape {
            Shape::Plane => Laid {
                centre_mm: plus(laid.centre_mm, step[0], laid.axis),
                axis: tilted(step[1], step[2])?,
                ..*laid
            },
            Shape::Sphere { .. } => Laid {
                centre_mm: plus(laid.centre_mm, 1.0, [step[0], step[1], step[2]]),
                shape: grown(step[3]),
                ..*laid
            },
            Shape::Cylinder { .. } => Laid {
                centre_mm: plus(plus(laid.centre_mm, step[0], u), step[1], v),
                axis: tilted(step[2], step[3])?,
                shape: grown(step[4]),
            },
        };
        (moved.shape == Shape::Plane || moved.shape.radius_mm() > 0.0).then_some(moved)
    }
}

/// The centre of the sphere, or across an axis of the circle, whose algebraic distances are least: |p|² = 2·p·c + k.
fn algebraic(points_mm: &[PointMm], middle_mm: PointMm, axis: Option<Vector>) -> Option<PointMm> {
    let axes = match axis {
        None => vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        Some(axis) => across(axis).to_vec(),
    };
    let mut normal = Normal::default();
    for point in points_mm {
        let way = minus(*point, middle_mm);
        let mut row = [0.0; MOST];
        let mut square = 0.0;
        for (at, axis) in axes.iter().enumerate() {
            let side = dot(way, *axis);
            row[at] = 2.0 * side;
            square += side * side;
        }
        row[axes.len()] = 1.0;
        normal.add(&row, -square);
    }
    let (found, _) = normal.solved(axes.len() + 1)?;
    Some(axes.iter().zip(found).fold(middle_mm, |centre, (axis, by)| plus(centre, by, *axis)))
}

/// Sums of squares and products of vectors: xx, yy, zz, xy, yz, zx.
fn spread(vectors: impl Iterator<Item = Vector>) -> [f64; 6] {
    vectors.fold([0.0; 6], |mut sums, [x, y, z]| {
        let terms = [x * x, y * y, z * z, x * y, y * z, z * x];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        sums
    })
}

/// The same axis, its first side from the last that is not 0 upwards.
fn toward(axis: Vector) -> Vector {
    let side = axis.iter().rev().find(|side| side.abs() > 1e-9);
    if side.is_some_and(|side| *side < 0.0) { axis.map(|side| -side) } else { axis }
}

/// Sums over chunks of fixed size, joined in order.
fn summed(points_mm: &[PointMm], add: impl Fn(&PointMm, &mut [f64; MOST]) + Sync) -> [f64; MOST] {
    let chunks: Vec<[f64; MOST]> = points_mm
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut sums = [0.0; MOST];
            chunk.iter().for_each(|point| add(point, &mut sums));
            sums
        })
        .collect();
    chunks.iter().fold([0.0; MOST], |mut all, chunk| {
        all.iter_mut().zip(chunk).for_each(|(all, own)| *all += own);
        all
    })
}

const CHUNK: usize = 1 << 14;
const MOST_ITERATIONS: u32 = 60;
const LEAST_SHARE: f64 = 1e-3;
/// Of the extent: a smaller step is rounding.
const STILL: f64 = 1e-13;
/// Of the extent: a step that may be left where rounding ended the descent.
const NEARLY_STILL: f64 = 1e-7;
