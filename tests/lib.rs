//! End-to-end tests: a daemon and a rig on free ports.
