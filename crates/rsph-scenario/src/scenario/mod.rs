//! The scenario file: its tables, its schema, and the way from text to tables.

mod document;
mod dynamics;
mod error;
mod examples;
mod explain;
mod keypath;
mod label_map;
mod loads;
mod material;
mod overrides;
mod part;
mod places;
mod region;
mod tables;
mod values;

pub use document::Document;
pub use dynamics::{
    DynamicsKind, DynamicsTable, ElasticTable, FluidTable, RemeshKernelName, RemeshTable, VelocityTable,
};
pub use error::ScenarioError;
pub(crate) use explain::{remedy_at, suggestion};
pub use keypath::KeyPath;
pub use label_map::{AxesName, LabelMapTable, LabelMapValue};
pub use loads::{
    BoundaryKind, BoundaryTable, ComponentName, CurveKindName, CurveTable, FoundationTable, LoadKindName,
    LoadTable, MotionTable, RampTable,
};
pub use material::{MaterialTable, MaterialTables, ModulusTable};
pub use part::{Names, PartTable, PartValue};
pub use region::{AxisName, RegionTable, SideName};
pub use tables::{
    BodyTable, CheckpointTable, FieldTable, FormulationName, GaugeTable, InitialTable, Integrator,
    MeasureName, ModeName, OrganName, OutputTable, ProbeTable, Scenario, ShapeTable, SolverTable, TimeTable,
    UnitsName,
};
pub use values::{CentreValue, EveryValue, TimeStepValue};

use crate::whole_file::Kind;
use std::path::{Path, PathBuf};

/// Scenarios are short texts; one may come from a pipe.
const FILE: Kind = Kind {
    what: "a scenario",
    limit: 1_000_000,
    if_larger: "a scenario is a text of some kilobytes: check that this is one",
    if_missing: "check the path; `rsph new > my.toml` writes one to start from",
    from_pipe: true,
};

/// A scenario file read, edited by `--set`, and understood.
#[derive(Clone, Debug)]
pub struct LoadedScenario {
    document: Document,
    tables: Scenario,
}

impl LoadedScenario {
    /// Reads the scenario file `path` and applies `sets`, each `key.path=value`.
    ///
    /// # Errors
    /// The first thing in the file or the edits that can not be understood, with its place.
    pub fn from_file(path: &Path, sets: &[String]) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        let bytes = FILE.read(path).map_err(|e| ScenarioError::unreadable(&name, e))?;
        let text = String::from_utf8(bytes).map_err(|e| ScenarioError::no_text(&name, e.as_bytes()))?;
        let base_dir = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Self::from_text(&name, text, base_dir, sets)
    }

    /// Understands the scenario `text`; `name` stands in messages for the file, relative mesh
    /// paths resolve in `base_dir`, and `sets` are edits of the form `key.path=value`.
    ///
    /// # Errors
    /// As [`LoadedScenario::from_file`].
    pub fn from_text(
        name: &str,
        text: String,
        base_dir: PathBuf,
        sets: &[String],
    ) -> Result<Self, ScenarioError> {
        let document = Document::new(name, text, sets)?.in_folder(base_dir);
        let tables = document.tables()?;
        Ok(Self { document, tables })
    }

    /// The tables of the scenario.
    pub fn tables(&self) -> &Scenario {
        &self.tables
    }

    /// The text with its places, for messages.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The scenario as run, as TOML: the text of the file with the edits in it.
    pub fn as_run(&self) -> &str {
        self.document.edited()
    }

    /// The scenario as run in a form that runs from any folder: relative paths of meshes and images are made absolute.
    pub fn as_run_anywhere(&self) -> String {
        self.document.with_absolute_paths()
    }

    /// The file it was read from, if it was.
    pub fn file(&self) -> Option<&Path> {
        Some(Path::new(self.document.name())).filter(|path| path.is_file())
    }

    /// Where relative mesh paths resolve.
    pub fn base_dir(&self) -> &Path {
        self.document.folder()
    }

    /// The title, or the name of the file if it has none.
    pub fn title(&self) -> &str {
        if self.tables.title.is_empty() { self.document.name() } else { &self.tables.title }
    }
}

/// JSON Schema of the scenario format.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Scenario).to_value()
}
