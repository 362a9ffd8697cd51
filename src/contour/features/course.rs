//! The points of a curve in the order of the curve, the same from wherever they are told.

use asphera_geometry::side::share_along;

use crate::polylines::Polylines;
use crate::triangulation::distance_mm;
use crate::{Chain, FoundCurve, PlaceMm, SampleId, Samples};

/// Points in the order of a curve. A closed one begins at the point farthest from the mean and goes counter-clockwise; an open one begins
/// at its end of smaller x. So features do not depend on where a chain begins or which way it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    places_mm: Vec<PlaceMm>,
    closed: bool,
}

impl Course {
    /// The points of a chain, in its order; of a closed one the first is not repeated.
    pub fn new(mut places_mm: Vec<PlaceMm>, closed: bool) -> Course {
        let count = places_mm.len();
        if closed && count > 2 {
            let mut sorted = places_mm.clone();
            sorted.sort_by(by_place);
            let mean = [0, 1]
                .map(|axis| sorted.iter().map(|place| place[axis]).sum::<f64>() / count as f64);
            let far = |place: &PlaceMm| distance_mm(*place, mean);
            let first = (0..count).reduce(|best, index| {
                let order = far(&places_mm[index]).total_cmp(&far(&places_mm[best]));
                let order = order.then(by_place(&places_mm[best], &places_mm[index]));
                if order.is_gt() { index } else { best }
            });
            places_mm.rotate_left(first.unwrap_or(0));
            if area_mm2(&places_mm) < 0.0 {
                places_mm[1..].reverse();
            }
        } else if count > 1 && by_place(&places_mm[count - 1], &places_mm[0]).is_lt() {
            places_mm.reverse();
        }
        Course { places_mm, closed }
    }

