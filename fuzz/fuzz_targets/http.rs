//! Requests to the server, against the laws of its answers.

#![no_main]

use asphera_fuzz::http;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| http::hold(input));
