//! slcan, the ASCII protocol of serial CAN adapters (Lawicel CAN232/CANUSB and its many relatives).
//!
//! One line is one frame or one command, ended by CR; a lone BEL (0x07) is the adapter's "no".
//! [`Decoder`] turns bytes, cut anywhere, into [`Item`]s; [`encode`] and [`Command`] give bytes. The
//! decoder reads both directions of the line, so the same one serves a host, an adapter and two
//! hosts on one null-modem.
//!
//! Sources: comment of Linux `drivers/net/can/slcan.c` (frames), EasySYNC USB2-F-7x01 user guide
//! ES_000005 sections 4.1 ff. (commands, timestamps), Nakakiyo092/canable2-fw wiki, page 1 (command
//! list, CAN FD lines).
//!
//! This crate deliberately opens no port and knows nothing of any device.
//!
//! # What a damaged line can do
//!
//! slcan has no checksum. A line is accepted only if its letter, the number of its hexadecimal
//! digits and the range of its identifier all fit, which leaves these holes:
//!
//! - **A byte replaced by another.** If the new byte is uniformly random it is another hexadecimal
//!   digit, upper or lower case, with probability about 20/256 = 8 %; the frame then has a wrong
//!   identifier or a wrong nibble and nothing in the line tells. Everything else is seen.
//! - **Bytes inserted or lost** change the length of the line and are always seen, but for one case:
//!   a hole that swallows the end of one line and the start of a later one, and is exactly as long
//!   as a whole number of lines. The halves then join into a well-formed line made of two frames. On
//!   a stream of lines of 14 bytes (a position of four bytes) a hole of random length does so with
//!   probability about 1/14. Receive overruns of a UART are such holes; TCP and USB have none.
//! - **Pure noise** is a line with a probability of about 1.4e-10 a byte (the shortest, `t`/`r` + three
//!   digits + length + CR; nine remote lengths and one data length, 1.4e-11 each).
//! - **A classic frame cannot begin inside another one**: `t`, `T`, `r` and `R` are no hexadecimal digits. The letters of CAN FD
//!   are: the tail of a damaged line may be one, if length and digits fit. A bus whose drivers read classic frames alone never
//!   gives them such a frame.
//! - **A length digit damaged by two**, or four digits lost, look like a timestamp appearing or
//!   vanishing. Both are seen once the decoder knows which to expect ([`Timestamps::Always`] or
//!   [`Timestamps::Never`]).
//!
//! Whoever needs more than that must check what the frames say: counters, ranges, time.

#![forbid(unsafe_code)]

mod bit_rate;
mod command;
mod decode;
mod encode;
mod hex;
mod item;
mod stamps;

pub use bit_rate::{BitRate, DataBitRate, UnsupportedBitRate, UnsupportedDataBitRate};
pub use command::Command;
pub use decode::{Decoder, MAX_LINE, Timestamps};
pub use encode::{TIMESTAMP_MODULUS_MS, encode, encode_timestamped};
pub use item::{AdapterStatus, Item};
pub use stamps::StampClock;

/// End of every line, and alone the adapter's "done".
pub const CR: u8 = b'\r';

/// The adapter's "no" (ASCII BEL).
pub const BEL: u8 = 0x07;
