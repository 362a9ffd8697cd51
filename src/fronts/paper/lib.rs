//! A measurement on paper: one HTML file that needs nothing beside itself, and a QIF document.
//!
//! The HTML draws the chapters of [`asphera_report::View`], and adds the map, the sections and the charts. They hold no clock, no script, no reference to anything outside: the
//! same measurement and [`Provenance`] give the same bytes.

mod blocks;
mod charts;
mod map;
mod page;
mod provenance;
mod qif;
mod sections;
mod spectra;
mod words;

pub use page::html;
pub use provenance::{Provenance, SourceFile, SourceFileError};
pub use qif::{QIF_NAMESPACE, qif};
