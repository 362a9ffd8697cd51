//! What is known of each method.

use super::{Kind, Method, Parameter};
use crate::Condition;

impl Method {
    /// All methods: graphs first, then curves, then regions.
    pub const ALL: [Method; 51] = [
        Method::Delaunay,
        Method::Emst,
        Method::Rng,
        Method::Gabriel,
        Method::Sig,
        Method::Sigdt,
        Method::Beta,
        Method::BetaLune,
        Method::Gamma,
        Method::Bc0,
        Method::ShapeHull,
        Method::Crust,
        Method::OneStepCrust,
        Method::NnCrust,
        Method::HnnCrust,
        Method::ConservativeCrust,
        Method::Cocone,
        Method::Crawl,
        Method::VoronoiLabelling,
        Method::Peel,
        Method::Connect2d,
        Method::SigConnect2d,
        Method::EmstCurve,
        Method::EdgeExchange,
        Method::Sculpting,
        Method::BallPivoting,
        Method::RRegular,
        Method::Discur,
        Method::Vicur,
        Method::Gathan,
        Method::GathanG,
        Method::Tsp,
        Method::Lenz,
        Method::Hiyoshi,
        Method::Lee,
        Method::FitConnect,
        Method::StretchDenoise,
        Method::OptimalTransport,
        Method::AlphaCurve,
        Method::Alpha,
        Method::Chi,
        Method::A,
        Method::Rgg,
        Method::Ec,
        Method::Ct,
        Method::Discern,
        Method::SimpleShape,
        Method::Auto,
        Method::TriangleGrowing,
        Method::DelaunayPainting,
        Method::ColourByNumbers,
    ];

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        self.facts().0
    }

    /// Whether it makes a proximity graph, a curve or a region.
    pub fn kind(&self) -> Kind {
        match self {
            Method::Delaunay
            | Method::Emst
            | Method::Rng
            | Method::Gabriel
            | Method::Sig
            | Method::Sigdt
            | Method::Beta
            | Method::BetaLune
            | Method::Gamma
            | Method::Bc0
            | Method::ShapeHull => Kind::Graph,
            Method::Alpha
            | Method::Chi
            | Method::A
            | Method::Rgg
            | Method::Ec
            | Method::Ct
            | Method::Discern
            | Method::SimpleShape
            | Method::Auto
            | Method::TriangleGrowing
            | Method::DelaunayPainting
            | Method::ColourByNumbers => Kind::Region,
            _ => Kind::Curve,
        }
    }

    /// What is proven of it: the condition under which its edges are those of the curve. `none` if nothing is.
    pub fn guarantee(&self) -> &'static str {
        self.facts().1
    }

    /// The condition under which it is proven to find smooth closed curves; `None` if none is known or none can be checked.
    pub fn condition(&self) -> Option<Condition> {
        let none = Condition::default();
        Some(match self {
            Method::Crust => Condition { epsilon: Some(0.252), ..none },
            Method::NnCrust => Condition { epsilon: Some(1.0 / 3.0), ..none },
            Method::Cocone => Condition { epsilon: Some(0.05), ..none },
            Method::HnnCrust => Condition { rho: Some(0.9), ..none },
            Method::Hiyoshi => {
                Condition { epsilon: Some(1.0 / 3.0), uniformity: Some(1.46), ..none }
            }
            Method::SigConnect2d => Condition { epsilon: Some(0.5), uniformity: Some(2.0), ..none },
            Method::RRegular => Condition { spacing: Some(SIN_22_5_DEG), ..none },
            _ => return None,
        })
    }

    /// Where it comes from, and at what point the description is not that of its authors.
    pub fn source(&self) -> &'static str {
        self.facts().2
    }

    /// The parameters it takes.
    pub fn parameters(&self) -> &'static [Parameter] {
        match self {
            Method::Beta => &BETA,
            Method::BetaLune => &BETA_LUNE,
            Method::Gamma => &GAMMA,
            Method::HnnCrust => &HNN_CRUST,
            Method::ConservativeCrust => &CONSERVATIVE_CRUST,
            Method::Peel => &PEEL,
            Method::RRegular => &R_REGULAR,
            Method::Vicur => &VICUR,
            Method::Gathan | Method::GathanG => &GATHAN,
            Method::Lenz => &LENZ,
            Method::Lee => &LEE,
            Method::AlphaCurve => &ALPHA_CURVE,
            Method::Alpha => &ALPHA,
            Method::Chi => &CHI,
            Method::A => &A,
            Method::Rgg => &RGG,
            Method::Ec => &EC,
            Method::BallPivoting => &BALL_PIVOTING,
            Method::StretchDenoise => &STRETCH_DENOISE,
            Method::OptimalTransport => &OPTIMAL_TRANSPORT,
            Method::TriangleGrowing => &TRIANGLE_GROWING,
            Method::DelaunayPainting => &DELAUNAY_PAINTING,
            Method::ColourByNumbers => &COLOUR_BY_NUMBERS,
            _ => &[],
        }
    }
}

