//! Vectors in space.

pub(crate) type Vector = [f64; 3];

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a` + `times`·`b`.
pub(crate) fn plus(a: Vector, times: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|axis| a[axis] + times * b[axis])
}

pub(crate) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of length 1; `None` of one without a length.
pub(crate) fn unit(a: Vector) -> Option<Vector> {
    let long = length(a);
    (long > 0.0 && long.is_finite()).then(|| a.map(|side| side / long))
}
