//! Integrals of functions of one variable that are smooth but for a few kinks.

/// The integral from `a` to `b`: Gauss-Legendre with 10 nodes, an interval halved until its halves agree to `tolerance`.
pub(crate) fn integral(f: &impl Fn(f64) -> f64, a: f64, b: f64, tolerance: f64) -> f64 {
    halved(f, [a, b], gauss(f, a, b), tolerance, 0)
}

fn halved(
    f: &impl Fn(f64) -> f64,
    [a, b]: [f64; 2],
    whole: f64,
    tolerance: f64,
    depth: u32,
) -> f64 {
    let middle = f64::midpoint(a, b);
    let (left, right) = (gauss(f, a, middle), gauss(f, middle, b));
    // A difference that is no number, or made of rounding, does not get smaller by halving.
    let is_far = (left + right - whole).abs() > tolerance.max(ROUNDING * (b - a).abs());
    if depth >= MAX_DEPTH || !is_far {
        return left + right;
    }
    halved(f, [a, middle], left, tolerance, depth + 1)
        + halved(f, [middle, b], right, tolerance, depth + 1)
}

/// A kink is enclosed in 2⁻⁴⁰ of the interval, where it no longer matters.
const MAX_DEPTH: u32 = 40;

/// What rounding may leave of an integrand of about 1.
const ROUNDING: f64 = 1e-13;

pub(crate) fn gauss(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let (centre, half) = (f64::midpoint(a, b), (b - a) / 2.0);
    let pairs = NODES
        .iter()
        .map(|&(node, weight)| weight * (f(centre - half * node) + f(centre + half * node)));
    half * pairs.sum::<f64>()
}

/// Positive nodes and weights of Gauss-Legendre with 10 nodes (Abramowitz and Stegun, table 25.4).
const NODES: [(f64, f64); 5] = [
    (0.148_874_338_981_631_2, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_05),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_of_smooth_and_kinked_functions_are_right() {
        assert!((integral(&|x: f64| x.powi(19), 0.0, 1.0, 1e-14) - 0.05).abs() < 1e-14);
        assert!((integral(&|x: f64| x.sin(), 0.0, 2.0, 1e-14) - (1.0 - 2_f64.cos())).abs() < 1e-14);
        let kinked = integral(&|x: f64| (x - 0.3).abs().powf(1.5), 0.0, 1.0, 1e-14);
        assert!((kinked - (0.3_f64.powf(2.5) + 0.7_f64.powf(2.5)) / 2.5).abs() < 1e-12);
    }
}
