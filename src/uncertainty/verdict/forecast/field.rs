//! The blocks of an aperture, and what was measured in them.

use asphera_form::Aperture;
use asphera_form::NM_PER_MM;
use asphera_geometry::BoundsMm;

/// The measured part of a block of the aperture, or the rest of one.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Its number in the box of the aperture.
    index: usize,
    /// Its mean place, mm.
    pub(super) place_mm: [f64; 2],
    /// Points it holds in the end, if they lie as densely everywhere.
    pub(super) weight: f64,
    /// Measured values; `None` of a rest.
    pub(super) seen: Option<Points>,
    /// Of a rest: the measured part of the same block, if that is half of it at least.
    pub(super) beside: Option<usize>,
}

/// The points of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Points {
    /// Mean deviation, nm.
    pub(super) mean_nm: f64,
    /// Mean square about it, nm².
    pub(super) scatter_nm2: f64,
    /// How far they reach below and above it, nm.
    pub(super) below_nm: f64,
    pub(super) above_nm: f64,
}

#[derive(Clone, Copy)]
struct Sums {
    count: f64,
    place_mm: [f64; 2],
    sum_nm: f64,
    square_nm2: f64,
    low_nm: f64,
    high_nm: f64,
}

impl Sums {
    const NONE: Sums = Sums {
        count: 0.0,
        place_mm: [0.0; 2],
        sum_nm: 0.0,
        square_nm2: 0.0,
        low_nm: f64::INFINITY,
        high_nm: f64::NEG_INFINITY,
    };

    /// Of one point at least.
    fn points(&self) -> Points {
        let mean_nm = self.sum_nm / self.count;
        Points {
            mean_nm,
            scatter_nm2: (self.square_nm2 / self.count - mean_nm * mean_nm).max(0.0),
            below_nm: mean_nm - self.low_nm,
            above_nm: self.high_nm - mean_nm,
        }
    }
}

/// `None` without an aperture, or without a point in it. `missing` is the share of the aperture that was not measured, if
/// that is known: where counts of points seem to say that there is more, blocks that lack least are taken for whole.
pub(super) fn blocks(
    places_mm: &[[f64; 2]],
    deviations_mm: &[f64],
    aperture: &Aperture,
    missing: Option<f64>,
) -> Option<Vec<Block>> {
    let sums = sums(places_mm, deviations_mm, aperture, aperture)?;
    let parts: Vec<Vec<[f64; 2]>> =
        (0..sums.len()).map(|index| parts(index, aperture).collect()).collect();
    let inside = || sums.iter().zip(&parts).filter(|(_, parts)| !parts.is_empty());
    // Points a part of a block, as most have them.
    let mut densities: Vec<f64> = inside()
        .filter(|(sums, _)| sums.count > 0.0)
        .map(|(sums, parts)| sums.count / parts.len() as f64)
        .collect();
    densities.sort_unstable_by(f64::total_cmp);
    let density = *densities.get(densities.len() / 2)?;
    let all = |index: usize| (density * parts[index].len() as f64).max(sums[index].count);
    let filled: Vec<[f64; 2]> = (0..sums.len()).map(|at| [sums[at].count, all(at)]).collect();
    let whole = whole(&filled, missing);
    let mut blocks: Vec<Block> = Vec::new();
    for (index, (sums, parts)) in sums.iter().zip(&parts).enumerate() {
        let all = all(index);
        if parts.is_empty() || all == 0.0 {
            continue;
        }
        let middle_mm =
            |axis: usize| parts.iter().map(|place| place[axis]).sum::<f64>() / parts.len() as f64;
        let middle_mm = [middle_mm(0), middle_mm(1)];
        let share = sums.count / all;
        let mut beside = None;
        let (mut rest_mm, mut rest) = (middle_mm, all);
        if share >= LEAST_SHARE {
            let place_mm = sums.place_mm.map(|sum| sum / sums.count);
            rest = all - sums.count;
            if whole[index] {
                rest = 0.0;
            } else {
                // The two parts have their middle in that of the block, and lie within it.
                let [low_mm, high_mm] = extent_mm(parts);
                rest_mm = [0, 1].map(|axis| {
                    let beyond_mm = share * (middle_mm[axis] - place_mm[axis]) / (1.0 - share);
                    (middle_mm[axis] + beyond_mm).clamp(low_mm[axis], high_mm[axis])
                });
            }
            beside = (share >= 0.5).then_some(blocks.len());
            let weight = all - rest;
            let (seen, none) = (Some(sums.points()), None);
            blocks.push(Block { index, place_mm, weight, seen, beside: none });
        }
        if rest > 0.0 {
            blocks.push(Block { index, place_mm: rest_mm, weight: rest, seen: None, beside });
        }
    }
    Some(blocks)
}

