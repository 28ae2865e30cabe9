//! Computation without Python's lock, on threads that this process has.

use pyo3::Python;
use pyo3::marker::Ungil;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::process;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The process that loaded the module: the threads of the usual pool are in it.
static FIRST: OnceLock<u32> = OnceLock::new();
/// The pool of a process that was forked from it, and that process.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Remembers the process that loads the module.
pub fn begin() {
    FIRST.get_or_init(process::id);
}

/// Runs `act` without Python's lock.
pub fn detach<T: Ungil + Send>(py: Python<'_>, act: impl FnOnce() -> T + Ungil + Send) -> T {
    py.detach(|| compute(act))
}

/// Runs `act` on the threads of this process. One that was forked has none of those of the process before; it gets its own.
pub fn compute<T: Send>(act: impl FnOnce() -> T + Send) -> T {
    match own_pool() {
        Some(pool) => pool.install(act),
        None => act(),
    }
}

/// The pool of a forked process; `None`: the usual one will do, or no thread can be started.
fn own_pool() -> Option<Arc<ThreadPool>> {
    let process = process::id();
    if FIRST.get().is_none_or(|first| *first == process) {
        return None;
    }
    let mut forked = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
    if forked.as_ref().is_none_or(|(of, _)| *of != process) {
        let pool = Arc::new(ThreadPoolBuilder::new().build().ok()?);
        // The pool of the process before has no threads here that could be waited for.
        std::mem::forget(forked.replace((process, pool)));
    }
    forked.as_ref().map(|(_, pool)| Arc::clone(pool))
}
