//! Devices, against the laws of what drivers make of their bytes.

#![no_main]

use asphera_fuzz::drivers;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| drivers::hold(input));
