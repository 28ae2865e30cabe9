//! Work that the user can interrupt by Ctrl-C although it does not look up by itself.

use crate::errors::plain;
use crate::pool::compute;
use pyo3::prelude::*;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// How often it is looked whether the user pressed Ctrl-C.
const SLICE: Duration = Duration::from_millis(50);
/// How long work may go on after Ctrl-C if nothing is lost by leaving it to itself.
pub const SOON: Duration = Duration::from_millis(250);

/// Does `work` in a thread of its own, without the interpreter lock. On Ctrl-C it calls `ask_to_stop`, waits
/// as long as `grace` for the work to end, and then leaves it to itself: its result is dropped.
pub fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    grace: Duration,
    ask_to_stop: impl Fn() + Send,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = channel();
    std::thread::Builder::new()
        .name("rsph".into())
        .spawn(move || {
            // Nobody listens any more after an interruption.
            let _ = sender.send(compute(work));
        })
        .map_err(|e| plain(&format!("cannot start a thread: {e}")))?;
    py.detach(move || {
        let mut stopped: Option<(PyErr, Instant)> = None;
        loop {
            match receiver.recv_timeout(SLICE) {
                Ok(result) => return stopped.map_or(Ok(result), |(e, _)| Err(e)),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(plain("the computation ended without a result: a mistake of the program"));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            match stopped.take() {
                Some((error, since)) if since.elapsed() > grace => return Err(error),
                Some(waiting) => stopped = Some(waiting),
                None => {
                    if let Err(error) = Python::attach(signals) {
                        ask_to_stop();
                        stopped = Some((error, Instant::now()));
                    }
                }
            }
        }
    })
}

/// Whether the user pressed Ctrl-C, as an error.
fn signals(py: Python<'_>) -> PyResult<()> {
    py.check_signals()
}
