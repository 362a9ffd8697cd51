//! The core surface of the material ratio curve.

use super::surface::Nodes;
use super::{Parameter, Support, Surface, Unknown};
use crate::Figure;

/// The functional parameters of ISO 25178-2:2021, 4.5, for stratified surfaces (procedure of ISO 13565-2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoreParameters {
    /// Height of the core in nm: fall of the equivalent line from 0 to 100 %.
    pub sk_nm: f64,
    /// Reduced peak height in nm: that of the triangle on Smrk1 with the area of the peaks; 0 without any.
    pub spk_nm: f64,
    /// Reduced dale depth in nm; 0 without dales.
    pub svk_nm: f64,
    /// Material ratio in percent above the core.
    pub smrk1_percent: f64,
    /// Material ratio in percent down to the lower end of the core.
    pub smrk2_percent: f64,
    /// Where the 40 % of the equivalent line begin, in percent.
    pub line_from_percent: f64,
    /// Samples that they rest on.
    pub support: Support,
}

impl CoreParameters {
    /// All but the beginning of the line.
    pub fn figures(&self) -> Vec<Figure> {
        let known = [
            (Parameter::Sk, Some(self.sk_nm)),
            (Parameter::Spk, Some(self.spk_nm)),
            (Parameter::Svk, Some(self.svk_nm)),
            (Parameter::Smrk1, Some(self.smrk1_percent)),
            (Parameter::Smrk2, Some(self.smrk2_percent)),
        ];
        Parameter::known(&known)
    }
}

/// The core of a surface.
///
/// Nodes by falling height, each at the middle of the share of area it stands for, give the material ratio
/// curve, linear between them. Of the secants over 40 % that begin or end at a node the flattest is taken, of
/// equal ones the first; equal is what rounding of heights may part. The equivalent line is that of least squares,
/// in height, of the nodes inside, weighted by area: on a grid, of samples at equal steps of the material ratio.
/// Material ratios and areas beyond the line are sums over whole nodes. `O(n log n)`.
///
/// Unknown with fewer than 5 nodes, or if one alone stands for so much that no 40 % hold two.
pub fn core_parameters(surface: Surface<'_>) -> Result<CoreParameters, Unknown> {
    let nodes = surface.nodes()?;
    let used = nodes.support.points;
    if used < LEAST_NODES {
        return Err(Unknown::TooFewPoints { used, needed: LEAST_NODES });
    }
    let curve = Curve::new(&nodes);
    let lumped = || {
        let largest_share = nodes.shares.iter().copied().fold(0.0, f64::max);
        Unknown::Lumped { largest_share }
    };
    let from = curve.flattest().ok_or_else(lumped)?;
    let (top, slope) = curve.line(from).ok_or_else(lumped)?;
    let bottom = top + slope;
    let (peaks, peak_share) = beyond(&nodes, |z| z - top);
    let (dales, dale_share) = beyond(&nodes, |z| bottom - z);
    let triangle = |area: f64, share: f64| if share > 0.0 { 2.0 * area / share } else { 0.0 };
    Ok(CoreParameters {
        sk_nm: -slope,
        spk_nm: triangle(peaks, peak_share),
        svk_nm: triangle(dales, dale_share),
        smrk1_percent: 100.0 * peak_share,
        smrk2_percent: 100.0 * (1.0 - dale_share),
        line_from_percent: 100.0 * from,
        support: nodes.support,
    })
}

/// Area in nm and share of the nodes with a positive excess.
fn beyond(nodes: &Nodes, excess: impl Fn(f64) -> f64) -> (f64, f64) {
    let pairs = nodes.heights_nm.iter().zip(&nodes.shares);
    let over = pairs.map(|(&z, share)| (excess(z), share)).filter(|(excess, _)| *excess > 0.0);
    over.fold((0.0, 0.0), |(area, all), (excess, share)| (area + excess * share, all + share))
}

/// Material ratio and height of the nodes, highest first, with their shares.
struct Curve {
    ratios: Vec<f64>,
    heights_nm: Vec<f64>,
    shares: Vec<f64>,
}

