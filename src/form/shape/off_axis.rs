//! A section of a shape away from its vertex, in a frame of its own.

use std::sync::Arc;

use super::argument::refused;
use super::at_first_use::AtFirstUse;
use super::taylor::{defined, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// A piece of a parent shape about its place (dx, dy), the origin moved onto the parent there.
///
/// The parameters are the parent's. When they change, the origin stays on the parent at (dx, dy), while the
/// axes keep the directions they were made with: a fit finds what little the part turns by the pose.
///
/// Meant for pieces that a line along their z meets once. Where it meets the parent again, the sheet counts
/// that is reached from the origin without a fold, or next to the height that slope and bend predict.
///
/// Heights are differences of the parent's, exact to the rounding of its coordinates at (dx, dy).
#[derive(Clone, Debug)]
pub struct OffAxis {
    parent: Arc<dyn Shape>,
    origin_mm: [f64; 3],
    /// Unit vectors of x, y and z in the parent's frame.
    axes: [[f64; 3]; 3],
    /// Effect of the parameters on the parent's height at the origin.
    at_origin: Vec<f64>,
    start: Met,
    domain: AtFirstUse,
}

impl OffAxis {
    /// With z along the parent's normal at (dx, dy): the frame is the parent's, turned by the smallest turn
    /// that does it, not about the normal. Fails where the parent has no tangent plane.
    pub fn tilted(parent: Arc<dyn Shape>, dx_mm: f64, dy_mm: f64) -> Result<OffAxis, ShapeError> {
        let [p, q] = at(&parent, dx_mm, dy_mm)?.gradient;
        let length = (1.0 + p * p + q * q).sqrt();
        let [a, b, c] = [-p / length, -q / length, length.recip()];
        let across = -a * b / (1.0 + c);
        let axes = [
            [1.0 - a * a / (1.0 + c), across, -a],
            [across, 1.0 - b * b / (1.0 + c), -b],
            [a, b, c],
        ];
        OffAxis::new(parent, [dx_mm, dy_mm], axes)
    }

    /// With the axes parallel to the parent's. Fails where the parent has no tangent plane.
    pub fn parallel(parent: Arc<dyn Shape>, dx_mm: f64, dy_mm: f64) -> Result<OffAxis, ShapeError> {
        OffAxis::new(parent, [dx_mm, dy_mm], PARALLEL)
    }

    /// The origin in the parent's frame, mm.
    pub fn origin_mm(&self) -> [f64; 3] {
        self.origin_mm
    }

    /// Unit vectors of x, y and z in the parent's frame.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        self.axes
    }

    fn new(
        parent: Arc<dyn Shape>,
        [x, y]: [f64; 2],
        axes: [[f64; 3]; 3],
    ) -> Result<OffAxis, ShapeError> {
        let jet = at(&parent, x, y)?;
        let mut at_origin = vec![0.0; parent.parameters().len()];
        let rate = rate(&jet, axes[2]);
        let seen = parent.by_parameters(x, y, &mut at_origin).filter(|()| rate > 0.0);
        seen.ok_or_else(|| refused(KIND, "decentre", x.hypot(y), INSIDE))?;
        let start = Met { x, y, w: 0.0, parent: jet, rate };
        let (origin_mm, domain) = ([x, y, jet.z_mm], AtFirstUse::default());
        Ok(OffAxis { parent, origin_mm, axes, at_origin, start, domain })
    }

    /// Where the place (u, v, w) of this frame lies in the parent's.
    fn place(&self, u: f64, v: f64, w: f64) -> [f64; 3] {
        let [x, y, z] = self.axes;
        std::array::from_fn(|i| self.origin_mm[i] + u * x[i] + v * y[i] + w * z[i])
    }

    /// Follows the surface from the origin to (u, v): first in one step, then in ever smaller ones.
    fn meet(&self, u: f64, v: f64) -> Option<Met> {
        (u.is_finite() && v.is_finite()).then_some(())?;
        STEPS.into_iter().find_map(|steps| {
            let mut met = self.start;
            for step in 1..=steps {
                let [from, to] = [step - 1, step].map(|at| f64::from(at) / f64::from(steps));
                // The height at the end of the step, from slope and bend at its beginning.
                let (du, dv) = (u * (to - from), v * (to - from));
                let Jet { gradient: [p, q], hessian_per_mm: [r, s, t], .. } = self.jet_at(&met);
                let bend = r * du * du + 2.0 * s * du * dv + t * dv * dv;
                let guess = met.w + p * du + q * dv + 0.5 * bend;
                met = self.newton(u * to, v * to, guess)?;
            }
            Some(met)
        })
    }

    /// Newton's method for the height w at which the line over (u, v) meets the parent. A step that leaves
    /// the parent's domain is halved. `None` unless it settles where the parent faces +z.
    fn newton(&self, u: f64, v: f64, guess: f64) -> Option<Met> {
        let z = self.axes[2];
        let mut w = guess;
        let [mut x, mut y, mut height] = self.place(u, v, w);
        let mut parent = self.parent.jet(x, y)?;
        let mut last = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let change = (parent.z_mm - height) / rate(&parent, z);
            if !change.is_finite() {
                return None;
            }
            let scale = x.abs() + y.abs() + height.abs() + w.abs();
            let stalled = change.abs() >= last && change.abs() <= STALL_TOLERANCE * scale;
            let settled = stalled || change.abs() <= STEP_TOLERANCE * scale;
            last = change.abs();
            let mut share = 1.0;
            loop {
                [x, y, height] = self.place(u, v, w + share * change);
                if let Some(jet) = self.parent.jet(x, y) {
                    (parent, w) = (jet, w + share * change);
                    break;
                }
                share *= 0.5;
                if share < SMALLEST_SHARE {
                    return None;
                }
            }
            if settled {
                let rate = rate(&parent, z);
                return (rate > 0.0).then_some(Met { x, y, w, parent, rate });
            }
        }
        None
    }

    /// Differentiates parent(place) = height of the place twice.
    fn jet_at(&self, met: &Met) -> Jet {
        let [p, q] = met.parent.gradient;
        let [r, s, t] = met.parent.hessian_per_mm;
        let [e1, e2, n] = self.axes;
        let slope = |e: [f64; 3]| (p * e[0] + q * e[1] - e[2]) / met.rate;
        let gradient = [slope(e1), slope(e2)];
        let tangent = |e: [f64; 3], slope: f64| [e[0] + slope * n[0], e[1] + slope * n[1]];
        let [one, two] = [tangent(e1, gradient[0]), tangent(e2, gradient[1])];
        let bend = |a: [f64; 2], b: [f64; 2]| {
            (r * a[0] * b[0] + s * (a[0] * b[1] + a[1] * b[0]) + t * a[1] * b[1]) / met.rate
        };
        Jet {
            z_mm: met.w,
            gradient,
            hessian_per_mm: [bend(one, one), bend(one, two), bend(two, two)],
        }
    }

    /// Whether there are heights all along the rim of the disc.
    fn holds(&self, disc_mm: f64) -> bool {
        (0..RIM).all(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(RIM)).sin_cos();
            self.meet(disc_mm * cos, disc_mm * sin).is_some()
        })
    }
}

