//! Topography files, in and out: bytes in, types out.
