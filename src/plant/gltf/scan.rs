//! A first look at a document's JSON that costs no memory: sizes, depth, integers, extensions.

use super::error::Fault;
use crate::document::DocumentError;
use crate::limits::{JSON_OBJECTS, JSON_VALUES};
use crate::plant::import::ImportError;
use gltf_json::Root;
use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;

/// A document that was looked through before it was built in memory.
#[derive(Debug)]
pub(super) struct Document {
    /// The document.
    pub(super) root: Root,
    /// The extensions that stand somewhere in it: how often, and the first pointer.
    pub(super) extensions: BTreeMap<String, (u64, String)>,
}

/// Reads a document.
///
/// Counts first: `[{},{},…]` takes two hundred times its size in memory. Integers of 2³² and more
/// are refused where they stand, since indices are 32 bits wide and the parser would cut them.
pub(super) fn parse(file: &str, json: &[u8], offset: u64) -> Result<Document, ImportError> {
    let syntax = |error: &serde_json::Error| {
        let line = error.line().max(1);
        let before = json.split(|&byte| byte == b'\n').nth(line - 1);
        let before = before.unwrap_or_default();
        let before = &before[..before.len().min(error.column().saturating_sub(1))];
        let column = 1 + String::from_utf8_lossy(before).chars().count();
        let text = error.to_string();
        let text = text.split(" at line ").next().unwrap_or_default();
        let chunk = if offset > 3 {
            format!(" (in the JSON chunk, from byte {offset})")
        } else {
            String::new()
        };
        let file = file.to_owned();
        let message = format!("not a glTF document: {text}{chunk}");
        ImportError::Syntax(DocumentError {
            file,
            line,
            column,
            message,
        })
    };
    let mut scan = Scan::default();
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let scanned = Walk(&mut scan)
        .deserialize(&mut deserializer)
        .and_then(|()| deserializer.end());
    if let Some(fault) = scan.fault {
        return Err(fault.in_file(file));
    }
    scanned.map_err(|error| syntax(&error))?;
    let root = Root::from_slice(json).map_err(|error| syntax(&error))?;
    let extensions = scan.extensions;
    Ok(Document { root, extensions })
}

#[derive(Default)]
struct Scan {
    pointer: String,
    objects: u64,
    values: u64,
    foreign_depth: u32,
    extensions: BTreeMap<String, (u64, String)>,
    fault: Option<Fault>,
}

impl Scan {
    fn refuse<E: serde::de::Error>(&mut self, message: String) -> E {
        let pointer = std::mem::take(&mut self.pointer);
        self.fault = Some(Fault::new(pointer, message));
        E::custom("refused")
    }

    fn count_value<E: serde::de::Error>(&mut self) -> Result<(), E> {
        self.values += 1;
        if self.values > JSON_VALUES {
            let message = format!("more than {JSON_VALUES} JSON values; put data into buffers");
            return Err(self.refuse(message));
        }
        Ok(())
    }
}

struct Walk<'s>(&'s mut Scan);

impl<'de> DeserializeSeed<'de> for Walk<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Walk<'_> {
    type Value = ();

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("JSON")
    }

    fn visit_unit<E: serde::de::Error>(self) -> Result<(), E> {
        self.0.count_value()
    }

    fn visit_bool<E: serde::de::Error>(self, _: bool) -> Result<(), E> {
        self.0.count_value()
    }

    fn visit_i64<E: serde::de::Error>(self, _: i64) -> Result<(), E> {
        self.0.count_value()
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<(), E> {
        if self.0.foreign_depth == 0 && value > u64::from(u32::MAX) {
            let message = format!("{value} exceeds the largest integer of glTF, {}", u32::MAX);
            return Err(self.0.refuse(message));
        }
        self.0.count_value()
    }

    fn visit_f64<E: serde::de::Error>(self, _: f64) -> Result<(), E> {
        self.0.count_value()
    }

    fn visit_str<E: serde::de::Error>(self, _: &str) -> Result<(), E> {
        self.0.count_value()
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<(), A::Error> {
        self.0.count_value()?;
        let length = self.0.pointer.len();
        for index in 0_u64.. {
            self.0.pointer.push_str(&format!("/{index}"));
            let item = items.next_element_seed(Walk(self.0))?;
            self.0.pointer.truncate(length);
            if item.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<(), A::Error> {
        let scan = self.0;
        scan.count_value()?;
        scan.objects += 1;
        if scan.objects > JSON_OBJECTS {
            let message = format!("more than {JSON_OBJECTS} JSON objects; join meshes first");
            return Err(scan.refuse(message));
        }
        let length = scan.pointer.len();
        let lists_extensions = scan.foreign_depth == 1 && scan.pointer.ends_with("/extensions");
        while let Some(key) = entries.next_key::<String>()? {
            scan.pointer.push('/');
            let escaped = key.replace('~', "~0").replace('/', "~1");
            scan.pointer.push_str(&escaped);
            if lists_extensions {
                let first = (0, scan.pointer.clone());
                scan.extensions.entry(key.clone()).or_insert(first).0 += 1;
            }
            let foreign = matches!(key.as_str(), "extensions" | "extras");
            scan.foreign_depth += u32::from(foreign);
            entries.next_value_seed(Walk(scan))?;
            scan.foreign_depth -= u32::from(foreign);
            scan.pointer.truncate(length);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(json: &str) -> String {
        parse("a.gltf", json.as_bytes(), 0).unwrap_err().to_string()
    }

    #[test]
    fn broken_json_is_named_by_line_and_column() {
        assert!(error("{\n \"ä\": }").starts_with("a.gltf:2:7: "));
        assert!(error("").starts_with("a.gltf:1:1: "));
        assert!(error(&"[".repeat(1 << 20)).contains("recursion limit"));
    }

    #[test]
    fn wide_integers_are_refused_and_not_cut() {
        let json = r#"{"asset":{"version":"2.0"},"scene":4294967296}"#;
        assert!(error(json).starts_with("a.gltf: /scene: 4294967296 exceeds"));
        let json = r#"{"asset":{"version":"2.0"},"extras":{"a":4294967296}}"#;
        assert!(parse("a.gltf", json.as_bytes(), 0).is_ok());
    }

    #[test]
    fn many_objects_are_refused_before_they_take_memory() {
        let list = "{},".repeat(usize::try_from(JSON_OBJECTS).unwrap());
        let json = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{list}{{}}]}}"#);
        assert!(error(&json).contains("/nodes/524286: more than 524288 JSON objects"));
    }

    #[test]
    fn extensions_are_counted_with_their_first_place() {
        let json = r#"{"asset":{"version":"2.0"},"nodes":[{},{"extensions":{"A":{}}},
            {"extensions":{"A":{"extensions":{"B":1}}}}]}"#;
        let document = parse("a.gltf", json.as_bytes(), 0).unwrap();
        let found = (2, "/nodes/1/extensions/A".to_owned());
        assert_eq!(
            document.extensions,
            BTreeMap::from([("A".to_owned(), found)])
        );
    }
}
