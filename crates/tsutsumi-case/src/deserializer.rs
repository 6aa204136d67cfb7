//! From the spanned tree of a TOML text to plain data, with faults that know their key path.
//!
//! The deserializer that comes with `toml` reports its errors as sentences. This one keeps what serde says as data, so
//! that a message can name the key path, the value and the known names; it also goes on after an unknown key, so that
//! all of them are reported at once. Unknown keys are faults in every struct, whether or not it asks for that.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;

use serde::de::{self, DeserializeSeed, Deserializer, Expected, Unexpected, Visitor};

use crate::key_path::{KeyPath, Segment};
use crate::tree::{Entry, Tree, Value};

/// Most unknown keys that are collected.
const MAX_FAULTS: usize = 1000;

/// What does not fit, as serde told it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FaultKind {
    UnknownKey { name: String, known: Vec<String> },
    MissingKey { name: String },
    WrongType { expected: String },
    UnknownName { name: String, known: Vec<String> },
    Other { message: String },
}

/// Whether a fault is about a key or about its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    Key,
    Value,
}

/// A place where the text does not fit the type.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    pub kind: FaultKind,
    /// `None` until the fault has reached a deserializer, which knows where it stands.
    pub place: Option<(KeyPath, Part)>,
}

impl Fault {
    fn new(kind: FaultKind) -> Self {
        Self { kind, place: None }
    }

    fn placed(mut self, trail: &Trail<'_>, part: Part) -> Self {
        if self.place.is_none() {
            self.place = Some((trail.path(), part));
        }
        self
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?}", self.kind)
    }
}

impl std::error::Error for Fault {}

impl de::Error for Fault {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(FaultKind::Other { message: message.to_string() })
    }

    fn invalid_type(_: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::new(FaultKind::WrongType { expected: plain_words(&expected.to_string()) })
    }

    fn invalid_value(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(unexpected, expected)
    }

    fn invalid_length(_: usize, expected: &dyn Expected) -> Self {
        Self::new(FaultKind::WrongType { expected: plain_words(&expected.to_string()) })
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(FaultKind::UnknownName { name: name.to_owned(), known: owned(known) })
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(FaultKind::UnknownKey { name: name.to_owned(), known: owned(known) })
    }

    fn missing_field(name: &'static str) -> Self {
        Self::new(FaultKind::MissingKey { name: name.to_owned() })
    }
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// What serde expects, in the words of a case file instead of those of Rust.
fn plain_words(expected: &str) -> String {
    let words = match expected {
        "f64" | "f32" => "a number",
        "usize" | "u64" | "u32" | "u16" | "u8" => "a whole number, 0 or more",
        "a nonzero usize" => "a whole number, 1 or more",
        "isize" | "i64" | "i32" | "i16" | "i8" => "a whole number",
        "a boolean" => "true or false",
        "a string" => "a string in double quotes",
        "a sequence" => "an array",
        "a map" => "a table",
        _ if expected.starts_with("struct ") => "a table",
        _ => return expected.replace("an array of length", "an array of"),
    };
    words.to_owned()
}

/// Deserialises a value of the tree that stands at `path`; on failure, all faults found.
pub(crate) fn deserialize<T: de::DeserializeOwned>(value: &Tree, path: &KeyPath) -> Result<T, Vec<Fault>> {
    let faults = RefCell::new(Vec::new());
    let trail = Trail::Start(path);
    let outcome = T::deserialize(Node { value: &value.value, trail: &trail, faults: &faults });
    let mut faults = faults.into_inner();
    match outcome {
        Ok(value) if faults.is_empty() => Ok(value),
        Ok(_) => Err(faults),
        Err(fault) => {
            faults.push(fault.placed(&trail, Part::Value));
            Err(faults)
        }
    }
}

/// The way from the top to a value, on the stack.
#[derive(Clone, Copy)]
enum Trail<'t> {
    Start(&'t KeyPath),
    Key(&'t Trail<'t>, &'t str),
    Index(&'t Trail<'t>, usize),
}

impl Trail<'_> {
    fn path(&self) -> KeyPath {
        let mut segments = Vec::new();
        let mut trail = self;
        loop {
            trail = match trail {
                Trail::Start(path) => {
                    segments.extend(path.segments().iter().rev().cloned());
                    segments.reverse();
                    return segments.into_iter().collect();
                }
                Trail::Key(parent, name) => {
                    segments.push(Segment::Key((*name).to_owned()));
                    parent
                }
                Trail::Index(parent, index) => {
                    segments.push(Segment::Index(*index));
                    parent
                }
            };
        }
    }
}

