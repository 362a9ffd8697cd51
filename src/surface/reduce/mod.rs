//! Reduction of a dense cloud to an ε-sample: which of the measured points are enough.
//!
//! A scan holds more points than its surface needs, and close points are worse than useless where
//! their distance falls to the size of the noise: the facets between them then show the noise, not
//! the surface. Measured lenses of 2.8 and 1.0 million points could not be reconstructed before
//! they were thinned (W. El-Hayek et al., J. Phys.: Conf. Ser. 483 (2014) 012003,
//! doi:10.1088/1742-6596/483/1/012003, section 6). [`Reducer`] keeps or drops each point as it
//! arrives. It never moves one.
//!
//! **The rule.** A point p comes with a [`Spacing`] s(p). It is dropped if a point kept before lies
//! nearer than s(p), else it is kept. From that alone follow, whatever the points and spacings:
//!
//! - *Covering*: every dropped point has a kept one within its own spacing.
//! - *Packing*: of two kept points the later is at least its own spacing away from the earlier. So any
//!   two are at least the smaller of their spacings apart; if |s(p) - s(q)| ≤ L·|p - q|, then at least
//!   1/(1 + L) of the larger.
//!
//! Neither batches nor threads can show, as each point is decided by those before it.
//!
//! **Distances are those in space**, not in the plane of projection. ε-sampling is defined in
//! space; on a slope of 45° a spacing in the plane would leave gaps 1.4 times as wide as meant. And
//! a spike or the second sheet of a fold over a good point is far from it in space: it stays, to be
//! found by [`crate::topography`], where in the plane it would vanish, or be kept in the place of
//! the good one. The price: noise of σ lengthens distances, to √(s² + 2σ²) of a spacing s, which is
//! nothing at the spacings that the noise allows.
//!
//! **From ε to the spacing.** Let every point of the surface have a measured point within the gap
//! g, and let s be the spacing there. Let c be the centre of an empty circle between kept points, R
//! its radius. A measured point p lies within g of c, and one that was kept within s(p) of p, so R
//! ≤ g + s(p). The local feature size changes by no more than the way gone: at the corners of the
//! facet about c it is at least lfs(p) - g - R. So R ≤ ε·lfs holds at every corner if
//!
//! ```text
//! s(p) = ε·(lfs(p) - g) / (1 + ε) - g                                                        (1)
//! ```
//!
//! and with it the condition of N. Amenta and M. Bern
//! (Discrete & Computational Geometry 22 (1999) 481-504, doi:10.1007/PL00009475), which is weaker
//! by 1 + ε. [`reduce()`] takes g from the mesh of all points, vertex by vertex.
//!
//! That is said of places and their nearest points in space. [`crate::assess`] takes the ε of the facets of a mesh,
//! which is an upper bound of it: on a slope facets of the projection reach farther than nearest neighbours in space,
//! as a circle that is empty in the plane need not be the smallest about them. As facets are what is interpolated
//! over, [`reduce()`] takes points back until they pass too (`mend.rs`): on an asphere with slopes up to 45° hardly
//! any, on steeper ones some.
//!
//! **From the noise to the spacing.** A facet is too small for its noise if that turns it by more
//! than a limit; [`crate::noise`] says by which and why, and gives the spacing from which on no facet
//! of any shape is turned so far, [`crate::noise::SpacingCriteria::packed_bound_mm`]. The check,
//! [`crate::noise::assess_spacing`], and the reduction ask one function,
//! [`crate::noise::SpacingCriteria::is_overdense`].
//!
//! Between that bound and (1) any spacing satisfies both; [`Keep`] says which is taken. Where the
//! bound is above (1) there is none; the noise prevails and those points are counted
//! ([`Tally::noise`]). As it holds for the worst of facets, that is so from a noise on about half
//! as large as the one for which [`crate::noise::SpacingCriteria::advice`] finds a conflict, which
//! speaks of even clouds.
//!
//! **How many points stay.** No rule that keeps points s apart can keep more than the hexagonal
//! lattice of that side, one per s²·√3/2; one that covers within s needs at least one per s²·3√3/2,
//! a third of that. Of points in no order this rule keeps 0.55 to 0.60 of the first, of rasters row
//! by row 0.85 to 0.96.

mod average;
mod bend;
mod fitted;
mod grid;
mod mend;
mod reducer;
mod target;
mod whole;

pub use average::{Averaged, AveragedPoint, average};
pub use bend::{CurvatureBound, curvature_bound};
pub use mend::Shortfall;
pub use reducer::{Fate, Reducer, Split, Tally};
pub use target::{About, Bound, Keep, Spacing, Target, TargetError};
pub use whole::{Reduction, Spread, reduce, spread};
