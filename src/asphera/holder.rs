//! Who holds a port: for messages that say what to end.

pub use asphera_transport::{Holder, holder_of_port};
