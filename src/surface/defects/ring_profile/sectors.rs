//! Mean deviations in the sectors about the axis of a part, and what polynomials along a diameter leave of them.

use nalgebra::{SMatrix, SVector};

use crate::defects::tail;

/// Sectors about the axis.
pub(super) const SECTORS: usize = 12;

/// Sample by its place about the axis.
pub(super) struct Polar {
    /// In nodes.
    pub(super) radius: f64,
    sector: usize,
    height_mm: f64,
}

impl Polar {
    /// A sample at a place in nodes.
    pub(super) fn new([x, y]: [f64; 2], height_mm: f64) -> Polar {
        let turn = y.atan2(x) / std::f64::consts::TAU + 0.5;
        let sector = ((turn * SECTORS as f64) as usize).min(SECTORS - 1);
        Polar { radius: x.hypot(y), sector, height_mm }
    }
}

/// Mean of a sector at a node.
#[derive(Clone, Copy)]
pub(super) struct Mean {
    /// Samples in it, by their weights; 0 where it is not known.
    pub(super) weight: f64,
    pub(super) height_mm: f64,
    /// Height that polynomials are fitted to: near to what the other sectors have there.
    calm_mm: f64,
}

const UNKNOWN: Mean = Mean { weight: 0.0, height_mm: 0.0, calm_mm: 0.0 };

/// By sector, the mean at each node outwards.
pub(super) struct Sectors {
    pub(super) means: Vec<Vec<Mean>>,
}

impl Sectors {
    /// Means of the samples less `taken_mm` at their radius: by a line over the nodes within reach.
    pub(super) fn new(polar: &[Polar], nodes: usize, taken_mm: impl Fn(f64) -> f64) -> Sectors {
        let mut sums = vec![vec![Sums::default(); nodes]; SECTORS];
        for of in polar {
            let node = (of.radius as usize).min(nodes - 1);
            sums[of.sector][node].add(of.radius - node as f64, of.height_mm - taken_mm(of.radius));
        }
        let mean = |sums: &[Sums], node: usize| {
            let mut about = Sums::default();
            for (other, sums) in window(sums, node, REACH) {
                let by = other as f64 - node as f64;
                about.add_moved(sums, 1.0 - (by + 0.5).abs() / REACH as f64, by);
            }
            let (weight, height_mm) = about.at_node();
            if weight < SAMPLES_LEAST {
                return UNKNOWN;
            }
            Mean { weight, height_mm, calm_mm: height_mm }
        };
        let of_sector = |sums: &Vec<Sums>| (0..nodes).map(|node| mean(sums, node)).collect();
        let mut means: Vec<Vec<Mean>> = sums.iter().map(of_sector).collect();
        // Where a sector ends its mean is as uncertain as the line through its last samples.
        for node in 0..nodes {
            let fullest = means.iter().map(|sector| sector[node].weight).fold(0.0, f64::max);
            for sector in &mut means {
                if sector[node].weight < WEIGHT_LEAST * fullest {
                    sector[node] = UNKNOWN;
                }
            }
        }
        Sectors { means }
    }

    /// Direction of the middle of a sector from the axis, in radians.
    pub(super) fn middle_of(sector: usize) -> f64 {
        ((sector as f64 + 0.5) / SECTORS as f64 - 0.5) * std::f64::consts::TAU
    }

    /// What a quadratic leaves along the diameter through each sector, over `wide` nodes to either side. Nodes before `first`
    /// do not count in it.
    pub(super) fn without_wide(&self, wide: usize, first: usize) -> Vec<Vec<Mean>> {
        let less = |sector: usize, node: usize| {
            let mut fit = Polynomial::<3>::new();
            let [own, opposite] = diameter(&self.means, sector);
            // Means count alike: by their samples those next to the axis would not be followed.
            let mut add = |way: f64, mean: &Mean| {
                if mean.weight > 0.0 {
                    fit.add(way, (1.0 - way.abs().powi(3)).powi(3), mean.calm_mm);
                }
            };
            for (other, mean) in window(own, node, wide).filter(|of| of.0 >= first) {
                add((other as f64 - node as f64) / wide as f64, mean);
            }
            let over = wide.saturating_sub(node).min(opposite.len());
            for (other, mean) in opposite[..over].iter().enumerate().skip(first) {
                add(-((other + node) as f64) / wide as f64, mean);
            }
            fit.solved().map(|terms| terms[0])
        };
        without(&self.means, less)
    }

