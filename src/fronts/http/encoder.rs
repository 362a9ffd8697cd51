//! Snapshots as JSON text, made once however many clients read them.

use std::sync::{Arc, Mutex, PoisonError};

use asphera_report::Snapshot;
use axum::extract::ws::Utf8Bytes;

/// Keeps the text of the snapshot encoded last. Copies of the text share their memory.
#[derive(Default)]
pub(super) struct Encoder {
    last: Mutex<Option<(Arc<Snapshot>, Utf8Bytes)>>,
}

impl Encoder {
    /// The JSON text of `snapshot`. The lock is held while encoding: who waits wants the same text.
    pub(super) fn encode(&self, snapshot: &Arc<Snapshot>) -> Utf8Bytes {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((of, text)) if Arc::ptr_eq(of, snapshot) => text.clone(),
            _ => {
                let text = serde_json::to_string(snapshot.as_ref())
                    .expect("a snapshot consists of numbers, strings and maps with string keys");
                let text = Utf8Bytes::from(text);
                *last = Some((Arc::clone(snapshot), text.clone()));
                text
            }
        }
    }
}
