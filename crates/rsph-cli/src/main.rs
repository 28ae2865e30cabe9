//! rsph.
fn main() {}