    /// What a quartic leaves along the diameter through each sector. A defect in some sectors would bend it in these and in
    /// the ones opposite: what is far from the other sectors is brought near to them before quartics are fitted again.
    pub(super) fn flat(&self) -> Sectors {
        (0..CALM_ROUNDS).fold(self.without_quartic(&self.means), |flat, _| {
            let calm = flat.calm();
            let fitted = |(own, (calm, left)): (&Mean, (&Mean, &Mean))| Mean {
                calm_mm: own.height_mm - left.height_mm + calm.calm_mm,
                ..*own
            };
            let fitted: Vec<Vec<Mean>> = self
                .means
                .iter()
                .zip(calm.iter().zip(&flat.means))
                .map(|(own, (calm, left))| {
                    own.iter().zip(calm.iter().zip(left)).map(fitted).collect()
                })
                .collect();
            self.without_quartic(&fitted)
        })
    }

    /// What quartics through the calm heights of `fitted` leave of its heights.
    fn without_quartic(&self, fitted: &[Vec<Mean>]) -> Sectors {
        let fits: Vec<Option<SVector<f64, 5>>> = (0..SECTORS)
            .map(|sector| {
                let mut fit = Polynomial::<5>::new();
                for (means, sign) in diameter(fitted, sector).into_iter().zip([1.0, -1.0]) {
                    for (node, mean) in means.iter().enumerate() {
                        let way = sign * node as f64 / means.len() as f64;
                        // Rings count by their area, as they do in a quartic over the plane.
                        fit.add(way, mean.weight, mean.calm_mm);
                    }
                }
                fit.solved()
            })
            .collect();
        let nodes = self.means[0].len() as f64;
        let left = without(fitted, |sector, node| {
            let terms = fits[sector]?;
            Some(terms.iter().rev().fold(0.0, |sum, term| sum * (node as f64 / nodes) + term))
        });
        Sectors { means: left }
    }

    /// The means with their calm heights no farther from the middle one at their node than noise of sectors goes.
    fn calm(&self) -> Vec<Vec<Mean>> {
        let middles: Vec<f64> = (0..self.means[0].len())
            .map(|node| {
                let at = self.means.iter().map(|sector| sector[node]);
                middle(at.filter(|mean| mean.weight > 0.0).map(|mean| mean.height_mm).collect())
            })
            .collect();
        let off = |(mean, middle_mm): (&Mean, &f64)| {
            (mean.height_mm - middle_mm).abs() * mean.weight.sqrt()
        };
        let known = |of: &(&Mean, &f64)| of.0.weight > 0.0;
        let all = self.means.iter().flat_map(|sector| sector.iter().zip(&middles));
        let mut sizes: Vec<f64> = all.filter(known).map(off).collect();
        let most_mm = CALM * tail::scale(&mut sizes).unwrap_or(0.0);
        let calm = |(mean, middle_mm): (&Mean, &f64)| {
            if mean.weight <= 0.0 {
                return UNKNOWN;
            }
            let most_mm = most_mm / mean.weight.sqrt();
            let calm_mm = mean.height_mm.clamp(middle_mm - most_mm, middle_mm + most_mm);
            Mean { calm_mm, ..*mean }
        };
        self.means.iter().map(|sector| sector.iter().zip(&middles).map(calm).collect()).collect()
    }
}

/// A sector and the one opposite.
fn diameter(means: &[Vec<Mean>], sector: usize) -> [&[Mean]; 2] {
    [&means[sector], &means[(sector + SECTORS / 2) % SECTORS]]
}

