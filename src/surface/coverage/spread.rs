//! The distribution of a figure over an area.

use crate::quantile::weighted_quantile;

/// How a figure is distributed over an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Half of the area has at most this.
    pub median: f64,
    /// 99 % of the area has at most this.
    pub p99: f64,
    /// The largest value.
    pub max: f64,
}

/// The spread of values with their areas; none if there are none. Reorders them.
pub(super) fn spread(entries: &mut [(f64, f64)]) -> Option<Spread> {
    let max = entries.iter().map(|&(value, _)| value).reduce(f64::max)?;
    let median = weighted_quantile(entries, 0.5)?;
    let p99 = weighted_quantile(entries, 0.99)?;
    Some(Spread { median, p99, max })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_area() {
        let mut entries = vec![(3.0, 1.0), (1.0, 60.0), (2.0, 39.0)];
        assert_eq!(spread(&mut entries), Some(Spread { median: 1.0, p99: 2.0, max: 3.0 }));
        assert_eq!(spread(&mut []), None);
    }
}
