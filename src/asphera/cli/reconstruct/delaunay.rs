//! Methods over the exact Delaunay triangulation in space: their figures and conditions.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    CellCocone, Cocone, POINTS_IN_CELL, Proof, Reconstruction, SamplingCondition, Wrap,
    alpha_shape, cocone, convection, loc_cocone, natural, robust_cocone, sculpture, super_cocone,
    tangential, wrap,
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
    Natural,
    Wrap,
    Tangential,
    LocCocone,
    SuperCocone,
    RobustCocone,
}

/// Figures of a method, and how its points meet its condition.
#[derive(Debug, Serialize)]
pub(super) struct DelaunayFigures {
    #[serde(skip)]
    method: DelaunayMethod,
    /// Diameter of the ball of the alpha shape, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    alpha_mm: Option<f64>,
    /// Components, tunnels and cavities of the wrap complex.
    #[serde(skip_serializing_if = "Option::is_none")]
    betti_of_complex: Option<[i64; 3]>,
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
        betti_of_complex: None,
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
        DelaunayMethod::Cocone => of_cocone(cocone(points_mm)?, figures(&[])),
        DelaunayMethod::LocCocone => of_cells(loc_cocone(points_mm, POINTS_IN_CELL)?, figures(&[])),
        DelaunayMethod::SuperCocone => {
            of_cells(super_cocone(points_mm, POINTS_IN_CELL)?, figures(&[]))
        }
        DelaunayMethod::Convection => (convection(points_mm)?, figures(&[])),
        DelaunayMethod::Sculpture => (sculpture(points_mm)?, figures(&[])),
        DelaunayMethod::Wrap => of_wrap(wrap(points_mm, alpha_mm)?, figures(&[])),
        DelaunayMethod::Natural => {
            let found = natural(points_mm)?;
            let counts = [
                ("points_with_both_poles_on_one_side", found.one_sided),
                ("tetrahedra_where_planes_disagree", found.mixed),
                ("tetrahedra_by_side", found.by_side),
                ("lids_left_out", found.lids),
            ];
            (found.surface, figures(&counts).with_condition(&found.sampling))
        }
        DelaunayMethod::Tangential => {
            let found = tangential(points_mm)?;
            let counts = [
                ("points_with_weight", found.weighted),
                ("rounds", found.rounds),
                ("points_that_disagree", found.inconsistent),
            ];
            (found.surface, figures(&counts).with_condition(&found.sampling))
        }
        DelaunayMethod::RobustCocone => {
            let found = robust_cocone(points_mm)?;
            let counts = [
                ("points_as_noise", found.noise),
                ("big_balls_inside", found.inner),
                ("lids_left_out", found.lids),
            ];
            (found.surface, figures(&counts).with_condition(&found.sampling))
        }
    })
}

fn of_cocone(found: Cocone, figures: DelaunayFigures) -> (Reconstruction, DelaunayFigures) {
    let counts = [
        ("candidates", found.candidates),
        ("pruned_candidates", found.pruned),
        ("points_not_flat", found.not_flat),
    ];
    (found.surface, figures.with_counts(&counts).with_condition(&found.sampling))
}

fn of_cells(found: CellCocone, figures: DelaunayFigures) -> (Reconstruction, DelaunayFigures) {
    let counts = [("cells", found.cells), ("rounds", found.rounds)];
    of_cocone(found.cocone, figures.with_counts(&counts))
}

fn of_wrap(found: Wrap, mut figures: DelaunayFigures) -> (Reconstruction, DelaunayFigures) {
    let [edges, facets, tetrahedra] = found.critical;
    let counts = [
        ("critical_edges", edges),
        ("critical_facets", facets),
        ("critical_tetrahedra", tetrahedra),
        ("chosen", found.chosen),
        ("tetrahedra_of_the_complex", found.simplices[3]),
    ];
    figures.betti_of_complex = Some(found.betti);
    figures = figures.with_counts(&counts);
    if let Some(sampling) = &found.sampling {
        figures = figures.with_condition(sampling);
    }
    (found.surface, figures)
}

impl DelaunayFigures {
    fn with_counts(mut self, counts: &[(&'static str, usize)]) -> DelaunayFigures {
        self.counts.extend(counts.iter().copied());
        self
    }

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
            DelaunayMethod::Natural => "natural",
            DelaunayMethod::Wrap => "wrap",
            DelaunayMethod::Tangential => "tangential",
            DelaunayMethod::LocCocone => "loccocone",
            DelaunayMethod::SuperCocone => "super-cocone",
            DelaunayMethod::RobustCocone => "robust-cocone",
        }
    }

    /// Whether the theorem of the method speaks about this surface.
    pub(super) fn guarantee(&self, proof: &Proof) -> String {
        if let (DelaunayMethod::Wrap, Some(diameter)) = (self.method, self.alpha_mm) {
            let diameter = short(diameter);
            return format!(
                "none for the surface; the complex has the Betti numbers of the alpha complex of balls of {diameter} mm"
            );
        }
        if proof.facets == 0 {
            return "none: no surface was found; the proof of the method needs dense points of a closed surface".to_owned();
        }
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
        match self.method {
            DelaunayMethod::RobustCocone => format!(
                "unknown: sampling ratio {largest} of at most {bound}, but the noise of the points is not known here"
            ),
            DelaunayMethod::SuperCocone => format!(
                "unknown: sampling ratio {largest} of at most {bound}, but the margin of cells is not proven; use --method loccocone"
            ),
            _ => format!(
                "holds: sampling ratio {largest} of at most {bound}; feature sizes estimated by poles"
            ),
        }
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
        if let Some([components, tunnels, cavities]) = self.betti_of_complex {
            lines.push((
                "complex",
                format!("components {components}, tunnels {tunnels}, cavities {cavities}"),
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