/// Means less what `wide_mm` says of sector and node; unknown where it says nothing.
fn without(means: &[Vec<Mean>], wide_mm: impl Fn(usize, usize) -> Option<f64>) -> Vec<Vec<Mean>> {
    let left = |sector: usize, node: usize, mean: Mean| {
        let known = (mean.weight > 0.0).then(|| wide_mm(sector, node)).flatten();
        known.map_or(UNKNOWN, |mm| Mean {
            height_mm: mean.height_mm - mm,
            calm_mm: mean.calm_mm - mm,
            ..mean
        })
    };
    let sectors = means.iter().enumerate();
    sectors
        .map(|(sector, means)| {
            let means = means.iter().enumerate();
            means.map(|(node, &mean)| left(sector, node, mean)).collect()
        })
        .collect()
}

/// The middle one of some values; 0 without any.
fn middle(mut values: Vec<f64>) -> f64 {
    let half = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(half, f64::total_cmp).1 }
}

/// What lies fewer than `wide` nodes before or behind a node, and the one `wide` nodes before it, with the nodes.
fn window<T>(all: &[T], node: usize, wide: usize) -> impl Iterator<Item = (usize, &T)> {
    all.iter().enumerate().take(node + wide).skip(node.saturating_sub(wide))
}

/// Sums over the samples of a sector between two nodes.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    radius: f64,
    square: f64,
    height: f64,
    product: f64,
}

impl Sums {
    /// Adds a sample, its radius from the node below.
    fn add(&mut self, radius: f64, height: f64) {
        self.count += 1.0;
        self.radius += radius;
        self.square += radius * radius;
        self.height += height;
        self.product += radius * height;
    }

    /// Adds sums of a node that lies `by` farther out.
    fn add_moved(&mut self, of: &Sums, weight: f64, by: f64) {
        self.count += weight * of.count;
        self.radius += weight * (of.radius + by * of.count);
        self.square += weight * (of.square + by * (2.0 * of.radius + by * of.count));
        self.height += weight * of.height;
        self.product += weight * (of.product + by * of.height);
    }

    /// Height at the node of a line through the samples, or their mean where they lie at one radius, and as many samples
    /// as would tell a mean as well: fewer where they lie to one side of the node.
    fn at_node(&self) -> (f64, f64) {
        let spread = self.count * self.square - self.radius * self.radius;
        if spread > FLAT * self.count * self.count {
            let height = (self.square * self.height - self.radius * self.product) / spread;
            (spread / self.square, height)
        } else {
            (self.count, self.height / self.count)
        }
    }
}

/// Least squares of a polynomial with N terms.
pub(super) struct Polynomial<const N: usize> {
    normal: SMatrix<f64, N, N>,
    right: SVector<f64, N>,
}

impl<const N: usize> Polynomial<N> {
    pub(super) fn new() -> Polynomial<N> {
        Polynomial { normal: SMatrix::zeros(), right: SVector::zeros() }
    }

    /// Adds a height at a place from -1 to 1.
    pub(super) fn add(&mut self, place: f64, weight: f64, height: f64) {
        if weight <= 0.0 {
            return;
        }
        let mut powers = SVector::<f64, N>::repeat(1.0);
        (1..N).for_each(|degree| powers[degree] = powers[degree - 1] * place);
        self.normal.ger(weight, &powers, &powers, 1.0);
        self.right.axpy(weight * height, &powers, 1.0);
    }

    /// Coefficients, the constant first; `None` where they are not determined.
    pub(super) fn solved(&self) -> Option<SVector<f64, N>> {
        let factor = self.normal.cholesky()?;
        let root = factor.l_dirty();
        let is_told = |term: usize| root[(term, term)] > TOLD * self.normal[(term, term)].sqrt();
        (0..N).all(is_told).then(|| factor.solve(&self.right))
    }
}

/// Nodes to either side that a mean reaches over: 1.5 spacings.
const REACH: usize = 3;
/// Fewest samples of a mean, by weight.
const SAMPLES_LEAST: f64 = 0.5;
/// Least weight of a mean, over the largest of the sectors at its node.
const WEIGHT_LEAST: f64 = 0.25;
/// Variance of radii in squares of nodes below which samples lie at one radius.
const FLAT: f64 = 0.05;
/// Rounds in which quartics are fitted to calmer means.
const CALM_ROUNDS: usize = 2;
/// Standard deviations that a mean may be away from the middle one of the sectors when polynomials are fitted.
const CALM: f64 = 3.0;
/// Share of a term that those before it must leave.
const TOLD: f64 = 1e-3;
