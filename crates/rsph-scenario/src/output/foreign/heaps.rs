//! An HDF5 file's tables of names ("local heaps"). The library, up to version 2.0, follows a list of free room that
//! runs in a circle for ever and takes memory at every turn, and reads at address 0 where two tables say that
//! their names lie in the same place; fuzzing found both.

use std::collections::BTreeMap;
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

/// What is wrong with the tables of names in the first `limit` bytes of `file`, if the library would not see it.
pub fn trouble(file: &mut File, limit: u64) -> io::Result<Option<&'static str>> {
    let mut piece = Vec::new();
    let mut at = 0;
    // Where the names of each table begin and end.
    let mut names = BTreeMap::new();
    loop {
        file.seek(SeekFrom::Start(at))?;
        piece.clear();
        // A header that lies across two pieces is in the second as a whole.
        let read = file.by_ref().take((PIECE + HEADER) as u64).read_to_end(&mut piece)?;
        for start in (0..read.saturating_sub(HEADER - 1)).filter(|i| piece[*i..].starts_with(START)) {
            let word = |i: usize| {
                piece.get(start + i..).and_then(|b| b.first_chunk()).map_or(0, |b| u64::from_le_bytes(*b))
            };
            let (size, first, address) = (word(8), word(16), word(24));
            if is_endless(file, size, first, address)? {
                return Ok(Some("a list of its free room runs in a circle"));
            }
            names.insert(at + start as u64, (address, address.saturating_add(size)));
        }
        at += PIECE as u64;
        if read <= PIECE || at >= limit {
            break;
        }
    }
    let mut places: Vec<_> = names.into_values().collect();
    places.sort_unstable();
    let shared = places.windows(2).any(|pair| pair[1].0 < pair[0].1 || pair[1].0 == pair[0].0);
    Ok(shared.then_some("two of its tables of names lie in the same place"))
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
