//! How far the places of a triangle lie from their nearest sample: a distribution over its area.
//!
//! **A triangle without an obtuse angle.** The bisectors of its sides meet in it and part it into what is nearest to
//! each corner. The angles at the corners add up to π, so discs of radius t about them cover half a disc of it, less
//! what lies beyond the bisectors. A side of half length h cuts a segment off the discs at its two ends, of which one
//! half each lies in the triangle. Up to the circumradius
//!
//! ```text
//! area within t = π t² / 2 - s(h₁) - s(h₂) - s(h₃)       s(h) = t² acos(h/t) - h √(t² - h²),  0 where t ≤ h
//! ```
//!
//! **An obtuse angle.** Its circumcentre lies beyond the longest side, where the corner with that angle is nearest to
//! some places of the next triangle. The segment of the longest side then counts positive: the formula holds for the
//! triangle with those places, so the sum over all triangles of a Delaunay triangulation is that of the places
//! (a Voronoi cell is a sum of right triangles with signs). A triangle gets no more than its own area,
//! as it may stand alone or on the hull. What it leaves out is the only error in a plane: it makes distances too
//! large, by less than 1 % of a percentile of points at random, by nothing on a raster.
//!
//! No place is farther than [`crate::triangle::Triangle::gap`].

use crate::triangle::Sizes;

/// What the distances from a triangle's places to their nearest sample depend on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nearness {
    /// Half of each side, ascending.
    pub halves_mm: [f64; 3],
    /// -1 where an angle is above 90°, else 1.
    pub bluntness: f64,
    /// The largest distance.
    pub gap_mm: f64,
    /// The area of all places.
    pub area_mm2: f64,
}

/// The part of an area within a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// The area in mm².
    pub area_mm2: f64,
    /// How fast it grows with the distance, in mm² per mm.
    pub rate_mm: f64,
}

impl Nearness {
    /// Of a triangle of these sizes, none of whose places is farther than `gap_mm`.
    #[inline]
    pub fn new(sizes: &Sizes, gap_mm: f64) -> Nearness {
        Nearness {
            halves_mm: sizes.halves_mm(),
            bluntness: sizes.bluntness(),
            gap_mm,
            area_mm2: sizes.area_mm2,
        }
    }

    /// The area of the places that are no farther than `reach_mm` from their nearest sample.
    #[inline(always)]
    pub fn within(&self, reach_mm: f64) -> Held {
        let [short, middle, long] = self.halves_mm.map(|half_mm| segment(half_mm, reach_mm));
        let square_mm2 = reach_mm * reach_mm;
        let area_mm2 = square_mm2
            * (std::f64::consts::FRAC_PI_2 - short.area - middle.area - self.bluntness * long.area);
        let rate_mm = 2.0
            * reach_mm
            * (std::f64::consts::FRAC_PI_2
                - short.angle
                - middle.angle
                - self.bluntness * long.angle);
        // Written so that all of it counts where a figure is no number.
        if reach_mm < self.gap_mm && area_mm2 < self.area_mm2 {
            if area_mm2 > 0.0 { Held { area_mm2, rate_mm } } else { Held::default() }
        } else {
            Held { area_mm2: self.area_mm2, rate_mm: 0.0 }
        }
    }

    /// The share of its area that is farther than `limit_mm` from the nearest sample.
    #[inline]
    pub fn share_beyond(&self, limit_mm: f64) -> f64 {
        if self.area_mm2 > 0.0 {
            (1.0 - self.within(limit_mm).area_mm2 / self.area_mm2).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }
}

/// What a chord cuts off a disc of radius 1.
struct Segment {
    /// Half of the angle it spans.
    angle: f64,
    area: f64,
}

/// The segment of a disc beyond a chord at a distance from its centre.
#[inline(always)]
fn segment(distance: f64, radius: f64) -> Segment {
    let ratio = distance / radius;
    // Written so that no number is none.
    let cosine = if ratio < 1.0 { ratio } else { 1.0 };
    let below = (1.0 - cosine).sqrt();
    let angle = below * series(cosine);
    Segment { angle, area: angle - cosine * below * (1.0 + cosine).sqrt() }
}

/// acos(x) / √(1 - x) for 0 ≤ x ≤ 1, to 2e-8: M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions (1964),
/// 4.4.46. The compiler makes several at once of it, which it cannot of a call of a library.
#[inline(always)]
fn series(x: f64) -> f64 {
    COEFFICIENTS.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

const COEFFICIENTS: [f64; 8] = [
    1.570_796_305_0,
    -0.214_598_801_6,
    0.088_978_987_4,
    -0.050_174_304_6,
    0.030_891_881_0,
    -0.017_088_125_6,
    0.006_670_090_1,
    -0.001_262_491_1,
];

/// A triangle in a distribution. The figure of a place is its distance to the nearest sample over a unit.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The distances of its places.
    pub nearness: Nearness,
    /// The figure is 0 all over the triangle where this has no end, and without end where it is not positive.
    pub unit_mm: f64,
    /// How often its area counts.
    pub weight: f64,
}

impl Entry {
    /// The area up to a value of the figure, and how fast it grows with that.
    #[inline(always)]
    pub fn held(&self, value: f64) -> Held {
        let held = if self.unit_mm == f64::INFINITY {
            Held { area_mm2: self.nearness.area_mm2, rate_mm: 0.0 }
        } else if self.unit_mm > 0.0 && value > 0.0 {
            let held = self.nearness.within(value * self.unit_mm);
            Held { rate_mm: held.rate_mm * self.unit_mm, ..held }
        } else {
            Held::default()
        };
        Held { area_mm2: self.weight * held.area_mm2, rate_mm: self.weight * held.rate_mm }
    }

