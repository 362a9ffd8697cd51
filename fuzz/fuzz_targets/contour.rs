//! Few points of every kind by every method of contours.

#![no_main]

use asphera_fuzz::contour::{Drawing, hold};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|drawing: Drawing| hold(&drawing));
