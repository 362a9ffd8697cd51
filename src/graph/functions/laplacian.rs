//! The Laplacian of a cloud: weights between neighbours, from their distances.
//!
//! Neighbours p and q weigh a(p, q) = exp(−‖p − q‖²/h²), h the mean distance of neighbours. The weights are divided by the
//! densities of both places, so that a dense region counts no more than a thin one (R. R. Coifman, S. Lafon, Applied and Computational
//! Harmonic Analysis 21 (2006) 5-30, α = 1). The paper of the Point Cloud Graph leaves that out.

use asphera_geometry::Sets;
use rayon::prelude::*;

use super::FunctionError;
use super::ring::Rings;
use crate::cloud::{CHUNK, Cloud, PlaceId};
use crate::nearest::Nearest;

/// Symmetric weights of a cloud in one piece.
pub(super) struct Laplacian {
    starts: Vec<usize>,
    ids: Vec<PlaceId>,
    weights: Vec<f64>,
    /// The sum of the weights of each place.
    degrees: Vec<f64>,
}

impl Laplacian {
    /// The weights between the neighbours of a cloud. k·n time.
    ///
    /// # Errors
    ///
    /// A cloud without points, or in more than one piece.
    pub(super) fn new<const D: usize>(
        cloud: &Cloud<D>,
        nearest: &Nearest,
    ) -> Result<Laplacian, FunctionError> {
        if cloud.is_empty() {
            return Err(FunctionError::NoPoints);
        }
        let rings = Rings::new(cloud, nearest);
        let count = cloud.len();
        let places = 0..count as PlaceId;
        let (mut edges, mut sum_mm) = (0_usize, 0.0);
        for place in places.clone() {
            for (_, length_mm) in rings.neighbours(place) {
                (edges, sum_mm) = (edges + 1, sum_mm + length_mm);
            }
        }
        let width_mm = sum_mm / edges.max(1) as f64;
        let likeness = |length_mm: f64| (-(length_mm / width_mm).powi(2)).exp();
        // A place is its own neighbour, at no distance.
        let density =
            |place| 1.0 + rings.neighbours(place).map(|(_, mm)| likeness(mm)).sum::<f64>();
        let densities: Vec<f64> = places.clone().into_par_iter().map(density).collect();
        let of_job = |first: usize| {
            let mut job = (Vec::new(), Vec::new(), Vec::new());
            let (ends, ids, weights) = &mut job;
            for place in first..(first + JOB).min(count) {
                for (other, length_mm) in rings.neighbours(place as PlaceId) {
                    let likeness = likeness(length_mm);
                    if likeness > NOTHING {
                        ids.push(other);
                        weights.push(likeness / (densities[place] * densities[other as usize]));
                    }
                }
                ends.push(ids.len());
            }
            job
        };
        let jobs: Vec<_> = (0..count).into_par_iter().step_by(JOB).map(of_job).collect();
        let (mut starts, mut ids, mut weights) = (vec![0], Vec::new(), Vec::new());
        for (ends, of_job, their_weights) in jobs {
            let before = ids.len();
            starts.extend(ends.into_iter().map(|end| before + end));
            ids.extend(of_job);
            weights.extend(their_weights);
        }
        let mut sets = Sets::new(count);
        for (place, ends) in starts.windows(2).enumerate() {
            // Weights are symmetric: each link is met from its other end, too.
            for &other in ids[ends[0]..ends[1]].iter().filter(|&&other| other as usize > place) {
                sets.join(place, other as usize);
            }
        }
        let (_, pieces) = sets.numbered();
        if pieces > 1 {
            return Err(FunctionError::Pieces { pieces: pieces as usize });
        }
        let degrees = starts.windows(2).map(|ends| weights[ends[0]..ends[1]].iter().sum());
        let degrees = degrees.collect();
        Ok(Laplacian { starts, ids, weights, degrees })
    }

    /// Number of places.
    pub(super) fn len(&self) -> usize {
        self.degrees.len()
    }

    /// The sum of the weights of each place.
    pub(super) fn degrees(&self) -> &[f64] {
        &self.degrees
    }

    /// The neighbours of a place with their weights.
    pub(super) fn neighbours(&self, place: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.starts[place]..self.starts[place + 1];
        let ids = self.ids[range.clone()].iter().map(|&id| id as usize);
        ids.zip(self.weights[range].iter().copied())
    }

    /// The weights divided by the roots of both degrees: the symmetric twin of the random walk. Its eigenvalues lie between −1
    /// and 1.
    pub(super) fn normalised(mut self) -> Laplacian {
        let roots: Vec<f64> = self.degrees.iter().map(|degree| degree.sqrt()).collect();
        let (mut rows, mut further) =
            (Vec::with_capacity(self.degrees.len()), &mut self.weights[..]);
        for ends in self.starts.windows(2) {
            let (row, others) = further.split_at_mut(ends[1] - ends[0]);
            rows.push((&self.ids[ends[0]..ends[1]], row));
            further = others;
        }
        rows.into_par_iter().zip(&roots).for_each(|((ids, row), root)| {
            for (weight, &other) in row.iter_mut().zip(ids) {
                *weight /= root * roots[other as usize];
            }
        });
        self
    }
}

/// The sum of products, over chunks of fixed length: threads change no bit.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let products = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let sums: Vec<f64> = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).map(products).collect();
    sums.iter().sum()
}

/// Places of one job.
const JOB: usize = 1 << 10;

/// Neighbours that are less alike are none: six mean distances apart.
const NOTHING: f64 = 1e-16;
