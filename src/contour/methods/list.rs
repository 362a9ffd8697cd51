//! What is known of each method.

use super::{Kind, Method, Parameter};

impl Method {
    /// All methods: graphs first, then curves.
    pub const ALL: [Method; 25] = [
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
        Method::Crust,
        Method::OneStepCrust,
        Method::NnCrust,
        Method::HnnCrust,
        Method::ConservativeCrust,
        Method::Crawl,
        Method::Peel,
        Method::Connect2d,
        Method::SigConnect2d,
        Method::EmstCurve,
        Method::RRegular,
        Method::Discur,
        Method::Vicur,
        Method::Gathan,
        Method::Lenz,
    ];

    /// The name on the command line.
    pub fn name(&self) -> &'static str {
        self.facts().0
    }

    /// Whether it makes a proximity graph or a curve.
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
            | Method::Bc0 => Kind::Graph,
            _ => Kind::Curve,
        }
    }

    /// What is proven of it: the condition under which its edges are those of the curve. `none` if nothing is.
    pub fn guarantee(&self) -> &'static str {
        self.facts().1
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
            Method::Gathan => &GATHAN,
            Method::Lenz => &LENZ,
            _ => &[],
        }
    }

    /// Name, guarantee and source.
    fn facts(&self) -> (&'static str, &'static str, &'static str) {
        const DENSE: &str = "dense, nearly uniform samples of smooth curves (no bound stated)";
        match self {
            Method::Delaunay => ("delaunay", "none", "the mesh of this program"),
            Method::Emst => ("emst", DENSE, "Figueiredo, de Miranda Gomes 1994"),
            Method::Rng => ("rng", "none", "Toussaint 1980"),
            Method::Gabriel => ("gabriel", "none", "Gabriel, Sokal 1969"),
            Method::Sig => ("sig", "none", "Toussaint 1988"),
            Method::Sigdt => ("sigdt", "none", "edges of sig in the Delaunay triangulation"),
            Method::Beta => ("beta", "none", "Kirkpatrick, Radke 1985, circles"),
            Method::BetaLune => {
                ("beta-lune", "none", "Kirkpatrick, Radke 1985, lunes; text not at hand")
            }
            Method::Gamma => ("gamma", "none", "Veltkamp 1992; text not at hand"),
            Method::Bc0 => ("bc0", "none", "Ohrhallinger, Mudur 2013; text not at hand"),
            Method::Crust => {
                ("crust", "smooth closed curves, ε < 0.252", "Amenta, Bern, Eppstein 1998")
            }
            Method::OneStepCrust => {
                ("one-step-crust", "none stated here", "Gold, Snoeyink 2001; text not at hand")
            }
            Method::NnCrust => ("nn-crust", "smooth closed curves, ε < 1/3", "Dey, Kumar 1999"),
            Method::HnnCrust => (
                "hnn-crust",
                "smooth closed curves, ρ < 0.9 (ε < 0.47)",
                "Ohrhallinger, Mitchell, Wimmer 2016",
            ),
            Method::ConservativeCrust => (
                "conservative-crust",
                "no edge without a reason in the samples (no bound stated)",
                "Dey, Mehlhorn, Ramos 2000; text not at hand",
            ),
            Method::Crawl => {
                ("crawl", "none", "Parakkat, Muthuganapathy 2016, as its public program")
            }
            Method::Peel => (
                "peel",
                "none",
                "Parakkat, Methirumangalath, Muthuganapathy 2018, as its public program",
            ),
            Method::Connect2d => (
                "connect2d",
                "one closed curve (no bound)",
                "Ohrhallinger, Mudur 2013; text not at hand",
            ),
            Method::SigConnect2d => (
                "sig-connect2d",
                "closed curves, ε < 0.5, neighbouring edges of a ratio below 2",
                "Marin, Ohrhallinger, Wimmer 2022; text not at hand; nesting is our choice",
            ),
            Method::EmstCurve => (
                "emst-curve",
                DENSE,
                "Figueiredo, de Miranda Gomes 1994; when it closes is our choice",
            ),
            Method::RRegular => (
                "r-regular",
                "borders that discs of radius r roll along on both sides, spacing < sin(π/8)·r",
                "Attali 1997; text not at hand",
            ),
            Method::Discur => (
                "discur",
                "a condition of its own (not stated here)",
                "Zeng, Nguyen, Yan, Li 2008, as a public program",
            ),
            Method::Vicur => ("vicur", "none", "Nguyen, Zeng 2008, as a public program"),
            Method::Gathan => (
                "gathan",
                "none",
                "Dey, Wenger 2001; text not at hand, order and angles are our choice",
            ),
            Method::Lenz => (
                "lenz",
                "none (ε < 0.48 claimed)",
                "Lenz 2006; text not at hand, the probe is our choice",
            ),
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