impl Curve {
    fn new(nodes: &Nodes) -> Curve {
        let mut order: Vec<(f64, f64)> =
            nodes.heights_nm.iter().copied().zip(nodes.shares.iter().copied()).collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
        let mut above = 0.0;
        let ratios = order.iter().map(|(_, share)| {
            above += share;
            above - 0.5 * share
        });
        Curve {
            ratios: ratios.collect(),
            heights_nm: order.iter().map(|(height, _)| *height).collect(),
            shares: order.iter().map(|(_, share)| *share).collect(),
        }
    }

    /// Where the flattest secant begins; `None` if none lies within the nodes.
    fn flattest(&self) -> Option<f64> {
        let (first, last) = (self.ratios[0], self.ratios[self.ratios.len() - 1]);
        let mut secants: Vec<(f64, f64)> = Vec::new();
        let mut cursor = 0;
        for (&ratio, &height) in self.ratios.iter().zip(&self.heights_nm) {
            if ratio + WINDOW <= last {
                secants.push((height - self.height(ratio + WINDOW, &mut cursor), ratio));
            }
        }
        cursor = 0;
        for (&ratio, &height) in self.ratios.iter().zip(&self.heights_nm) {
            if ratio - WINDOW >= first {
                let from = ratio - WINDOW;
                secants.push((self.height(from, &mut cursor) - height, from));
            }
        }
        let least = secants.iter().map(|(fall, _)| *fall).min_by(f64::total_cmp)?;
        let extent = self.heights_nm[0] - self.heights_nm[self.heights_nm.len() - 1];
        let flattest = secants.iter().filter(|(fall, _)| *fall <= least + EQUAL * extent);
        flattest.map(|(_, from)| *from).min_by(f64::total_cmp)
    }

    /// Height at a ratio between those of the first and the last node; the cursor goes along with rising
    /// ratios.
    fn height(&self, ratio: f64, cursor: &mut usize) -> f64 {
        while *cursor + 2 < self.ratios.len() && self.ratios[*cursor + 1] <= ratio {
            *cursor += 1;
        }
        let (low, high) = (self.ratios[*cursor], self.ratios[*cursor + 1]);
        let share = if high > low { ((ratio - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        let (upper, lower) = (self.heights_nm[*cursor], self.heights_nm[*cursor + 1]);
        upper + share * (lower - upper)
    }

    /// Height at 0 and slope per ratio of 1 of the line through the nodes of a window.
    fn line(&self, from: f64) -> Option<(f64, f64)> {
        let begin = self.ratios.partition_point(|&ratio| ratio < from - SLACK);
        let end = self.ratios.partition_point(|&ratio| ratio <= from + WINDOW + SLACK);
        if end < begin + 2 {
            return None;
        }
        let mean = |quantity: &dyn Fn(usize) -> f64| {
            let sum =
                |f: &dyn Fn(usize) -> f64| (begin..end).map(|i| self.shares[i] * f(i)).sum::<f64>();
            sum(quantity) / sum(&|_| 1.0)
        };
        let about = self.heights_nm[begin];
        let (ratio, height) =
            (mean(&|i| self.ratios[i]), mean(&|i| self.heights_nm[i] - about) + about);
        let square = mean(&|i| (self.ratios[i] - ratio) * (self.ratios[i] - ratio));
        let product = mean(&|i| (self.ratios[i] - ratio) * (self.heights_nm[i] - height));
        (square > 0.0).then(|| {
            // A falling curve has no rising line but by rounding.
            let slope = (product / square).min(0.0);
            (height - slope * ratio, slope)
        })
    }
}

/// Falls that differ by less than this share of all heights are equal: a symmetric surface has two flattest secants, and the last bit
/// of its heights is not to choose.
const EQUAL: f64 = 1e-9;
/// Share of the area under the equivalent line.
const WINDOW: f64 = 0.4;
/// Rounding of the ratios at the ends of the window.
const SLACK: f64 = 1e-12;
/// Of which 40 % are two.
const LEAST_NODES: usize = 5;
