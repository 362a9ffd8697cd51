//! What the simulated profiler measures.

use std::fmt;
use std::sync::Arc;

/// Surface of a part: its height in mm over a place (x, y) in mm; `None` beside it.
#[derive(Clone)]
pub struct Surface(Arc<dyn Fn([f64; 2]) -> Option<f64> + Send + Sync>);

impl Surface {
    /// A surface of a function.
    pub fn new(height_mm: impl Fn([f64; 2]) -> Option<f64> + Send + Sync + 'static) -> Surface {
        Surface(Arc::new(height_mm))
    }

    /// Height in mm over a place; `None` beside the part.
    pub fn height_mm(&self, place_mm: [f64; 2]) -> Option<f64> {
        (self.0)(place_mm)
    }
}

impl fmt::Debug for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Surface").finish_non_exhaustive()
    }
}
