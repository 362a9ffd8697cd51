//! Forbes' polynomials against closed forms, prysm and their orthogonality.

use asphera_form::shape::{ConicSection, Projection, QAsphere, Shape};

const TERMS: usize = 21;

/// A single polynomial with its envelope over the unit disc, on a flat base.
fn bfs(m: usize) -> QAsphere {
    QAsphere::bfs(ConicSection::FLAT, 1.0, Projection::ConicNormal, &unit(m)).unwrap()
}

fn con(m: usize) -> QAsphere {
    QAsphere::con(ConicSection::FLAT, 1.0, &unit(m)).unwrap()
}

fn unit(m: usize) -> Vec<f64> {
    (0..=m).map(|index| if index == m { 1.0 } else { 0.0 }).collect()
}

/// Holds `Σ a·Q` for single terms, and the derivatives by the coefficients, against an expected value.
fn hold(make: fn(usize) -> QAsphere, m: usize, u: f64, expected: f64, tolerance: f64) {
    let sum = make(m).sag_mm(u, 0.0).unwrap();
    assert!((sum - expected).abs() <= tolerance, "Q{m}({u}): {sum}, not {expected}");
    let mut by = vec![f64::NAN; TERMS];
    make(TERMS - 1).by_parameters(0.0, u, &mut by).unwrap();
    assert!((by[m] - expected).abs() <= tolerance, "dz/dQ{m} at {u}: {}, not {expected}", by[m]);
}

/// Closed forms of the first six, Forbes, Opt. Express 15 (2007) 5218.
#[test]
fn closed_forms() {
    for step in 0..=40 {
        let u = f64::from(step) / 40.0;
        let x = u * u;
        let slope_orthogonal = [
            1.0,
            (13.0 - 16.0 * x) / 19_f64.sqrt(),
            (2.0 / 95.0_f64).sqrt() * (29.0 - 4.0 * x * (25.0 - 19.0 * x)),
            (2.0 / 2545.0_f64).sqrt() * (207.0 - 4.0 * x * (315.0 - x * (577.0 - 320.0 * x))),
            (7737.0 - 16.0 * x * (4653.0 - 2.0 * x * (7381.0 - 8.0 * x * (1168.0 - 509.0 * x))))
                / (3.0 * 131_831_f64.sqrt()),
            (66657.0
                - 32.0
                    * x
                    * (28338.0
                        - x * (135_325.0 - 8.0 * x * (35884.0 - x * (34661.0 - 12432.0 * x)))))
                / (3.0 * 6_632_213_f64.sqrt()),
        ];
        let sag_orthogonal = [
            1.0,
            -(5.0 - 6.0 * x),
            15.0 - 14.0 * x * (3.0 - 2.0 * x),
            -(35.0 - 12.0 * x * (14.0 - x * (21.0 - 10.0 * x))),
            70.0 - 3.0 * x * (168.0 - 5.0 * x * (84.0 - 11.0 * x * (8.0 - 3.0 * x))),
            -(126.0
                - x * (1260.0 - 11.0 * x * (420.0 - x * (720.0 - 13.0 * x * (45.0 - 14.0 * x))))),
        ];
        for m in 0..6 {
            hold(bfs, m, u, x * (1.0 - x) * slope_orthogonal[m], 1e-13);
            hold(con, m, u, x * x * sag_orthogonal[m], 1e-12);
        }
    }
}

