//! The correlated part of a budget: functions with independent standard normal factors, at nodes.
//!
//! Up to 2048 points are nodes of their own. More are gathered into the cells of a grid of 48 by 48 over their
//! bounding box, each with its mean place, derivatives and residual: sums of smooth functions over the points
//! then differ by about (cell/D)²·(D/ℓ)²/12 for a part of size D, a thousandth for ℓ = D/5.

use asphera_geometry::BoundsMm;
use std::ops::Range;

use super::budget::{Budget, Effect};
use super::field::Field;
use super::linear::{Linear, dot};

/// A place that stands for one point or for several close together.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) count: f64,
    /// Means over its points.
    pub(super) place_mm: [f64; 2],
    pub(super) row: Vec<f64>,
    pub(super) distance_mm: f64,
    /// Sum over its points.
    gain: Vec<f64>,
    pub(super) points: Vec<usize>,
}

/// Correlated errors: Σ function·factor.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    pub(super) nodes: Vec<Node>,
    /// Node of each point.
    node_of: Vec<usize>,
    pub(super) fields: Vec<Field>,
    /// The functions that belong to each long-wave error and then to each effect.
    pub(super) sources: Vec<Range<usize>>,
    /// At each node, what the functions do to the residuals, in mm.
    pub(super) residual_mm: Vec<Vec<f64>>,
    /// G·v of each function: what it takes off the parameters.
    pub(super) moved: Vec<Vec<f64>>,
    /// Variance of long-wave errors that is left for independent noise, at each node in mm².
    remainder_mm2: Vec<f64>,
    /// Its share of the variance of each long-wave error, as a mean over the points.
    neglected: Vec<f64>,
}

impl Modes {
    /// `O(n·p + N·m²)` for N nodes and m functions.
    pub(super) fn new(linear: &Linear, budget: &Budget) -> Modes {
        let (nodes, node_of) = gather(linear);
        let places_mm: Vec<[f64; 2]> = nodes.iter().map(|node| node.place_mm).collect();
        let mut raw_mm: Vec<Vec<f64>> = vec![Vec::new(); nodes.len()];
        let mut remainder_mm2 = vec![0.0; nodes.len()];
        let (mut fields, mut sources, mut functions) = (Vec::new(), Vec::new(), 0);
        let mut neglected = Vec::new();
        for wave in &budget.long_waves {
            let (field, at) = Field::new(wave, &places_mm);
            for (all, values) in raw_mm.iter_mut().zip(at.values_mm) {
                all.extend(values);
            }
            let counts = nodes.iter().map(|node| node.count);
            let left: f64 =
                at.remainder_mm2.iter().zip(counts).map(|(left, count)| left * count).sum();
            let variance = wave.sigma_mm * wave.sigma_mm * linear.len() as f64;
            neglected.push(if variance > 0.0 { left / variance } else { 0.0 });
            for (all, left) in remainder_mm2.iter_mut().zip(at.remainder_mm2) {
                *all += left;
            }
            sources.push(functions..functions + field.functions());
            functions += field.functions();
            fields.push(field);
        }
        for effect in &budget.effects {
            for (all, node) in raw_mm.iter_mut().zip(&nodes) {
                let sum: f64 = node
                    .points
                    .iter()
                    .map(|&place| dot(&linear.normals[place], &effect.at(linear.points[place])))
                    .sum();
                all.push(sum / node.count);
            }
            sources.push(functions..functions + 1);
            functions += 1;
        }
        let p = linear.parameters.len();
        let mut moved = vec![vec![0.0; p]; functions];
        for (node, values) in nodes.iter().zip(&raw_mm) {
            for (moved, value) in moved.iter_mut().zip(values) {
                moved.iter_mut().zip(&node.gain).for_each(|(sum, gain)| *sum += gain * value);
            }
        }
        let residual_mm = nodes.iter().zip(&raw_mm);
        let residual_mm = residual_mm.map(|(node, values)| residual(&node.row, values, &moved));
        let residual_mm = residual_mm.collect();
        Modes { node_of, fields, sources, residual_mm, moved, remainder_mm2, neglected, nodes }
    }

    /// Number of functions.
    pub(super) fn functions(&self) -> usize {
        self.moved.len()
    }

    /// The errors by these factors of the functions.
    pub(super) fn waves<'a>(&'a self, budget: &'a Budget, factors: &[f64]) -> Waves<'a> {
        let (of_fields, of_effects) = self.sources.split_at(self.fields.len());
        let fields = self.fields.iter().zip(of_fields);
        let effects = budget.effects.iter().zip(of_effects);
        Waves {
            fields: fields
                .map(|(field, range)| (field, field.weights(&factors[range.clone()])))
                .collect(),
            effects: effects.map(|(effect, range)| (effect, factors[range.start])).collect(),
        }
    }

