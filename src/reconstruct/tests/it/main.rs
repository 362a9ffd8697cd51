//! Tests of reconstruction and proof from outside.

mod proof;
#[expect(dead_code, reason = "shapes that the reconstruction is tested on")]
mod shapes;
