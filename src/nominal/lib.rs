//! The reader of nominal files: TOML text in, a checked [`Part`](asphera_measure::Part) out.
//!
//! `config/nominals` has an example of every kind of surface. A problem names file, line, key, what is expected and what was
//! found; all problems come at once.

mod aperture;
mod criterion;
mod defects;
mod drawing;
mod figures;
mod flip;
mod judging;
mod part;
mod surface;
mod text;

pub use aperture::aperture_lines_mm;
pub use drawing::{DRAWINGS, drawn_lines, is_drawing};
pub use flip::{FlipError, flipped};
pub use judging::guard;
pub use part::{folder, parse, read};
pub use text::{bytes_of, parse as parse_text, text_of};
