//! What a line scanner sees.

use std::fmt;
use std::sync::Arc;

/// What a line scanner sees of a part that moves under it.
#[derive(Clone)]
pub struct Sight {
    points: usize,
    height: Arc<Height>,
}

type Height = dyn Fn(u64, usize, f64) -> Option<f64> + Send + Sync;

impl Sight {
    /// A line of so many points, where the device does not say how many it has.
    ///
    /// `height_mm` takes the trigger, the number of the point and its place along the line in mm, as the device measures it, and gives
    /// the height in mm as the device measures it; `None` where there is nothing.
    pub fn new(
        points: usize,
        height_mm: impl Fn(u64, usize, f64) -> Option<f64> + Send + Sync + 'static,
    ) -> Sight {
        Sight { points, height: Arc::new(height_mm) }
    }

    /// Points of the line.
    pub(crate) fn points(&self) -> usize {
        self.points
    }

    /// Height at a point, mm.
    pub(crate) fn height_mm(&self, trigger: u64, point: usize, across_mm: f64) -> Option<f64> {
        (self.height)(trigger, point, across_mm)
    }
}

impl fmt::Debug for Sight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sight").field("points", &self.points).finish_non_exhaustive()
    }
}
