//! CAN frames as text and as records, and settings of devices on a bus, against the laws of their readers.

#![no_main]

use asphera_fuzz::can;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| can::hold(input));
