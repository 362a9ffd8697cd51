//! A measurement on paper: one HTML file that needs nothing beside itself, and a QIF document.
//!
//! Both are made from the same [`asphera_report::Report`] as every other output, of which the HTML draws the
//! map, the sections and the charts. They hold no clock, no script, no reference to anything outside: the
//! same measurement and [`Provenance`] give the same bytes.

mod charts;
mod defects;
mod errors;
mod map;
mod page;
mod provenance;
mod qif;
mod sections;
mod spectra;
mod standards;
mod tables;
mod words;

pub use page::html;
pub use provenance::{Provenance, SourceFile, SourceFileError};
pub use qif::{QIF_NAMESPACE, qif};
