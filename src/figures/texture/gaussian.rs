//! The Gaussian filter of ISO 16610: its settings and what it did.

use std::f64::consts::{LN_2, PI};

use super::binned_filter::BinnedFilter;
use super::grid_filter::GridFilter;
use super::mesh_filter::MeshFilter;
use super::regression::FittedNode;
use super::robust::{Robust, RobustReport, iterate};
use super::unknown::positive;
use super::{Grid, Mesh, TextureError};

/// Degree of the polynomial that is fitted about each node with the weights of the filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// The weighted mean: the filter of ISO 16610-21 and -61, its weights renormalised at borders and gaps.
    /// There a slope pulls the result aside.
    #[default]
    Zero,
    /// A quadric: what is of degree two passes whole, up to the border and around gaps, and of degree
    /// three inside.
    Two,
}

/// A low pass with Gaussian weights: ISO 16610-21:2011 (profiles), -31 (robust), -61:2015 (areas), -71:2014
/// (areas, robust).
///
/// The weight at a distance r is exp(−π·(r/αc)²) with the cut-off c, renormalised over what is measured about
/// each node: a regression. Inside the surface a wave of wavelength λ passes by the share exp(−y) for order
/// 0 and (1 + y)·exp(−y) for order 2, with y = π·(αc/λ)²; α is √(ln 2/π) = 0.4697 and 0.7309, so that either
/// halves a wave of wavelength c.
///
/// Weights end at 2.129·αc, that is 1 and 1.56 cut-offs: on a grid along x and y each, which leaves out
/// 2e-7 of the whole weight, on a mesh at that radius, which leaves out 7e-7. The share of a wave that passes
/// differs by as much for order 0, by 1e-5 for order 2. With a cut-off of fewer than four distances of nodes
/// hardly a neighbour has a weight and more passes than stated: at three, 56 % of a wave of the cut-off
/// instead of half.
///
/// A gap stays a gap. About a node with too few neighbours for a quadric, terms the neighbours do not
/// determine are left out, the highest first; [`Filtered::lowered`] counts these nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    cutoff_mm: f64,
    order: Order,
    robust: Option<Robust>,
}

impl Gaussian {
    /// The linear filter. Fails unless the cut-off is positive and finite.
    pub fn new(cutoff_mm: f64, order: Order) -> Result<Gaussian, TextureError> {
        Ok(Gaussian { cutoff_mm: positive("cut-off", cutoff_mm)?, order, robust: None })
    }

    /// The same, with weights that are iterated so that outliers have none.
    pub fn robust(self, settings: Robust) -> Gaussian {
        Gaussian { robust: Some(settings), ..self }
    }

    /// Cut-off wavelength (nesting index) in mm.
    pub fn cutoff_mm(&self) -> f64 {
        self.cutoff_mm
    }

    /// Degree of the regression.
    pub fn order(&self) -> Order {
        self.order
    }

    /// Where the weights end, in mm.
    pub fn window_mm(&self) -> f64 {
        WINDOW * self.unit_mm()
    }

    /// The long waves of a grid; of one row those along it.
    ///
    /// The moments of the weights factor along x and y with and without gaps. For w taps along both
    /// directions together `O(n·2w)` for order 0, about `O(n·21w)` for order 2, and that for each iteration
    /// of a robust filter.
    pub fn of_grid(&self, grid: &Grid) -> Filtered<Grid> {
        let engine = GridFilter::new(grid, self.unit_mm(), self.window_mm(), self.order);
        let heights: Vec<Option<f64>> = grid.heights_nm().collect();
        self.run(
            &heights,
            &grid.weights(),
            engine.terms(),
            |weights| engine.fit(weights),
            |z| grid.with_heights(z),
        )
    }

    /// The long waves of a mesh; each vertex has the weight of its area besides. `O(n·k)` for k vertices
    /// within the window, and that for each iteration of a robust filter.
    pub fn of_mesh(&self, mesh: &Mesh) -> Filtered<Mesh> {
        let engine = MeshFilter::new(mesh, self.unit_mm(), self.window_mm(), self.order);
        self.run_mesh(mesh, engine.terms(), |weights| engine.fit(weights))
    }

