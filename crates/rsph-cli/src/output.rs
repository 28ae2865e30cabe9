//! Results on stdout, without a panic when the reader (`| head`) has gone.

pub use rsph_scenario::output::{interval, number};

use crate::exit::Trouble;
use std::io::{ErrorKind, Write};

/// Prints `text`.
pub fn print(text: &str) -> Result<(), Trouble> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Trouble::system(format!("cannot write to stdout: {e}"), "check where the output goes"))
        }
        _ => Ok(()),
    }
}

/// A rate with its factor: 950, 12.3 k, 1.87 M.
pub fn rate(x: f64) -> String {
    match x {
        x if x >= 1e6 => format!("{:.2} M", x / 1e6),
        x if x >= 1e4 => format!("{:.1} k", x / 1e3),
        _ => format!("{x:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_have_a_factor() {
        assert_eq!(rate(1.874e6), "1.87 M");
    }
}
