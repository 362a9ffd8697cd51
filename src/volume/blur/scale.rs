//! Three σ on a grid, and the area that their total variations tell.

use std::f64::consts::SQRT_2;

use crate::counting_uncertainty;

/// The three σ: the first, √2 and 2 times as large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// The grid is 2^`level` times coarser than that of the samples.
    pub(super) level: u32,
    /// The first σ, in spacings of that grid.
    first: f64,
}

/// Where the search for a scale begins.
pub(super) const BASE: Scale = Scale { level: 0, first: 1.5 };

/// For bodies from which [`BASE`] takes much.
const FINER: Scale = Scale { level: 0, first: 1.0 };

/// Levels above it are not worth their σ: the error is some 10⁻⁵ already.
const LAST_LEVEL: u32 = 3;

/// Loss between the first σ and the last, above which smooth bodies need finer σ: a tube of 6 spacings.
const MUCH: f64 = 0.1;

/// Loss of [`FINER`] of a ball of 4 spacings.
const FINE: f64 = 0.2;

/// Loss of [`BASE`] up to which σ may be doubled: a ball of 26 spacings. A body four times as large may have it doubled once more.
const LITTLE: f64 = 0.01;

/// Loss above which a coarser grid finds more than the curvature of the same faces: the other side of a wall, or a gap.
const TRUSTED_LOSS: f64 = 0.06;

/// The same of edges: a cube of 33 spacings.
const TRUSTED_EDGES: f64 = 0.15;

/// Order up to which a coarser grid finds edges alone.
const TRUSTED_EDGE_ORDER: f64 = 1.25;

/// Order above which the same holds: the loss by a wall begins late and grows fast.
const TRUSTED_ORDER: f64 = 2.6;

/// Loss of a coarser grid up to which faces count as flat there.
const FLAT_LOSS: f64 = LITTLE / 4.0;

/// Standard uncertainty of the area of flat faces by steps of the grid, as a share of it, by the σ of [`BASE`]. A face at a small angle θ has the
/// excess θ²·exp(−4π²σ²θ²), at most 1/(4π²eσ²). Twice as much is left of it at no blur, and half of that counts. It falls as σ⁻².
pub(super) const STEPS_DOUBT: f64 = 4e-3;

/// Between 1, the order of edges, and 2, that of smooth bodies.
const EDGE_ORDER: f64 = 1.5;

/// The same of [`FINER`] where the loss is [`MUCH`] or less, and where it is [`FINE`]; between them it follows the loss. Higher terms lower the
/// order of small smooth bodies: balls of 6, 5 and 4 spacings have 1.94, 1.84 and 1.54 at least, ellipsoids of 4, 6 and 8 1.70, of 3, 4
/// and 5 1.19. Cubes have 0.6 to 0.8, cylinders 12 wide and 24 long 1.21 to 1.36, discs 24 wide and 8 high 1.34 to 1.52.
const FINER_EDGE_ORDERS: [f64; 2] = [1.7, 1.1];

/// Share of the difference between both extrapolations that is the standard uncertainty where detail is too fine to choose.
const UNDECIDED: f64 = 0.8;

/// The same of other smooth bodies, where edges would have more area: pins 8 wide and 24 long, with short edges beside much curvature, have
/// the order of ellipsoids and are 3 % too small.
const MIXED: f64 = 1.2;

/// The same of edges, of the difference to the line through the two finer σ: cubes of 8 spacings are 4 % too small.
const EDGE_DOUBT: f64 = 1.25;

/// Share of the difference between both extrapolations that is uncertain of edges: the line and the parabola may agree where both are off by
/// curved faces and by higher terms. Pins 12 wide and high are off by 0.7 %, which is this share.
const CURVED_EDGES: f64 = 0.1;

impl Scale {
    /// The σ, in spacings of the grid of the level.
    pub(super) fn sigmas(self) -> [f64; 3] {
        [1.0, SQRT_2, 2.0].map(|times| times * self.first)
    }

    /// Twice the σ, on a grid twice as coarse.
    pub(super) fn next(self) -> Scale {
        Scale { level: self.level + 1, ..self }
    }

    /// Whether the σ are finer than those of [`BASE`].
    pub(super) fn is_finer(self) -> bool {
        self == FINER
    }

