//! The steps of the final figures, for whoever shows how far they are.

/// A step of the final figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The last points are meshed.
    Mesh,
    /// The nominal is fitted.
    Fit,
    /// Coverage, gaps and noise of the samples are assessed.
    Sampling,
    /// The deviation of every point, its figures and their uncertainties.
    Deviation,
    /// The deviation on a grid, and figures of standards that need more than deviations.
    Standards,
    /// The part that was not measured is estimated.
    Unmeasured,
    /// Defects are looked for.
    Defects,
    /// The figures are held against their limits.
    Verdict,
}

impl Step {
    /// The step as a line of progress names it.
    pub const fn words(self) -> &'static str {
        match self {
            Step::Mesh => "finishing the mesh",
            Step::Fit => "fitting the nominal",
            Step::Sampling => "assessing the sampling",
            Step::Deviation => "deviations and uncertainties",
            Step::Standards => "figures of standards",
            Step::Unmeasured => "estimating what was not measured",
            Step::Defects => "looking for defects",
            Step::Verdict => "holding figures against limits",
        }
    }
}
