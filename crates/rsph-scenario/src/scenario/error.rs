//! A scenario that can not be understood or simulated: what, where, and what to do about it.

use crate::whole_file::Unreadable;
use miette::{Diagnostic, LabeledSpan, NamedSource, Severity, SourceCode};
use std::fmt;
use std::ops::Range;

/// A text with longer lines (bytes) is not shown: it was not written by hand.
const LONGEST_LINE: usize = 1000;

/// Wrong input, with its place in the scenario file (or the `--set` that brought it in).
#[derive(Clone, Debug)]
pub struct ScenarioError {
    /// Dotted key, e.g. `boundary[0].region`; empty if the text as a whole is meant.
    pub key: String,
    /// The value as written, if there is one.
    pub value: Option<String>,
    /// What is wrong and what is allowed.
    pub problem: String,
    /// What to do about it.
    pub remedy: String,
    place: Option<Box<Place>>,
}

#[derive(Clone, Debug)]
struct Place {
    source: NamedSource<String>,
    span: Range<usize>,
}

impl ScenarioError {
    /// An error without a place.
    pub fn new(key: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { key: key.into(), value: None, problem: problem.into(), remedy: remedy.into(), place: None }
    }

    /// A file that can not be read.
    pub(super) fn unreadable(name: &str, why: Unreadable) -> Self {
        Self::new("", format!("{name}: {}", why.problem), why.remedy)
    }

    /// A file whose `bytes` are no text.
    pub(super) fn no_text(name: &str, bytes: &[u8]) -> Self {
        let remedy = match bytes {
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "it looks like UTF-16: save it as UTF-8",
            _ => "a scenario is a TOML text in UTF-8; `rsph new > my.toml` writes one to start from",
        };
        Self::new("", format!("{name}: this is no text in UTF-8"), remedy)
    }

    pub(super) fn with_value(mut self, value: Option<String>) -> Self {
        self.value = value;
        self
    }

    pub(super) fn at(mut self, name: &str, text: &str, span: Range<usize>) -> Self {
        let end = span.end.min(text.len());
        let source = NamedSource::new(name, text.to_owned());
        self.place = Some(Box::new(Place { source, span: span.start.min(end)..end }));
        self
    }

    /// File, line and column (from 1), or the `--set`, where it is.
    pub fn place(&self) -> Option<String> {
        let place = self.place.as_ref()?;
        let name = place.source.name();
        if name.starts_with("--set") {
            return Some(name.to_owned());
        }
        let before = place.source.inner().get(..place.span.start)?;
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
        Some(format!("{name}:{line}:{column}"))
    }

    /// The place, if a terminal can show it.
    fn shown(&self) -> Option<&Place> {
        self.place.as_deref().filter(|p| p.source.inner().lines().all(|line| line.len() <= LONGEST_LINE))
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = self.place() {
            write!(f, "{place}: ")?;
        }
        match (self.key.as_str(), &self.value) {
            ("", _) => write!(f, "{}", self.problem),
            (key, Some(value)) => write!(f, "`{key}` = {value}: {}", self.problem),
            (key, None) => write!(f, "`{key}`: {}", self.problem),
        }
    }
}

impl std::error::Error for ScenarioError {}

impl Diagnostic for ScenarioError {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Error)
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        (!self.remedy.is_empty()).then(|| Box::new(&self.remedy) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.shown().map(|p| &p.source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.shown()?;
        let label = LabeledSpan::new_with_span(Some("here".into()), place.span.clone());
        Some(Box::new(std::iter::once(label)))
    }
}
