//! Where keys and values stand in a TOML text.

use super::keypath::{KeyPath, Segment};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where a key and its value stand.
pub(super) struct Found {
    /// Whether the whole path is there; else this is the nearest table that holds it.
    pub exact: bool,
    /// Range of the key; of the value itself for an entry of a list.
    pub key: Range<usize>,
    /// Range of the value; of the header for a table that has one.
    pub value: Range<usize>,
    /// Whether `value` is that of a header.
    pub is_header: bool,
}

/// Finds `path` in `text`.
pub(super) fn find(text: &str, path: &KeyPath) -> Option<Found> {
    let (root, _) = DeTable::parse_recoverable(text);
    let mut found: Option<Found> = None;
    let root = Spanned::new(root.span(), DeValue::Table(root.into_inner()));
    let mut at = &root;
    for segment in path.segments() {
        let next = match (segment, at.get_ref()) {
            (Segment::Key(k), DeValue::Table(t)) => {
                t.iter().find(|(key, _)| key.get_ref() == k.as_str()).map(|(key, v)| (key.span(), v))
            }
            (Segment::Index(i), DeValue::Array(a)) => a.get(*i).map(|v| (v.span(), v)),
            _ => None,
        };
        let Some((key, value)) = next else {
            return found.map(|f| Found { exact: false, ..f });
        };
        found = Some(Found { exact: true, key, value: value.span(), is_header: is_header(text, value) });
        at = value;
    }
    found
}

/// Whether the span of `value` is not its own text: that of a table with a header or dotted keys,
/// or of a list of such tables.
fn is_header(text: &str, value: &Spanned<DeValue<'_>>) -> bool {
    match value.get_ref() {
        DeValue::Table(_) => !text.get(value.span()).is_some_and(|t| t.starts_with('{')),
        DeValue::Array(list) => list.first().is_some_and(|v| v.get_ref().is_table() && is_header(text, v)),
        _ => false,
    }
}

/// The path of the smallest key or value that covers `span`.
pub(super) fn path_at(text: &str, span: &Range<usize>) -> KeyPath {
    fn visit(value: &DeValue<'_>, path: &KeyPath, span: &Range<usize>, best: &mut (usize, KeyPath)) {
        let mut offer = |place: Range<usize>, path: &KeyPath| {
            let covers = place.start <= span.start && span.end <= place.end;
            if covers && place.len() <= best.0 {
                *best = (place.len(), path.clone());
            }
        };
        match value {
            DeValue::Table(table) => {
                let children: Vec<_> = table.iter().map(|(k, v)| (k, v, path.key(k.get_ref()))).collect();
                for (key, value, path) in &children {
                    offer(value.span(), path);
                    offer(key.span(), path);
                }
                for (_, value, path) in &children {
                    visit(value.get_ref(), path, span, best);
                }
            }
            DeValue::Array(list) => {
                for (i, value) in list.iter().enumerate() {
                    offer(value.span(), &path.index(i));
                }
                for (i, value) in list.iter().enumerate() {
                    visit(value.get_ref(), &path.index(i), span, best);
                }
            }
            _ => {}
        }
    }
    let (root, _) = DeTable::parse_recoverable(text);
    let mut best = (usize::MAX, KeyPath::default());
    visit(&DeValue::Table(root.into_inner()), &KeyPath::default(), span, &mut best);
    best.1
}
