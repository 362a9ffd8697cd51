//! A figure as it may turn out.

/// A figure of all wholes.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// In nm, ascending; never empty.
    values_nm: Vec<f64>,
}

impl Predicted {
    /// Of values in nm, one at least.
    pub(in crate::verdict) fn of_values(mut values_nm: Vec<f64>) -> Predicted {
        debug_assert!(!values_nm.is_empty(), "a value");
        values_nm.sort_unstable_by(f64::total_cmp);
        Predicted { values_nm }
    }

    /// Not exceeded with probability `p`, 0 to 1, in nm.
    pub fn quantile_nm(&self, p: f64) -> f64 {
        let last = self.values_nm.len() - 1;
        self.values_nm[((p * self.values_nm.len() as f64) as usize).min(last)]
    }

    /// The probability that it exceeds a limit in nm.
    pub fn beyond(&self, limit_nm: f64) -> f64 {
        let within = self.values_nm.partition_point(|&nm| nm <= limit_nm);
        1.0 - within as f64 / self.values_nm.len() as f64
    }
}