/// A value of the tree and the way to it.
#[derive(Clone, Copy)]
struct Node<'t, 'de> {
    value: &'de Value,
    trail: &'t Trail<'t>,
    faults: &'t RefCell<Vec<Fault>>,
}

impl<'de> Node<'_, 'de> {
    fn visit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            Value::String(text) => visitor.visit_borrowed_str(text),
            Value::Integer(Some(number)) => visitor.visit_i64(*number),
            Value::Integer(None) => Err(de::Error::custom("is a whole number beyond 64 bits: write a decimal point")),
            Value::Float(Some(number)) => visitor.visit_f64(*number),
            Value::Float(None) => Err(de::Error::custom("is a number beyond the range of 64-bit floating point")),
            Value::Boolean(value) => visitor.visit_bool(*value),
            Value::Date => Err(de::Error::invalid_type(Unexpected::Other("date"), &visitor)),
            Value::Array(array) => self.visit_array(array, visitor),
            Value::Table(table) => visitor.visit_map(Entries::new(self, table, None)),
        }
    }

    fn visit_array<V: Visitor<'de>>(self, array: &'de [Tree], visitor: V) -> Result<V::Value, Fault> {
        let mut elements = Elements { node: self, values: array.iter().enumerate() };
        let value = visitor.visit_seq(&mut elements)?;
        match elements.values.len() {
            0 => Ok(value),
            excess => {
                Err(de::Error::custom(format!("must have {} elements, not {}", array.len() - excess, array.len())))
            }
        }
    }

    fn report_unknown_keys(&self, table: &BTreeMap<String, Entry>, known: &'static [&'static str]) {
        let room = MAX_FAULTS.saturating_sub(self.faults.borrow().len());
        for name in table.keys().filter(|name| !known.contains(&name.as_str())).take(room) {
            let fault: Fault = de::Error::unknown_field(name, known);
            let trail = Trail::Key(self.trail, name);
            self.faults.borrow_mut().push(fault.placed(&trail, Part::Key));
        }
    }
}

impl<'t, 'de> Deserializer<'de> for Node<'t, 'de> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.visit(visitor).map_err(|fault| fault.placed(self.trail, Part::Value))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let Value::Table(table) = self.value else {
            return Err(
                Fault::new(FaultKind::WrongType { expected: "a table".to_owned() }).placed(self.trail, Part::Value)
            );
        };
        self.report_unknown_keys(table, known);
        let entries = Entries::new(self, table, Some(known));
        visitor.visit_map(entries).map_err(|fault| fault.placed(self.trail, Part::Value))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let variant = match self.value {
            Value::String(name) => Variant { node: self, name, value: None },
            Value::Table(table) if table.len() == 1 => match table.iter().next() {
                Some((name, entry)) => Variant { node: self, name, value: Some(&entry.tree.value) },
                None => return Err(one_of(variants).placed(self.trail, Part::Value)),
            },
            Value::Table(_) => return Err(single_key(variants).placed(self.trail, Part::Value)),
            _ => return Err(one_of(variants).placed(self.trail, Part::Value)),
        };
        visitor.visit_enum(variant).map_err(|fault| fault.placed(self.trail, Part::Value))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

fn one_of(variants: &[&str]) -> Fault {
    let names: Vec<_> = variants.iter().map(|name| format!("`{name}`")).collect();
    let expected = match names.as_slice() {
        [only] => only.clone(),
        _ => format!("one of {}", names.join(", ")),
    };
    Fault::new(FaultKind::WrongType { expected })
}

fn single_key(variants: &[&str]) -> Fault {
    let names: Vec<_> = variants.iter().map(|name| format!("`{name}`")).collect();
    let expected = match names.as_slice() {
        [only] => format!("a table with the single key {only}"),
        _ => format!("a table with just one of the keys {}", names.join(", ")),
    };
    Fault::new(FaultKind::WrongType { expected })
}

