//! Exit codes, and how trouble is told to the user.

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, MietteDiagnostic, Severity};
use rsph_core::error::Failure;
use rsph_scenario::mesh_io::MeshError;
use rsph_scenario::output::vtkhdf::VtkHdfError;
use rsph_scenario::run::RunError;
use rsph_scenario::scenario::ScenarioError;
use std::io::{IsTerminal, Write};

/// What the program returns to the shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// All is well.
    Good = 0,
    /// A validation bound is missed.
    BoundMissed = 1,
    /// Wrong input; nothing was written.
    WrongInput = 2,
    /// The simulation failed; results up to there are readable.
    SimulationFailed = 3,
    /// The system failed: disk, memory, permission.
    SystemFailed = 4,
    /// The user stopped it (Ctrl-C).
    Interrupted = 130,
    /// The system stopped it (SIGTERM).
    Terminated = 143,
}

/// Something to tell the user before leaving.
#[derive(Debug)]
pub struct Trouble {
    code: Code,
    what: Box<dyn Diagnostic>,
}

impl Trouble {
    /// Wrong input: what is wrong, and what to do.
    pub fn input(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(Code::WrongInput, what, remedy)
    }

    /// A mesh that can not be read or written.
    pub fn mesh(error: &MeshError) -> Self {
        Self::input(format!("{}: {}", error.path().display(), error.problem()), error.remedy())
    }

    /// A results file that can not be read.
    pub fn results(error: &VtkHdfError) -> Self {
        Self::input(error.to_string(), &error.remedy)
    }

    /// The system failed: what happened, and what to do.
    pub fn system(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(Code::SystemFailed, what, remedy)
    }

    /// The simulation failed.
    pub fn failure(failure: &Failure) -> Self {
        let place = failure
            .place
            .map_or_else(String::new, |p| format!(", at X = ({:.4}, {:.4}, {:.4})", p.x, p.y, p.z));
        Self::new(Code::SimulationFailed, format!("{failure}{place}"), &failure.remedy)
    }

    fn new(code: Code, what: impl Into<String>, remedy: impl Into<String>) -> Self {
        let what = MietteDiagnostic::new(what).with_severity(Severity::Error).with_help(remedy);
        Self { code, what: Box::new(what) }
    }

    /// Writes the message to stderr; returns the exit code.
    pub fn report(&self) -> Code {
        let terminal = std::io::stderr().is_terminal();
        let theme = if terminal { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        let mut text = String::new();
        let handler = GraphicalReportHandler::new_themed(theme)
            .with_links(false)
            .with_wrap_lines(terminal)
            .without_syntax_highlighting();
        if handler.render_report(&mut text, self.what.as_ref()).is_err() {
            text = self.what.to_string();
        }
        // Nobody is left to tell when stderr is closed.
        let _ = writeln!(std::io::stderr(), "{}", text.trim_end());
        self.code
    }
}

impl From<ScenarioError> for Trouble {
    fn from(error: ScenarioError) -> Self {
        Self { code: Code::WrongInput, what: Box::new(error) }
    }
}

impl From<RunError> for Trouble {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Scenario(error) => (*error).into(),
            RunError::Folder(error) if error.is_of_the_system() => {
                Self::system(error.to_string(), error.remedy())
            }
            RunError::Folder(error) => Self::input(error.to_string(), error.remedy()),
            RunError::Checkpoint(error) => Self::input(error.to_string(), error.remedy),
            RunError::Memory(error) => Self::system(error.to_string(), error.remedy()),
            RunError::Sink(error) => Self::system(
                error.to_string(),
                "results up to there are readable; check the space left on the disk and the permissions of the \
                 folder, then go on with `--resume`",
            ),
        }
    }
}
