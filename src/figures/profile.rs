//! Means over rings and over sectors.

use std::f64::consts::TAU;
use std::num::NonZeroU16;

use super::invariant::{SAME_RADIUS, usual_rings};
use super::{Sample, Unknown};

/// Deviations of the points of one ring or sector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heights {
    /// Area-weighted mean in nm.
    pub mean_nm: f64,
    /// Root of the area-weighted mean square about the mean in nm.
    pub spread_nm: f64,
    /// Smallest in nm.
    pub low_nm: f64,
    /// Largest in nm.
    pub high_nm: f64,
}

/// One ring of a radial profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Inner radius in mm; belongs to it.
    pub from_mm: f64,
    /// Outer radius in mm; belongs to the next ring, that of the last ring to it.
    pub to_mm: f64,
    /// Points in it.
    pub count: usize,
    /// Share of sixteen equal sectors of it that hold a point.
    pub covered: f64,
    /// Its deviations; `None` if no point with an area lies in it.
    pub heights: Option<Heights>,
}

/// One sector of an azimuthal profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sector {
    /// Where it begins in rad, from +x towards +y; belongs to it.
    pub from_rad: f64,
    /// Where it ends in rad.
    pub to_rad: f64,
    /// Points in it.
    pub count: usize,
    /// Its deviations; `None` if no point with an area lies in it.
    pub heights: Option<Heights>,
}

/// Mean deviation by distance from the axis, over `rings` of equal width, by default as many as leave some
/// sixteen points in the innermost of a full disc. The innermost comes first. `O(n)`.
///
/// The rings go from the inner to the outer radius of the aperture. A ring without points stays unknown:
/// nothing is interpolated.
pub fn radial_profile(sample: &Sample, rings: Option<NonZeroU16>) -> Result<Vec<Ring>, Unknown> {
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    let [near_mm, far_mm] = sample.reach_mm();
    if far_mm == 0.0 {
        return Err(Unknown::OnePlace);
    }
    let rings = usize::from(rings.unwrap_or_else(|| usual_rings(sample)).get());
    // All points at one radius make one ring without width.
    let rings = if far_mm - near_mm > SAME_RADIUS * far_mm { rings } else { 1 };
    let width_mm = (far_mm - near_mm) / rings as f64;
    let ring_of = |[x, y]: [f64; 2]| {
        let ring = (x.hypot(y) - near_mm) / width_mm;
        Some(if ring >= 0.0 { (ring as usize).min(rings - 1) } else { 0 })
    };
    let bins = bins(sample, rings, ring_of);
    let mut covered = vec![[false; SECTORS]; rings];
    for &place in sample.places_mm() {
        if let Some(ring) = ring_of(place) {
            covered[ring][sector_of(place, SECTORS)] = true;
        }
    }
    let rings = bins.into_iter().zip(covered).enumerate();
    let rings = rings.map(|(i, ((count, heights), covered))| Ring {
        from_mm: near_mm + width_mm * i as f64,
        to_mm: near_mm + width_mm * (i + 1) as f64,
        count,
        covered: covered.iter().filter(|&&covered| covered).count() as f64 / SECTORS as f64,
        heights,
    });
    Ok(rings.collect())
}

/// Mean deviation by azimuth, over equal `sectors` from +x towards +y, of the points whose distance from
/// the axis lies in `band_mm`, from its first to its second number, both included; of all points without
/// it. `O(n)`.
pub fn azimuthal_profile(
    sample: &Sample,
    sectors: NonZeroU16,
    band_mm: Option<[f64; 2]>,
) -> Result<Vec<Sector>, Unknown> {
    let sectors = usize::from(sectors.get());
    let bins = bins(sample, sectors, |place| {
        let radius_mm = place[0].hypot(place[1]);
        let inside = band_mm.is_none_or(|[from, to]| (from..=to).contains(&radius_mm));
        inside.then(|| sector_of(place, sectors))
    });
    if bins.iter().all(|(count, _)| *count == 0) {
        return Err(Unknown::NoPoints);
    }
    let begin = |i: usize| TAU * i as f64 / sectors as f64;
    let sectors = bins.into_iter().enumerate().map(|(i, (count, heights))| Sector {
        from_rad: begin(i),
        to_rad: begin(i + 1),
        count,
        heights,
    });
    Ok(sectors.collect())
}

fn sector_of([x, y]: [f64; 2], sectors: usize) -> usize {
    let angle = y.atan2(x);
    let turn = if angle < 0.0 { angle + TAU } else { angle } / TAU;
    ((turn * sectors as f64) as usize).min(sectors - 1)
}

/// Number and heights of the points of each bin.
fn bins(
    sample: &Sample,
    count: usize,
    bin_of: impl Fn([f64; 2]) -> Option<usize>,
) -> Vec<(usize, Option<Heights>)> {
    #[derive(Clone, Copy)]
    struct Bin {
        count: usize,
        area: f64,
        sum: f64,
        square: f64,
        low: f64,
        high: f64,
    }
    let empty = Bin {
        count: 0,
        area: 0.0,
        sum: 0.0,
        square: 0.0,
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };
    let mut bins = vec![empty; count];
    let of: Vec<Option<usize>> = sample.places_mm().iter().map(|&place| bin_of(place)).collect();
    let points = || of.iter().zip(sample.values_nm()).zip(sample.areas());
    for ((&bin, &value), &area) in points() {
        let Some(bin) = bin.map(|bin| &mut bins[bin]) else { continue };
        bin.count += 1;
        bin.area += area;
        bin.sum += area * value;
        bin.low = bin.low.min(value);
        bin.high = bin.high.max(value);
    }
    // The squares about the mean need the mean first, else a large piston would cost their digits.
    for ((&bin, &value), &area) in points() {
        let Some(bin) = bin.map(|bin| &mut bins[bin]).filter(|bin| bin.area > 0.0) else {
            continue;
        };
        let off = value - bin.sum / bin.area;
        bin.square += area * off * off;
    }
    let heights = |bin: &Bin| {
        (bin.area > 0.0).then(|| Heights {
            mean_nm: bin.sum / bin.area,
            spread_nm: (bin.square / bin.area).sqrt(),
            low_nm: bin.low,
            high_nm: bin.high,
        })
    };
    bins.iter().map(|bin| (bin.count, heights(bin))).collect()
}

/// Sectors by which the coverage of a ring is judged.
const SECTORS: usize = 16;
