//! `--set key.path=value`: edits of a scenario before it is understood. Comments and order of the
//! file are kept, so that the scenario as run reads like the one that was written.

use super::error::ScenarioError;
use super::keypath::{KeyPath, Segment};
use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// Keys of which a table takes only one: setting the first removes the second.
const ALTERNATIVES: &[(&str, &str)] = &[("body.spacing", "particles"), ("body.particles", "spacing")];

/// One edit.
#[derive(Clone, Debug)]
pub(super) struct Override {
    /// What it sets.
    pub path: KeyPath,
    /// As the user typed it, `key.path=value`.
    pub text: String,
}

impl Override {
    /// The name under which messages show it.
    pub fn name(&self) -> String {
        format!("--set {}", self.text)
    }

    /// Applies the edit `text` to `document`.
    pub fn apply(text: &str, document: &mut DocumentMut) -> Result<Self, ScenarioError> {
        let wrong = |problem: String, remedy: &str| {
            ScenarioError::new("", problem, remedy).at(&format!("--set {text}"), text, 0..text.len())
        };
        let (key, value) = text.split_once('=').ok_or_else(|| {
            wrong("an edit has the form key.path=value".into(), "for example `--set time.until=1.0`")
        })?;
        let path = KeyPath::from(key);
        let Some(Segment::Key(_)) = path.segments().first() else {
            return Err(wrong(
                "the key must start with a name".into(),
                "for example `--set load.0.ramp.to=1.0` for the first load",
            ));
        };
        let value = parse_value(value.trim()).map_err(|e| {
            wrong(format!("the value is no TOML: {e}"), "quote texts, write lists as [1, 2, 3]")
        })?;
        set_in_table(document.as_table_mut(), path.segments(), value)
            .map_err(|e| wrong(e, "look up the keys with `rsph schema` or in the scenario file"))?;
        if let Some((_, other)) = ALTERNATIVES.iter().find(|(k, _)| KeyPath::from(*k) == path)
            && let Some(body) = document.get_mut("body").and_then(Item::as_table_like_mut)
        {
            body.remove(other);
        }
        Ok(Self { path, text: text.into() })
    }
}

/// A TOML value; bare words are texts.
fn parse_value(text: &str) -> Result<Value, String> {
    match text.parse::<Value>() {
        Ok(value) => Ok(value),
        Err(e) if text.is_empty() || text.starts_with(['[', '{', '"', '\'']) => Err(e.to_string()),
        Err(_) => Ok(Value::from(text)),
    }
}

fn set_in_table(table: &mut dyn TableLike, path: &[Segment], value: Value) -> Result<(), String> {
    let Some((Segment::Key(key), rest)) = path.split_first() else {
        return Err("a table has named keys, not numbered entries".into());
    };
    if rest.is_empty() {
        match table.get_mut(key).and_then(Item::as_value_mut) {
            Some(old) => replace(old, value),
            None => {
                table.insert(key, Item::Value(value));
            }
        }
        return Ok(());
    }
    if !table.contains_key(key) {
        if matches!(rest.first(), Some(Segment::Index(_))) {
            return Err(format!("there is no list `{key}`"));
        }
        table.insert(key, Item::Table(Table::new()));
    }
    match table.get_mut(key) {
        Some(Item::Value(v)) => set_in_value(v, key, rest, value),
        Some(Item::Table(t)) => set_in_table(t, rest, value),
        Some(Item::ArrayOfTables(list)) => {
            let length = list.len();
            let index = index_of(key, rest, length)?;
            let entry = list.get_mut(index).ok_or_else(|| no_entry(key, index, length))?;
            match (&rest[1..], value) {
                ([], Value::InlineTable(whole)) => {
                    *entry = whole.into_table();
                    Ok(())
                }
                ([], _) => Err(format!("`{key}.{index}` is a table: give it as {{ key = value, ... }}")),
                (inner, value) => set_in_table(entry, inner, value),
            }
        }
        Some(Item::None) | None => Err(format!("there is no `{key}`")),
    }
}

