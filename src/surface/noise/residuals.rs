//! Residuals of one neighbourhood from its own polynomial, freed of wrong readings.

use asphera_geometry::{PointMm, VertexId};

use crate::curvature::{CUBIC, Local, QUADRIC, System, derivatives, dot, terms_at};

/// Fewest degrees of freedom that say something of the noise.
pub(super) const FREEDOM_MIN: usize = 3;
/// A sample whose residual has less than this share of the noise's variance is one that bends the
/// polynomial to itself: it tells nothing.
const VARIANCE_MIN: f64 = 1e-3;
/// Largest condition of a fit that is used.
const CONDITION: f64 = 1e3;

/// Residuals r = P z of a least-squares fit, P the projection on what the terms leave.
///
/// Under white noise σ the covariance of the residuals is σ² P (R. D. Cook, S. Weisberg, Residuals
/// and Influence in Regression, 1982, chapter 2), so rᵢ/√Pᵢᵢ, the studentized residual, has the
/// standard deviation σ whatever its leverage. A sample is left out by a step of elimination, after
/// which r and P are those of the fit without it.
#[derive(Default)]
pub(super) struct Residuals {
    /// Row by row.
    projection: Vec<f64>,
    values: Vec<f64>,
    /// Whether a sample was left out.
    out: Vec<bool>,
    freedom: usize,
    places: Vec<[f64; 3]>,
}

impl Residuals {
    /// Fits the samples, the vertex first; `None` if they do not determine a polynomial or leave
    /// too few degrees of freedom.
    ///
    /// A cubic is used where there are enough samples: the third order of a surface's form would
    /// otherwise count as noise.
    pub(super) fn fit(&mut self, points: &[PointMm], samples: &[VertexId]) -> Option<Slope> {
        let local = Local::of(points, samples, &mut self.places).ok()?;
        let terms = if samples.len() >= CUBIC + FREEDOM_MIN
            && let Some(system) = System::<CUBIC>::of(&self.places, CONDITION)
        {
            self.project(&system)
        } else if samples.len() >= QUADRIC + FREEDOM_MIN
            && let Some(system) = System::<QUADRIC>::of(&self.places, CONDITION)
        {
            self.project(&system)
        } else {
            return None;
        };
        let [_, x, y, ..] = local.in_mm(terms);
        Some(Slope { secant: x.hypot(y).hypot(1.0) })
    }

    fn project<const N: usize>(&mut self, system: &System<N>) -> [f64; 6] {
        let count = self.places.len();
        let rows: Vec<[f64; N]> =
            self.places.iter().map(|place| system.forward(terms_at::<N>(place))).collect();
        self.projection.clear();
        for (i, left) in rows.iter().enumerate() {
            self.projection.extend(
                rows.iter()
                    .enumerate()
                    .map(|(j, right)| f64::from(u8::from(i == j)) - dot(left, right)),
            );
        }
        // From the residuals of a refined solution, not from P z: z may be steep.
        let (terms, _) = system.solve(&self.places);
        self.values.clear();
        self.values
            .extend(self.places.iter().map(|place| place[2] - dot(&terms_at::<N>(place), &terms)));
        self.out.clear();
        self.out.resize(count, false);
        self.freedom = count - N;
        derivatives(&terms)
    }

    /// How many samples there are, those left out among them.
    pub(super) fn samples(&self) -> usize {
        self.values.len()
    }

    /// How many samples were left out.
    pub(super) fn left_out(&self) -> usize {
        self.out.iter().filter(|&&out| out).count()
    }

    pub(super) fn freedom(&self) -> usize {
        self.freedom
    }

    /// Standard deviation of the noise from the sum of the squared residuals.
    pub(super) fn deviation(&self) -> f64 {
        // Summed anew: taking off what a sample contributed leaves rounding where little is left.
        let squares: f64 = self.values.iter().map(|value| value * value).sum();
        (squares / self.freedom as f64).sqrt()
    }

    /// The sizes of the studentized residuals of the samples that were not left out.
    pub(super) fn studentized(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.samples()).filter_map(|index| Some(self.squared(index)?.sqrt()))
    }

    /// Square of a studentized residual: what the sum of squares loses without the sample.
    fn squared(&self, index: usize) -> Option<f64> {
        let variance = self.projection[index * self.samples() + index];
        let tells = !self.out[index] && variance >= VARIANCE_MIN;
        tells.then(|| self.values[index] * self.values[index] / variance)
    }

    /// Leaves out the sample with the largest studentized residual, if that is above the limit and
    /// enough are left.
    pub(super) fn leave_out_worst(&mut self, limit: f64) -> bool {
        let worst = (0..self.samples())
            .filter_map(|index| Some((index, self.squared(index)?)))
            .reduce(|worst, other| if other.1 > worst.1 { other } else { worst });
        match worst {
            Some((index, squared)) if squared > limit * limit && self.freedom > FREEDOM_MIN => {
                self.leave_out(index);
                true
            }
            _ => false,
        }
    }

    /// The largest studentized residual.
    pub(super) fn worst(&self) -> f64 {
        self.studentized().fold(0.0, f64::max)
    }

    fn leave_out(&mut self, index: usize) {
        let count = self.samples();
        let column: Vec<f64> = self.projection[index * count..(index + 1) * count].to_vec();
        let pivot = column[index];
        let residual = self.values[index];
        for (i, value) in self.values.iter_mut().enumerate() {
            let share = column[i] / pivot;
            *value -= share * residual;
            let row = &mut self.projection[i * count..(i + 1) * count];
            row.iter_mut().zip(&column).for_each(|(entry, other)| *entry -= share * other);
        }
        // But for rounding they are zero already.
        self.values[index] = 0.0;
        self.out[index] = true;
        self.freedom -= 1;
    }
}

/// How steep the surface is at the vertex.
pub(super) struct Slope {
    /// An area of it over its projection.
    pub(super) secant: f64,
}
