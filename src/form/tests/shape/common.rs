//! Differences of heights, against which derivatives are held.

use asphera_form::shape::Shape;

/// A derivative by central differences with the steps h, h/2 and h/4, extrapolated twice (Richardson): the
/// error is of order h⁶.
pub(crate) fn slope(f: impl Fn(f64) -> f64, at: f64, step: f64) -> f64 {
    let difference = |h: f64| (f(at + h) - f(at - h)) / (2.0 * h);
    let [a, b, c] = [step, step / 2.0, step / 4.0].map(difference);
    let [ab, bc] = [(4.0 * b - a) / 3.0, (4.0 * c - b) / 3.0];
    (16.0 * bc - ab) / 15.0
}

/// Holds every derivative a shape gives at a place against differences of its heights and slopes over about
/// `step`, in mm, and with other parameters. `largest` is the largest height about, which rounds most.
pub(crate) fn check(shape: &dyn Shape, x: f64, y: f64, step: f64, largest: f64) {
    let jet = shape.jet(x, y).unwrap();
    let gradient = |x: f64, y: f64| shape.jet(x, y).unwrap().gradient;
    let sag = |x: f64, y: f64| shape.sag_mm(x, y).unwrap();
    let noise = 1e-12 * largest / step;
    let near = |name: &str, ours: f64, differences: f64, noise: f64| {
        let allowed = 1e-8 * differences.abs() + noise;
        assert!(
            (ours - differences).abs() <= allowed,
            "{name} of {shape:?} at ({x}, {y}): {ours} against {differences}, allowed {allowed}"
        );
    };
    near("height", jet.z_mm, sag(x, y), 1e-14 * largest);
    near("dz/dx", jet.gradient[0], slope(|x| sag(x, y), x, step), noise);
    near("dz/dy", jet.gradient[1], slope(|y| sag(x, y), y, step), noise);
    let noise = noise / step;
    let [xx, xy, yy] = jet.hessian_per_mm;
    near("d2z/dx2", xx, slope(|x| gradient(x, y)[0], x, step), noise);
    near("d2z/dxdy", xy, slope(|x| gradient(x, y)[1], x, step), noise);
    near("d2z/dydx", xy, slope(|y| gradient(x, y)[0], y, step), noise);
    near("d2z/dy2", yy, slope(|y| gradient(x, y)[1], y, step), noise);

    let parameters = shape.parameters();
    let mut ours = vec![f64::NAN; parameters.len()];
    shape.by_parameters(x, y, &mut ours).unwrap();
    let values: Vec<f64> = parameters.iter().map(|parameter| parameter.value).collect();
    for (index, parameter) in parameters.iter().enumerate() {
        let step = if values[index] == 0.0 { 1e-3 } else { 1e-3 * values[index].abs() };
        let with = |value: f64| {
            let mut values = values.clone();
            values[index] = value;
            shape.with_parameters(&values).unwrap().sag_mm(x, y).unwrap()
        };
        let noise = 1e-13 * largest / step;
        near(&parameter.name, ours[index], slope(with, values[index], step), noise);
    }
    let same = shape.with_parameters(&values).unwrap();
    assert_eq!(same.parameters(), parameters);
    assert_eq!(same.jet(x, y), Some(jet));
}

/// Whether two numbers agree to a relative tolerance.
pub(crate) fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs())
}