/// The elements of an array.
struct Elements<'t, 'de> {
    node: Node<'t, 'de>,
    values: std::iter::Enumerate<std::slice::Iter<'de, Tree>>,
}

impl<'de> de::SeqAccess<'de> for &mut Elements<'_, 'de> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some((index, value)) = self.values.next() else {
            return Ok(None);
        };
        let trail = Trail::Index(self.node.trail, index);
        let node = Node { value: &value.value, trail: &trail, faults: self.node.faults };
        seed.deserialize(node).map(Some).map_err(|fault| fault.placed(&trail, Part::Value))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.values.len())
    }
}

/// The keys and values of a table; those that are not `known` have been reported and are left out.
struct Entries<'t, 'de> {
    node: Node<'t, 'de>,
    entries: Vec<(&'de str, &'de Value)>,
    value: Option<(&'de str, &'de Value)>,
}

impl<'t, 'de> Entries<'t, 'de> {
    fn new(node: Node<'t, 'de>, table: &'de BTreeMap<String, Entry>, known: Option<&[&str]>) -> Self {
        let is_known = |name: &str| known.is_none_or(|known| known.contains(&name));
        let entries = table.iter().filter(|(name, _)| is_known(name));
        let mut entries: Vec<_> = entries.map(|(name, entry)| (name.as_str(), &entry.tree.value)).collect();
        entries.reverse();
        Self { node, entries, value: None }
    }
}

impl<'de> de::MapAccess<'de> for Entries<'_, 'de> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        let Some((name, value)) = self.entries.pop() else {
            return Ok(None);
        };
        self.value = Some((name, value));
        let trail = Trail::Key(self.node.trail, name);
        let name = de::value::BorrowedStrDeserializer::new(name);
        seed.deserialize(name).map(Some).map_err(|fault: Fault| fault.placed(&trail, Part::Key))
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Fault> {
        let Some((name, value)) = self.value.take() else {
            return Err(de::Error::custom("has a value without a key"));
        };
        let trail = Trail::Key(self.node.trail, name);
        let node = Node { value, trail: &trail, faults: self.node.faults };
        seed.deserialize(node).map_err(|fault| fault.placed(&trail, Part::Value))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.entries.len())
    }
}

/// A variant of an enum: a name, or a table with the name as its only key.
struct Variant<'t, 'de> {
    node: Node<'t, 'de>,
    name: &'de str,
    value: Option<&'de Value>,
}

impl<'de> Variant<'_, 'de> {
    fn with_value<T>(self, read: impl FnOnce(Node<'_, 'de>) -> Result<T, Fault>) -> Result<T, Fault> {
        let trail = Trail::Key(self.node.trail, self.name);
        match self.value {
            Some(value) => read(Node { value, trail: &trail, faults: self.node.faults }),
            None => {
                let expected = format!("a table with what belongs to it: {{ {} = … }}", self.name);
                Err(Fault::new(FaultKind::WrongType { expected }).placed(self.node.trail, Part::Value))
            }
        }
    }
}

impl<'t, 'de> de::EnumAccess<'de> for Variant<'t, 'de> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Fault> {
        let inner = Trail::Key(self.node.trail, self.name);
        let (trail, part) = match self.value {
            Some(_) => (&inner, Part::Key),
            None => (self.node.trail, Part::Value),
        };
        let name = de::value::BorrowedStrDeserializer::new(self.name);
        let variant = seed.deserialize(name).map_err(|fault: Fault| fault.placed(trail, part))?;
        Ok((variant, self))
    }
}

impl<'de> de::VariantAccess<'de> for Variant<'_, 'de> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        match self.value {
            None => Ok(()),
            Some(_) => Err(Fault::new(FaultKind::WrongType { expected: format!("the word {:?}", self.name) })),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Fault> {
        self.with_value(|node| seed.deserialize(node))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Fault> {
        self.with_value(|node| node.deserialize_any(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(self, known: &'static [&'static str], visitor: V) -> Result<V::Value, Fault> {
        self.with_value(|node| node.deserialize_struct("", known, visitor))
    }
}