    /// Share by which steps of the grid raise the total variation, for each σ.
    fn excess(self) -> [f64; 3] {
        self.sigmas().map(|sigma| {
            let sigma = sigma * f64::from(self.level).exp2();
            let found = EXCESS.iter().find(|(of, _)| (of - sigma).abs() < 1e-9);
            found.map_or(EXCESS_FAR * sigma.powi(-4), |(_, excess)| *excess)
        })
    }
}

/// Total variations at the σ of a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Variations {
    pub(super) scale: Scale,
    pub(super) sums: [f64; 3],
}

impl Variations {
    /// The sum over blocks of one scale.
    pub(super) fn sum(blocks: &[Variations]) -> Variations {
        let scale = blocks.first().map_or(BASE, |of| of.scale);
        let sums = std::array::from_fn(|index| blocks.iter().map(|of| of.sums[index]).sum());
        Variations { scale, sums }
    }

    /// The sums without what steps of the grid add.
    fn smooth(&self) -> [f64; 3] {
        let excess = self.scale.excess();
        std::array::from_fn(|index| self.sums[index] / (1.0 + excess[index]))
    }

    /// The order of the loss, and whether it is that of edges.
    pub(super) fn order(&self) -> (Option<f64>, bool) {
        let [fine, middle, coarse] = self.smooth();
        let (first, second) = (fine - middle, middle - coarse);
        let order = (first > 0.0 && second > 0.0).then(|| 2.0 * (second / first).log2());
        let tells = !self.is_fine() && !self.is_flat();
        (order, tells && order.is_some_and(|order| order < self.edge_order()))
    }

    /// Order below which edges prevail.
    fn edge_order(&self) -> f64 {
        if !self.scale.is_finer() {
            return EDGE_ORDER;
        }
        let [of_much, of_fine] = FINER_EDGE_ORDERS;
        let share = ((self.loss() - MUCH) / (FINE - MUCH)).clamp(0.0, 1.0);
        of_much + share * (of_fine - of_much)
    }

    /// The share of the total variation that the last σ loses against the first.
    pub(super) fn loss(&self) -> f64 {
        let [fine, _, coarse] = self.smooth();
        if fine > 0.0 { 1.0 - coarse / fine } else { 0.0 }
    }

    /// Whether detail is as fine as the blur: then the order says nothing of edges.
    pub(super) fn is_fine(&self) -> bool {
        self.scale.is_finer() && self.loss() > FINE
    }

    /// Whether a coarser grid than that of the samples takes nothing off: its order says nothing.
    fn is_flat(&self) -> bool {
        self.scale.level > 0 && self.loss() <= FLAT_LOSS
    }

    /// Whether the loss is that of curvature or edges, not of walls.
    pub(super) fn is_trusted(&self) -> bool {
        let is_of_curvature = self.order().0.is_some_and(|order| order < TRUSTED_ORDER);
        self.is_flat() || self.loss() <= TRUSTED_LOSS && is_of_curvature
    }

    /// The same of edges, which lose more.
    pub(super) fn are_edges_trusted(&self) -> bool {
        self.loss() <= TRUSTED_EDGES
            && self.order().0.is_some_and(|order| order < TRUSTED_EDGE_ORDER)
    }

    /// Finer σ, where these take much.
    pub(super) fn finer(&self) -> Option<Scale> {
        (self.loss() > MUCH).then_some(FINER)
    }

    /// Coarser σ, where those of [`BASE`] take little: σ grows as the root of the radius of curvature.
    pub(super) fn coarser(&self, loss_of_base: f64) -> Option<Scale> {
        let level = self.scale.level;
        let most = LITTLE * (-4.0 * f64::from(level)).exp2();
        let may_grow = level < LAST_LEVEL && (self.is_flat() || loss_of_base <= most);
        may_grow.then_some(self.scale.next())
    }

    /// Adds what each σ takes off the creases at the border of the volume.
    pub(super) fn with_creases(mut self, creases: f64) -> Variations {
        let grid = f64::from(self.scale.level).exp2();
        for (sum, sigma) in self.sums.iter_mut().zip(self.scale.sigmas()) {
            *sum += sigma * grid * creases;
        }
        self
    }

