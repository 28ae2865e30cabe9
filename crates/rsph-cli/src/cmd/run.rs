//! `rsph run`

use crate::exit::{Code, Trouble};
use crate::interrupt::Interrupt;
use crate::output::{number, print, rate};
use crate::progress::Display;
use clap::Args;
use rsph_scenario::run::{self, Begin};
use rsph_scenario::scenario::{LoadedScenario, UnitsName};
use rsph_scenario::sink::{Outcome, Status};
use std::path::{Path, PathBuf};

/// Most threads that are started for each core.
const MOST_THREADS_A_CORE: usize = 4;

/// Run a scenario and store its results
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rsph run scenarios/liver_load.toml
  rsph run my.toml --output out/fine --set body.particles=5000
  rsph run my.toml --set load.0.ramp.to=1 --set solver.formulation=paper --force

The folder then holds report.html (open it in a browser), particles.vtkhdf and surface.vtkhdf (open
them in ParaView), probes.csv, summary.json, and scenario.toml: the scenario as run.
Ctrl-C (or SIGTERM) closes the last frame, stores a checkpoint and leaves; a second one leaves at once.
After that, or whatever else ended a run, `rsph run my.toml --resume` goes on with it.")]
pub struct Arguments {
    /// The scenario file (TOML); `rsph new` prints one to start from
    #[arg(value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Folder for the results [default: out/<name of the scenario file>]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Change a value of the scenario; lists are indexed from 0: load.0.pressure=300
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
    /// Number of threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// Go on with an interrupted run from the folder's checkpoint
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Overwrite the results that are in the folder
    #[arg(long)]
    force: bool,
    /// Show neither progress nor a summary, only warnings and errors
    #[arg(short, long)]
    pub quiet: bool,
}

pub fn run(arguments: &Arguments) -> Result<Code, Trouble> {
    let scenario = LoadedScenario::from_file(&arguments.scenario, &arguments.set)?;
    let folder = arguments.output.clone().unwrap_or_else(|| {
        Path::new("out").join(arguments.scenario.file_stem().unwrap_or_else(|| "scenario".as_ref()))
    });
    if let Some(asked) = arguments.threads {
        start_threads(asked.into())?;
    }
    let begin = match (arguments.resume, arguments.force) {
        (true, _) => Begin::Resumed,
        (false, true) => Begin::Overwriting,
        (false, false) => Begin::Fresh,
    };
    let interrupt = Interrupt::listen()?;
    let mut display = Display::new(arguments.quiet);
    let outcome = run::run(&scenario, &folder, begin, &mut display, &interrupt.stop)?;
    if !arguments.quiet {
        print(&summary(&outcome, &folder, scenario.tables().units))?;
    }
    match &outcome.status {
        Status::Finished => Ok(Code::Good),
        Status::Interrupted => Ok(interrupt.code()),
        Status::Failed(failure) => Err(Trouble::failure(failure)),
    }
}

/// Starts so many threads, or as many as are of use.
fn start_threads(asked: usize) -> Result<(), Trouble> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = asked.min(MOST_THREADS_A_CORE * cores);
    if threads < asked {
        tracing::warn!(
            "{asked} threads would only wait for each other on {cores} cores: {threads} are started"
        );
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|e| Trouble::system(format!("cannot start {threads} threads: {e}"), "ask for fewer"))
}

/// What came out, and where it is.
fn summary(outcome: &Outcome, folder: &Path, units: UnitsName) -> String {
    let how = match outcome.status {
        Status::Finished => "finished",
        Status::Interrupted => "interrupted (`--resume` goes on from here)",
        Status::Failed(_) => "failed; the results up to there are complete",
    };
    let folder = folder.display();
    let unit = |si: &'static str| if units == UnitsName::Si { si } else { "" };
    let (metres, pascals, newtons) = (unit(" m"), unit(" Pa"), unit(" N"));
    let largest = outcome.largest.map_or_else(String::new, |most| {
        format!(
            "largest displacement {}{metres}, strain {}, von Mises stress {}{pascals}\n",
            number(most.displacement),
            number(most.strain),
            number(most.von_mises),
        )
    });
    let balance = outcome.equilibrium.map_or_else(String::new, |rest| {
        let [load, held] = [rest.load, rest.reaction].map(|force| {
            let [x, y, z] = <[f64; 3]>::from(force).map(number);
            format!("({x}, {y}, {z}){newtons}")
        });
        format!("load {load}, carried by what is held: {held}\n")
    });
    format!(
        "{how}: t = {}, {} steps in {} s ({} steps/s, {} threads)\n{largest}{balance}\
         picture: {folder}/report.html (open it in a browser)\n\
         ParaView: {folder}/particles.vtkhdf, {folder}/surface.vtkhdf\n",
        number(outcome.time),
        outcome.steps,
        number(outcome.wall_seconds),
        rate(outcome.steps as f64 / outcome.wall_seconds.max(1e-9)),
        outcome.threads,
    )
}
