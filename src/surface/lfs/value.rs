//! What is known of the local feature size at a place.

/// The local feature size at a place of a surface, or why it is not known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lfs {
    /// It is known.
    Known {
        /// The best value in mm.
        mm: f64,
        /// It is hardly below this many mm, even if waves of a few samples' length hide in the noise.
        lower_mm: f64,
        /// It is hardly above this many mm; perhaps infinite.
        upper_mm: f64,
    },
    /// Nothing bends and nothing faces the place: no medial ball was found, and none below this size
    /// could have been missed. A plane.
    Beyond {
        /// It is hardly below this many mm.
        lower_mm: f64,
    },
    /// It is at most so large. How small it is cannot be told: it is finer than the samples are apart.
    Hidden {
        /// It is hardly above this many mm.
        upper_mm: f64,
    },
    /// Nothing is known.
    Unknown(Why),
}

/// Why nothing is known of the local feature size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Why {
    /// There are no points.
    NoPoints,
    /// No point has a normal.
    NoNormals,
    /// The points lie within a few sampling gaps of one line: they are no sample of a surface.
    Narrow,
    /// The place is not finite, or not on the nominal.
    Outside,
}

impl Lfs {
    /// The best value in mm: infinite over a plane, none where it is hidden or unknown.
    pub fn mm(&self) -> Option<f64> {
        match *self {
            Lfs::Known { mm, .. } => Some(mm),
            Lfs::Beyond { .. } => Some(f64::INFINITY),
            Lfs::Hidden { .. } | Lfs::Unknown(_) => None,
        }
    }

    /// What it is hardly below, in mm; zero if nothing is known.
    pub fn lower_mm(&self) -> f64 {
        match *self {
            Lfs::Known { lower_mm, .. } | Lfs::Beyond { lower_mm } => lower_mm,
            Lfs::Hidden { .. } | Lfs::Unknown(_) => 0.0,
        }
    }

    /// What it is hardly above, in mm; infinite if nothing is known.
    pub fn upper_mm(&self) -> f64 {
        match *self {
            Lfs::Known { upper_mm, .. } | Lfs::Hidden { upper_mm } => upper_mm,
            Lfs::Beyond { .. } | Lfs::Unknown(_) => f64::INFINITY,
        }
    }
}
