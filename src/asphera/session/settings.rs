//! How often a recording is cut, written and made durable.

use asphera_link::{Problem, check_range};

use super::RecordError;

/// Settings of a recorder. The defaults lose at most 0.25 s to a killed process and 1 s to a power cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Uncompressed size above which a chunk is closed, bytes, 1024 to 1 MiB. A longer entry has a
    /// chunk of its own.
    pub chunk_bytes: u32,
    /// Age at which a chunk is closed and handed to the operating system, ms, 1 to 60,000.
    pub chunk_ms: u32,
    /// Time an entry may wait to be made durable (`fdatasync`), ms, 0 to 60,000. 0: with each append.
    pub sync_ms: u32,
    /// File size at which a segment is closed, bytes, 1024 to 1 TiB.
    pub segment_bytes: u64,
    /// Age at which a segment is closed, s, 1 to 86,400.
    pub segment_s: u32,
    /// Free space below which recording stops in good order, bytes; 0 to record until the disk is full.
    pub reserve_bytes: u64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            chunk_bytes: 64 << 10,
            // Half of what is promised: the rest is for threads that wait for their turn.
            chunk_ms: 125,
            sync_ms: 1000,
            segment_bytes: 64 << 20,
            segment_s: 60,
            reserve_bytes: 256 << 20,
        }
    }
}

impl Settings {
    /// Every value out of its range; empty when a recorder can use the settings.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_range(&mut problems, "chunk_bytes", self.chunk_bytes, 1 << 10, 1 << 20);
        check_range(&mut problems, "chunk_ms", self.chunk_ms, 1, 60_000);
        check_range(&mut problems, "sync_ms", self.sync_ms, 0, 60_000);
        check_range(&mut problems, "segment_bytes", self.segment_bytes, 1 << 10, 1 << 40);
        check_range(&mut problems, "segment_s", self.segment_s, 1, 86_400);
        problems
    }

    pub(super) fn check(&self) -> Result<(), RecordError> {
        match self.problems().into_iter().next() {
            None => Ok(()),
            Some(problem) => Err(RecordError::Value {
                key: problem.key,
                expected: problem.expected,
                found: problem.found,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_can_be_used() {
        assert_eq!(Settings::default().problems(), []);
    }

    #[test]
    fn every_value_out_of_range_is_told() {
        let settings = Settings {
            chunk_bytes: 0,
            chunk_ms: 0,
            sync_ms: 60_001,
            segment_bytes: 0,
            segment_s: 0,
            reserve_bytes: u64::MAX,
        };
        let keys: Vec<_> = settings.problems().into_iter().map(|problem| problem.key).collect();
        assert_eq!(keys, ["chunk_bytes", "chunk_ms", "sync_ms", "segment_bytes", "segment_s"]);
        assert!(matches!(settings.check(), Err(RecordError::Value { .. })));
    }
}
