//! The text of a scenario, its edits, and the place of every key in it.

use super::error::ScenarioError;
use super::explain::{explain, suggestion};
use super::keypath::{KeyPath, Segment};
use super::overrides::Override;
use super::tables::Scenario;
use rsph_core::error::InvalidInput;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a scenario file with the edits made to it.
#[derive(Clone, Debug)]
pub struct Document {
    name: String,
    original: String,
    edited: String,
    overrides: Vec<Override>,
}

impl Document {
    pub(super) fn new(name: &str, original: String, sets: &[String]) -> Result<Self, ScenarioError> {
        // Syntax first: a message about a syntax error must point into the file as it is.
        DeTable::parse(&original).map_err(|e| syntax_error(name, &original, &e))?;
        let mut document = Self { name: name.into(), edited: original.clone(), original, overrides: vec![] };
        if !sets.is_empty() {
            let mut tree: toml_edit::DocumentMut =
                document.original.parse().map_err(|e: toml_edit::TomlError| {
                    ScenarioError::new("", e.message(), "correct the TOML").at(
                        name,
                        &document.original,
                        e.span().unwrap_or_default(),
                    )
                })?;
            for set in sets {
                document.overrides.push(Override::apply(set, &mut tree)?);
            }
            document.edited = tree.to_string();
        }
        Ok(document)
    }

    /// Name of the file in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text with the edits in it.
    pub fn edited(&self) -> &str {
        &self.edited
    }

    pub(super) fn tables(&self) -> Result<Scenario, ScenarioError> {
        let whole = |e: &toml::de::Error| syntax_error(&self.name, &self.edited, e);
        let values: toml::Table = self.edited.parse().map_err(|e| whole(&e))?;
        if let Some(path) = first_not_finite(&toml::Value::Table(values), &KeyPath::default()) {
            return Err(self.error(
                &path,
                "must be a finite number",
                "write a plain number such as 1.5 or 2e5",
            ));
        }
        let deserializer = toml::Deserializer::parse(&self.edited).map_err(|e| whole(&e))?;
        Scenario::deserialize(deserializer).map_err(|e| {
            let path = e.span().map_or_else(KeyPath::default, |span| path_at(&self.edited, &span));
            explain(self, &path, e.message())
        })
    }

    /// An error at `path`: its value and its place, or those of the nearest table that holds it.
    pub fn error(
        &self,
        path: &KeyPath,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> ScenarioError {
        let value =
            find(&self.edited, path).and_then(|f| f.exact.then(|| self.value_text(&f.value))).flatten();
        self.place(path, false, ScenarioError::new(path.to_string(), problem, remedy).with_value(value))
    }

    /// An error of the core, which knows the key but not the file.
    pub fn invalid_input(&self, error: &InvalidInput) -> ScenarioError {
        let path = KeyPath::from(error.key.as_str());
        let place = ScenarioError::new(path.to_string(), &error.problem, &error.remedy);
        self.place(&path, false, place.with_value(Some(error.value.clone()).filter(|v| !v.is_empty())))
    }

    /// The key at `path` is none of `known`.
    pub(super) fn unknown_key(&self, path: &KeyPath, known: &[&str]) -> ScenarioError {
        let parent = path.parent().to_string();
        let place = if parent.is_empty() { "at the top level".into() } else { format!("in `{parent}`") };
        let allowed = known.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ");
        let remedy = suggestion(path.last_key(), known)
            .map_or_else(|| "remove it, or see `rsph schema`".into(), |s| format!("did you mean `{s}`?"));
        let error =
            ScenarioError::new(path.to_string(), format!("unknown key; allowed {place}: {allowed}"), remedy);
        let value = find(&self.edited, path).and_then(|f| self.value_text(&f.value));
        self.place(path, true, error.with_value(value))
    }

    /// Points at the key itself (`at_key`) or at its value.
    fn place(&self, path: &KeyPath, at_key: bool, error: ScenarioError) -> ScenarioError {
        let original = find(&self.original, path);
        let exact = original.as_ref().is_some_and(|f| f.exact);
        let set =
            self.overrides.iter().rev().find(|o| {
                o.path.holds(path) || (!exact && path.holds(&o.path) && !path.segments().is_empty())
            });
        if let Some(set) = set {
            return error.at(&set.name(), &set.text, 0..set.text.len());
        }
        let span = match original {
            Some(f) if at_key && f.exact => f.key,
            Some(f) => f.value,
            None => 0..self.original.find('\n').unwrap_or(self.original.len()),
        };
        error.at(&self.name, &self.original, span)
    }

    fn value_text(&self, span: &Range<usize>) -> Option<String> {
        let text = self.edited.get(span.clone())?.split_whitespace().collect::<Vec<_>>().join(" ");
        let short: String = text.chars().take(80).collect();
        // The span of a table is that of its header, which is not a value worth showing.
        (!text.is_empty() && !text.starts_with("[[") && !is_header(&text))
            .then(|| if short.len() < text.len() { format!("{short}...") } else { short })
    }
}

fn is_header(text: &str) -> bool {
    text.strip_prefix('[').and_then(|t| t.strip_suffix(']')).is_some_and(|t| {
        !t.is_empty()
            && t.parse::<f64>().is_err()
            && t.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c))
    })
}

fn syntax_error(name: &str, text: &str, error: &toml::de::Error) -> ScenarioError {
    let problem = format!("this is no valid TOML: {}", error.message());
    ScenarioError::new("", problem, "correct the line; texts are quoted, lists stand in [ ], tables in { }")
        .at(name, text, error.span().unwrap_or_default())
}

fn first_not_finite(value: &toml::Value, path: &KeyPath) -> Option<KeyPath> {
    match value {
        toml::Value::Float(x) => (!x.is_finite()).then(|| path.clone()),
        toml::Value::Array(list) => {
            list.iter().enumerate().find_map(|(i, v)| first_not_finite(v, &path.index(i)))
        }
        toml::Value::Table(table) => table.iter().find_map(|(k, v)| first_not_finite(v, &path.key(k))),
        _ => None,
    }
}

/// Where a key and its value stand.
struct Found {
    /// Whether the whole path is there; else this is the nearest table that holds it.
    exact: bool,
    key: Range<usize>,
    value: Range<usize>,
}

fn find(text: &str, path: &KeyPath) -> Option<Found> {
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
        found = Some(Found { exact: true, key, value: value.span() });
        at = value;
    }
    found
}

/// The path of the smallest key or value that covers `span`.
fn path_at(text: &str, span: &Range<usize>) -> KeyPath {
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
