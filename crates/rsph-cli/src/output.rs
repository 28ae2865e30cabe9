//! Results on stdout, without a panic when the reader (`| head`) has gone.

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

/// A number with four significant digits.
pub fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
        let digits = if x == 0.0 { 0 } else { (3 - x.abs().log10().floor() as i32).clamp(0, 6) };
        format!("{x:.*}", digits as usize)
    } else {
        format!("{x:.3e}")
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
    fn numbers_are_short_and_keep_their_size() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(0.012345), "0.01235");
        assert_eq!(number(1000.0), "1000");
        assert_eq!(number(2.2451e-6), "2.245e-6");
        assert_eq!(rate(1.874e6), "1.87 M");
    }
}
