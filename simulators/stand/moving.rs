//! A station that moves its axes itself: what the other devices show follows where the axes stand.

use std::fmt;
use std::sync::Arc;

/// What moves on order, and what follows it.
#[derive(Clone)]
pub struct Moving {
    travels: Vec<Vec<Option<[f64; 2]>>>,
    follow: Arc<Follow>,
}

type Follow = dyn Fn(u64, &mut [Vec<f64>]) + Send + Sync;

impl Moving {
    /// Axes with so much travel: of each device and channel from where to where the axis runs, in the unit of the channel; `None` where
    /// nothing moves it.
    ///
    /// `follow` takes the number of a reading and the values of all channels of all devices, where those of moved axes and of what stands
    /// still are right. It sets the others.
    pub fn new(
        travels: Vec<Vec<Option<[f64; 2]>>>,
        follow: impl Fn(u64, &mut [Vec<f64>]) + Send + Sync + 'static,
    ) -> Moving {
        Moving { travels, follow: Arc::new(follow) }
    }

    /// Travel of a channel, where something moves it.
    pub(crate) fn travel(&self, device: usize, channel: usize) -> Option<[f64; 2]> {
        *self.travels.get(device)?.get(channel)?
    }

    /// Sets the values that follow the axes.
    pub(crate) fn follow(&self, reading: u64, values: &mut [Vec<f64>]) {
        (self.follow)(reading, values);
    }
}

impl fmt::Debug for Moving {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Moving").field("travels", &self.travels).finish_non_exhaustive()
    }
}
