//! Parts of a scene by a library: what `asphera parts` and a station share.

mod figures;
mod form;
mod library;
mod plan;
mod running;
mod scene;
mod shape;

pub(crate) use self::figures::{judged, matched};
pub(crate) use self::form::form;
pub(crate) use self::library::{Library, files_in};
pub use self::plan::PartsPlan;
pub(crate) use self::plan::{Judged, heights_of_parts, sampling_without_whole};
pub(crate) use self::running::RunningParts;
pub(crate) use self::scene::{Scene, ScenePart, figures_of, parts_of, pieces};
