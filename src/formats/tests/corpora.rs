//! The laws of the fuzz target `readers` over all inputs that are kept: finds of the fuzzer stay mended without it.

#[path = "../../../fuzz/src/readers.rs"]
pub mod readers;

use std::fs;
use std::path::Path;

#[test]
fn inputs_that_a_fuzzer_found_hold_the_laws() {
    for folder in ["seeds/readers", "corpus/readers"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz").join(folder);
        let inputs = fs::read_dir(&folder).expect("the inputs lie in the tree");
        let mut held = 0;
        for input in inputs {
            let path = input.expect("a folder that can be listed").path();
            let bytes = fs::read(&path).expect("an input can be read");
            // A law that breaks says what it found; the file is told by a panic of its own.
            let outcome = std::panic::catch_unwind(|| readers::hold(&bytes));
            assert!(outcome.is_ok(), "{}", path.display());
            held += 1;
        }
        assert!(held >= 30, "{held} inputs in {}", folder.display());
    }
}
