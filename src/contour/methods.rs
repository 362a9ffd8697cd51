//! The methods by name: parameters, guarantee, source.

mod facts;
mod list;
mod parameters;

use thiserror::Error;

pub use self::parameters::{Parameter, Parameters};
use crate::curves::{
    MOST_FOR_EXCHANGE, MOST_FOR_MATCHING, MOST_FOR_TOUR, MovedCurve, Transport, ball_pivoting,
    cocone, connect2d, conservative_crust, crawl, crust, discur, edge_exchange, emst_curve,
    fit_connect, gathan, gathan_g, hiyoshi, hnn_crust, lee, lee_reach_mm, lenz, nn_crust,
    one_sided_hnn_crust, one_step_curve, optimal_transport, peel, pivoting_radii_mm, regular_shape,
    sig_connect2d, stretch_denoise, transport_tolerance_mm, tsp, vicur, voronoi_labelling,
};
use crate::graphs::{
    MOST_FOR_PAIRS, bc0, beta_skeleton, delaunay, emst, gabriel, gamma_neighbourhood,
    lune_beta_skeleton, rng, sig, sigdt,
};
use crate::regions::{
    a_shape, alpha_curve, alpha_shape, auto_shape, chi_default_mm, chi_length_mm, chi_shape,
    connecting_a_mm, connecting_alpha_mm, ct_shape, discern, ec_shape, joining_alpha_mm,
    relaxed_gabriel, sculpting, shape_hull_graph, simple_shape,
};
use crate::strokes::{
    Hint, HintError, Strokes, closing_gap_mm, colour_by_numbers, delaunay_painting,
    triangle_growing,
};
use crate::{FoundCurve, Graph, Region, Triangulation};

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
    /// [`shape_hull_graph`].
    ShapeHull,
    /// [`crust`].
    Crust,
    /// [`one_step_crust`](crate::curves::one_step_crust).
    OneStepCrust,
    /// [`nn_crust`].
    NnCrust,
    /// [`hnn_crust`].
    HnnCrust,
    /// [`conservative_crust`].
    ConservativeCrust,
    /// [`cocone`].
    Cocone,
    /// [`crawl`].
    Crawl,
    /// [`voronoi_labelling`].
    VoronoiLabelling,
    /// [`peel`].
    Peel,
    /// [`connect2d`].
    Connect2d,
    /// [`sig_connect2d`].
    SigConnect2d,
    /// [`emst_curve`].
    EmstCurve,
    /// [`edge_exchange`].
    EdgeExchange,
    /// [`sculpting`].
    Sculpting,
    /// [`ball_pivoting`].
    BallPivoting,
    /// [`regular_shape`].
    RRegular,
    /// [`discur`].
    Discur,
    /// [`vicur`].
    Vicur,
    /// [`gathan`].
    Gathan,
    /// [`gathan_g`].
    GathanG,
    /// [`tsp`].
    Tsp,
    /// [`lenz`].
    Lenz,
    /// [`hiyoshi`].
    Hiyoshi,
    /// [`lee`].
    Lee,
    /// [`fit_connect`].
    FitConnect,
    /// [`stretch_denoise`].
    StretchDenoise,
    /// [`optimal_transport`].
    OptimalTransport,
    /// [`alpha_curve`].
    AlphaCurve,
    /// [`alpha_shape`].
    Alpha,
    /// [`chi_shape`].
    Chi,
    /// [`a_shape`].
    A,
    /// [`relaxed_gabriel`].
    Rgg,
    /// [`ec_shape`].
    Ec,
    /// [`ct_shape`].
    Ct,
    /// [`discern`].
    Discern,
    /// [`simple_shape`].
    SimpleShape,
    /// [`auto_shape`].
    Auto,
    /// [`triangle_growing`].
    TriangleGrowing,
    /// [`delaunay_painting`].
    DelaunayPainting,
    /// [`colour_by_numbers`].
    ColourByNumbers,
}

