//! Reads tables by the table of keys: refuses what [`KEYS`] does not know, fills in its defaults,
//! and says where and what is wrong.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::document::{Document, DocumentError};

use super::SceneError;
use super::keys::{Absent, KEYS, Key, Kind};
use super::value::{Found, Value};

/// Parses the document without giving it meaning.
pub(super) fn parse_tables(document: &Document) -> Result<Spanned<DeTable<'_>>, DocumentError> {
    DeTable::parse(&document.text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        document.error(offset, error.message())
    })
}

/// One table of a scene file.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    document: &'a Document,
    /// What leads to this table in [`Key::path`]: `camera`, `tree[]`; empty for the outermost.
    prefix: &'static str,
    /// `None` where the file lacks the table and all its keys have defaults.
    table: Option<&'a DeTable<'a>>,
    place: Range<usize>,
}

impl<'a> Reader<'a> {
    /// The outermost table.
    pub(super) fn new(
        document: &'a Document,
        root: &'a Spanned<DeTable<'a>>,
    ) -> Result<Self, SceneError> {
        Self {
            document,
            prefix: "",
            table: Some(root.get_ref()),
            place: 0..0,
        }
        .with_known_keys()
    }

    /// The value of a key that is required or has a default.
    pub(super) fn have<T: Value>(&self, name: &str) -> Result<T, SceneError> {
        Ok(self
            .get(name)?
            .expect("the table of keys requires this key or gives it a default"))
    }

    /// The value of a key, or its default; `None` where it is absent and has none.
    pub(super) fn get<T: Value>(&self, name: &str) -> Result<Option<T>, SceneError> {
        let key = self.key(name);
        if let Some(found) = self.found(name) {
            return match T::read(&key.kind, found) {
                Ok(value) => Ok(Some(value)),
                Err(place) => Err(self.unfit(key, found, place)),
            };
        }
        match key.absent {
            Absent::Required => Err(self.missing(key)),
            Absent::Rule(_) => Ok(None),
            Absent::Value(text) => Ok(Some(default_value(key, text))),
        }
    }

    /// The table below a key; an empty one where it is absent and its default is empty.
    pub(super) fn table(&self, name: &str) -> Result<Option<Self>, SceneError> {
        let key = self.key(name);
        let (table, place) = match (self.found(name), key.absent) {
            (Some(found), _) => match found.get_ref() {
                DeValue::Table(table) => (Some(table), found.span()),
                _ => return Err(self.unfit(key, found, found.span())),
            },
            (None, Absent::Required) => return Err(self.missing(key)),
            (None, Absent::Rule(_)) => return Ok(None),
            (None, Absent::Value(_)) => (None, self.place.clone()),
        };
        let below = Self {
            document: self.document,
            prefix: key.path,
            table,
            place,
        };
        below.with_known_keys().map(Some)
    }

    /// The tables below a key: at least one where it is there; none where it is not required.
    pub(super) fn tables(&self, name: &str) -> Result<Vec<Self>, SceneError> {
        let key = self.key(name);
        let found = match (self.found(name), key.absent) {
            (Some(found), _) => found,
            (None, Absent::Required) => return Err(self.missing(key)),
            (None, _) => return Ok(Vec::new()),
        };
        let (DeValue::Array(array), Kind::Tables { most }) = (found.get_ref(), key.kind) else {
            return Err(self.unfit(key, found, found.span()));
        };
        if array.is_empty() || array.len() > most {
            let count = format!("{} tables", array.len());
            return Err(self.wrong(key, found.span(), &count, &key.kind.wanted()));
        }
        let below = |entry: &'a Found<'a>| match entry.get_ref() {
            DeValue::Table(table) => Self {
                document: self.document,
                prefix: prefix_of_each(key),
                table: Some(table),
                place: entry.span(),
            }
            .with_known_keys(),
            _ => Err(self.unfit(key, entry, entry.span())),
        };
        array.iter().map(below).collect()
    }

