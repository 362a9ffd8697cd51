//! The answer of a verdict.

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Every limit holds.
    Pass,
    /// A limit is broken.
    Fail,
    /// There is no answer.
    Undecided,
}

/// Why no limit can be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// There is no limit.
    NoTolerance,
    /// There are no figures.
    NoFigures,
}

/// A sentence fragment for a report.
impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Reason::NoTolerance => "no limits are given",
            Reason::NoFigures => "there are no figures",
        })
    }
}
