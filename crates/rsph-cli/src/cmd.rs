//! The verbs, one file each.

pub mod image;
pub mod info;
pub mod new;
pub mod run;
pub mod sample;
pub mod schema;
pub mod surface;
mod unit;
pub mod validate;
