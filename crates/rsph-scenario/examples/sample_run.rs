//! Writes the folder of a made-up run, for looking at a report and for checks of other readers:
//! `cargo run --release -p rsph-scenario --example sample_run -- FOLDER [failed]`.

#[path = "../tests/common/mod.rs"]
mod common;

use rsph_scenario::output::{RunWriters, polydata::PolyData, vtp};
use rsph_scenario::sink::{SinkError, Status};
use std::path::Path;

fn main() -> Result<(), SinkError> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "out/sample".to_owned());
    let failed = arguments.next().is_some_and(|a| a == "failed");
    let mut writers = RunWriters::create(folder.as_ref(), common::info())?;
    for frame in 0..=20_u32 {
        for k in 0..10 {
            let t = 0.15 * (f64::from(frame) + f64::from(k) / 10.0);
            writers.sample(t, &common::readings(t), &common::conservation(t))?;
        }
        let t = 0.15 * f64::from(frame);
        // A remesh in the middle of the run changes particles and surface.
        let (cells, rings) = if frame < 12 { (10, 32) } else { (11, 36) };
        let snapshot = common::snapshot(t, u64::from(frame) * 15, cells);
        writers.frame(snapshot, common::surface(t, rings), &common::conservation(t))?;
    }
    let status = if failed { Status::Failed(common::failure()) } else { Status::Finished };
    writers.finish(&common::outcome(status))?;
    let last = PolyData::from_surface(3.0, common::surface(3.0, 36));
    vtp::write(&Path::new(&folder).join("surface.vtp"), &last)
}
