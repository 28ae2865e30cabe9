//! A series that never grows beyond what a page can hold: whenever it gets too long, every second
//! entry goes. The first and the last entry always stay.

/// Evenly spaced entries of a longer series.
#[derive(Clone, Debug)]
pub struct Thinned<T> {
    kept: Vec<(u64, T)>,
    last: Option<T>,
    stride: u64,
    seen: u64,
}

impl<T> Default for Thinned<T> {
    fn default() -> Self {
        Self { kept: Vec::new(), last: None, stride: 1, seen: 0 }
    }
}

impl<T> Thinned<T> {
    /// Takes the next entry, then drops entries until `fits` says yes or two are left.
    pub fn push(&mut self, entry: T, fits: impl Fn(&[&T]) -> bool) {
        let index = self.seen;
        self.seen += 1;
        if !index.is_multiple_of(self.stride) {
            self.last = Some(entry);
            return;
        }
        self.last = None;
        self.kept.push((index, entry));
        while self.kept.len() > 2 && !fits(&self.entries()) {
            self.stride *= 2;
            let stride = self.stride;
            let newest = self.kept.pop_if(|(i, _)| !i.is_multiple_of(stride));
            self.kept.retain(|(i, _)| i.is_multiple_of(stride));
            self.last = self.last.take().or(newest.map(|(_, entry)| entry));
        }
    }

    /// The entries in order.
    pub fn entries(&self) -> Vec<&T> {
        self.kept.iter().map(|(_, e)| e).chain(&self.last).collect()
    }

    /// The numbers of the entries that are kept, how far apart they are, how many entries there were, and whether
    /// the last of [`Self::entries`] stays only until the next one comes.
    pub fn layout(&self) -> (Vec<u64>, u64, u64, bool) {
        (self.kept.iter().map(|(i, _)| *i).collect(), self.stride, self.seen, self.last.is_some())
    }

    /// The series with that layout and those entries; `None` if they do not belong together.
    pub fn from_layout(
        (numbers, stride, seen, last): (Vec<u64>, u64, u64, bool),
        mut entries: Vec<T>,
    ) -> Option<Self> {
        if entries.len() != numbers.len() + usize::from(last) || stride == 0 {
            return None;
        }
        let last = if last { entries.pop() } else { None };
        Some(Self { kept: numbers.into_iter().zip(entries).collect(), last, stride, seen })
    }

    /// How many entries there were.
    pub fn seen(&self) -> u64 {
        self.seen
    }
}

#[cfg(test)]
mod tests {
    use super::Thinned;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn first_and_last_stay_and_the_rest_is_even(count in 1_u64..500, limit in 3_usize..50) {
            let mut series = Thinned::default();
            for i in 0..count {
                series.push(i, |e| e.len() <= limit);
            }
            let entries: Vec<u64> = series.entries().into_iter().copied().collect();
            prop_assert_eq!(entries[0], 0);
            prop_assert_eq!(*entries.last().unwrap(), count - 1);
            prop_assert!(entries.len() <= limit + 1);
            let steps: Vec<u64> = entries.windows(2).map(|w| w[1] - w[0]).collect();
            if let Some((_, even)) = steps.split_last() {
                prop_assert!(even.iter().all(|s| s == &even[0]));
            }
            if count <= limit as u64 {
                prop_assert_eq!(entries.len() as u64, count);
            }
        }
    }
}
