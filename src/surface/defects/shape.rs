//! Areas of triangles above a level, and the axes of a cloud of places.

/// What of a triangle lies above a level.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Above {
    /// Projected area in mm².
    pub(super) area_mm2: f64,
    /// Length of the level's line through it in mm.
    pub(super) contour_mm: f64,
}

/// The part of a triangle over which the linear interpolation of the values at its corners is above
/// a level.
pub(super) fn above(mut corners: [([f64; 2], f64); 3], level: f64) -> Above {
    corners.sort_by(|p, q| q.1.total_cmp(&p.1));
    let [(a, high), (b, middle), (c, low)] = corners;
    let area_mm2 = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs();
    if low > level {
        return Above { area_mm2, contour_mm: 0.0 };
    }
    if high <= level {
        return Above::default();
    }
    let cut = |p: [f64; 2], q: [f64; 2], from: f64, to: f64| {
        let share = (from - level) / (from - to);
        [0, 1].map(|axis| p[axis] + share * (q[axis] - p[axis]))
    };
    let (far, other, share) = if middle > level {
        let share = (level - low) * (level - low) / ((high - low) * (middle - low));
        (cut(a, c, high, low), cut(b, c, middle, low), 1.0 - share)
    } else {
        let share = (high - level) * (high - level) / ((high - middle) * (high - low));
        (cut(a, b, high, middle), cut(a, c, high, low), share)
    };
    Above { area_mm2: share * area_mm2, contour_mm: (far[0] - other[0]).hypot(far[1] - other[1]) }
}

/// The axes of a cloud of places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Principal {
    /// Unit vector along the longer one.
    pub(super) direction: [f64; 2],
    /// Variances along it and across, the larger first.
    pub(super) variances: [f64; 2],
}

/// The axes of weighted places about their mean; `None` without weight.
pub(super) fn principal(
    places: impl Iterator<Item = ([f64; 2], f64)> + Clone,
) -> Option<Principal> {
    let weight: f64 = places.clone().map(|(_, weight)| weight).sum();
    if weight <= 0.0 || weight.is_nan() {
        return None;
    }
    let mean = [0, 1].map(|axis| {
        places.clone().map(|(place, weight)| weight * place[axis]).sum::<f64>() / weight
    });
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for (place, share) in places {
        let [x, y] = [place[0] - mean[0], place[1] - mean[1]];
        xx += share * x * x / weight;
        xy += share * x * y / weight;
        yy += share * y * y / weight;
    }
    let (half, apart) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
    Some(Principal { direction: [cos, sin], variances: [half + apart, (half - apart).max(0.0)] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_triangle() {
        let corners = |a: f64, b: f64, c: f64| [([0.0, 0.0], a), ([2.0, 0.0], b), ([0.0, 2.0], c)];
        assert_eq!(above(corners(1.0, 2.0, 3.0), 0.5).area_mm2, 2.0);
        assert_eq!(above(corners(1.0, 2.0, 3.0), 3.0), Above::default());
        // Half of the height over a corner: a quarter of the area.
        let peak = above(corners(1.0, 0.0, 0.0), 0.5);
        assert_eq!(peak.area_mm2, 0.5);
        assert!((peak.contour_mm - 2.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(above(corners(0.0, 1.0, 1.0), 0.5).area_mm2, 1.5);
        assert_eq!(above(corners(0.0, 0.0, 0.0), 0.0), Above::default());
    }

    #[test]
    fn axes_of_a_rectangle() {
        let places = (0..400).map(|i| [f64::from(i % 100) / 100.0, f64::from(i / 100) / 10.0]);
        let (sin, cos) = 0.3_f64.sin_cos();
        let turned = places.map(|[x, y]| ([cos * x - sin * y + 7.0, sin * x + cos * y], 2.0));
        let found = principal(turned).unwrap();
        assert!((found.variances[0] - 1.0 / 12.0).abs() < 1e-4, "{found:?}");
        assert!((found.variances[1] - 0.0125).abs() < 1e-10, "{found:?}");
        assert!((found.direction[0] - cos).abs() < 1e-10, "{found:?}");
        assert!(principal(std::iter::empty()).is_none());
    }
}
