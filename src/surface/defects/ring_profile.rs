//! Form that is alike about the axis of a part: rings and waves of turning and of zonal polishing, and a turned edge.
//!
//! Where points are so coarse that no window follows a ring, the ring looks like a bent ridge. But a scratch does not run
//! round the axis at one height. So what is alike all round is form, however narrow:
//!
//! 1. Each of twelve sectors about the axis has its mean deviation at radii half a spacing apart (`ring_profile/sectors.rs`).
//! 2. A quartic along each diameter is taken off the means, for a quartic over the plane is what every window of the
//!    reference follows. *Rings* are what a quadratic over 30 spacings to either side then leaves. It leaves out
//!    the middle, where a pit is alike in all sectors as well. The mean of the middle third of the sectors counts, and what is
//!    far from the other sectors bends neither, so a defect in a quarter of the circle moves nothing.
//! 3. If nearly all sectors stand out to the same side anywhere outside the middle, there is a *profile*: what the
//!    quartic leaves of the means.
//! 4. The profile has the rings of the middle only if these are no higher than the ones around. Else they may be a defect.
//! 5. Where only some sectors go on, in corners, the profile goes on by these (`ring_profile/corners.rs`).
//! 6. The rings may lie about a place beside the axis, and swell round it (`ring_profile/uneven.rs`): the profile is found
//!    anew about that place, without the swelling, until neither changes.
//! 7. In each, a second round over the remainder gives back what the means flattened (J. W. Tukey's twicing).

mod corners;
mod quartic;
mod sectors;
mod uneven;

use self::quartic::Quartic;
use self::sectors::{Mean, Polar, SECTORS, Sectors};
use self::uneven::{Change, Uneven, WAVES};
use super::DeviatingSurface;
use super::tail;

/// Ring profile of a surface.
pub(super) struct RingProfile {
    /// The middle of the rings from the axis.
    centre_mm: [f64; 2],
    step_mm: f64,
    /// By nodes outwards from the middle, in mm.
    heights_mm: Vec<f64>,
    uneven: Uneven,
}

impl RingProfile {
    /// Finds the profile of a surface whose vertices have `places_mm` about the axis; `None` where no form is alike all
    /// round. Takes some 30 ns a vertex, and as much again for each of up to [`FITS`] better ones.
    pub(super) fn of(
        surface: &DeviatingSurface<'_>,
        places_mm: &[[f64; 2]],
    ) -> Option<RingProfile> {
        let mut found = RingProfile::about([0.0; 2], Uneven::default(), surface, places_mm)?;
        let mut last = f64::INFINITY;
        for _ in 0..FITS {
            let (RingProfile { centre_mm, step_mm, uneven, .. }, Some(change)) = &found else {
                break;
            };
            let [away, swell] = change.sizes();
            let size = (away / NEAR).max(swell / EVEN);
            let centre_mm = [0, 1].map(|axis| centre_mm[axis] + change.centre[axis] * step_mm);
            let far = centre_mm[0].hypot(centre_mm[1]) > FARTHEST * step_mm;
            if far || size < 1.0 || size >= last {
                break;
            }
            last = size;
            let by = if swell < EVEN { [0.0; WAVES] } else { change.terms };
            let terms = std::array::from_fn(|term| uneven.terms[term] + by[term]);
            let uneven = Uneven { rings_mm: change.rings_mm.clone(), terms };
            let Some(better) = RingProfile::about(centre_mm, uneven, surface, places_mm) else {
                break;
            };
            found = better;
        }
        Some(found.0)
    }

