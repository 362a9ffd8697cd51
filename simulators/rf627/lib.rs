//! A simulated RIFTEK RF627 line scanner over a moving part.
//!
//! [`Scanner`] makes datagrams of the profiles of a surface. A [`Scan`] moves the part under it and lists what leaves
//! the scanner and when, with faults of scanner and network ([`Fault`]). [`send`] sends such a list. It knows the
//! protocol from [`asphera_rf627::wire`] and nothing of the driver's state machine.

#![forbid(unsafe_code)]

mod part;
mod scan;
mod scanner;
mod send;

pub use part::Part;
pub use scan::{Departure, Fault, Scan};
pub use scanner::{Optics, Scanner};
pub use send::send;