    /// The courses of the chains of a curve, in their order. Where noise was taken away, samples but outliers belong to the nearest chain, in the
    /// order of their feet on it. Those farther from it than its noise and one of its sides explain belong to none: the curve leaves them out.
    pub fn of_curve(samples: &Samples, curve: &FoundCurve, outliers: &[SampleId]) -> Vec<Course> {
        let chains = curve.graph.chains(samples.len());
        let Some(moved_mm) = &curve.places_mm else {
            let places = |chain: &Chain| chain.places_mm(samples);
            return chains.iter().map(|chain| Course::new(places(chain), chain.closed)).collect();
        };
        let place = |sample: SampleId| moved_mm[sample as usize];
        // Sides in the order of the chains, and the chain of each.
        let (mut sides, mut chain_of) = (Vec::new(), Vec::new());
        for (number, chain) in chains.iter().enumerate() {
            let count = chain.samples.len();
            for from in 0..if chain.closed { count } else { count - 1 } {
                let to = (from + 1) % count;
                sides.push([place(chain.samples[from]), place(chain.samples[to])]);
                chain_of.push(number);
            }
        }
        let line = Polylines::of_sides(sides.clone());
        let mut ordered: Vec<(u32, f64, PlaceMm)> = (0..samples.len() as SampleId)
            .filter(|sample| outliers.binary_search(sample).is_err())
            .filter_map(|sample| {
                let at = samples.places()[sample as usize];
                let (side, distance_mm) = line.nearest(at)?;
                let [p, q] = sides[side as usize];
                let most_mm = FAR * curve.sigma_mm.unwrap_or(0.0) + self::distance_mm(p, q);
                (distance_mm <= most_mm).then(|| (side, share_along([p, q], at), at))
            })
            .collect();
        ordered.sort_by(|p, q| {
            p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)).then_with(|| by_place(&p.2, &q.2))
        });
        let mut points = vec![Vec::new(); chains.len()];
        for (side, _, at) in ordered {
            points[chain_of[side as usize]].push(at);
        }
        let closed = chains.iter().map(|chain| chain.closed);
        points.into_iter().zip(closed).map(|(points, closed)| Course::new(points, closed)).collect()
    }

    /// The points.
    pub fn places_mm(&self) -> &[PlaceMm] {
        &self.places_mm
    }

    /// Whether the last is followed by the first.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The same points, beginning at one of them; for closed ones.
    pub(super) fn beginning_at(&self, first: usize) -> Course {
        let mut places_mm = self.places_mm.clone();
        places_mm.rotate_left(first);
        Course { places_mm, closed: self.closed }
    }

    /// The open courses that are left without the edges from some of its points to the next.
    pub(super) fn without(&self, edges: &[usize]) -> Vec<Course> {
        let count = self.places_mm.len();
        let [Some(&first), Some(&last)] = [edges.first(), edges.last()] else { return Vec::new() };
        let mut parts: Vec<_> = edges.windows(2).map(|pair| pair[0] + 1..pair[1] + 1).collect();
        match self.closed {
            true => parts.push(last + 1..first + 1 + count),
            false => parts.extend([0..first + 1, last + 1..count]),
        }
        let place = |index: usize| self.places_mm[index % count];
        parts.into_iter().map(|part| Course::new(part.map(place).collect(), false)).collect()
    }

    /// Largest side of the box round the points, mm.
    pub(super) fn extent_mm(&self) -> f64 {
        let range = |axis: usize| {
            let values = self.places_mm.iter().map(|place| place[axis]);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
                (low.min(it), high.max(it))
            });
            (high - low).max(0.0)
        };
        range(0).max(range(1))
    }

    /// The noise of the points across the curve; none of fewer than 9 points.
    ///
    /// Each is held against the cubic through its four neighbours at one and two strides, in the direction of the outer two. What is
    /// left, over what noise of five points makes of it, has the standard deviation σ, of all within 3.5 σ by their median. The stride is doubled until it is wide against σ.
    pub fn noise(&self) -> Option<Noise> {
        let count = self.places_mm.len();
        if count < LEAST {
            return None;
        }
        let mut steps: Vec<f64> =
            self.places_mm.windows(2).map(|pair| distance_mm(pair[0], pair[1])).collect();
        steps.sort_by(f64::total_cmp);
        let step_mm = steps[steps.len() / 2];
        let mut stride = 1;
        loop {
            let left_mm: Vec<f64> = (0..count).map(|at| self.left_mm(at, stride)).collect();
            let mut sizes: Vec<f64> =
                left_mm.iter().copied().filter(|left| left.is_finite()).map(f64::abs).collect();
            sizes.sort_by(f64::total_cmp);
            let median = sizes.get(sizes.len() / 2).copied().unwrap_or(f64::INFINITY);
            let rough_mm = median / MEDIAN;
            let inner = &sizes[..sizes.partition_point(|size| *size <= NEAR * rough_mm)];
            let squares_mm2: f64 = inner.iter().map(|size| size * size).sum();
            let sigma_mm = (squares_mm2 / (INNER * inner.len() as f64)).sqrt();
            let wide = stride as f64 * step_mm >= WIDE * sigma_mm;
            if wide || 32 * stride > count {
                return sigma_mm.is_finite().then_some(Noise { sigma_mm, left_mm, stride });
            }
            stride *= 2;
        }
    }

    /// A point less the cubic through its neighbours, over what equal noise makes of it; NaN where the curve goes back there.
    fn left_mm(&self, at: usize, stride: usize) -> f64 {
        let count = self.places_mm.len();
        let neighbour = |steps: isize| {
            let index = at as isize + steps * stride as isize;
            match self.closed {
                true => Some(self.places_mm[index.rem_euclid(count as isize) as usize]),
                false => usize::try_from(index).ok().and_then(|it| self.places_mm.get(it).copied()),
            }
        };
        let Some([a, b, c, d]) = neighbour(-2)
            .zip(neighbour(-1))
            .zip(neighbour(1).zip(neighbour(2)))
            .map(|((a, b), (c, d))| [a, b, c, d])
        else {
            return f64::NAN;
        };
        let length = distance_mm(a, d);
        let along = [(d[0] - a[0]) / length, (d[1] - a[1]) / length];
        let local = |place: PlaceMm| {
            let [x, y] = [place[0] - a[0], place[1] - a[1]];
            [x * along[0] + y * along[1], y * along[0] - x * along[1]]
        };
        let [t, s] = local(self.places_mm[at]);
        let others = [a, b, c, d].map(local);
        let goes_on = others[0][0] < others[1][0]
            && others[1][0] < t
            && t < others[2][0]
            && others[2][0] < others[3][0];
        if !goes_on {
            return f64::NAN;
        }
        let (mut left, mut squares) = (s, 1.0);
        for (index, [at, height]) in others.iter().enumerate() {
            let rest = others.iter().enumerate().filter(|(other, _)| *other != index);
            let weight: f64 = rest.map(|(_, [other, _])| (t - other) / (at - other)).product();
            left -= weight * height;
            squares += weight * weight;
        }
        left / squares.sqrt()
    }
}

/// The noise of points across their curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation, mm.
    pub sigma_mm: f64,
    /// Of every point that by which that was found; NaN where there is none.
    pub(super) left_mm: Vec<f64>,
    /// Points from one to the next of the five.
    pub(super) stride: usize,
}

/// The area within closed lines of points in mm², counter-clockwise above 0.
pub(super) fn area_mm2(places_mm: &[PlaceMm]) -> f64 {
    let Some(&[x, y]) = places_mm.first() else { return 0.0 };
    let next = places_mm.iter().cycle().skip(1);
    let crossed = places_mm.iter().zip(next);
    0.5 * crossed.map(|(p, q)| (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x)).sum::<f64>()
}

fn by_place(p: &PlaceMm, q: &PlaceMm) -> std::cmp::Ordering {
    p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1]))
}

/// Distance from a curve without its noise, in σ, that noise explains.
const FAR: f64 = 6.0;
/// Least points whose noise can be found.
pub(super) const LEAST: usize = 9;
/// Median of the size of a standard normal number.
const MEDIAN: f64 = 0.674_489_750_196_082;
/// Size in σ beyond which what is left is no noise.
const NEAR: f64 = 3.5;
/// Mean square of standard normal numbers up to that size.
const INNER: f64 = 0.993_890;
/// Stride over σ from which points keep their order.
const WIDE: f64 = 3.0;
