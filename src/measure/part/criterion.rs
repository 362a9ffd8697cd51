//! The loss and the weights of a fit.

use asphera_form::Loss;

/// The criterion of a fit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Criterion {
    /// How much a deviation counts.
    pub loss: Loss,
    /// The scale of the loss, mm; `None`: found from the deviations.
    pub loss_scale_mm: Option<f64>,
    /// Weights of points.
    pub weights: Weights,
}

/// Weights of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// All alike.
    #[default]
    None,
    /// By 1/u², with the standard uncertainty u that each point of the file carries.
    Uncertainty,
}

impl Criterion {
    /// Whether it is least squares of points that count alike.
    pub fn is_plain(&self) -> bool {
        self.loss == Loss::Squares && self.weights == Weights::None
    }
}