/// Orders m of [`PRYSM`].
const ORDERS: [usize; 7] = [0, 1, 2, 3, 5, 9, 20];
/// Places u, and `Qbfs(m, u)` and `Qcon(m, u)` of prysm 0.21.1 there.
const PRYSM: [(f64, [f64; 7], [f64; 7]); 5] = [
    (
        0.1,
        [
            0.009900000000000003,
            0.029162410426690336,
            0.04023132027271071,
            0.05401507838623314,
            0.07433757684628975,
            0.09629188226167584,
            0.04207632926795108,
        ],
        [
            0.00010000000000000002,
            -0.0004940000000000001,
            0.00145828,
            -0.0033345080000000004,
            -0.011385414414979996,
            -0.055190706568755035,
            0.34981778808622893,
        ],
    ),
    (
        0.35,
        [
            0.10749375,
            0.2722547632719456,
            0.279034742493874,
            0.25593096337360455,
            0.07761695246668336,
            0.018701992683069605,
            0.047645813966529095,
        ],
        [
            0.015006249999999995,
            -0.06400165624999997,
            0.15419184484374993,
            -0.2698271280195311,
            -0.41737883960615835,
            0.1539284125100714,
            -0.2106293302721334,
        ],
    ),
    (
        0.5,
        [
            0.1875,
            0.3871390509065729,
            0.23804689456734762,
            0.08541334728484054,
            -0.03349113539530055,
            0.030789358986757026,
            0.03751600109119034,
        ],
        [
            0.0625,
            -0.21875,
            0.39062500000000006,
            -0.4296875000000001,
            0.0511474609375,
            -0.19841670989990234,
            -0.08409531108975446,
        ],
    ),
    (
        0.8,
        [
            0.23039999999999997,
            0.14588638283122557,
            -0.12938726146986038,
            0.06725239567935011,
            -0.03451784626897472,
            -0.02417945940580898,
            0.013518516482961864,
        ],
        [
            0.4096000000000001,
            -0.4751359999999998,
            -0.16842752000000039,
            0.3105095679999997,
            -0.17295623585791947,
            0.09190926265246145,
            -0.16735864300829,
        ],
    ),
    (
        0.97,
        [
            0.055607190000000035,
            -0.02620831834270627,
            0.017687845194338945,
            -0.0023107660822896904,
            0.018538831532183643,
            0.017109398506527165,
            -0.00811649307697617,
        ],
        [
            0.8852928099999999,
            0.5713679795739998,
            0.23938200723749048,
            -0.05838287283602635,
            -0.39476897329124677,
            0.014538114272790878,
            -0.17348854072611117,
        ],
    ),
];

#[test]
fn table_of_prysm() {
    for (u, slope_orthogonal, sag_orthogonal) in PRYSM {
        for (index, &m) in ORDERS.iter().enumerate() {
            hold(bfs, m, u, slope_orthogonal[index], 1e-13);
            hold(con, m, u, sag_orthogonal[index], 1e-13);
        }
    }
}

/// The slopes of u²(1−u²)·Q^bfs are orthonormal under the mean with the weight 1/√(1−u²), which
/// Chebyshev's quadrature takes exactly.
#[test]
fn slopes_of_q_bfs_are_orthonormal() {
    let nodes = 128;
    let shapes: Vec<_> = (0..TERMS).map(bfs).collect();
    for m in 0..TERMS {
        for n in 0..=m {
            let mean: f64 = (0..nodes)
                .map(|i| {
                    let u = ((f64::from(i) + 0.5) * std::f64::consts::FRAC_PI_2 / f64::from(nodes))
                        .cos();
                    let slope = |shape: &QAsphere| shape.jet(u, 0.0).unwrap().gradient[0];
                    slope(&shapes[m]) * slope(&shapes[n]) / f64::from(nodes)
                })
                .sum();
            let expected = if m == n { 1.0 } else { 0.0 };
            assert!((mean - expected).abs() < 1e-11, "{m} {n}: {mean}");
        }
    }
}

/// A departure along the normal of the sphere, added to it, is what the factor says to first order.
#[test]
fn departure_along_the_normal() {
    let base = ConicSection::new(20.0, -0.6).unwrap();
    let tiny = 1e-7;
    let on_axis = QAsphere::bfs(base, 12.0, Projection::Axis, &[tiny, 0.4 * tiny]).unwrap();
    let normal = QAsphere::bfs(base, 12.0, Projection::ConicNormal, &[tiny, 0.4 * tiny]).unwrap();
    let bare = asphera_form::shape::Conic::new(base);
    for r in [0.5, 3.0, 8.0, 11.9] {
        let base = bare.jet(r, 0.0).unwrap();
        let cosine = (1.0 + base.gradient[0].powi(2)).sqrt().recip();
        let departures = [&on_axis, &normal].map(|q| q.sag_mm(r, 0.0).unwrap() - base.z_mm);
        assert!((departures[1] * cosine - departures[0]).abs() < 1e-14);
    }
}
