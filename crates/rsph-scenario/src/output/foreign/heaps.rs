//! The lists of free room in an HDF5 file's tables of names ("local heaps"). The library, up to version 2.0, follows a
//! list that runs in a circle for ever and takes memory at every turn; fuzzing found it.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

/// How a heap begins: its signature and version.
const START: &[u8; 5] = b"HEAP\0";
/// Bytes of a heap's header: signature, size of its data, first free place, address of its data.
const HEADER: usize = 32;
/// Bytes of an entry in the list: place of the next, size.
const ENTRY: u64 = 16;
/// End of a list.
const NONE: u64 = 1;
/// Bytes that are looked through at a time.
const PIECE: usize = 1 << 20;

/// Whether a list of free room in the first `limit` bytes of `file` never ends.
pub fn has_endless_list(file: &mut File, limit: u64) -> io::Result<bool> {
    let mut piece = Vec::new();
    let mut at = 0;
    loop {
        file.seek(SeekFrom::Start(at))?;
        piece.clear();
        // A header that lies across two pieces is in the second as a whole.
        let read = file.by_ref().take((PIECE + HEADER) as u64).read_to_end(&mut piece)?;
        for start in (0..read.saturating_sub(HEADER - 1)).filter(|i| piece[*i..].starts_with(START)) {
            let word = |i: usize| {
                piece.get(start + i..).and_then(|b| b.first_chunk()).map_or(0, |b| u64::from_le_bytes(*b))
            };
            if is_endless(file, word(8), word(16), word(24))? {
                return Ok(true);
            }
        }
        at += PIECE as u64;
        if read <= PIECE || at >= limit {
            return Ok(false);
        }
    }
}

/// Whether the list in `size` bytes at `address` that begins at `first` never ends. One that leaves its heap is for
/// the library, which sees that.
fn is_endless(file: &mut File, size: u64, first: u64, address: u64) -> io::Result<bool> {
    let length = file.metadata()?.len();
    let mut place = first;
    for _ in 0..=size.min(length) / ENTRY {
        let inside = place.checked_add(ENTRY).is_some_and(|end| end <= size);
        let Some(entry) = address.checked_add(place).filter(|e| inside && e.saturating_add(ENTRY) <= length)
        else {
            return Ok(false);
        };
        let mut next = [0; 8];
        file.seek(SeekFrom::Start(entry))?;
        file.read_exact(&mut next)?;
        place = u64::from_le_bytes(next);
        if place == NONE {
            return Ok(false);
        }
    }
    Ok(true)
}