    /// Whether the file has the key.
    pub(super) fn has(&self, name: &str) -> bool {
        self.found(name).is_some()
    }

    /// An error at a key, or at its table where the file lacks it: what is there, as it is
    /// written, and what would be right.
    pub(super) fn refuse(&self, name: &str, wanted: &str) -> SceneError {
        let key = self.key(name);
        match self.found(name) {
            Some(found) => {
                let text = self.text(found.span());
                self.wrong(key, found.span(), &text, wanted)
            }
            None => self.wrong(key, self.place.clone(), "nothing", wanted),
        }
    }

    fn key(&self, name: &str) -> &'static Key {
        KEYS.iter()
            .find(|key| local_name(key, self.prefix) == Some(name))
            .expect("only keys of the table are asked for")
    }

    fn found(&self, name: &str) -> Option<&'a Found<'a>> {
        let mut entries = self.table?.iter();
        entries
            .find(|(key, _)| key.get_ref().as_ref() == name)
            .map(|(_, value)| value)
    }

    fn with_known_keys(self) -> Result<Self, SceneError> {
        let known = || KEYS.iter().filter_map(|key| local_name(key, self.prefix));
        for key in self.table.iter().flat_map(|table| table.keys()) {
            if !known().any(|name| name == key.get_ref().as_ref()) {
                let place = match self.prefix {
                    "" => String::new(),
                    prefix => format!(" in `{}`", prefix.replace("[]", "")),
                };
                let names: Vec<&str> = known().collect();
                let message = format!(
                    "unknown key `{}`{place}, wanted one of {}",
                    shortened(key.get_ref()),
                    names.join(", ")
                );
                return Err(self.document.error(key.span().start, message).into());
            }
        }
        Ok(self)
    }

    /// An error at `place` within what was found. The place of a table is only its heading.
    fn unfit(&self, key: &Key, found: &Found<'_>, place: Range<usize>) -> SceneError {
        let text = if found.get_ref().is_table() {
            "a table".to_owned()
        } else {
            self.text(place.clone())
        };
        self.wrong(key, place, &text, &key.kind.wanted())
    }

    fn missing(&self, key: &Key) -> SceneError {
        self.wrong(key, self.place.clone(), "nothing", &key.kind.wanted())
    }

    fn wrong(&self, key: &Key, place: Range<usize>, found: &str, wanted: &str) -> SceneError {
        let path = key.path.replace("[]", "");
        let message = format!("`{path}`: found {found}, wanted {wanted}");
        self.document.error(place.start, message).into()
    }

    fn text(&self, place: Range<usize>) -> String {
        shortened(self.document.text.get(place).unwrap_or_default())
    }
}

/// The name of a key within the table that `prefix` leads to, if it stands there.
fn local_name(key: &Key, prefix: &str) -> Option<&'static str> {
    let name = match prefix {
        "" => key.path,
        _ => key.path.strip_prefix(prefix)?.strip_prefix('.')?,
    };
    (!name.contains('.')).then_some(name)
}

/// What leads to each of several tables: `tree[]` for `tree`.
fn prefix_of_each(key: &Key) -> &'static str {
    KEYS.iter()
        .filter_map(|below| below.path.rsplit_once('.'))
        .map(|(prefix, _)| prefix)
        .find(|prefix| prefix.strip_suffix("[]") == Some(key.path))
        .expect("the table of keys has keys below it")
}

fn default_value<T: Value>(key: &Key, text: &'static str) -> T {
    let value = DeValue::parse(text).expect("defaults are TOML, as a test reads each");
    T::read(&key.kind, &value).expect("defaults are in range, as a test reads each")
}

/// A text on one line, cut after 48 characters.
fn shortened(text: &str) -> String {
    let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.chars().count() <= 48 {
        line
    } else {
        line.chars().take(47).chain(['…']).collect()
    }
}
