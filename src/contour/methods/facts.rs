//! Names of the methods, what is proven of them, and where they come from.

use super::{Kind, Method};

/// Name, guarantee and source.
type Facts = (&'static str, &'static str, &'static str);

const DENSE: &str = "dense, nearly uniform samples of smooth curves (no bound stated)";

/// Samples of an area, as the methods for regions ask for them.
const R_SAMPLES: &str = "samples of an area, at most 2r apart on its border, at least 2r within";

impl Method {
    pub(super) fn facts(&self) -> Facts {
        match self.kind() {
            Kind::Graph => of_graph(self),
            Kind::Curve => of_curve(self),
            Kind::Region => of_region(self),
        }
    }
}

fn of_graph(method: &Method) -> Facts {
    match method {
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
        Method::ShapeHull => {
            ("shape-hull", "none", "Peethambaran, Muthuganapathy 2015; text not at hand")
        }
        _ => UNNAMED,
    }
}

fn of_curve(method: &Method) -> Facts {
    match method {
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
        Method::Cocone => (
            "cocone",
            "smooth closed curves, ε < 0.05 (stated of surfaces)",
            "Amenta, Choi, Dey, Leekha 2002, in the plane; text not at hand, thinning is our choice",
        ),
        Method::Crawl => ("crawl", "none", "Parakkat, Muthuganapathy 2016, as its public program"),
        Method::VoronoiLabelling => (
            "voronoi-labelling",
            "none",
            "Parakkat, Methirumangalath, Muthuganapathy 2018, after a public program; text not at hand",
        ),
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
        Method::EmstCurve => {
            ("emst-curve", DENSE, "Figueiredo, de Miranda Gomes 1994; when it closes is our choice")
        }
        Method::RRegular => (
            "r-regular",
            "borders that discs of radius r roll along on both sides, spacing < sin(π/8)·r",
            "Attali 1997; text not at hand",
        ),
        _ => of_grown_curve(method),
    }
}

/// Of curves that are grown, exchanged edge by edge, or fitted.
fn of_grown_curve(method: &Method) -> Facts {
    match method {
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
        Method::Lee => (
            "lee",
            "none",
            "Lee 2000; text not at hand, distance, thinning and joining are our choice",
        ),
        Method::AlphaCurve => {
            ("alpha-curve", "none stated here", "Edelsbrunner, Kirkpatrick, Seidel 1983")
        }
        Method::GathanG => (
            "gathan-g",
            "none here (its authors: smooth pieces, samples even about each corner)",
            "Dey, Wenger 2002; text not at hand, order, angles and corners are our choice",
        ),
        Method::Sculpting => {
            ("sculpting", "none", "Boissonnat 1984, in the plane; text not at hand")
        }
        Method::BallPivoting => (
            "ball-pivoting",
            "none stated here",
            "Bernardini, Bajaj 1997, in the plane; text not at hand, radii, order and joining are our choice",
        ),
        Method::Hiyoshi => (
            "hiyoshi",
            "smooth closed curves, ε < 1/3, neighbouring edges of a ratio below 1.46",
            "Hiyoshi 2009; text not at hand",
        ),
        Method::EdgeExchange => (
            "edge-exchange",
            "none",
            "Ohrhallinger, Mudur 2011; text not at hand, the order of steps is our choice",
        ),
        Method::Tsp => (
            "tsp",
            "none here (the shortest tour: dense samples of one closed curve)",
            "Giesen 2000; text not at hand, a short tour instead of the shortest is our choice",
        ),
        Method::FitConnect => (
            "fit-connect",
            "none (curves within the noise found)",
            "Ohrhallinger, Wimmer 2019, after a description of its program; bound and order are our choice",
        ),
        Method::OptimalTransport => (
            "optimal-transport",
            "none (approximates; few vertices beside the points; slow in straight rows of even steps without noise)",
            "de Goes, Cohen-Steiner, Alliez, Desbrun 2011, after CGAL's manual; ties, flips, tolerance and relevance are our choice",
        ),
        Method::StretchDenoise => (
            "stretch-denoise",
            "no point moves by more than its noise",
            "Ohrhallinger, Wimmer 2018, after a description of its program; bound, order and noise not given are our choice",
        ),
        _ => UNNAMED,
    }
}

fn of_region(method: &Method) -> Facts {
    match method {
        Method::Alpha => {
            ("alpha", "none stated here", "Edelsbrunner, Kirkpatrick, Seidel 1983; their α is -1/α")
        }
        Method::Chi => (
            "chi",
            "none",
            "Duckham, Kulik, Worboys, Galton 2008; the default length is partly our choice",
        ),
        Method::A => (
            "a",
            "none",
            "Melkemi, Djebali 2000; text not at hand, what α and t choose is our choice",
        ),
        Method::Rgg => (
            "rgg",
            "samples of areas whose concavities are divergent (no bound stated)",
            "Peethambaran, Muthuganapathy 2015, as its public program",
        ),
        Method::Ec => (
            "ec",
            R_SAMPLES,
            "Methirumangalath, Parakkat, Muthuganapathy 2015, as its public program",
        ),
        Method::Ct => {
            ("ct", R_SAMPLES, "Thayyil, Parakkat, Muthuganapathy 2020, as its public program")
        }
        Method::Discern => (
            "discern",
            "nearest neighbours at the least reach of the concavities",
            "Thayyil, Peethambaran, Muthuganapathy 2021, as its public program",
        ),
        Method::SimpleShape => ("simple-shape", "none", "Gheibi and others 2011; text not at hand"),
        Method::Auto => (
            "auto",
            "none",
            "alpha at twice the median edge, its border moved out by 0.33 to 0.40 of that: our choice",
        ),
        Method::TriangleGrowing => (
            "triangle-growing",
            "none; sides longer than gap_mm are crossed, others never",
            "Parakkat, Pundarikaksha, Muthuganapathy 2018; text not at hand, gap, mask and middle line are our choice",
        ),
        Method::DelaunayPainting => (
            "delaunay-painting",
            "each place has the label that reaches it through the widest gaps; takes --hints",
            "Parakkat, Memari, Cani 2022; text not at hand, the brush is our choice",
        ),
        Method::ColourByNumbers => (
            "colour-by-numbers",
            "as delaunay-painting, across gaps wider than gap_mm only; takes --hints",
            "Parakkat, Cani, Singh 2021; text not at hand, gap and middle line are our choice",
        ),
        _ => UNNAMED,
    }
}

/// What no method has: each is listed with those of its kind, which a test holds.
const UNNAMED: Facts = ("", "", "");
