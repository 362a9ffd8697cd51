//! Files of volumes in every format, at once and slice by slice.

#![no_main]

use asphera_fuzz::volumes;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| volumes::hold(input));
