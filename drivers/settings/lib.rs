//! TOML files read key by key, with the place of everything.
//!
//! A person who sets up a bench wants all mistakes at once: each with file, line and key, what would do and
//! what is there. Serde stops at the first one. So tables are read by hand: a [`Section`] notes each key that is
//! asked for, and [`Section::finish`] reports the keys that nobody asked for, which are typing errors.
//!
//! ```
//! use asphera_settings::File;
//!
//! let file = File::parse("bench.toml", "[link.probe]\nbaud = 9600\n")?;
//! let root = file.root();
//! for (_, link) in root.sections("link") {
//!     link.within("baud_bd", 115_200, 300..=4_000_000u32);
//!     link.finish();
//! }
//! root.finish();
//! drop(root);
//! let problems = file.conclude(Some(())).unwrap_err();
//! assert_eq!(
//!     problems.to_string(),
//!     "bench.toml:2: link.probe.baud: expected a known key (did you mean `baud_bd`?), found `baud`"
//! );
//! # Ok::<(), asphera_settings::Problems>(())
//! ```
//!
//! This crate deliberately knows no device, opens no file and holds no settings itself.

#![forbid(unsafe_code)]

mod document;
mod item;
mod nearest;
mod problem;
mod syntax;

pub use document::{File, Section};
pub use item::{FromItem, OrAuto, number};
pub use problem::{Problem, Problems};
