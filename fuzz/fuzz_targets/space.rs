//! Few points in space by the local surface, by exact tetrahedra and by one more method.

#![no_main]

use asphera_fuzz::space::{Cloud, hold};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|cloud: Cloud| hold(&cloud));
