//! A run that goes on from its checkpoint: the same scenario, and the same state.

use super::prepared::Prepared;
use crate::output::VERSION;
use crate::output::checkpoint::{Checkpoint, CheckpointError, FILE as CHECKPOINT};
use crate::scenario::LoadedScenario;
use std::path::Path;
use toml::{Table, Value};

/// Keys of the scenario that say nothing about the motion.
const FREE: &[&str] = &["title", "output.checkpoint", "output.every"];
/// The end of a run in time; equilibria are spread over the time up to it.
const END: &str = "time.until";
/// Most keys that a message names.
const MOST_KEYS: usize = 8;

/// Results that a run goes on writing.
const CONTINUED: &[&str] = &["particles.vtkhdf", "surface.vtkhdf", "probes.csv"];

/// Makes sure that the results of the run are beside its checkpoint, if there is one.
///
/// # Errors
/// The first that is not there.
pub(super) fn check_results(folder: &Path) -> Result<(), CheckpointError> {
    let missing = CONTINUED.iter().find(|name| !folder.join(name).is_file());
    match missing.filter(|_| folder.join(CHECKPOINT).is_file()) {
        None => Ok(()),
        Some(name) => Err(CheckpointError::new(
            folder,
            format!("the run can not go on: its {name} is not there"),
            "put the results back beside the checkpoint, or run from the start with `--force`",
        )),
    }
}

/// Makes sure that the checkpoint is one of this scenario.
///
/// # Errors
/// The keys that differ.
pub(super) fn check_scenario(
    folder: &Path,
    scenario: &LoadedScenario,
    checkpoint: &Checkpoint,
) -> Result<(), CheckpointError> {
    let (now, then) = (scenario.as_run_anywhere(), &checkpoint.scenario);
    if now == *then {
        return Ok(());
    }
    let parse = |text: &str| text.parse::<Table>().unwrap_or_default();
    let mut keys = Vec::new();
    differing("", &Value::Table(parse(then)), &Value::Table(parse(&now)), &mut keys);
    let is_static = parse(&now).get("solver").and_then(|solver| solver.get("mode")) == Some(&"static".into());
    keys.retain(|key| !FREE.iter().any(|free| key.starts_with(free)) && (is_static || key != END));
    if keys.is_empty() {
        return Ok(());
    }
    let differ = if keys.len() == 1 { "differs" } else { "differ" };
    let more = keys.len().saturating_sub(MOST_KEYS);
    keys.truncate(MOST_KEYS);
    let names = keys.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ");
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    Err(CheckpointError::new(
        folder,
        format!("belongs to another scenario: {names}{more} {differ}"),
        "resume with the scenario as it was (scenario.toml in that folder, without `--set`), or run from the start \
         with `--force`",
    ))
}

/// Adds the keys at which two values differ.
fn differing(path: &str, a: &Value, b: &Value, keys: &mut Vec<String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match (a, b) {
        (Value::Table(a), Value::Table(b)) => {
            for (key, value) in a {
                match b.get(key) {
                    Some(other) => differing(&below(key), value, other, keys),
                    None => keys.push(below(key)),
                }
            }
            keys.extend(b.keys().filter(|key| !a.contains_key(*key)).map(|key| below(key)));
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() && a.iter().all(Value::is_table) => {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                differing(&format!("{path}[{i}]"), a, b, keys);
            }
        }
        _ if a != b => keys.push(path.to_owned()),
        _ => {}
    }
}

/// What to tell the user about a checkpoint.
pub(super) fn note(checkpoint: &Checkpoint) -> Option<String> {
    let version = &checkpoint.version;
    (version != VERSION).then(|| {
        format!("the run was begun by rsph {version}: with this version, {VERSION}, results may differ in the last digits")
    })
}

/// Takes back the state of simulation and run.
///
/// # Errors
/// When it is not that of this body.
pub(super) fn restore(
    folder: &Path,
    checkpoint: &Checkpoint,
    prepared: &mut Prepared,
) -> Result<(), CheckpointError> {
    let state = &checkpoint.state;
    let Prepared { simulation, accounting, until, .. } = &mut *prepared;
    simulation
        .set_state(state)
        .and_then(|()| accounting.restore(state, simulation))
        .map_err(|e| CheckpointError::new(folder, format!("`{}`: {}", e.key, e.problem), e.remedy))?;
    let time = simulation.time();
    if *until < time {
        return Err(CheckpointError::new(
            folder,
            format!("is at t = {time}, later than the end of the scenario, `time.until` = {until}"),
            "resume with a later end, or run from the start with `--force`",
        ));
    }
    prepared.count_frames();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_that_differ_are_named() {
        let parse = |text: &str| Value::Table(text.parse().unwrap());
        let a = parse("title = \"a\"\n[time]\nuntil = 1.0\n[[load]]\nx = [1, 2]\n");
        let b = parse("title = \"a\" # comment\n[time]\nuntil = 2.0\ndt = 1\n[[load]]\nx = [1, 3]\n");
        let mut keys = Vec::new();
        differing("", &a, &b, &mut keys);
        assert_eq!(keys, ["load[0].x", "time.until", "time.dt"]);
        keys.clear();
        differing("", &a, &a, &mut keys);
        assert!(keys.is_empty());
    }
}
