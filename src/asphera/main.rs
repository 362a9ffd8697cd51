//! asphera: form of optical surfaces while they are measured.

use std::process::ExitCode;

fn main() -> ExitCode {
    asphera::cli::main()
}
