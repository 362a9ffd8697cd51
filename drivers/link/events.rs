//! Events of a driver until the station takes them.

use std::collections::VecDeque;

use crate::{Event, Fault, FaultKind};

/// Events of a driver in their order. [`Event::Online`] and [`Event::Ready`] come once a connection.
#[derive(Debug, Default)]
pub struct Events {
    queue: VecDeque<Event>,
    online: bool,
    ready: bool,
}

impl Events {
    /// Begins a connection: nothing is proven. Events that wait stay.
    pub fn restart(&mut self) {
        (self.online, self.ready) = (false, false);
    }

    /// Adds an event.
    pub fn push(&mut self, event: Event) {
        self.queue.push_back(event);
    }

    /// Takes the oldest event.
    pub fn pop(&mut self) -> Option<Event> {
        self.queue.pop_front()
    }

    /// Drops the events that wait.
    pub fn clear(&mut self) {
        self.queue.clear();
    }

    /// Whether the device was proven on this connection.
    pub fn is_online(&self) -> bool {
        self.online
    }

    /// The device gave a valid frame: [`Event::Online`], if it is the first of the connection.
    pub fn prove_online(&mut self) {
        if !std::mem::replace(&mut self.online, true) {
            self.push(Event::Online);
        }
    }

    /// The device may measure: [`Event::Ready`], if that is new on this connection.
    pub fn prove_ready(&mut self) {
        if !std::mem::replace(&mut self.ready, true) {
            self.push(Event::Ready);
        }
    }

    /// Adds an [`Event::Fault`].
    pub fn fault(&mut self, kind: FaultKind, detail: String) {
        self.push(Event::Fault(Fault { kind, detail }));
    }

    /// Adds an [`Event::Reopen`].
    pub fn reopen(&mut self, kind: FaultKind, detail: String) {
        self.push(Event::Reopen(Fault { kind, detail }));
    }

    /// Adds an [`Event::Discarded`], unless there are no bytes.
    pub fn discarded(&mut self, bytes: u64) {
        if bytes > 0 {
            self.push(Event::Discarded { bytes });
        }
    }
}

impl Extend<Event> for Events {
    fn extend<T: IntoIterator<Item = Event>>(&mut self, events: T) {
        self.queue.extend(events);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proof_counts_once_a_connection() {
        let mut events = Events::default();
        for _ in 0..2 {
            events.prove_online();
            events.prove_ready();
            events.discarded(0);
        }
        events.restart();
        assert!(!events.is_online());
        events.prove_online();
        events.discarded(3);
        let taken: Vec<Event> = std::iter::from_fn(|| events.pop()).collect();
        let expected = [Event::Online, Event::Ready, Event::Online, Event::Discarded { bytes: 3 }];
        assert_eq!(taken, expected);
    }
}
