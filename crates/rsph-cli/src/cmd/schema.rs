//! `rsph schema`

use crate::exit::{Code, Trouble};
use crate::output::print;
use clap::Args;

/// Print the JSON Schema of the scenario format: every key with its meaning, unit and default
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  rsph schema > scenario.schema.json
  rsph schema | less

Editors complete and check scenarios against it (in VS Code: the extension Even Better TOML).")]
pub struct Arguments {}

pub fn run(_: &Arguments) -> Result<Code, Trouble> {
    let text = format!("{:#}\n", rsph_scenario::scenario::schema());
    print(&text)?;
    Ok(Code::Good)
}