    /// The same about a place, with rings that change round, and how much more they do.
    fn about(
        centre_mm: [f64; 2],
        uneven: Uneven,
        surface: &DeviatingSurface<'_>,
        places_mm: &[[f64; 2]],
    ) -> Option<(RingProfile, Option<Change>)> {
        let step_mm = surface.spacing_mm / NODES_PER_SPACING;
        let mut profile = RingProfile { centre_mm, step_mm, heights_mm: Vec::new(), uneven };
        let polar = |(&place_mm, &deviation_mm): (&[f64; 2], &f64)| {
            let place = profile.place(place_mm);
            Polar::new(place, deviation_mm - profile.uneven.height_mm(place))
        };
        let pairs = places_mm.iter().zip(surface.deviations_mm);
        let polar: Vec<Polar> =
            pairs.filter(|(_, deviation_mm)| deviation_mm.is_finite()).map(polar).collect();
        let farthest = polar.iter().map(|of| of.radius).fold(0.0, f64::max);
        // Written so that NaN fails.
        if !(farthest >= NODES_LEAST as f64 && farthest <= polar.len() as f64) {
            return None;
        }
        let nodes = farthest as usize + 1;
        let flat = Sectors::new(&polar, nodes, |_| 0.0).flat();
        let rings = Alike::of(&flat.without_wide(WIDE, 0))?;
        let middle_is_higher = rings.middle_is_higher(&rings.standing_out()?);
        let alike_mm = |flat: &Sectors| {
            let Alike { mut heights_mm, last, .. } = Alike::of(&flat.means)?;
            corners::go_on(&mut heights_mm, last, &flat.means);
            if middle_is_higher {
                let rings = Alike::of(&flat.without_wide(WIDE, MIDDLE))?;
                rings.fade(&mut heights_mm);
            }
            Some(heights_mm)
        };
        profile.heights_mm = alike_mm(&flat)?;
        let left = Sectors::new(&polar, nodes, |radius| profile.at(radius)).flat();
        let more_mm = alike_mm(&left)?;
        let rings_mm = profile.rings_mm(&flat);
        let change = Uneven::change(&profile.heights_mm, rings_mm, &left, MIDDLE);
        profile.heights_mm.iter_mut().zip(more_mm).for_each(|(mm, more_mm)| *mm += more_mm);
        Some((profile, change))
    }

    /// The rings of the profile: without its quartic, and without the middle, where nothing says on which side they are higher.
    fn rings_mm(&self, flat: &Sectors) -> Vec<f64> {
        let quartic = Quartic::of(&self.heights_mm, self.heights_mm.len(), &flat.means);
        let ring = |(node, height_mm): (usize, &f64)| {
            outside(node) * (height_mm - quartic.at(node).unwrap_or(*height_mm))
        };
        self.heights_mm.iter().enumerate().map(ring).collect()
    }

    /// Height in mm at a place about the axis.
    pub(super) fn height_mm(&self, place_mm: [f64; 2]) -> f64 {
        let place = self.place(place_mm);
        self.at(place[0].hypot(place[1])) + self.uneven.height_mm(place)
    }

    /// A place about the axis from the middle of the rings, in nodes.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.centre_mm[0]) / self.step_mm, (y - self.centre_mm[1]) / self.step_mm]
    }

    /// The same at a distance from the middle in nodes.
    fn at(&self, radius: f64) -> f64 {
        let below = (radius as usize).min(self.heights_mm.len() - 2);
        let [low, high] = [below, below + 1].map(|node| self.heights_mm[node]);
        low + (radius - below as f64) * (high - low)
    }
}

/// Heights that the sectors have in common.
struct Alike {
    heights_mm: Vec<f64>,
    /// Standard deviation by the scatter of the sectors.
    deviations_mm: Vec<f64>,
    /// Height in the direction of the common one that all but a fifth of the sectors reach, in their standard deviations.
    reached: Vec<f64>,
    /// Standard deviation of single samples by that scatter.
    single_mm: f64,
    /// The last node where as many sectors are known as usual: each lost a quartic of its own, so a mean of fewer is another.
    last: usize,
}

impl Alike {
    /// `None` where nowhere enough sectors are known.
    fn of(sectors: &[Vec<Mean>]) -> Option<Alike> {
        let nodes = sectors.first()?.len();
        let (mut heights_mm, mut reached) = (vec![0.0; nodes], vec![0.0; nodes]);
        let (mut weights, mut scatter) = (vec![0.0; nodes], Vec::new());
        let mut counts = vec![0; nodes];
        for node in 0..nodes {
            let all = sectors.iter().map(|sector| sector[node]);
            let mut at: Vec<Mean> = all.filter(|mean| mean.weight > 0.0).collect();
            let count = at.len();
            if count < SECTORS_LEAST {
                continue;
            }
            counts[node] = count;
            at.sort_unstable_by(|p, q| p.height_mm.total_cmp(&q.height_mm));
            let height_mm = middle_third(&at, |mean| mean.height_mm);
            heights_mm[node] = height_mm;
            let fewest = if height_mm > 0.0 { count / 5 } else { count - 1 - count / 5 };
            let Mean { weight, height_mm: least_mm, .. } = at[fewest];
            reached[node] = least_mm * weight.sqrt() * height_mm.signum();
            weights[node] = at.iter().map(|mean| mean.weight).sum();
            if node >= MIDDLE {
                let apart = |of: &Mean| (of.height_mm - height_mm).abs() * of.weight.sqrt();
                scatter.extend(at.iter().map(apart));
            }
        }
        let usual = usual(&counts)?;
        let last = counts.iter().rposition(|&count| count >= usual)?;
        level(&mut heights_mm, &mut weights);
        let scatter_mm = tail::scale(&mut scatter)?;
        reached.iter_mut().for_each(|reached| *reached /= scatter_mm);
        let deviations_mm = weights.iter().map(|weight| scatter_mm / weight.sqrt()).collect();
        Some(Alike { heights_mm, deviations_mm, reached, single_mm: scatter_mm, last })
    }

