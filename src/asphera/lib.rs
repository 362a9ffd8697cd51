//! The asphera daemon and its command line.
