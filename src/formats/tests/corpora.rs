//! The laws of the fuzz targets `readers` and `volumes` over all inputs that are kept: finds of the fuzzer stay mended without it.

#[path = "../../../fuzz/src/readers.rs"]
pub mod readers;
#[path = "../../../fuzz/src/volumes.rs"]
pub mod volumes;

use std::fs;
use std::path::Path;

#[test]
fn inputs_that_a_fuzzer_found_hold_the_laws() {
    hold("seeds/readers", readers::hold);
    hold("corpus/readers", readers::hold);
}

#[test]
fn volumes_that_a_fuzzer_found_hold_the_laws() {
    hold("seeds/volumes", volumes::hold);
    hold("corpus/volumes", volumes::hold);
}

fn hold(folder: &str, law: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz").join(folder);
    let inputs = fs::read_dir(&folder).expect("the inputs lie in the tree");
    let mut held = 0;
    for input in inputs {
        let path = input.expect("a folder that can be listed").path();
        let bytes = fs::read(&path).expect("an input can be read");
        // A law that breaks says what it found; the file is told by a panic of its own.
        let outcome = std::panic::catch_unwind(|| law(&bytes));
        assert!(outcome.is_ok(), "{}", path.display());
        held += 1;
    }
    assert!(held >= 30, "{held} inputs in {}", folder.display());
}