    /// Share of the variance of each long-wave error that is taken for independent noise.
    pub(super) fn neglected(&self) -> Vec<f64> {
        self.neglected.clone()
    }

    /// The variance at a point, in mm², that is left for independent noise.
    pub(super) fn remainder_mm2(&self, place: usize) -> f64 {
        self.remainder_mm2[self.node_of[place]]
    }

    /// The node that stands for a point.
    pub(super) fn node_of(&self, place: usize) -> usize {
        self.node_of[place]
    }

    /// The node that stands for each point.
    pub(super) fn nodes_of(&self) -> &[usize] {
        &self.node_of
    }

    /// What the functions do to the distance of one point from the nominal where it lies, in mm.
    pub(super) fn raw_at(&self, place: usize, linear: &Linear, budget: &Budget) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::with_capacity(self.functions());
        for field in &self.fields {
            values.extend(field.at(linear.places_mm[place]));
        }
        for effect in &budget.effects {
            values.push(dot(&linear.normals[place], &effect.at(linear.points[place])));
        }
        values
    }
}

/// The correlated errors of one draw.
pub(super) struct Waves<'a> {
    fields: Vec<(&'a Field, Vec<f64>)>,
    effects: Vec<(&'a Effect, f64)>,
}

impl Waves<'_> {
    /// The error of the distance of a point in mm.
    pub(super) fn at(&self, place: usize, linear: &Linear) -> f64 {
        let of_fields = self
            .fields
            .iter()
            .map(|(field, weights)| field.sum_at(linear.places_mm[place], weights));
        let along = |effect: &Effect| dot(&linear.normals[place], &effect.at(linear.points[place]));
        let of_effects = self.effects.iter().map(|(effect, factor)| along(effect) * factor);
        of_fields.chain(of_effects).fold(0.0, |sum, error_mm| sum + error_mm)
    }
}

/// v − J·G·v of every function at one place.
fn residual(row: &[f64], values_mm: &[f64], moved: &[Vec<f64>]) -> Vec<f64> {
    values_mm.iter().zip(moved).map(|(value, moved)| value - dot(row, moved)).collect()
}

fn gather(linear: &Linear) -> (Vec<Node>, Vec<usize>) {
    let p = linear.parameters.len();
    let cell_of = cells(&linear.places_mm);
    let mut index_of = std::collections::BTreeMap::new();
    let mut nodes: Vec<Node> = Vec::new();
    let mut node_of = Vec::with_capacity(linear.len());
    for (place, cell) in cell_of.into_iter().enumerate() {
        let index = *index_of.entry(cell).or_insert_with(|| {
            nodes.push(Node {
                count: 0.0,
                place_mm: [0.0; 2],
                row: vec![0.0; p],
                distance_mm: 0.0,
                gain: vec![0.0; p],
                points: Vec::new(),
            });
            nodes.len() - 1
        });
        node_of.push(index);
        let node = &mut nodes[index];
        node.count += 1.0;
        node.points.push(place);
        for axis in 0..2 {
            node.place_mm[axis] += linear.places_mm[place][axis];
        }
        node.distance_mm += linear.distances_mm[place];
        node.row.iter_mut().zip(linear.row(place)).for_each(|(sum, entry)| *sum += entry);
        node.gain.iter_mut().zip(linear.gain(place)).for_each(|(sum, entry)| *sum += entry);
    }
    for node in &mut nodes {
        node.place_mm = node.place_mm.map(|sum| sum / node.count);
        node.distance_mm /= node.count;
        node.row.iter_mut().for_each(|sum| *sum /= node.count);
    }
    (nodes, node_of)
}

/// A cell for each place.
fn cells(places_mm: &[[f64; 2]]) -> Vec<usize> {
    if places_mm.len() <= OWN_NODES {
        return (0..places_mm.len()).collect();
    }
    let BoundsMm { low, high } = BoundsMm::about(places_mm.iter().copied());
    let side = |axis: usize, value: f64| {
        let share = (value - low[axis]) / (high[axis] - low[axis]).max(f64::MIN_POSITIVE);
        ((share * CELLS as f64) as usize).min(CELLS - 1)
    };
    places_mm.iter().map(|place| side(1, place[1]) * CELLS + side(0, place[0])).collect()
}

/// Up to this many points are nodes of their own.
const OWN_NODES: usize = 2048;
/// Cells along one side.
const CELLS: usize = 48;
