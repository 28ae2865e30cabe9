//! The state of a simulation as named arrays: what a checkpoint stores. Names have the form `part/quantity`.
//! Files are written by whoever stores a state; the core only fills it and takes it back.

use crate::error::InvalidInput;
use crate::tensor::{Mat3, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Named arrays of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    reals: BTreeMap<String, Arc<Vec<f64>>>,
    wholes: BTreeMap<String, Vec<i64>>,
}

/// A part of a simulation that has a state of its own.
pub(crate) trait Stateful {
    /// Puts everything that the future depends on into `state`.
    fn save(&self, state: &mut State);

    /// Takes it back.
    ///
    /// # Errors
    /// The name of what is missing or has another length.
    fn restore(&mut self, state: &State) -> Result<(), InvalidInput>;
}

impl State {
    /// Puts an array of real numbers.
    pub fn put(&mut self, name: &str, values: impl Into<Vec<f64>>) {
        self.share(name, Arc::new(values.into()));
    }

    /// Puts an array of real numbers that others hold as well.
    pub fn share(&mut self, name: &str, values: Arc<Vec<f64>>) {
        self.reals.insert(name.to_owned(), values);
    }

    /// Puts an array of whole numbers.
    pub fn put_whole(&mut self, name: &str, values: impl Into<Vec<i64>>) {
        self.wholes.insert(name.to_owned(), values.into());
    }

    /// Puts vectors, three values each.
    pub fn put_vectors(&mut self, name: &str, vectors: &[Vec3]) {
        self.put(name, vectors.iter().flat_map(|v| <[f64; 3]>::from(*v)).collect::<Vec<_>>());
    }

    /// Puts matrices, nine values each, column by column.
    pub fn put_matrices(&mut self, name: &str, matrices: &[Mat3]) {
        self.put(name, matrices.iter().flat_map(|m| m.as_slice().to_vec()).collect::<Vec<_>>());
    }

    /// Whether there is an array of that name.
    pub fn has(&self, name: &str) -> bool {
        self.reals.contains_key(name) || self.wholes.contains_key(name)
    }

    /// All arrays of real numbers, by name.
    pub fn reals(&self) -> impl Iterator<Item = (&str, &[f64])> {
        self.reals.iter().map(|(name, values)| (name.as_str(), values.as_slice()))
    }

    /// All arrays of whole numbers, by name.
    pub fn wholes(&self) -> impl Iterator<Item = (&str, &[i64])> {
        self.wholes.iter().map(|(name, values)| (name.as_str(), values.as_slice()))
    }

    /// Real numbers.
    ///
    /// # Errors
    /// When there is no such array.
    pub fn real(&self, name: &str) -> Result<&[f64], InvalidInput> {
        self.reals.get(name).map(|values| values.as_slice()).ok_or_else(|| damaged(name, "is missing"))
    }

    /// Real numbers, `len` of them.
    ///
    /// # Errors
    /// When there is no such array, or it has another length.
    pub fn real_of(&self, name: &str, len: usize) -> Result<&[f64], InvalidInput> {
        checked(name, self.real(name)?, len)
    }

    /// Whole numbers, `len` of them.
    ///
    /// # Errors
    /// When there is no such array, or it has another length.
    pub fn whole_of(&self, name: &str, len: usize) -> Result<&[i64], InvalidInput> {
        let values = self.wholes.get(name).ok_or_else(|| damaged(name, "is missing"))?;
        checked(name, values, len)
    }

    /// A fixed number of real numbers.
    ///
    /// # Errors
    /// When there is no such array, or it has another length.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<[f64; N], InvalidInput> {
        self.real(name)?.try_into().map_err(|_| damaged(name, &format!("must hold {N} values")))
    }

    /// A fixed number of counts.
    ///
    /// # Errors
    /// When there is no such array, it has another length or holds a negative number.
    pub fn counts<const N: usize>(&self, name: &str) -> Result<[u64; N], InvalidInput> {
        let values = self.whole_of(name, N)?;
        let mut counts = [0; N];
        for (count, value) in counts.iter_mut().zip(values) {
            *count = u64::try_from(*value).map_err(|_| damaged(name, "must not be negative"))?;
        }
        Ok(counts)
    }

    /// Puts counts.
    pub fn put_counts(&mut self, name: &str, counts: &[u64]) {
        self.put_whole(name, counts.iter().map(|c| *c as i64).collect::<Vec<_>>());
    }

    /// Vectors, `len` of them.
    ///
    /// # Errors
    /// When there is no such array, or it has another length.
    pub fn vectors(&self, name: &str, len: usize) -> Result<Vec<Vec3>, InvalidInput> {
        let values = self.real_of(name, 3 * len)?;
        Ok(values.as_chunks::<3>().0.iter().map(|v| Vec3::from(*v)).collect())
    }

    /// Matrices, `len` of them.
    ///
    /// # Errors
    /// When there is no such array, or it has another length.
    pub fn matrices(&self, name: &str, len: usize) -> Result<Vec<Mat3>, InvalidInput> {
        let values = self.real_of(name, 9 * len)?;
        Ok(values.as_chunks::<9>().0.iter().map(|m| Mat3::from_column_slice(m)).collect())
    }
}

fn checked<'a, T>(name: &str, values: &'a [T], len: usize) -> Result<&'a [T], InvalidInput> {
    if values.len() == len {
        return Ok(values);
    }
    Err(damaged(name, &format!("holds {} values, expected {len}", values.len())))
}

/// An array that is not as this program stores it.
pub(crate) fn damaged(name: &str, problem: &str) -> InvalidInput {
    InvalidInput::new(
        name,
        "",
        format!("this part of the stored state {problem}"),
        "the checkpoint is damaged or belongs to another body: run from the start",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_is_there_and_nothing_else() {
        let mut state = State::default();
        let (v, m) = (Vec3::new(1.0, -0.0, f64::NAN), Mat3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0));
        state.put_vectors("a/v", &[v, v]);
        state.put_matrices("a/m", &[m]);
        state.put_counts("a/n", &[3, 4]);
        let back = state.vectors("a/v", 2).unwrap();
        assert!(back[1].iter().zip(v.iter()).all(|(x, y)| x.to_bits() == y.to_bits()));
        assert_eq!(state.matrices("a/m", 1).unwrap(), [m]);
        assert_eq!(state.counts::<2>("a/n").unwrap(), [3, 4]);
        assert!(state.has("a/n") && !state.has("a"));
        assert!(state.vectors("a/v", 3).unwrap_err().problem.contains("6 values, expected 9"));
        assert_eq!(state.counts::<1>("b").unwrap_err().key, "b");
        state.put_whole("a/n", [-1]);
        assert!(state.counts::<1>("a/n").is_err());
    }
}
