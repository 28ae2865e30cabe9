//! The compiled half of the Python package `rsph`: a thin layer over the core and the scenario
//! crate. What users see, with its documentation, is in `python/rsph`.
//!
//! A simulation that is built in Python passes through the same tables as a scenario file, as a
//! TOML text; so names, defaults, checks and messages are those of the command line.
// What PyO3 extracts from Python is owned.
#![allow(clippy::needless_pass_by_value)]

mod arrays;
mod errors;
mod field;
mod force;
mod history;
mod image;
mod interrupt;
mod law;
mod pool;
mod results;
mod run;
mod sampling;
mod scenario;
mod shape;
mod simulation;
mod snapshot;

use pyo3::prelude::*;

/// The compiled module `rsph._rsph`.
#[pymodule]
mod _rsph {
    #[pymodule_export]
    use crate::image::frame_to_nifti;
    #[pymodule_export]
    use crate::law::Law;
    #[pymodule_export]
    use crate::results::{describe_results, read_field, read_frame};
    #[pymodule_export]
    use crate::run::run_scenario;
    #[pymodule_export]
    use crate::sampling::sample;
    #[pymodule_export]
    use crate::scenario::{check, material_models, read_scenario, scenario_text};
    #[pymodule_export]
    use crate::shape::{Shape, organ_names};
    #[pymodule_export]
    use crate::simulation::Simulation;
    #[pymodule_export]
    use crate::snapshot::Snapshot;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::pool::begin();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