/// Which blocks have no rest, given as the points they hold and will hold: those that are nearly full, and where it is known
/// how much is missing, those with the smallest rests as long as the others make up for as much.
fn whole(filled: &[[f64; 2]], missing: Option<f64>) -> Vec<bool> {
    let mut whole: Vec<bool> =
        filled.iter().map(|[count, all]| *count >= WHOLE_SHARE * all).collect();
    let Some(missing) = missing else { return whole };
    let rest = |at: usize| filled[at][1] - filled[at][0];
    let mut left: Vec<usize> = (0..filled.len()).filter(|&at| !whole[at]).collect();
    left.sort_by(|&a, &b| rest(b).total_cmp(&rest(a)).then(a.cmp(&b)));
    let room = missing * filled.iter().map(|[_, all]| all).sum::<f64>();
    let mut kept = 0.0;
    for at in left {
        whole[at] = kept >= room;
        kept += rest(at);
    }
    whole
}

fn extent_mm(places_mm: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let BoundsMm { low, high } = BoundsMm::about(places_mm.iter().copied());
    [low, high]
}

/// For each block the share of its part in the aperture that is in the zone.
pub(super) fn shares(blocks: &[Block], aperture: &Aperture, zone: &Aperture) -> Vec<f64> {
    let share = |block: &Block| {
        let (mut all, mut inside) = (0.0, 0.0);
        for [x, y] in parts(block.index, aperture) {
            all += 1.0;
            inside += f64::from(u8::from(zone.contains(x, y)));
        }
        inside / all
    };
    blocks.iter().map(share).collect()
}

/// For each block how far its points in the zone reach below and above its mean, nm; `None` without one.
pub(super) fn extremes_nm(
    blocks: &[Block],
    aperture: &Aperture,
    zone: &Aperture,
    places_mm: &[[f64; 2]],
    deviations_mm: &[f64],
) -> Vec<Option<[f64; 2]>> {
    let Some(sums) = sums(places_mm, deviations_mm, aperture, zone) else {
        return vec![None; blocks.len()];
    };
    let of_block = |block: &Block| {
        let (own, seen) = (&sums[block.index], block.seen?);
        (own.count > 0.0).then_some([seen.mean_nm - own.low_nm, own.high_nm - seen.mean_nm])
    };
    blocks.iter().map(of_block).collect()
}

/// Of the points in the zone, by the blocks of the aperture.
fn sums(
    places_mm: &[[f64; 2]],
    deviations_mm: &[f64],
    aperture: &Aperture,
    zone: &Aperture,
) -> Option<Vec<Sums>> {
    let half_mm = aperture.half_extents_mm()?;
    let mut sums = vec![Sums::NONE; SIDE * SIDE];
    for (&[x, y], &deviation_mm) in places_mm.iter().zip(deviations_mm) {
        if !(deviation_mm.is_finite() && aperture.contains(x, y) && zone.contains(x, y)) {
            continue;
        }
        let [column, row] = [x / half_mm[0], y / half_mm[1]]
            .map(|share| ((0.5 * (share + 1.0) * SIDE as f64) as usize).min(SIDE - 1));
        let own = &mut sums[row * SIDE + column];
        let nm = deviation_mm * NM_PER_MM;
        own.count += 1.0;
        own.place_mm[0] += x;
        own.place_mm[1] += y;
        own.sum_nm += nm;
        own.square_nm2 += nm * nm;
        own.low_nm = own.low_nm.min(nm);
        own.high_nm = own.high_nm.max(nm);
    }
    Some(sums)
}

/// Middles of the small parts of a block that lie in the aperture, mm.
fn parts(index: usize, aperture: &Aperture) -> impl Iterator<Item = [f64; 2]> {
    let half_mm = aperture.half_extents_mm().unwrap_or([0.0; 2]);
    let low = [index % SIDE, index / SIDE].map(|at| (at * PARTS) as f64);
    (0..PARTS * PARTS).filter_map(move |part| {
        let at = [part % PARTS, part / PARTS];
        let [x, y] = [0, 1].map(|axis| {
            let share = (low[axis] + at[axis] as f64 + 0.5) / (SIDE * PARTS) as f64;
            half_mm[axis] * (2.0 * share - 1.0)
        });
        aperture.contains(x, y).then_some([x, y])
    })
}

/// Blocks along either side of the box: their covariance is factorised in a millisecond.
const SIDE: usize = 12;
/// Parts of a block along either side.
const PARTS: usize = 8;
/// What was measured of a smaller share of a block does not count.
const LEAST_SHARE: f64 = 0.1;
/// A block of which so much was measured has no rest, whatever is missing: densities differ by as much.
const WHOLE_SHARE: f64 = 0.97;