const BETA: [Parameter; 1] = [Parameter {
    name: "beta",
    default: 1.0,
    low: 1e-6,
    high: 1e6,
    meaning: "1 is the Gabriel graph; larger has fewer edges, below 1 more",
}];

const BETA_LUNE: [Parameter; 1] = [Parameter {
    name: "beta",
    default: 2.0,
    low: 1.0,
    high: 1e6,
    meaning: "1 is the Gabriel graph, 2 the relative neighbourhood graph",
}];

const GAMMA: [Parameter; 2] = [
    Parameter {
        name: "gamma0",
        default: 0.0,
        low: -1.0,
        high: 1.0,
        meaning: "disc on one side: radius |pq|/(2(1-|γ|)), larger part if above 0",
    },
    Parameter {
        name: "gamma1",
        default: 0.0,
        low: -1.0,
        high: 1.0,
        meaning: "disc on the other side",
    },
];

const HNN_CRUST: [Parameter; 1] = [Parameter {
    name: "one_sided",
    default: 0.0,
    low: 0.0,
    high: 1.0,
    meaning: "true keeps edges that one end alone chose",
}];

const CONSERVATIVE_CRUST: [Parameter; 1] = [Parameter {
    name: "rho",
    default: 1.0,
    low: 1e-6,
    high: 1e6,
    meaning: "smaller leaves more edges out",
}];

const PEEL: [Parameter; 1] = [Parameter {
    name: "delta",
    default: 0.0,
    low: 0.0,
    high: 1e6,
    meaning: "above 0: ends with an edge L get their shortest missing edge below delta·L",
}];

const R_REGULAR: [Parameter; 1] = [Parameter {
    name: "delta",
    default: std::f64::consts::FRAC_PI_2,
    low: 1e-6,
    high: std::f64::consts::PI,
    meaning: "largest sum of the two opposite angles, radians",
}];

const VICUR: [Parameter; 1] = [Parameter {
    name: "c",
    default: 0.7,
    low: 0.0,
    high: 1.0,
    meaning: "weight of smoothness against nearness",
}];

const GATHAN: [Parameter; 2] = [
    Parameter {
        name: "phi_deg",
        default: 35.0,
        low: 0.01,
        high: 89.99,
        meaning: "largest angle between an edge and the tangent",
    },
    Parameter {
        name: "rho",
        default: 0.5,
        low: 0.0,
        high: 1e6,
        meaning: "least length of the Voronoi edge over that of the edge",
    },
];

const LENZ: [Parameter; 2] = [
    Parameter {
        name: "u",
        default: 2.5,
        low: 1e-6,
        high: 1e6,
        meaning: "largest step over the step before",
    },
    Parameter {
        name: "phi_deg",
        default: 60.0,
        low: 0.01,
        high: 89.99,
        meaning: "largest turn from one step to the next",
    },
];

const LEE: [Parameter; 1] = [Parameter {
    name: "h_mm",
    default: 0.0,
    low: 0.0,
    high: 1e12,
    meaning: "points within this distance are averaged, mm; 0 takes it from the points",
}];

