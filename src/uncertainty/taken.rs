//! Where the points of an uncertainty were taken, and how that scatters means over the area.
//!
//! Limits are of figures that are formed after the fit: a coefficient, or the root of a mean square of what least squares
//! leave. To first order such a figure is a mean over the area of what each point is worth to it (its influence: Hampel, J.
//! Am. Stat. Assoc. 69 (1974) 383). Places scattered within strata give that mean a variance, as in [`super::places()`].

use super::places::Places;
use super::strata::Stratum;

/// The points used, by their order there.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// Share of the area that each stands for.
    pub(super) shares: Vec<f64>,
    strata: Vec<Stratum>,
}

/// What a point is worth to a figure, in the unit of the figure or of its square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Worth {
    pub(crate) value: f64,
    /// Of the variance that noise gives the value, by its variance σ² and by σ⁴ in mm² and mm⁴.
    pub(crate) by_noise: [f64; 2],
}

impl Taken {
    /// `indices` are those of the points used among the points of `places`, in ascending order.
    pub(super) fn new(places: &Places, indices: &[usize]) -> Taken {
        let used = |index: &usize| indices.binary_search(index).ok();
        let strata = places.strata.iter().map(|stratum| {
            let all = stratum.members.iter().map(used);
            let kept = all.enumerate().filter_map(|(at, place)| Some((at, place?)));
            let (kept, members): (Vec<usize>, Vec<usize>) = kept.unzip();
            Stratum {
                members,
                weights: kept.iter().map(|&at| stratum.weights[at]).collect(),
                off_mm: kept.iter().map(|&at| stratum.off_mm[at]).collect(),
                ..*stratum
            }
        });
        Taken {
            strata: strata.collect(),
            shares: indices.iter().map(|&index| places.shares[index]).collect(),
        }
    }

    /// Variance of the mean over the area of what points are worth, less that by their noise.
    pub(super) fn scatter(&self, worth: &[Worth], noise_mm2: &[f64]) -> f64 {
        let of_stratum = |stratum: &Stratum| {
            let members = || stratum.members.iter();
            let by_noise = members().map(|&at| {
                let [square, fourth] = worth[at].by_noise;
                noise_mm2[at] * (square + fourth * noise_mm2[at])
            });
            let by_noise = by_noise.sum::<f64>() / stratum.members.len().max(1) as f64;
            let values: Vec<f64> = members().map(|&at| worth[at].value).collect();
            stratum.weight() * (stratum.variance(&values) - by_noise)
        };
        let strata = self.strata.iter().filter(|stratum| !stratum.members.is_empty());
        strata.map(of_stratum).sum::<f64>().max(0.0)
    }
}