fn set_in_value(old: &mut Value, key: &str, path: &[Segment], value: Value) -> Result<(), String> {
    let Some((first, rest)) = path.split_first() else {
        replace(old, value);
        return Ok(());
    };
    match old {
        Value::InlineTable(t) => {
            let Segment::Key(inner) = first else {
                return Err(format!("`{key}` is a table: it has named keys, not numbered entries"));
            };
            if !rest.is_empty() && t.get(inner).is_none() {
                t.insert(inner, Value::InlineTable(InlineTable::new()));
            }
            match t.get_mut(inner) {
                Some(v) => set_in_value(v, inner, rest, value)?,
                None => {
                    t.insert(inner, value);
                }
            }
            Ok(())
        }
        Value::Array(list) => {
            let length = list.len();
            let index = index_of(key, path, length)?;
            let entry = list.get_mut(index).ok_or_else(|| no_entry(key, index, length))?;
            set_in_value(entry, key, rest, value)
        }
        other => Err(format!("`{key}` is a {}, which has no keys inside", other.type_name())),
    }
}

fn index_of(key: &str, path: &[Segment], length: usize) -> Result<usize, String> {
    match path.first() {
        Some(Segment::Index(i)) => Ok(*i),
        _ => Err(format!("`{key}` is a list of {length}: say which entry, as in `{key}.0`")),
    }
}

fn no_entry(key: &str, index: usize, length: usize) -> String {
    format!("`{key}` has no entry {index}: it holds {length}, counted from 0")
}

/// Puts `new` where `old` was, comment at the end of the line included.
fn replace(old: &mut Value, new: Value) {
    let decor = old.decor().clone();
    *old = new;
    *old.decor_mut() = decor;
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TEXT: &str = "\
# a comment
[body]
shape = { box = { size = [1.0, 1.0, 1.0] } } # a cube
spacing = 0.1
[[load]]
kind = \"traction\"
";

    fn edit(text: &str) -> Result<String, ScenarioError> {
        let mut document: DocumentMut = TEXT.parse().unwrap();
        Override::apply(text, &mut document)?;
        Ok(document.to_string())
    }

    #[test]
    fn values_lists_words_and_new_tables_are_set() {
        assert!(edit("body.spacing=0.05").unwrap().contains("spacing = 0.05"));
        assert!(
            edit("body.shape.box.size.2=3").unwrap().contains("size = [1.0, 1.0,3]")
                || edit("body.shape.box.size.2=3").unwrap().contains("size = [1.0, 1.0, 3]")
        );
        assert!(edit("title=A bare title").unwrap().contains("title = \"A bare title\""));
        assert!(edit("solver.formulation=paper").unwrap().contains("[solver]\nformulation = \"paper\""));
        assert!(edit("load.0.kind=pressure").unwrap().contains("kind = \"pressure\""));
        let nested = edit("load[0].ramp.to=1").unwrap();
        let table: toml::Table = nested.parse().unwrap();
        assert_eq!(table["load"][0]["ramp"]["to"].as_integer(), Some(1));
    }

    #[test]
    fn comments_survive() {
        let edited = edit("body.shape={ organ = \"liver\" }").unwrap();
        assert!(edited.contains("# a comment") && edited.contains("# a cube"), "{edited}");
    }

    #[test]
    fn particles_take_the_place_of_spacing() {
        let edited = edit("body.particles=1000").unwrap();
        assert!(edited.contains("particles = 1000") && !edited.contains("spacing"), "{edited}");
    }

    #[test]
    fn mistakes_name_the_set() {
        for (text, says) in [
            ("body.spacing", "key.path=value"),
            ("load.3.kind=x", "no entry 3"),
            ("load.kind=x", "say which entry"),
            ("body.spacing.x=1", "no keys inside"),
            ("time.until=[1", "no TOML"),
            ("probe.0.name=x", "no list `probe`"),
        ] {
            let error = edit(text).unwrap_err().to_string();
            assert!(error.contains(says) && error.contains(&format!("--set {text}")), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn any_edit_leaves_toml_or_an_error(text in "(body|load|x)?[.0-9a-z\\[\\]]{0,12}=?\\PC{0,12}") {
            if let Ok(edited) = edit(&text) {
                prop_assert!(edited.parse::<toml::Table>().is_ok(), "{}", edited);
            }
        }
    }
}
