//! Archives by gzip of one or more members, with zeros after the last, as tapes and tar leave them.

use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Read};

/// The first bytes of a member.
pub const START: [u8; 2] = [0x1f, 0x8b];

/// What the members of an archive hold, one after the other.
pub struct Members<R>(Option<GzDecoder<R>>);

impl<R: BufRead> Members<R> {
    /// Of the archive `stream`.
    pub fn new(stream: R) -> Self {
        Self(Some(GzDecoder::new(stream)))
    }
}

impl<R: BufRead> Read for Members<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.0 {
            let read = member.read(into)?;
            if read > 0 || into.is_empty() {
                return Ok(read);
            }
            let rest = self.0.take().map(GzDecoder::into_inner);
            if let Some(mut rest) = rest
                && skip_zeros(&mut rest)?
            {
                self.0 = Some(GzDecoder::new(rest));
            }
        }
        Ok(0)
    }
}

/// Skips zeros; whether anything follows them.
fn skip_zeros(stream: &mut impl BufRead) -> io::Result<bool> {
    loop {
        let ahead = stream.fill_buf()?;
        let zeros = ahead.iter().take_while(|byte| **byte == 0).count();
        let (is_end, goes_on) = (ahead.is_empty(), zeros < ahead.len());
        stream.consume(zeros);
        if is_end || goes_on {
            return Ok(goes_on);
        }
    }
}
