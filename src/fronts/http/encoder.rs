//! Snapshots as JSON text with their words, made once however many clients read them.

use std::sync::{Arc, Mutex, PoisonError};

use asphera_report::{Snapshot, View};
use axum::extract::ws::Utf8Bytes;
use serde::Serialize;

/// A snapshot, and how people read it.
#[derive(Serialize)]
struct Worded<'a> {
    #[serde(flatten)]
    snapshot: &'a Snapshot,
    view: View,
}

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
                let view = View::of_snapshot(snapshot);
                let text = serde_json::to_string(&Worded { snapshot, view })
                    .expect("a snapshot consists of numbers, strings and maps with string keys");
                let text = Utf8Bytes::from(text);
                *last = Some((Arc::clone(snapshot), text.clone()));
                text
            }
        }
    }
}