const ALPHA_CURVE: [Parameter; 1] = [Parameter {
    name: "alpha_mm",
    default: 0.0,
    low: 0.0,
    high: 1e12,
    meaning: "radius of the discs, mm; 0 takes half the longest edge of the spanning tree",
}];

const ALPHA: [Parameter; 1] = [Parameter {
    name: "alpha_mm",
    default: 0.0,
    low: 0.0,
    high: 1e12,
    meaning: "largest radius of a triangle's circle, mm; 0 takes the smallest alpha with one part and all points",
}];

const CHI: [Parameter; 2] = [
    Parameter {
        name: "l_mm",
        default: 0.0,
        low: 0.0,
        high: 1e12,
        meaning: "longest side of the border that may stay, mm; 0 takes it from the points",
    },
    Parameter {
        name: "lambda",
        default: -1.0,
        low: -1.0,
        high: 1.0,
        meaning: "from 0 to 1 it sets l_mm: 0 the shortest edge, 1 the longest",
    },
];

const A: [Parameter; 2] = [
    Parameter {
        name: "alpha_mm",
        default: 0.0,
        low: 0.0,
        high: 1e12,
        meaning: "largest radius of a triangle's circle outside the set, mm; 0 takes one from the points",
    },
    Parameter {
        name: "t",
        default: 0.5,
        low: 0.0,
        high: 1.0,
        meaning: "0 asks for alpha_mm everywhere, 1 scales it by the spacing of the points",
    },
];

const HOLES: Parameter = Parameter {
    name: "holes",
    default: 0.0,
    low: 0.0,
    high: 1.0,
    meaning: "true looks for holes; in points at random it finds some that are none",
};

const RGG: [Parameter; 1] = [HOLES];

const EC: [Parameter; 2] = [
    Parameter {
        name: "v",
        default: 1.0,
        low: 1e-6,
        high: 1e6,
        meaning: "size of the circles; larger takes more away",
    },
    HOLES,
];

const BALL_PIVOTING: [Parameter; 1] = [Parameter {
    name: "radius_mm",
    default: 0.0,
    low: 0.0,
    high: 1e12,
    meaning: "radius of the disc, mm; 0 takes five from the points, each twice the one before",
}];

const STRETCH_DENOISE: [Parameter; 1] = [Parameter {
    name: "noise_mm",
    default: 0.0,
    low: 0.0,
    high: 1e12,
    meaning: "how far a point may move, mm; 0 takes it from the points, each for itself",
}];

const OPTIMAL_TRANSPORT: [Parameter; 3] = [
    Parameter {
        name: "vertices",
        default: 0.0,
        low: 0.0,
        high: 1e8,
        meaning: "how many vertices stay; 0 goes by tolerance_mm",
    },
    Parameter {
        name: "tolerance_mm",
        default: 0.0,
        low: 0.0,
        high: 1e12,
        meaning: "root mean square way of a point to the curve, mm; 0 takes it from the points",
    },
    Parameter {
        name: "relevance",
        default: 25.0,
        low: 0.0,
        high: 1e12,
        meaning: "least square of an edge's length over the mean square way of its points",
    },
];

const GAP: Parameter = Parameter {
    name: "gap_mm",
    default: 0.0,
    low: 0.0,
    high: 1e12,
    meaning: "widest gap that is closed, mm; 0 takes three times the spacing of nine points in ten",
};

const TRIANGLE_GROWING: [Parameter; 2] = [
    GAP,
    Parameter {
        name: "mask_mm",
        default: 0.0,
        low: 0.0,
        high: 1e12,
        meaning: "a region has a triangle larger than the square of this, mm; 0 takes gap_mm",
    },
];

const DELAUNAY_PAINTING: [Parameter; 1] = [Parameter {
    name: "brush_mm",
    default: 0.0,
    low: 0.0,
    high: 1e12,
    meaning: "lines of points nearer to each other than this do not stop a label, mm; 0 for all do",
}];

const COLOUR_BY_NUMBERS: [Parameter; 1] = [GAP];

/// sin(π/8), the bound of the spacing of r-regular shapes.
const SIN_22_5_DEG: f64 = 0.382_683_432_365_089_8;
