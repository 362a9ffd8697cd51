//! Where property tests of this crate's own modules keep the cases that failed.
//!
//! The default is a folder beside that of `lib.rs`. There the workspace would take it for a crate
//! and refuse to build; a file beside the source does no harm.

use proptest::prelude::ProptestConfig;
use proptest::test_runner::FileFailurePersistence;

/// The default configuration, but for the place: `<module>.regressions`.
pub(crate) fn beside_source() -> ProptestConfig {
    ProptestConfig::with_failure_persistence(FileFailurePersistence::WithSource("regressions"))
}
