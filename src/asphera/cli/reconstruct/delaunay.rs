//! Methods over the exact Delaunay triangulation in space: their figures and conditions.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    Proof, Reconstruction, SamplingCondition, alpha_shape, cocone, convection, sculpture,
};
use serde::Serialize;

use crate::cli::output::Failure;
use crate::cli::summary::short;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum DelaunayMethod {
    Alpha,
    Cocone,
    Convection,
    Sculpture,
}

/// Figures of a method, and how its points meet its condition.
#[derive(Debug, Serialize)]
pub(super) struct DelaunayFigures {
    #[serde(skip)]
    method: DelaunayMethod,
    /// Diameter of the ball of the alpha shape, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    alpha_mm: Option<f64>,
    /// The largest sampling ratio of all facets, by poles.
    epsilon_max: Option<f64>,
    /// The largest ratio for which the theorem of the method holds; `None` where there is no theorem.
    epsilon_bound: Option<f64>,
    /// Facets above the bound.
    epsilon_above: Option<usize>,
    /// The worst of them.
    epsilon_worst: Vec<WorstFacet>,
    /// Counts of the method, by name.
    counts: BTreeMap<&'static str, usize>,
}

#[derive(Debug, Serialize)]
struct WorstFacet {
    place_mm: PointMm,
    epsilon: f64,
}

/// The surface that a method finds.
pub(super) fn surface(
    method: DelaunayMethod,
    points_mm: &[PointMm],
    alpha_mm: Option<f64>,
) -> Result<(Reconstruction, DelaunayFigures), Failure> {
    let figures = |counts: &[(&'static str, usize)]| DelaunayFigures {
        method,
        alpha_mm,
        epsilon_max: None,
        epsilon_bound: None,
        epsilon_above: None,
        epsilon_worst: Vec::new(),
        counts: counts.iter().copied().collect(),
    };
    Ok(match method {
        DelaunayMethod::Alpha => {
            let found = alpha_shape(points_mm, alpha_mm.unwrap_or(f64::NAN))?;
            let counts = [
                ("singular", found.singular),
                ("regular", found.regular),
                ("tetrahedra", found.tetrahedra),
            ];
            (found.surface, figures(&counts))
        }
        DelaunayMethod::Cocone => {
            let found = cocone(points_mm)?;
            let counts = [
                ("candidates", found.candidates),
                ("pruned_candidates", found.pruned),
                ("points_not_flat", found.not_flat),
            ];
            (found.surface, figures(&counts).with_condition(&found.sampling))
        }
        DelaunayMethod::Convection => (convection(points_mm)?, figures(&[])),
        DelaunayMethod::Sculpture => (sculpture(points_mm)?, figures(&[])),
    })
}

impl DelaunayFigures {
    fn with_condition(mut self, condition: &SamplingCondition) -> DelaunayFigures {
        self.epsilon_max = Some(condition.largest);
        self.epsilon_bound = Some(condition.bound);
        self.epsilon_above = Some(condition.above);
        let worst = condition.worst.iter();
        self.epsilon_worst =
            worst.map(|&(place_mm, epsilon)| WorstFacet { place_mm, epsilon }).collect();
        self
    }

    pub(super) fn method(&self) -> &'static str {
        match self.method {
            DelaunayMethod::Alpha => "alpha",
            DelaunayMethod::Cocone => "cocone",
            DelaunayMethod::Convection => "convection",
            DelaunayMethod::Sculpture => "sculpture",
        }
    }

    /// Whether the theorem of the method speaks about this surface.
    pub(super) fn guarantee(&self, proof: &Proof) -> String {
        let (Some(largest), Some(bound)) = (self.epsilon_max, self.epsilon_bound) else {
            return format!(
                "none: the {} method has no theorem; the proof says what the surface is",
                self.method()
            );
        };
        let largest = short(largest);
        if self.epsilon_above != Some(0) {
            let worst = self.epsilon_worst.first().map(|worst| worst.place_mm.map(short));
            let [x, y, z] = worst.unwrap_or_default();
            return format!(
                "none: expected a sampling ratio of at most {bound}, found {largest} at {x}, {y}, {z} mm; measure more densely there"
            );
        }
        if !proof.is_closed || !proof.is_manifold {
            return format!(
                "none: the theorem is about closed surfaces; the sampling ratio of {largest} is within {bound}"
            );
        }
        format!(
            "holds: sampling ratio {largest} of at most {bound}; feature sizes estimated by poles"
        )
    }

    /// Lines for a terminal.
    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let (Some(largest), Some(above)) = (self.epsilon_max, self.epsilon_above) {
            lines.push((
                "sampling",
                format!("ε up to {}, {above} facets above the bound", short(largest)),
            ));
        }
        if !self.counts.is_empty() {
            let counts: Vec<String> = (self.counts.iter())
                .map(|(name, count)| format!("{count} {}", name.replace('_', " ")))
                .collect();
            lines.push(("method", counts.join(", ")));
        }
        lines
    }
}
