//! Signals: the first asks the run to close its last frame and to store a checkpoint, the second leaves at once.

use crate::exit::{Code, Trouble};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown, register_usize};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What the signals have asked for.
pub struct Interrupt {
    /// Set by the first signal.
    pub stop: Arc<AtomicBool>,
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Listens for Ctrl-C (SIGINT) and SIGTERM.
    pub fn listen() -> Result<Self, Trouble> {
        let (stop, signal) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
        let listen = |number: i32, code: Code| -> io::Result<()> {
            // In this order: what shuts down must see the flag as the signals before have left it.
            register_conditional_shutdown(number, code as i32, Arc::clone(&stop))?;
            register_usize(number, Arc::clone(&signal), code as usize)?;
            register(number, Arc::clone(&stop))?;
            Ok(())
        };
        listen(SIGINT, Code::Interrupted)
            .and_then(|()| listen(SIGTERM, Code::Terminated))
            .and_then(|()| outlive_full_quota())
            .map_err(|e| Trouble::system(format!("cannot listen for signals: {e}"), "try again"))?;
        Ok(Self { stop, signal })
    }

    /// The exit code that belongs to the signal.
    pub fn code(&self) -> Code {
        if self.signal.load(Ordering::Relaxed) == Code::Terminated as usize {
            Code::Terminated
        } else {
            Code::Interrupted
        }
    }
}

/// A file that grows beyond its allowed size is an error to be told, not the end of the program.
#[cfg(unix)]
fn outlive_full_quota() -> io::Result<()> {
    register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false))).map(|_| ())
}

#[cfg(not(unix))]
fn outlive_full_quota() -> io::Result<()> {
    Ok(())
}
