//! Dotted keys such as `load[0].ramp.to`.

use std::fmt;

/// One step of a [`KeyPath`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Segment {
    /// A key of a table.
    Key(String),
    /// An entry of a list, from 0.
    Index(usize),
}

/// The place of a value in a scenario.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeyPath(Vec<Segment>);

impl KeyPath {
    /// Its steps.
    pub fn segments(&self) -> &[Segment] {
        &self.0
    }

    /// The path of `key` in the table at this path.
    #[must_use]
    pub fn key(&self, key: &str) -> Self {
        let mut segments = self.0.clone();
        segments.push(Segment::Key(key.into()));
        Self(segments)
    }

    /// The path of entry `index` of the list at this path.
    #[must_use]
    pub fn index(&self, index: usize) -> Self {
        let mut segments = self.0.clone();
        segments.push(Segment::Index(index));
        Self(segments)
    }

    /// The path of what holds this one.
    #[must_use]
    pub fn parent(&self) -> Self {
        Self(self.0[..self.0.len().saturating_sub(1)].to_vec())
    }

    /// Whether this path is `other` or holds it.
    pub fn holds(&self, other: &Self) -> bool {
        other.0.starts_with(&self.0)
    }

    /// The last key, list entries left aside.
    pub fn last_key(&self) -> &str {
        self.0
            .iter()
            .rev()
            .find_map(|s| match s {
                Segment::Key(k) => Some(k.as_str()),
                Segment::Index(_) => None,
            })
            .unwrap_or_default()
    }
}

impl From<&str> for KeyPath {
    /// Reads `load[0].ramp.to`; `load.0.ramp.to` means the same.
    fn from(text: &str) -> Self {
        let pieces = text.split(['.', '[', ']']).map(str::trim).filter(|s| !s.is_empty());
        let segment =
            |s: &str| s.parse().map_or_else(|_| Segment::Key(s.trim_matches('"').into()), Segment::Index);
        Self(pieces.map(segment).collect())
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, segment) in self.0.iter().enumerate() {
            match segment {
                Segment::Index(index) => write!(f, "[{index}]")?,
                Segment::Key(key) => {
                    let dot = if i == 0 { "" } else { "." };
                    // Without quotes a number would be read as an entry of a list.
                    let quote = if key.parse::<usize>().is_ok() { "\"" } else { "" };
                    write!(f, "{dot}{quote}{key}{quote}")?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn both_ways_to_index_a_list_are_read() {
        assert_eq!(KeyPath::from("load.0.ramp.to"), KeyPath::from("load[0].ramp.to"));
        assert_eq!(KeyPath::from("load.0.ramp.to").to_string(), "load[0].ramp.to");
        assert_eq!(KeyPath::from("sweep.\"0\"").to_string(), "sweep.\"0\"");
        assert_eq!(KeyPath::from("body").key("shape").index(2).last_key(), "shape");
    }

    proptest! {
        #[test]
        fn any_text_is_read_and_its_display_reads_back(text in "\\PC{0,40}") {
            let path = KeyPath::from(text.as_str());
            let keys_are_plain = path.segments().iter().all(|s| match s {
                Segment::Key(k) => !k.contains(['"', ' ']) && k.trim() == k && !k.is_empty(),
                Segment::Index(_) => true,
            });
            prop_assume!(keys_are_plain);
            prop_assert_eq!(KeyPath::from(path.to_string().as_str()), path);
        }
    }
}
