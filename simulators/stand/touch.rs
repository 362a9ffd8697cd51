//! What the probe of a measuring machine touches.

use std::fmt;
use std::sync::Arc;

use asphera_sim_ippdme::{Machine, MachineSettings, Probe, Surface};

/// A part under the probe of a machine that runs a program.
#[derive(Clone)]
pub struct Touch {
    noise_nm: f64,
    seed: u64,
    speed: f64,
    height: Arc<Height>,
}

type Height = dyn Fn([f64; 2]) -> Option<f64> + Send + Sync;

impl Touch {
    /// A part whose readings have a standard deviation of `noise_nm`, under a machine that is `speed` times as fast as usual.
    ///
    /// `height_mm` takes x and y and gives z, all mm as the machine reads them; `None` beside the part.
    pub fn new(
        height_mm: impl Fn([f64; 2]) -> Option<f64> + Send + Sync + 'static,
        noise_nm: f64,
        seed: u64,
        speed: f64,
    ) -> Touch {
        Touch { noise_nm, seed, speed, height: Arc::new(height_mm) }
    }

    /// A machine over this part.
    pub(crate) fn machine(&self) -> Machine {
        let height = Arc::clone(&self.height);
        let surface = Surface::new(move |place_mm| height(place_mm));
        let usual = MachineSettings::usual();
        Machine::new(MachineSettings {
            // The heights are those that are read: the ball is in them.
            probe: Probe { surface, radius_mm: 0.0 },
            noise_nm: self.noise_nm,
            seed: self.seed,
            speed_mm_s: self.speed * usual.speed_mm_s,
            touch_mm_s: self.speed * usual.touch_mm_s,
            scan_mm_s: self.speed * usual.scan_mm_s,
            ..usual
        })
    }
}

impl fmt::Debug for Touch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Touch").field("noise_nm", &self.noise_nm).finish_non_exhaustive()
    }
}
