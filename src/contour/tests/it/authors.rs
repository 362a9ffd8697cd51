//! Edges of the authors' programs, on points without ties.
//!
//! The programs, restated without their drawing, were run with CGAL 5.5 on these points. The README has more such comparisons.

use asphera_contour::{Method, Parameters};

use crate::places::{by_row, triangulation};
use crate::regions::region;

fn numbers<T: std::str::FromStr>(text: &str) -> Vec<[T; 2]> {
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{word}"));
    let pairs = text.split(';').map(str::split_whitespace);
    pairs.map(|mut words| [(); 2].map(|()| number(words.next().unwrap()))).collect()
}

#[test]
fn rough_curves_have_the_edges_of_the_programs() {
    let set = triangulation(&numbers(ROUGH));
    for (method, edges) in
        [(Method::HnnCrust, ROUGH_HNN), (Method::Crawl, ROUGH_CRAWL), (Method::Peel, ROUGH_PEEL)]
    {
        let found = method.run(&set, &Parameters::new()).unwrap();
        assert_eq!(by_row(&found, &set), numbers::<u32>(edges), "{}", method.name());
    }
}

#[test]
fn areas_have_the_borders_of_the_programs() {
    let set = triangulation(&numbers(RING));
    for (method, parameters, edges) in [
        (Method::Ec, "", RING_EC),
        (Method::Ec, "holes=true", RING_EC_HOLES),
        (Method::Ct, "", RING_CT),
        (Method::Discern, "", RING_DISCERN),
    ] {
        let border = region(method, &set, parameters);
        let found = by_row(border.border(), &set);
        assert_eq!(found, numbers::<u32>(edges), "{} {parameters}", method.name());
    }
}

/// Places about a curve with three lobes, off it by a fifteenth of its radius.
const ROUGH: &str = "\
    19.42 17.23; 21.31 17.8; 20.23 17.77; 17.98 21.06; 21.34 22.33; 22.92 20.39; 21.68 21.2; \
    19.59 23.8; 20.92 22.88; 21.55 17.62; 22.75 21.07; 20.39 17.53; 23.15 18.08; 17.39 19.39; \
    18.03 20.72; 23.72 18.92; 18.5 23.16; 17.05 18.23; 18.88 17.14; 17.67 20.46; 23.48 19; 16.59 \
    18.54; 19.67 23.51; 17.87 22.07; 21.53 21.31; 17.05 17.19; 21.58 21.36; 17.38 19.74; 23.08 \
    19.84; 22.4 17.74; 18.12 17.19; 20.12 17.99; 19.4 23.66; 18.26 21.44; 17.53 17.07; 21.26 \
    22.15";

/// Edges of HNN-Crust (S. Ohrhallinger, hnn-crust-sgp16).
const ROUGH_HNN: &str = "\
    0 18; 1 9; 1 11; 2 11; 2 31; 3 14; 3 33; 4 8; 4 35; 5 10; 5 28; 6 10; 6 24; 7 22; 7 32; 9 \
    29; 12 29; 13 21; 13 27; 14 19; 15 20; 16 23; 16 32; 17 21; 17 25; 18 30; 19 27; 20 28; 23 \
    33; 24 26; 25 34; 26 35; 30 34";

/// Edges of Crawl (A. D. Parakkat, Crawl_through_Neighbors).
const ROUGH_CRAWL: &str = "\
    0 18; 0 31; 1 9; 1 11; 2 11; 2 31; 3 14; 3 33; 4 8; 4 35; 5 10; 5 28; 6 10; 6 24; 7 22; 7 \
    32; 9 29; 12 15; 12 29; 13 21; 13 27; 14 19; 15 20; 16 23; 16 32; 17 21; 17 25; 18 30; 19 \
    27; 20 28; 23 33; 24 26; 25 34; 26 35; 30 34";

/// Edges of Peel without restored ones (A. D. Parakkat, Peeling_the_Longest).
const ROUGH_PEEL: &str = "\
    0 18; 1 9; 1 11; 2 11; 2 31; 3 14; 3 33; 4 8; 4 35; 5 10; 5 28; 6 10; 6 24; 7 22; 7 32; 8 \
    22; 9 29; 12 29; 13 21; 13 27; 14 19; 15 20; 16 23; 16 32; 17 21; 17 25; 18 30; 19 27; 20 \
    28; 23 33; 24 26; 25 34; 26 35; 30 34";

/// Places in a ring, no two nearer than 0.62.
const RING: &str = "\
    18.41 19.57; 17.55 20.56; 21.7 22.21; 18.96 17.66; 18.5 20.86; 22.41 19.35; 19.87 21.6; \
    20.67 21.46; 20.04 22.3; 19.61 17.73; 18.41 18.92; 18.96 18.57; 22.82 20.62; 17.29 19.93; \
    22.33 18.4; 20.71 22.49; 18.25 20.28; 20.17 17.25; 21.02 17.69; 19.17 21.87; 20.86 18.61; \
    18.37 21.47; 17.92 18.39; 21.63 21.4; 21.83 20.76; 22.86 19.93; 21.55 18.25; 17.71 21.44; \
    21.96 19.97; 20.15 18.37; 21.19 19.15; 21.13 20.77; 18.79 22.61; 19.18 21.05; 18.05 22.1; \
    22.39 21.63; 21.16 21.85; 21.96 18.91; 17.36 19.18; 19.55 22.75; 19.65 18.74; 21.35 19.79; \
    18.29 17.88";

/// Outer edges of the EC-shape (S. Methirumangalath and others, HoleDetection).
const RING_EC: &str = "\
    1 13; 1 16; 2 35; 2 36; 3 9; 3 42; 4 16; 4 21; 5 25; 5 37; 8 15; 8 39; 9 17; 12 24; 12 25; \
    13 38; 14 26; 14 37; 15 36; 17 18; 18 26; 21 27; 22 38; 22 42; 23 24; 23 35; 27 34; 32 34; \
    32 39";

/// Those and the edges of its hole.
const RING_EC_HOLES: &str = "\
    0 10; 0 33; 1 13; 1 16; 2 35; 2 36; 3 9; 3 42; 4 16; 4 21; 5 25; 5 37; 6 7; 6 33; 7 31; 8 \
    15; 8 39; 9 17; 10 11; 11 40; 12 24; 12 25; 13 38; 14 26; 14 37; 15 36; 17 18; 18 26; 20 29; \
    20 30; 21 27; 22 38; 22 42; 23 24; 23 35; 27 34; 29 40; 30 41; 31 41; 32 34; 32 39";

/// Edges of the CT-shape (S. B. Thayyil and others, Reconstruction).
const RING_CT: &str = "\
    0 10; 0 16; 1 13; 1 27; 2 35; 2 36; 3 9; 3 42; 4 16; 4 33; 5 25; 5 37; 6 7; 6 33; 7 31; 8 \
    15; 8 39; 9 17; 10 11; 11 40; 12 25; 12 35; 13 38; 14 26; 14 37; 15 36; 17 18; 18 26; 20 29; \
    20 30; 22 38; 22 42; 27 34; 29 40; 30 41; 31 41; 32 34; 32 39";

/// Edges of the shape of points of an area (S. B. Thayyil and others, Discern).
const RING_DISCERN: &str = "\
    0 11; 0 16; 1 13; 1 27; 2 15; 2 35; 3 17; 3 42; 5 14; 5 25; 6 7; 6 33; 7 31; 11 40; 12 25; \
    12 35; 13 38; 14 18; 15 39; 16 33; 17 18; 20 30; 20 40; 22 38; 22 42; 27 34; 30 41; 31 41; \
    32 34; 32 39";
