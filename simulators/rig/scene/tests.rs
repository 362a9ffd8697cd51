//! Tests of the scenes.
