//! Vectors in space.

/// Its parts along x, y and z.
pub type Vector = [f64; 3];

/// `a` less `b`.
#[inline(always)]
pub fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Scalar product.
#[inline(always)]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
#[inline(always)]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a` + `times`·`b`.
#[inline(always)]
pub fn plus(a: Vector, times: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|axis| a[axis] + times * b[axis])
}

/// Euclidean length.
#[inline(always)]
pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector of length 1; `None` of one without a length.
#[inline(always)]
pub fn unit(a: Vector) -> Option<Vector> {
    let long = length(a);
    (long > 0.0 && long.is_finite()).then(|| a.map(|side| side / long))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_and_lengths() {
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!([cross(x, y), cross(y, z), cross(z, x)], [z, x, y]);
        assert_eq!((dot([1.0, 2.0, 3.0], [4.0, -5.0, 6.0]), length([2.0, 3.0, 6.0])), (12.0, 7.0));
        assert_eq!(plus(minus(x, y), 2.0, y), [1.0, 1.0, 0.0]);
        assert_eq!(unit([0.0, 0.0, -4.0]), Some([0.0, 0.0, -1.0]));
        assert_eq!(
            (unit([0.0; 3]), unit([f64::NAN, 0.0, 1.0]), unit([1e308; 3])),
            (None, None, None)
        );
    }
}
