//! Files of points in every format, against the laws of what readers give.

#![no_main]

use asphera_fuzz::readers;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| readers::hold(input));
