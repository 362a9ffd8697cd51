//! A simulated CHRocodile 2.
