//! The methods by name: parameters, guarantee, source.

mod list;
mod parameters;

use thiserror::Error;

pub use self::parameters::{Parameter, Parameters};
use crate::curves::{
    connect2d, conservative_crust, crawl, crust, discur, emst_curve, gathan, hnn_crust, lenz,
    nn_crust, one_sided_hnn_crust, one_step_crust, peel, regular_shape, sig_connect2d, vicur,
};
use crate::graphs::{
    MOST_FOR_PAIRS, bc0, beta_skeleton, delaunay, emst, gabriel, gamma_neighbourhood,
    lune_beta_skeleton, rng, sig, sigdt,
};
use crate::{Graph, Triangulation};

/// A method that makes a graph of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// [`delaunay`].
    Delaunay,
    /// [`emst`].
    Emst,
    /// [`rng`].
    Rng,
    /// [`gabriel`].
    Gabriel,
    /// [`sig`].
    Sig,
    /// [`sigdt`].
    Sigdt,
    /// [`beta_skeleton`].
    Beta,
    /// [`lune_beta_skeleton`].
    BetaLune,
    /// [`gamma_neighbourhood`].
    Gamma,
    /// [`bc0`].
    Bc0,
    /// [`crust`].
    Crust,
    /// [`one_step_crust`].
    OneStepCrust,
    /// [`nn_crust`].
    NnCrust,
    /// [`hnn_crust`].
    HnnCrust,
    /// [`conservative_crust`].
    ConservativeCrust,
    /// [`crawl`].
    Crawl,
    /// [`peel`].
    Peel,
    /// [`connect2d`].
    Connect2d,
    /// [`sig_connect2d`].
    SigConnect2d,
    /// [`emst_curve`].
    EmstCurve,
    /// [`regular_shape`].
    RRegular,
    /// [`discur`].
    Discur,
    /// [`vicur`].
    Vicur,
    /// [`gathan`].
    Gathan,
    /// [`lenz`].
    Lenz,
}

/// Whether a method tells which samples are near each other, or the curve they are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A proximity graph.
    Graph,
    /// A curve.
    Curve,
}

/// Reason why a method cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MethodError {
    /// There is no such method.
    #[error("no method is called `{name}`: expected one of {expected}")]
    Unknown {
        /// The name.
        name: String,
        /// The names there are.
        expected: String,
    },
    /// A parameter the method does not have.
    #[error("{method} has no parameter `{name}`: expected {expected}")]
    NoParameter {
        /// The method.
        method: &'static str,
        /// The parameter.
        name: String,
        /// Those it has.
        expected: String,
    },
    /// A word that is no value.
    #[error("parameter `{name}`: expected a number, true or false, found `{found}`")]
    NotANumber {
        /// The parameter.
        name: String,
        /// The word.
        found: String,
    },
    /// A word without `=`.
    #[error("expected parameters as key=value,…, found `{found}`")]
    NoValue {
        /// The word.
        found: String,
    },
    /// A value out of range.
    #[error("{method}: expected {name} from {low} to {high}, found {found}")]
    OutOfRange {
        /// The method.
        method: &'static str,
        /// The parameter.
        name: &'static str,
        /// The least value allowed.
        low: f64,
        /// The largest.
        high: f64,
        /// The value.
        found: f64,
    },
    /// More samples than the method can take.
    #[error(
        "{method} with these parameters asks about every pair: expected at most {MOST_FOR_PAIRS} places, found {found}; \
         take fewer points, or parameters within the Delaunay triangulation"
    )]
    TooMany {
        /// The method.
        method: &'static str,
        /// How many there are.
        found: usize,
    },
}

impl Method {
    /// The method of a name as [`Method::name`] gives it.
    ///
    /// # Errors
    ///
    /// An unknown name.
    pub fn from_name(name: &str) -> Result<Method, MethodError> {
        Method::ALL.into_iter().find(|method| method.name() == name).ok_or_else(|| {
            let names: Vec<&str> = Method::ALL.iter().map(Method::name).collect();
            MethodError::Unknown { name: name.to_owned(), expected: names.join(", ") }
        })
    }

    /// The graph that the method makes.
    ///
    /// # Errors
    ///
    /// Parameters the method does not have or that are out of range; too many samples for a method that asks about every
    /// pair.
    pub fn run(
        &self,
        triangulation: &Triangulation,
        parameters: &Parameters,
    ) -> Result<Graph, MethodError> {
        parameters.check(self)?;
        let value = |name| parameters.value(self, name);
        let paired = |graph: Option<Graph>| {
            graph.ok_or(MethodError::TooMany { method: self.name(), found: triangulation.len() })
        };
        Ok(match self {
            Method::Delaunay => delaunay(triangulation),
            Method::Emst => emst(triangulation),
            Method::Rng => rng(triangulation),
            Method::Gabriel => gabriel(triangulation),
            Method::Sig => sig(triangulation),
            Method::Sigdt => sigdt(triangulation),
            Method::Beta => paired(beta_skeleton(triangulation, value("beta")))?,
            Method::BetaLune => lune_beta_skeleton(triangulation, value("beta")),
            Method::Gamma => {
                let gamma = [value("gamma0"), value("gamma1")];
                paired(gamma_neighbourhood(triangulation, gamma))?
            }
            Method::Bc0 => bc0(triangulation),
            Method::Crust => crust(triangulation),
            Method::OneStepCrust => one_step_crust(triangulation).crust,
            Method::NnCrust => nn_crust(triangulation),
            Method::HnnCrust if value("one_sided") > 0.0 => one_sided_hnn_crust(triangulation),
            Method::HnnCrust => hnn_crust(triangulation),
            Method::ConservativeCrust => conservative_crust(triangulation, value("rho")),
            Method::Crawl => crawl(triangulation),
            Method::Peel => peel(triangulation, value("delta")),
            Method::Connect2d => connect2d(triangulation),
            Method::SigConnect2d => sig_connect2d(triangulation),
            Method::EmstCurve => emst_curve(triangulation),
            Method::RRegular => regular_shape(triangulation, value("delta")),
            Method::Discur => discur(triangulation),
            Method::Vicur => vicur(triangulation, value("c")),
            Method::Gathan => gathan(triangulation, value("phi_deg"), value("rho")),
            Method::Lenz => lenz(triangulation, value("u"), value("phi_deg")),
        })
    }
}