    /// The nodes outside the middle where nearly all sectors stand out from their scatter to one side; `None` without any.
    fn standing_out(&self) -> Option<Vec<usize>> {
        let stands_out = |&node: &usize| {
            self.reached[node] > SURE && self.heights_mm[node].abs() > LOWEST * self.single_mm
        };
        let nodes = (MIDDLE..self.heights_mm.len()).filter(stands_out);
        Some(nodes.collect()).filter(|found: &Vec<usize>| !found.is_empty())
    }

    /// Whether the middle stands higher than the rings next to it.
    fn middle_is_higher(&self, stand_out: &[usize]) -> bool {
        let sure_mm = |node: usize| {
            let by_chance_mm = CHANCE * self.deviations_mm[node];
            (self.heights_mm[node].abs() - by_chance_mm).max(0.0)
        };
        let next = stand_out.iter().filter(|&&node| node < MIDDLE + WIDE);
        let next_mm = next.map(|&node| self.heights_mm[node].abs()).fold(0.0, f64::max);
        (0..MIDDLE).map(sure_mm).fold(0.0, f64::max) > HIGHER * next_mm
    }

    /// Takes the rings out of a profile in the middle, and a share of them next to it.
    fn fade(&self, profile_mm: &mut [f64]) {
        for (node, (mm, ring_mm)) in profile_mm.iter_mut().zip(&self.heights_mm).enumerate() {
            *mm -= (1.0 - outside(node)) * ring_mm;
        }
    }
}

/// The count of sectors that most nodes have, of those with enough; `None` without any.
fn usual(counts: &[usize]) -> Option<usize> {
    let nodes = |usual: &usize| counts.iter().filter(|&count| count == usual).count();
    (SECTORS_LEAST..=SECTORS).max_by_key(nodes).filter(|usual| nodes(usual) > 0)
}

/// Share of the rings at a node that are outside the middle.
fn outside(node: usize) -> f64 {
    let way = (node.saturating_sub(MIDDLE) as f64 / TAPER).min(1.0);
    way * way * (3.0 - 2.0 * way)
}

/// Mean of the middle third of what is sorted; not of nothing.
fn middle_third<T>(sorted: &[T], height_mm: impl Fn(&T) -> f64) -> f64 {
    let count = sorted.len();
    let middle = &sorted[count / 3..count - count / 3];
    middle.iter().map(height_mm).sum::<f64>() / middle.len() as f64
}

/// Lets heights go on level where too few sectors have samples, next to the axis and in corners.
fn level(heights_mm: &mut [f64], weights: &mut [f64]) {
    let Some(first) = weights.iter().position(|&weight| weight > 0.0) else { return };
    let mut last = (heights_mm[first], weights[first]);
    for (height_mm, weight) in heights_mm.iter_mut().zip(weights) {
        if *weight == 0.0 {
            (*height_mm, *weight) = last;
        }
        last = (*height_mm, *weight);
    }
}

/// Fits of the middle of the rings and of how they change round.
const FITS: usize = 5;
/// Nodes by which the middle is known well enough.
const NEAR: f64 = 0.05;
/// Share of the rings' height by which the change round is.
const EVEN: f64 = 0.03;
/// Nodes from the axis within which it lies.
const FARTHEST: f64 = 10.0;
/// Nodes along a spacing.
const NODES_PER_SPACING: f64 = 2.0;
/// Fewer sectors with samples do not tell what is alike all round.
const SECTORS_LEAST: usize = SECTORS * 3 / 4;
/// Nodes to either side that a ring is narrower than: half of the widest window of the reference.
const WIDE: usize = 60;
/// Nodes of the middle: at its border a defect of the largest width covers a quarter of the circle.
const MIDDLE: usize = 26;
/// Nodes over which rings fade towards the middle.
const TAPER: f64 = 14.0;
/// Nodes of the smallest surface.
const NODES_LEAST: usize = 3 * MIDDLE;
/// Standard deviations by which a ring stands out in nearly all sectors: of noise alone one does by chance in millions, also
/// where a defect covers four of them.
const SURE: f64 = 1.5;
/// Lowest ring, in standard deviations of single samples: lower ones are no defects unless wide, and then windows follow them.
const LOWEST: f64 = 0.7;
/// Standard deviations that noise may add in the middle.
const CHANCE: f64 = 3.0;
/// How much higher than the rings about it the middle may be.
const HIGHER: f64 = 1.5;

#[cfg(test)]
mod tests;
