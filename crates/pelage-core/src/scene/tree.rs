//! A parsed scene file that knows the position of every key and value.

use crate::SceneFault;
use std::{
    collections::BTreeMap,
    ops::Range,
    path::{Path, PathBuf},
};
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// All texts that a scene consists of: files, the preset, flags.
#[derive(Debug, Default)]
pub(super) struct Sources(Vec<Source>);

#[derive(Debug)]
struct Source {
    name: PathBuf,
    /// `None` for sources without lines: flags of the command line, defaults.
    text: Option<String>,
}

/// The position of a key or value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Origin {
    source: usize,
    span: Option<Range<usize>>,
}

/// A value and its position.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub origin: Origin,
    pub value: Value,
}

/// A TOML value.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Table(Table),
    Array(Vec<Node>),
    String(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    /// A value that no key accepts, described for messages: a date, an integer that is too large.
    Other(String),
}

/// A table by key.
pub(super) type Table = BTreeMap<String, Entry>;

/// A key's position and its value.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub key: Origin,
    pub node: Node,
}

impl Sources {
    /// Adds a source; it has no lines if `text` is `None`.
    pub fn add(&mut self, name: impl Into<PathBuf>, text: Option<String>) -> Origin {
        self.0.push(Source { name: name.into(), text });
        Origin { source: self.0.len() - 1, span: None }
    }

    /// A fault at `origin`.
    pub fn fault(&self, origin: &Origin, message: impl Into<String>, help: Option<String>) -> SceneFault {
        let source = &self.0[origin.source];
        let (line, column) = match (&source.text, &origin.span) {
            (Some(text), Some(span)) => line_and_column(text, span.start),
            _ => (0, 0),
        };
        SceneFault { file: source.name.clone(), line, column, message: message.into(), help }
    }

    /// Parses `text` as a TOML document; all syntax errors are reported together.
    pub fn parse(&mut self, name: &Path, text: &str) -> Result<Node, Vec<SceneFault>> {
        let origin = self.add(name, Some(text.to_owned()));
        let (document, errors) = DeTable::parse_recoverable(text);
        if errors.is_empty() {
            let table = self.table(&origin, document.into_inner());
            return Ok(Node { origin, value: Value::Table(table) });
        }
        let fault = |e: &toml::de::Error| {
            let place = Origin { span: e.span(), ..origin.clone() };
            let help = escape_help(text, e.span());
            self.fault(&place, format!("not valid TOML: {}", one_line(e.message())), help)
        };
        Err(errors.iter().map(fault).collect())
    }

    /// The TOML value that `text` denotes; other text is a string.
    pub fn parse_value(&self, origin: &Origin, text: &str) -> Node {
        match DeValue::parse(text) {
            Ok(value) => self.node(origin, value),
            Err(_) => Node { origin: origin.clone(), value: Value::String(text.to_owned()) },
        }
    }

    fn table(&self, origin: &Origin, table: DeTable<'_>) -> Table {
        let entry = |(key, value): (Spanned<std::borrow::Cow<'_, str>>, Spanned<DeValue<'_>>)| {
            let place = Origin { span: Some(key.span()), ..origin.clone() };
            (key.into_inner().into_owned(), Entry { key: place, node: self.node(origin, value) })
        };
        table.into_iter().map(entry).collect()
    }

    fn node(&self, origin: &Origin, value: Spanned<DeValue<'_>>) -> Node {
        let origin = Origin { span: Some(value.span()), ..origin.clone() };
        let value = match value.into_inner() {
            DeValue::String(s) => Value::String(s.into_owned()),
            DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
                Ok(i) => Value::Integer(i),
                Err(_) => Value::Other(format!("the integer {i}, which is too large")),
            },
            DeValue::Float(f) => match f.as_str().parse() {
                Ok(f) => Value::Float(f),
                Err(_) => Value::Other(format!("the number {f}")),
            },
            DeValue::Boolean(b) => Value::Boolean(b),
            DeValue::Datetime(d) => Value::Other(format!("the date {d}")),
            DeValue::Array(a) => Value::Array(a.into_iter().map(|v| self.node(&origin, v)).collect()),
            DeValue::Table(t) => Value::Table(self.table(&origin, t)),
        };
        Node { origin, value }
    }
}