    /// The largest value of the figure, if it has an end.
    #[inline]
    pub fn largest(&self) -> Option<f64> {
        (self.unit_mm > 0.0).then(|| self.nearness.gap_mm / self.unit_mm)
    }
}

/// The value up to which a share of the area has places. `None` without area.
#[inline]
pub fn quantile(entries: &[Entry], share: f64) -> Option<f64> {
    let areas_mm2 = entries.iter().map(|entry| entry.weight * entry.nearness.area_mm2);
    let wanted = share * areas_mm2.sum::<f64>();
    if wanted.is_nan() || wanted <= 0.0 {
        return None;
    }
    let held =
        |value: f64| entries.iter().fold(Held::default(), |sum, entry| sum.and(entry.held(value)));
    if held(0.0).area_mm2 >= wanted {
        return Some(0.0);
    }
    let most = entries.iter().filter_map(Entry::largest).fold(0.0, f64::max);
    if held(most).area_mm2 < wanted * (1.0 - ROUNDING) {
        return Some(f64::INFINITY);
    }
    let mut search = Search::new(most);
    let mut value = share * most;
    for _ in 0..MOST_STEPS {
        match search.next(value, held(value), wanted) {
            Ok(found) => return Some(found),
            Err(other) => value = other,
        }
    }
    Some(value)
}

impl Held {
    /// The sum of both.
    #[inline]
    pub fn and(self, other: Held) -> Held {
        Held { area_mm2: self.area_mm2 + other.area_mm2, rate_mm: self.rate_mm + other.rate_mm }
    }
}

/// A search for the value up to which there is an area: Newton's steps within bounds; after two of them by the cubic
/// through both.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    low: f64,
    high: f64,
    /// The value looked at last, and what it holds.
    last: Option<(f64, Held)>,
}

impl Search {
    /// For a value from 0 to `high`.
    #[inline]
    pub fn new(high: f64) -> Search {
        Search { low: 0.0, high, last: None }
    }

    /// The value that is looked for, given what another one holds.
    ///
    /// # Errors
    ///
    /// Where to look next, if that is not near enough yet.
    #[inline]
    pub fn next(&mut self, at: f64, held: Held, wanted: f64) -> Result<f64, f64> {
        let missing = wanted - held.area_mm2;
        if missing > 0.0 {
            self.low = self.low.max(at);
        } else {
            self.high = self.high.min(at);
        }
        let before = self.last.replace((at, held));
        let newton = at + missing / held.rate_mm;
        let (to, error) = match before.and_then(|before| cubic(before, (at, held), wanted)) {
            Some((to, width)) => (to, CURVATURE * ((to - at) / at * width).powi(2)),
            None => (newton, CURVATURE * ((newton - at) / at).powi(2)),
        };
        let is_inside = (self.low..=self.high).contains(&to);
        if is_inside && error <= NEAR {
            return Ok(to);
        }
        let middle = 0.5 * (self.low + self.high);
        if self.high - self.low <= NEAR * self.high {
            return Ok(middle);
        }
        Err(if is_inside { to } else { middle })
    }
}

/// Where the cubic in the area through two values with their rates holds an area, and how far apart they are as a
/// share; none where they are not close or do not rise.
fn cubic(first: (f64, Held), second: (f64, Held), wanted: f64) -> Option<(f64, f64)> {
    let ((x0, f0), (x1, f1)) = (first, second);
    let width = ((x1 - x0) / x1).abs();
    let step = f1.area_mm2 - f0.area_mm2;
    if !(width < CLOSE && f0.rate_mm > 0.0 && f1.rate_mm > 0.0 && step != 0.0) {
        return None;
    }
    let u = (wanted - f0.area_mm2) / step;
    let (slope0, slope1) = (step / f0.rate_mm, step / f1.rate_mm);
    let (u2, u3) = (u * u, u * u * u);
    let to = x0 * (2.0 * u3 - 3.0 * u2 + 1.0)
        + x1 * (3.0 * u2 - 2.0 * u3)
        + slope0 * (u3 - 2.0 * u2 + u)
        + slope1 * (u3 - u2);
    to.is_finite().then_some((to, width))
}

/// A value is found to this share of itself.
const NEAR: f64 = 1e-6;
/// The square of a step as a share of the value, times this, is more than what is left after it: about the 99th
/// percentile areas bend that much.
const CURVATURE: f64 = 100.0;
/// Values so near to each other are joined by a cubic.
const CLOSE: f64 = 0.03;
/// More steps than any search takes.
const MOST_STEPS: usize = 200;
/// What sums of areas are rounded by.
const ROUNDING: f64 = 1e-12;
