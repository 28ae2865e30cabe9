//! From the terse messages of the parser to sentences that say what is allowed and what to do.

use super::document::Document;
use super::error::ScenarioError;
use super::examples::example;
use super::keypath::KeyPath;

/// The word of `known` that was probably meant by `word`.
pub fn suggestion<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    known
        .iter()
        .map(|k| (strsim::jaro_winkler(word, k), strsim::damerau_levenshtein(word, k), *k))
        .map(
            |(likeness, edits, k)| {
                if word.eq_ignore_ascii_case(k) { (1.0, 0, k) } else { (likeness, edits, k) }
            },
        )
        .filter(|(likeness, edits, k)| *likeness > 0.85 || (*edits <= 1 + k.len() / 5 && *edits < k.len()))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, _, k)| k)
}

/// Turns the parser's `message` about the key at `path` into an error with a remedy.
pub(super) fn explain(document: &Document, path: &KeyPath, message: &str) -> ScenarioError {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let first_line = message.lines().next().unwrap_or_default();
    if let (true, Some((key, known))) = (first_line.starts_with("unknown field"), quoted.split_first()) {
        let path = if path.last_key() == *key { path.clone() } else { path.key(key) };
        return document.unknown_key(&path, known);
    }
    // The parser words strangers in a variant's table in its own way.
    if let Some((keys, known)) = first_line
        .strip_prefix("unexpected keys in table: ")
        .and_then(|rest| rest.split_once(", available keys: "))
    {
        let known: Vec<&str> = known.split(", ").collect();
        let key = keys.split(", ").next().unwrap_or_default();
        let path = if path.last_key() == key { path.clone() } else { path.key(key) };
        return document.unknown_key(&path, &known);
    }
    if let (true, Some((word, known))) = (first_line.starts_with("unknown variant"), quoted.split_first()) {
        let allowed = known.iter().map(|k| format!("\"{k}\"")).collect::<Vec<_>>().join(", ");
        let remedy =
            suggestion(word, known).map_or_else(|| remedy_at(path), |s| format!("did you mean \"{s}\"?"));
        return document.error(path, format!("unknown name \"{word}\"; allowed: {allowed}"), remedy);
    }
    if let (true, Some(key)) = (first_line.starts_with("missing field"), quoted.first()) {
        let missing = path.key(key);
        let place = if path.segments().is_empty() { "the scenario".into() } else { format!("`{path}`") };
        let remedy = remedy_at(&missing);
        return document.error(&missing, format!("missing in {place}"), remedy);
    }
    document.error(path, in_plain_words(first_line), remedy_at(path))
}

/// The example for a key, as something to do.
pub fn remedy_at(path: &KeyPath) -> String {
    match example(&path.to_string()) {
        Some(line) if line.contains('\n') => format!("for example\n{line}"),
        Some(line) => format!("for example `{line}`"),
        None => "see `rsph schema` for what is allowed".into(),
    }
}

/// Replaces the names of Rust types by what they mean to a user.
fn in_plain_words(message: &str) -> String {
    const WORDS: &[(&str, &str)] = &[
        ("expected f64", "a number is allowed"),
        ("expected usize", "a whole number, 0 or more, is allowed"),
        ("expected u64", "a whole number, 0 or more, is allowed"),
        ("expected u32", "a whole number from 0 to 4294967295 is allowed"),
        ("expected a map", "a table is allowed"),
        ("wanted exactly 1 element, more than 1 element", "has several keys, and exactly one is allowed"),
        ("expected a boolean", "true or false is allowed"),
        ("expected a string", "a text in quotes is allowed"),
        ("expected an array of length 3", "a list of three is allowed"),
        ("expected a sequence", "a list is allowed"),
        ("expected string or table", "a name or a table is allowed"),
    ];
    let message = &message.replace("type: sequence,", "type: list,").replace("type: map,", "type: table,");
    for (rust, plain) in WORDS {
        if let Some(start) = message.strip_suffix(rust) {
            return format!("{start}{plain}");
        }
    }
    if let Some((start, rest)) = message.split_once("expected struct ") {
        let _ = rest;
        return format!("{start}a table {{ key = value, ... }} is allowed");
    }
    if let Some((start, _)) = message.split_once("expected enum ") {
        return format!("{start}a table {{ kind = ... }} or a name is allowed");
    }
    message.clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_slips_are_recognised_and_strangers_are_not() {
        let known = ["density", "young_modulus", "poisson_ratio"];
        assert_eq!(suggestion("youngs_modulus", &known), Some("young_modulus"));
        assert_eq!(suggestion("poisson", &known), Some("poisson_ratio"));
        assert_eq!(suggestion("colour", &known), None);
        assert_eq!(suggestion("si", &["SI", "normalised"]), Some("SI"));
    }
}
