//! Ctrl-C: the first asks the run to close its last frame, the second leaves at once.

use crate::exit::{Code, Trouble};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that Ctrl-C (or SIGTERM) sets.
pub fn stop_flag() -> Result<Arc<AtomicBool>, Trouble> {
    let flag = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&flag);
    ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(Code::Interrupted as i32);
        }
    })
    .map_err(|e| Trouble::system(format!("cannot listen for Ctrl-C: {e}"), "try again"))?;
    Ok(flag)
}
