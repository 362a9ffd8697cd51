//! Configurations, nominals and lens files, against the laws of what is read of them.

#![no_main]

use asphera_fuzz::toml;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| toml::hold(input));
