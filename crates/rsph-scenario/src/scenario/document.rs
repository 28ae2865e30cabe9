//! The text of a scenario, its edits, and the place of every key in it.

use super::error::ScenarioError;
use super::explain::{explain, suggestion};
use super::keypath::KeyPath;
use super::overrides::Override;
use super::places::{find, path_at};
use super::tables::Scenario;
use rsph_core::error::InvalidInput;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::de::DeTable;
use toml_edit::visit_mut::{self, VisitMut};
use toml_edit::{Item, KeyMut};

/// Longer values are cut in messages.
const MAX_VALUE: usize = 80;

/// The text of a scenario file with the edits made to it.
#[derive(Clone, Debug)]
pub struct Document {
    name: String,
    original: String,
    edited: String,
    overrides: Vec<Override>,
    folder: PathBuf,
}

impl Document {
    pub(super) fn new(name: &str, mut original: String, sets: &[String]) -> Result<Self, ScenarioError> {
        // Some editors put a mark before the text.
        if original.starts_with('\u{feff}') {
            original.remove(0);
        }
        // Syntax first: a message about a syntax error must point into the file as it is.
        DeTable::parse(&original).map_err(|e| syntax_error(name, &original, &e))?;
        let mut document = Self {
            name: name.into(),
            edited: original.clone(),
            original,
            overrides: vec![],
            folder: PathBuf::new(),
        };
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

    /// The same text, whose relative paths start at `folder`.
    pub(super) fn in_folder(self, folder: PathBuf) -> Self {
        Self { folder, ..self }
    }

    /// Where relative paths start.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Name of the file in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text with the edits in it.
    pub fn edited(&self) -> &str {
        &self.edited
    }

    /// The text with the edits in it, where files have absolute paths.
    pub(super) fn with_absolute_paths(&self) -> String {
        let Ok(mut tree) = self.edited.parse::<toml_edit::DocumentMut>() else { return self.edited.clone() };
        let mut paths = Paths { folder: &self.folder };
        paths.visit_document_mut(&mut tree);
        tree.to_string()
    }

    pub(crate) fn tables(&self) -> Result<Scenario, ScenarioError> {
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
        let error = ScenarioError::new(path.to_string(), problem, remedy).with_value(self.value_at(path));
        self.place(path, false, error)
    }

    /// An error of the core, which knows the key but not the file.
    pub fn invalid_input(&self, error: &InvalidInput) -> ScenarioError {
        let path = KeyPath::from(error.key.as_str());
        // As the user wrote it, if it is there; defaults and derived values are the core's to tell.
        let value = self.value_at(&path).or_else(|| Some(error.value.clone()).filter(|v| !v.is_empty()));
        let error = ScenarioError::new(path.to_string(), &error.problem, &error.remedy).with_value(value);
        self.place(&path, false, error)
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
        self.place(path, true, error.with_value(self.value_at(path)))
    }

    /// Points at the key itself (`at_key`) or at its value.
    fn place(&self, path: &KeyPath, at_key: bool, error: ScenarioError) -> ScenarioError {
        let original = find(&self.original, path);
        // What a `--set` put there, or inside of it, is not what the file says.
        let set = self
            .overrides
            .iter()
            .rev()
            .find(|o| o.path.holds(path) || (path.holds(&o.path) && !path.segments().is_empty()));
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

    /// The value at `path` as the user wrote it, on one line.
    fn value_at(&self, path: &KeyPath) -> Option<String> {
        let found = find(&self.edited, path).filter(|f| f.exact && !f.is_header)?;
        let text = self.edited.get(found.value)?.split_whitespace().collect::<Vec<_>>().join(" ");
        let short: String = text.chars().take(MAX_VALUE).collect();
        Some(if short.len() < text.len() { format!("{short}...") } else { short })
    }
}

/// Keys whose value is a file, or a table with its `path`.
const FILES: [&str; 4] = ["mesh", "labelmap", "part", "modulus"];

/// Makes paths of files absolute that start at a folder.
struct Paths<'a> {
    folder: &'a Path,
}

impl Paths<'_> {
    fn make_absolute_in(&self, table: &mut Item) {
        if let Some(path) = table.as_table_like_mut().and_then(|t| t.get_mut("path")) {
            self.make_absolute(path);
        }
    }

    fn make_absolute(&self, path: &mut Item) {
        if let Some(text) = path.as_str()
            && !Path::new(text).is_absolute()
        {
            let file = self.folder.join(text);
            *path = toml_edit::value(std::path::absolute(&file).unwrap_or(file).display().to_string());
        }
    }
}

impl VisitMut for Paths<'_> {
    fn visit_table_like_kv_mut(&mut self, key: KeyMut<'_>, node: &mut Item) {
        if FILES.contains(&key.get()) {
            // The text of a part is its name.
            if node.is_str() && key.get() == "labelmap" {
                self.make_absolute(node);
            }
            self.make_absolute_in(node);
        }
        visit_mut::visit_table_like_kv_mut(self, key, node);
    }
}

fn syntax_error(name: &str, text: &str, error: &toml::de::Error) -> ScenarioError {
    const REMEDY: &str = "correct the line; numbers have a decimal point and no unit, texts stand in straight \
                          quotes, lists in [ ], tables in { }";
    let message = error.message();
    let message = if message.contains("i128") { "this whole number is too large" } else { message };
    ScenarioError::new("", format!("this is no valid TOML: {message}"), REMEDY).at(
        name,
        text,
        error.span().unwrap_or_default(),
    )
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

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[time]\nuntil = 3.0\n\n[[load]]\nkind = \"traction\"\nramp = { to = 1.0 }\n";

    fn message(sets: &[&str], key: &str) -> String {
        let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
        let document = Document::new("f.toml", TEXT.into(), &sets).unwrap();
        document.error(&KeyPath::from(key), "is wrong", "").to_string()
    }

    #[test]
    fn places_are_those_of_the_file_whatever_was_set() {
        assert_eq!(message(&[], "load[0].ramp.to"), "f.toml:6:15: `load[0].ramp.to` = 1.0: is wrong");
        let before = ["title=x", "time.dt=1"];
        assert_eq!(message(&before, "load[0].ramp.to"), "f.toml:6:15: `load[0].ramp.to` = 1.0: is wrong");
    }

    #[test]
    fn absent_keys_are_placed_at_the_table_that_would_hold_them() {
        assert_eq!(message(&[], "time.dt"), "f.toml:1:1: `time.dt`: is wrong");
        assert_eq!(message(&[], "load[0].region.plane"), "f.toml:4:1: `load[0].region.plane`: is wrong");
    }

    #[test]
    fn a_set_at_or_inside_the_key_is_to_blame() {
        let set = ["load.0.ramp.to=-1"];
        for key in ["load[0].ramp.to", "load[0].ramp"] {
            assert!(message(&set, key).starts_with("--set load.0.ramp.to=-1: "), "{key}");
        }
        assert!(message(&set, "load[0].kind").starts_with("f.toml:5:8: "));
    }

    #[test]
    fn tables_show_no_value_but_inline_ones_do() {
        assert_eq!(message(&[], "time"), "f.toml:1:1: `time`: is wrong");
        assert_eq!(message(&[], "load[0].ramp"), "f.toml:6:8: `load[0].ramp` = { to = 1.0 }: is wrong");
    }
}
