//! A length that takes time to find, found once.

use std::sync::OnceLock;

/// A length in mm that follows from the rest of a shape. Whether it was asked for does not make two shapes differ.
#[derive(Clone, Debug, Default)]
pub(super) struct AtFirstUse(OnceLock<f64>);

impl AtFirstUse {
    /// The length; `find` is asked the first time only.
    pub(super) fn or_find(&self, find: impl FnOnce() -> f64) -> f64 {
        *self.0.get_or_init(find)
    }
}

impl PartialEq for AtFirstUse {
    fn eq(&self, _: &AtFirstUse) -> bool {
        true
    }
}
