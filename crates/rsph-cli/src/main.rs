//! `rsph`: the command line.
#![forbid(unsafe_code)]

mod cmd;
mod exit;
mod interrupt;
mod output;
mod progress;

use clap::{Parser, Subcommand};
use exit::{Code, Trouble};
use std::io::IsTerminal;
use std::process::ExitCode;
use tracing::Level;

/// How human organs deform: remeshed Smoothed Particle Hydrodynamics.
#[derive(Debug, Parser)]
#[command(name = "rsph", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "\
Start with
  rsph new > my.toml         a commented scenario
  rsph run my.toml           runs it; results in out/my
  rsph run my.toml --set time.until=0.1 --output out/short

Exit codes: 0 good; 1 a validation bound is missed; 2 wrong input; 3 the simulation failed;
4 the system failed; 130 interrupted (Ctrl-C), 143 terminated (SIGTERM).")]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Run(cmd::run::Arguments),
    Validate(cmd::validate::Arguments),
    Sample(cmd::sample::Arguments),
    Surface(cmd::surface::Arguments),
    Image(cmd::image::Arguments),
    Info(cmd::info::Arguments),
    Schema(cmd::schema::Arguments),
    New(cmd::new::Arguments),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let level = match &cli.verb {
        Verb::Run(arguments) if arguments.quiet => Level::WARN,
        _ => Level::INFO,
    };
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_max_level(level)
        .with_target(false)
        .without_time()
        .init();
    let result = match &cli.verb {
        Verb::Run(arguments) => cmd::run::run(arguments),
        Verb::Validate(arguments) => cmd::validate::run(arguments),
        Verb::Sample(arguments) => cmd::sample::run(arguments),
        Verb::Surface(arguments) => cmd::surface::run(arguments),
        Verb::Image(arguments) => cmd::image::run(arguments),
        Verb::Info(arguments) => cmd::info::run(arguments),
        Verb::Schema(arguments) => cmd::schema::run(arguments),
        Verb::New(arguments) => cmd::new::run(arguments),
    };
    result.unwrap_or_else(|trouble: Trouble| trouble.report()).into()
}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}
