//! The probes' readings over time.

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rsph_core::simulation::Simulation;

/// Readings at some moments of a run, in the order of time.
#[derive(Clone, Default)]
pub struct History {
    last_step: Option<u64>,
    time: Vec<f64>,
    columns: Vec<(String, Vec<f64>)>,
}

impl History {
    /// Adds the readings of this moment, once.
    pub fn record(&mut self, simulation: &mut Simulation) {
        if self.last_step.replace(simulation.step_count()) == Some(simulation.step_count()) {
            return;
        }
        let readings = simulation.readings();
        if self.columns.len() < readings.len() {
            // A probe that came later has no readings from before.
            let before = std::mem::take(&mut self.columns);
            let missing = || vec![f64::NAN; self.time.len()];
            let known = |name: &String| before.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone());
            self.columns =
                readings.iter().map(|r| (r.name.clone(), known(&r.name).unwrap_or_else(missing))).collect();
        }
        self.time.push(simulation.time());
        for ((_, values), reading) in self.columns.iter_mut().zip(readings) {
            values.push(reading.value);
        }
    }

    /// Arrays (S,) by name, `time` first.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("time", self.time.clone().into_pyarray(py))?;
        for (name, values) in &self.columns {
            dict.set_item(name, values.clone().into_pyarray(py))?;
        }
        Ok(dict)
    }
}