    /// As [`Gaussian::of_mesh`] where some 2000 vertices at most lie within the window; where there are more, by
    /// way of a grid of 32 nodes a cut-off ([`Filtered::nodes_mm`] then says how far apart), on which the time no
    /// longer grows with the cut-off. A wave of the cut-off then passes by 0.7 % of itself less, one of twice the
    /// cut-off by 0.2 %.
    pub fn of_dense_mesh(&self, mesh: &Mesh) -> Filtered<Mesh> {
        let within = mesh.mean_spacing_mm().map_or(0.0, |spacing_mm| {
            PI * (self.window_mm() / spacing_mm) * (self.window_mm() / spacing_mm)
        });
        if within <= MOST_WITHIN {
            return self.of_mesh(mesh);
        }
        let nodes_mm = self.cutoff_mm / NODES_A_CUTOFF;
        let (unit_mm, window_mm) = (self.unit_mm(), self.window_mm());
        let engine = BinnedFilter::new(mesh, unit_mm, window_mm, self.order, nodes_mm);
        // Many nodes for few vertices: these lie in clusters, and their windows hold fewer than that.
        let Some(engine) = engine else { return self.of_mesh(mesh) };
        let filtered = self.run_mesh(mesh, engine.terms(), |weights| engine.fit(weights));
        Filtered { nodes_mm: Some(nodes_mm), ..filtered }
    }

    fn run_mesh(
        &self,
        mesh: &Mesh,
        terms: u8,
        fit: impl Fn(&[f64]) -> Vec<FittedNode>,
    ) -> Filtered<Mesh> {
        let heights: Vec<Option<f64>> = mesh.heights_nm().collect();
        // In units of the largest: only ratios count.
        let largest = mesh.areas_mm2().iter().copied().fold(0.0, f64::max);
        let share = |area: &f64| if *area > 0.0 { area / largest } else { 0.0 };
        let areas: Vec<f64> = mesh.areas_mm2().iter().map(share).collect();
        self.run(&heights, &areas, terms, fit, |z| mesh.with_heights(z))
    }

    fn run<T>(
        &self,
        heights_nm: &[Option<f64>],
        areas: &[f64],
        terms: u8,
        fit: impl Fn(&[f64]) -> Vec<FittedNode>,
        rebuild: impl FnOnce(std::vec::IntoIter<Option<f64>>) -> T,
    ) -> Filtered<T> {
        let (fitted, report) = match self.robust {
            None => (fit(areas), None),
            Some(settings) => {
                let (fitted, report) = iterate(settings, heights_nm, areas, fit);
                (fitted, Some(report))
            }
        };
        let pairs = || heights_nm.iter().zip(&fitted).filter(|(height, _)| height.is_some());
        let undetermined = pairs().filter(|(_, node)| node.terms == 0).count();
        let lowered = pairs().filter(|(_, node)| node.terms > 0 && node.terms < terms).count();
        let filtered: Vec<Option<f64>> = heights_nm
            .iter()
            .zip(&fitted)
            .map(|(height, node)| height.filter(|_| node.terms > 0).map(|_| node.value_nm))
            .collect();
        let surface = rebuild(filtered.into_iter());
        Filtered { surface, filter: *self, nodes_mm: None, undetermined, lowered, robust: report }
    }

    /// α times the cut-off: the unit of distance of the weights.
    pub(super) fn unit_mm(&self) -> f64 {
        let halves = match self.order {
            Order::Zero => LN_2,
            Order::Two => HALVES_TWO,
        };
        (halves / PI).sqrt() * self.cutoff_mm
    }
}

/// Surface after a filter.
#[derive(Clone, Debug, PartialEq)]
pub struct Filtered<T> {
    /// The long waves, at the nodes that were measured.
    pub surface: T,
    /// The filter.
    pub filter: Gaussian,
    /// Distance in mm of the nodes of the grid that a mesh was filtered on; `None` if on its own vertices.
    pub nodes_mm: Option<f64>,
    /// Measured nodes that became gaps: nothing within the window has a weight.
    pub undetermined: usize,
    /// Nodes about which the neighbours determine fewer terms than the order asks for.
    pub lowered: usize,
    /// How the robust iteration went; `None` for the linear filter.
    pub robust: Option<RobustReport>,
}

/// More vertices within a window are dearer than a grid.
const MOST_WITHIN: f64 = 2000.0;
const NODES_A_CUTOFF: f64 = 32.0;
/// Where the weights end, in units of αc: √(π/ln 2), one cut-off for order 0.
const WINDOW: f64 = 2.128_934_038_862_452_6;
/// The root of (1 + y)·exp(−y) = ½, as ln 2 is that of exp(−y) = ½.
const HALVES_TWO: f64 = 1.678_346_990_016_660_6;