impl Node {
    /// An empty table.
    pub fn empty(origin: Origin) -> Self {
        Self { origin, value: Value::Table(Table::new()) }
    }

    /// A node of a plain TOML value, all of it at `origin`.
    pub fn from_toml(origin: &Origin, value: toml::Value) -> Self {
        use toml::Value as T;
        let value = match value {
            T::String(s) => Value::String(s),
            T::Integer(i) => Value::Integer(i),
            T::Float(f) => Value::Float(f),
            T::Boolean(b) => Value::Boolean(b),
            T::Datetime(d) => Value::Other(format!("the date {d}")),
            T::Array(a) => Value::Array(a.into_iter().map(|v| Self::from_toml(origin, v)).collect()),
            T::Table(t) => Value::Table(
                t.into_iter()
                    .map(|(k, v)| (k, Entry { key: origin.clone(), node: Self::from_toml(origin, v) }))
                    .collect(),
            ),
        };
        Self { origin: origin.clone(), value }
    }

    /// The plain TOML value.
    pub fn to_toml(&self) -> toml::Value {
        use toml::Value as T;
        match &self.value {
            Value::Table(t) => T::Table(t.iter().map(|(k, e)| (k.clone(), e.node.to_toml())).collect()),
            Value::Array(a) => T::Array(a.iter().map(Self::to_toml).collect()),
            Value::String(s) | Value::Other(s) => T::String(s.clone()),
            Value::Integer(i) => T::Integer(*i),
            Value::Float(f) => T::Float(*f),
            Value::Boolean(b) => T::Boolean(*b),
        }
    }

    /// The table, if it is one.
    pub fn as_table(&self) -> Option<&Table> {
        if let Value::Table(table) = &self.value { Some(table) } else { None }
    }

    /// The table, mutable, if it is one.
    pub fn as_table_mut(&mut self) -> Option<&mut Table> {
        if let Value::Table(table) = &mut self.value { Some(table) } else { None }
    }

    /// The value under a key.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.as_table()?.get(key).map(|e| &e.node)
    }

    /// The node at a dotted path, array indices included.
    pub fn at(&self, path: &str) -> Option<&Node> {
        path.split('.').try_fold(self, |node, key| match &node.value {
            Value::Table(table) => table.get(key).map(|e| &e.node),
            Value::Array(items) => items.get(key.parse::<usize>().ok()?),
            _ => None,
        })
    }

    /// The position of the value at a dotted path, or of the innermost given table around it.
    pub fn origin_of(&self, path: &str) -> &Origin {
        let mut node = self;
        for key in path.split('.') {
            match node.at(key) {
                Some(inner) => node = inner,
                None => break,
            }
        }
        &node.origin
    }

    /// What the value is, for messages.
    pub fn describe(&self) -> String {
        match &self.value {
            Value::Table(_) => "a table".into(),
            Value::Array(a) if a.len() == 1 => "an array of 1 value".into(),
            Value::Array(a) => format!("an array of {} values", a.len()),
            Value::String(s) => format!("the string {s:?}"),
            Value::Integer(i) => i.to_string(),
            Value::Float(f) => f.to_string(),
            Value::Boolean(b) => b.to_string(),
            Value::Other(s) => s.clone(),
        }
    }
}

/// What to do about a backslash at `span` of a TOML text, or just before it.
fn escape_help(text: &str, span: Option<Range<usize>>) -> Option<String> {
    let span = span?;
    let first = span.start.saturating_sub(1);
    let around = text.as_bytes().get(first..span.end.max(span.start + 1).min(text.len()))?;
    around.contains(&b'\\').then(|| ESCAPE_HELP.to_owned())
}

/// What to do where a backslash in a file name was read as the beginning of an escape.
pub(super) const ESCAPE_HELP: &str =
    "in double quotes \\ begins an escape: write / between folders, or put the name in single quotes";

fn one_line(message: &str) -> String {
    message.split('\n').map(str::trim).collect::<Vec<_>>().join("; ")
}

/// Line and column (in characters), both from 1, of a byte offset.
fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[start..].chars().count() + 1)
}
