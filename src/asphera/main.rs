//! asphera.
fn main() {}
