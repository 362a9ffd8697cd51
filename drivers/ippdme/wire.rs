//! Lines of I++ DME: bytes and types, no state beyond the begin of a line.
//!
//! ```text
//! 00010 PtMeas(X(1.33), Y(-2.6E01), Z(30.998), IJK(2,2,2))⏎   command: tag, method
//! 00010 &⏎                                                    acknowledged
//! 00010 # X(3.06205), Y(-24.26795), Z(32.73005)⏎              data
//! 00010 ! Error(2, 1006, "cause", "Surface not found")⏎       error
//! 00010 %⏎                                                    complete
//! ```
//!
//! A line ends with CR LF, and has bytes 32 to 126 only.

mod answer;
mod call;
mod lines;
mod server_error;
mod tag;

pub use answer::{Answer, Data, Kind, numbers};
pub use call::{Argument, Call, CallError, items};
pub use lines::{Framer, LineError, MAX_LINE};
pub use server_error::{ServerError, Severity};
pub use tag::Tag;