/// A place of the surface: x and y in the parent's frame, height w in the section's, the parent's jet, and
/// its `rate`.
#[derive(Clone, Copy, Debug)]
struct Met {
    x: f64,
    y: f64,
    w: f64,
    parent: Jet,
    rate: f64,
}

impl Shape for OffAxis {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        self.meet(x_mm, y_mm).and_then(|met| defined(self.jet_at(&met)))
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.meet(x_mm, y_mm).and_then(|met| number(met.w))
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        self.parent.parameters()
    }

    /// The parent rises by its own derivative, the origin by that at (dx, dy); the difference is seen along
    /// the section's z.
    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let met = self.meet(x_mm, y_mm)?;
        self.parent.by_parameters(met.x, met.y, derivatives)?;
        for (derivative, at_origin) in derivatives.iter_mut().zip(&self.at_origin) {
            *derivative = (*derivative - at_origin) / met.rate;
        }
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        let parent = self.parent.with_parameters(values)?;
        let [dx, dy, _] = self.origin_mm;
        Ok(Arc::new(OffAxis::new(parent, [dx, dy], self.axes)?))
    }

    /// Parallel: what the parent's domain leaves about the origin. Tilted: the largest disc found by trial
    /// whose rim has heights in 64 directions, to one part in a thousand; some thousand heights of the
    /// parent the first time.
    fn domain_mm(&self) -> f64 {
        self.domain.or_find(|| self.find_domain_mm())
    }

    fn parent_axis_mm(&self) -> Option<[[f64; 3]; 2]> {
        let along = |of: [f64; 3]| {
            self.axes.map(|axis| axis.iter().zip(of).map(|(a, b)| a * b).sum::<f64>())
        };
        Some([along(self.origin_mm.map(|entry| -entry)), along([0.0, 0.0, 1.0])])
    }
}

impl OffAxis {
    fn find_domain_mm(&self) -> f64 {
        let [dx, dy, _] = self.origin_mm;
        if self.axes == PARALLEL {
            return (self.parent.domain_mm() - dx.hypot(dy)).max(0.0);
        }
        let (mut inside, mut outside) = (0.0, SMALLEST_DISC_MM);
        while self.holds(outside) {
            if outside > LARGEST_DISC_MM {
                return f64::INFINITY;
            }
            (inside, outside) = (outside, 2.0 * outside);
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            if self.holds(middle) { inside = middle } else { outside = middle }
        }
        inside
    }
}

/// How fast a line along z leaves the parent: 1 along its axis, 0 where the two touch.
fn rate(parent: &Jet, z: [f64; 3]) -> f64 {
    z[2] - parent.gradient[0] * z[0] - parent.gradient[1] * z[1]
}

/// The parent at the origin of the section.
fn at(parent: &Arc<dyn Shape>, dx_mm: f64, dy_mm: f64) -> Result<Jet, ShapeError> {
    let found = dx_mm.hypot(dy_mm);
    parent.jet(dx_mm, dy_mm).ok_or_else(|| refused(KIND, "decentre", found, INSIDE))
}

const KIND: &str = "off-axis section";
const INSIDE: &str = "a place at which the parent has a tangent plane";
const PARALLEL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// In how many steps the surface is followed.
const STEPS: [u32; 3] = [1, 4, 32];
/// Newton's method doubles the digits in every step once it is near.
const MAX_STEPS: u32 = 40;
/// Relative size of the last step, and of one that rounding alone keeps from growing smaller.
const STEP_TOLERANCE: f64 = 2.0 * f64::EPSILON;
const STALL_TOLERANCE: f64 = 64.0 * f64::EPSILON;
/// A step halved this often goes nowhere.
const SMALLEST_SHARE: f64 = 1e-9;
/// Places on the rim of a disc that is tried as the domain, the radii tried, and halvings between them.
const RIM: u32 = 64;
const SMALLEST_DISC_MM: f64 = 1e-3;
const LARGEST_DISC_MM: f64 = 1e6;
const BISECTIONS: u32 = 10;