/// Kind of what a method makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A proximity graph.
    Graph,
    /// A curve.
    Curve,
    /// An area: parts with holes.
    Region,
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
    /// Hints that cannot be used.
    #[error(transparent)]
    Hints(#[from] HintError),
    /// More samples than the method can take.
    #[error(
        "{method} with these parameters takes time that grows with the square of the points or faster: expected at most {most} \
         places, found {found}; take fewer points, or a method or parameters without this limit"
    )]
    TooMany {
        /// The method.
        method: &'static str,
        /// How many it takes.
        most: usize,
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

    /// The graph that the method makes; of a region its border.
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
        match self.region(triangulation, parameters)? {
            Some(region) => Ok(region.border().clone()),
            None => self.graph(triangulation, parameters),
        }
    }

    /// The curve that the method makes, with the places that it goes through if those are not the samples; of a region its border.
    ///
    /// # Errors
    ///
    /// As [`Method::run`].
    pub fn curve(
        &self,
        triangulation: &Triangulation,
        parameters: &Parameters,
    ) -> Result<FoundCurve, MethodError> {
        let parameters = self.chosen(triangulation, parameters)?;
        let moved = match self {
            Method::Lee if parameters.value(self, "h_mm") > 0.0 => {
                lee(triangulation, parameters.value(self, "h_mm"))
            }
            Method::FitConnect => fit_connect(triangulation),
            Method::StretchDenoise => {
                stretch_denoise(triangulation, parameters.value(self, "noise_mm"))
            }
            Method::OptimalTransport => self.transported(triangulation, &parameters),
            _ => {
                let graph = self.run(triangulation, &parameters)?;
                return Ok(FoundCurve { graph, ..FoundCurve::default() });
            }
        };
        Ok(FoundCurve {
            graph: moved.graph,
            places_mm: Some(moved.places_mm),
            sigma_mm: Some(moved.sigma_mm),
        })
    }

    /// The region that the method makes; none if it makes a graph or a curve.
    ///
    /// # Errors
    ///
    /// Parameters the method does not have or that are out of range.
    pub fn region(
        &self,
        triangulation: &Triangulation,
        parameters: &Parameters,
    ) -> Result<Option<Region>, MethodError> {
        let parameters = self.chosen(triangulation, parameters)?;
        let value = |name| parameters.value(self, name);
        // No triangles: no length could be chosen, and nothing encloses an area.
        let within = |alpha_mm: f64, shape: &dyn Fn(f64) -> Region| {
            if alpha_mm > 0.0 { shape(alpha_mm) } else { Region::default() }
        };
        Ok(Some(match self {
            Method::Alpha => {
                within(value("alpha_mm"), &|alpha_mm| alpha_shape(triangulation, alpha_mm))
            }
            Method::Chi => chi_shape(triangulation, value("l_mm")),
            Method::A => {
                let t = value("t");
                within(value("alpha_mm"), &|alpha_mm| a_shape(triangulation, alpha_mm, t))
            }
            Method::Rgg => relaxed_gabriel(triangulation, value("holes") > 0.0),
            Method::Ec => ec_shape(triangulation, value("v"), value("holes") > 0.0),
            Method::Ct => ct_shape(triangulation),
            Method::Discern => discern(triangulation),
            Method::SimpleShape => simple_shape(triangulation),
            Method::Auto => auto_shape(triangulation),
            _ if self.takes_hints() => Region::default(),
            _ => return Ok(self.strokes(triangulation, &parameters, &[])?.map(|it| it.region)),
        }))
    }

    /// Whether it takes points of strokes round areas, and nothing of points that fill them.
    pub fn is_of_strokes(&self) -> bool {
        matches!(self, Method::TriangleGrowing) || self.takes_hints()
    }

    /// Whether it needs hints that name places within regions; without them [`Method::region`] is empty.
    pub fn takes_hints(&self) -> bool {
        matches!(self, Method::DelaunayPainting | Method::ColourByNumbers)
    }

    /// The regions and lines that the method makes of strokes; none of other methods. Hints count where the method takes them.
    ///
    /// # Errors
    ///
    /// Parameters the method does not have or that are out of range; hints that cannot be used, or none where the method needs them.
    pub fn strokes(
        &self,
        triangulation: &Triangulation,
        parameters: &Parameters,
        hints: &[Hint],
    ) -> Result<Option<Strokes>, MethodError> {
        let parameters = self.chosen(triangulation, parameters)?;
        let value = |name| parameters.value(self, name);
        Ok(Some(match self {
            Method::TriangleGrowing => {
                let (gap_mm, mask_mm) = (value("gap_mm"), value("mask_mm"));
                let mask_mm = if mask_mm > 0.0 { mask_mm } else { gap_mm };
                triangle_growing(triangulation, gap_mm, mask_mm)
            }
            Method::DelaunayPainting => delaunay_painting(triangulation, hints, value("brush_mm"))?,
            Method::ColourByNumbers => colour_by_numbers(triangulation, hints, value("gap_mm"))?,
            _ => return Ok(None),
        }))
    }

    /// The parameters with the lengths that the method takes from the points where 0 stands for that; a run with them gives the
    /// same.
    ///
    /// # Errors
    ///
    /// Parameters the method does not have or that are out of range.
    pub fn chosen(
        &self,
        triangulation: &Triangulation,
        parameters: &Parameters,
    ) -> Result<Parameters, MethodError> {
        parameters.check(self)?;
        let value = |name| parameters.value(self, name);
        let (name, length_mm) = match self {
            Method::Alpha if value("alpha_mm") == 0.0 => {
                ("alpha_mm", connecting_alpha_mm(triangulation))
            }
            Method::A if value("alpha_mm") == 0.0 => {
                ("alpha_mm", connecting_a_mm(triangulation, value("t")))
            }
            Method::AlphaCurve if value("alpha_mm") == 0.0 => {
                ("alpha_mm", joining_alpha_mm(triangulation))
            }
            Method::OptimalTransport
                if value("vertices") == 0.0 && value("tolerance_mm") == 0.0 =>
            {
                ("tolerance_mm", transport_tolerance_mm(triangulation))
            }
            Method::TriangleGrowing | Method::ColourByNumbers if value("gap_mm") == 0.0 => {
                ("gap_mm", closing_gap_mm(triangulation))
            }
            Method::Lee if value("h_mm") == 0.0 => ("h_mm", lee_reach_mm(triangulation)),
            Method::Chi if value("lambda") >= 0.0 => {
                ("l_mm", chi_length_mm(triangulation, value("lambda")))
            }
            Method::Chi if value("l_mm") == 0.0 => ("l_mm", chi_default_mm(triangulation)),
            _ => return Ok(parameters.clone()),
        };
        let parameters = parameters.clone();
        Ok(match length_mm {
            Some(length_mm) => parameters.with(name, length_mm),
            None => parameters,
        })
    }

    fn graph(
        &self,
        triangulation: &Triangulation,
        parameters: &Parameters,
    ) -> Result<Graph, MethodError> {
        let parameters = self.chosen(triangulation, parameters)?;
        let value = |name| parameters.value(self, name);
        let limited = |most: usize, graph: Option<Graph>| {
            let found = triangulation.len();
            graph.ok_or(MethodError::TooMany { method: self.name(), most, found })
        };
        Ok(match self {
            Method::Delaunay => delaunay(triangulation),
            Method::Emst => emst(triangulation),
            Method::Rng => rng(triangulation),
            Method::Gabriel => gabriel(triangulation),
            Method::Sig => sig(triangulation),
            Method::Sigdt => sigdt(triangulation),
            Method::Beta => limited(MOST_FOR_PAIRS, beta_skeleton(triangulation, value("beta")))?,
            Method::BetaLune => lune_beta_skeleton(triangulation, value("beta")),
            Method::Gamma => {
                let gamma = [value("gamma0"), value("gamma1")];
                limited(MOST_FOR_PAIRS, gamma_neighbourhood(triangulation, gamma))?
            }
            Method::Bc0 => bc0(triangulation),
            Method::Crust => crust(triangulation),
            Method::OneStepCrust => one_step_curve(triangulation),
            Method::NnCrust => nn_crust(triangulation),
            Method::HnnCrust if value("one_sided") > 0.0 => {
                one_sided_hnn_crust(triangulation.samples())
            }
            Method::HnnCrust => hnn_crust(triangulation.samples()),
            Method::ConservativeCrust => conservative_crust(triangulation, value("rho")),
            Method::Cocone => cocone(triangulation),
            Method::Crawl => crawl(triangulation),
            Method::VoronoiLabelling => voronoi_labelling(triangulation),
            Method::Peel => peel(triangulation, value("delta")),
            Method::Connect2d => connect2d(triangulation),
            Method::SigConnect2d => sig_connect2d(triangulation),
            Method::EmstCurve => emst_curve(triangulation),
            Method::RRegular => regular_shape(triangulation, value("delta")),
            Method::Discur => discur(triangulation),
            Method::Vicur => vicur(triangulation, value("c")),
            Method::Gathan => gathan(triangulation, value("phi_deg"), value("rho")),
            Method::Lenz => lenz(triangulation, value("u"), value("phi_deg")),
            Method::Lee if value("h_mm") > 0.0 => lee(triangulation, value("h_mm")).graph,
            Method::GathanG => gathan_g(triangulation, value("phi_deg"), value("rho")),
            Method::Sculpting => sculpting(triangulation),
            Method::BallPivoting => {
                ball_pivoting(triangulation, &radii_mm(triangulation, value("radius_mm")))
            }
            Method::Hiyoshi => limited(MOST_FOR_MATCHING, hiyoshi(triangulation))?,
            Method::EdgeExchange => limited(MOST_FOR_EXCHANGE, edge_exchange(triangulation))?,
            Method::Tsp => limited(MOST_FOR_TOUR, tsp(triangulation))?,
            Method::FitConnect | Method::StretchDenoise => fit_connect(triangulation).graph,
            Method::OptimalTransport => self.transported(triangulation, &parameters).graph,
            Method::ShapeHull => shape_hull_graph(triangulation),
            Method::AlphaCurve if value("alpha_mm") > 0.0 => {
                alpha_curve(triangulation, value("alpha_mm"))
            }
            // Of one sample no length can be chosen; regions are made elsewhere.
            _ => Graph::default(),
        })
    }

    fn transported(&self, triangulation: &Triangulation, parameters: &Parameters) -> MovedCurve {
        let value = |name| parameters.value(self, name);
        let settings = Transport {
            vertices: value("vertices") as usize,
            tolerance_mm: value("tolerance_mm"),
            relevance: value("relevance"),
        };
        optimal_transport(triangulation, settings)
    }
}

/// The radii of [`ball_pivoting`]: the one given, or those that the points ask for.
fn radii_mm(triangulation: &Triangulation, given_mm: f64) -> Vec<f64> {
    if given_mm > 0.0 { vec![given_mm] } else { pivoting_radii_mm(triangulation) }
}