    /// Standard uncertainty of the area: of its extrapolation, and of smooth bodies from the place of the grid.
    ///
    /// The extrapolation may be off by the difference to that through the two finer σ, of edges a quarter more; of smooth bodies by
    /// most of that to the one of edges, if it is more. Counting moves a surface at random (see [`counting_uncertainty`]). On curved faces the
    /// area follows by twice the mean curvature:
    ///
    /// ```text
    /// u² = 0.06665 ∫ (κ₁ + κ₂)² dA ≤ 0.06665 · 2 ∫ (κ₁² + κ₂²) dA
    /// ```
    ///
    /// and the loss of the total variation is σ²/2 times that integral. Balls have equality.
    pub(super) fn uncertainty(&self, has_edges: bool) -> f64 {
        let [fine, middle, _] = self.smooth();
        let area = self.area(has_edges);
        if has_edges {
            let linear = fine + (fine - middle) / (SQRT_2 - 1.0);
            let of_curvature = CURVED_EDGES * (area - self.area(false)).abs();
            let of_model = EDGE_DOUBT * (area - linear).abs();
            return of_model.hypot(of_curvature).hypot(self.of_steps(true));
        }
        let sigma = self.scale.sigmas()[0] * f64::from(self.scale.level).exp2();
        let bent = 2.0 * (area - fine).max(0.0) / (sigma * sigma);
        let of_place = counting_uncertainty(2.0 * bent);
        let between = self.area(true) - area;
        // An order above 2 is none of edges.
        let of_edges =
            if self.is_fine() { UNDECIDED * between.abs() } else { MIXED * between.max(0.0) };
        let of_model = of_edges.max((area - (2.0 * fine - middle)).abs());
        of_place.hypot(of_model).hypot(self.of_steps(false))
    }

    /// Standard uncertainty by steps of the grid: faces that are flat at this scale have one direction, not the mean of all. So have those
    /// between edges.
    fn of_steps(&self, has_edges: bool) -> f64 {
        let level = self.scale.level;
        let has_one_direction = has_edges || self.is_flat() || level == 0 && self.loss() <= LITTLE;
        if has_one_direction {
            STEPS_DOUBT * (-2.0 * f64::from(level)).exp2() * self.area(false)
        } else {
            0.0
        }
    }

    /// The area at no blur.
    pub(super) fn area(&self, has_edges: bool) -> f64 {
        self.smooth().iter().zip(weights(has_edges)).map(|(sum, weight)| sum * weight).sum()
    }
}

/// How far the area moves by a unit of creases of a scale.
fn of_creases(scale: Scale, has_edges: bool) -> f64 {
    let none = Variations { scale, sums: [0.0; 3] };
    none.with_creases(1.0).area(has_edges)
}

/// How far the area moves by what blur takes off creases, and the standard uncertainty of that.
pub(super) fn by_creases(scale: Scale, has_edges: bool, creases: f64) -> [f64; 2] {
    let of_unit = of_creases(scale, has_edges);
    [of_unit * creases, CREASE_DOUBT * of_unit * creases]
}

/// What the variations count in the polynomial through them at σ = 0: of second degree in σ for edges, in σ² for smooth bodies
/// (Lagrange).
fn weights(has_edges: bool) -> [f64; 3] {
    let at = if has_edges { [1.0, SQRT_2, 2.0] } else { [1.0, 2.0, 4.0] };
    std::array::from_fn(|own| {
        (0..3)
            .filter(|&other| other != own)
            .map(|other| at[other] / (at[other] - at[own]))
            .product()
    })
}

/// Share of what is given back of creases that is uncertain, for their angles are known roughly. Where they are sharp, their sides are near to
/// each other for long.
const CREASE_DOUBT: f64 = 0.4;

/// Share by which steps of the grid raise the total variation, by σ in spacings: the mean over all directions of the surface.
///
/// Integrated, not fitted: the blurred half-space of a direction is a sum of steps, and its slope is known between them. The mean over 12,000
/// directions is certain to 10⁻⁷; the test below does the same with fewer. σ of 3 and more are those of coarser grids.
const EXCESS: [(f64, f64); 7] = [
    (1.0, 2.8007e-3),
    (SQRT_2, 6.811e-4),
    (1.5, 5.368e-4),
    (2.0, 1.683e-4),
    (1.5 * SQRT_2, 1.326e-4),
    (3.0, 4.18e-5),
    (3.0 * SQRT_2, 9.3e-6),
];

/// The same above, times σ⁴: steps of a plane at a small angle θ to the grid are 1/θ long and add θ²·exp(−4π²σ²θ²), whose mean goes with
/// σ⁻⁴.
const EXCESS_FAR: f64 = 2.7e-3;
