//! The JSON schemas of case files, study files, element tests and calibrations, and the documentation of their keys, from the types in
//! [`schema`](crate::schema), [`study`](crate::study), [`element`](crate::element) and [`calibration`](crate::calibration).

use std::collections::BTreeSet;
use std::sync::LazyLock;

use serde_json::{Map, Value, json};

use crate::calibration::schema::CalibrationFile;
use crate::element::schema::ElementTestFile;
use crate::key_path::{KeyPath, Segment};
use crate::schema::Case;
use crate::study::schema::StudyFile;

/// The JSON schema of case files. What the registry knows comes from there: the laws and exact motions by name with the schemas of
/// their parameters, and the words that other keys may have, by the type of the table and the key (`("Method", "shape")`).
pub fn case_schema(laws: &[(&str, Value)], motions: &[(&str, Value)], words: &[(&str, &str, Vec<&str>)]) -> Value {
    let mut schema = CASE_KEYS.schema.clone();
    insert_named(&mut schema, "Material", "law", laws);
    insert_named(&mut schema, "ExactMotion", "solution", motions);
    for (table, key, words) in words {
        restrict(&mut schema, &format!("/$defs/{table}/properties/{key}"), words);
    }
    schema
}

/// The JSON schema of element tests, with the laws by name.
pub(crate) fn element_test_schema(laws: &[(&str, Value)]) -> Value {
    let mut schema = ELEMENT_TEST_KEYS.schema.clone();
    insert_named(&mut schema, "TestMaterial", "law", laws);
    schema
}

/// Puts the names that the key of a table may have, and the schemas of the parameters that go with each, into the table.
fn insert_named(schema: &mut Value, table: &str, key: &str, named: &[(&str, Value)]) {
    let mut definitions = Map::new();
    let condition = |(name, one): &(&str, Value)| named_condition(key, name, one, &mut definitions);
    let conditions: Vec<_> = named.iter().map(condition).collect();
    if let Some(table) = schema.pointer_mut(&format!("/$defs/{table}")).and_then(Value::as_object_mut)
        && !named.is_empty()
    {
        table.insert("allOf".to_owned(), conditions.into());
    }
    let names: Vec<_> = named.iter().map(|(name, _)| *name).collect();
    restrict(schema, &format!("/$defs/{table}/properties/{key}"), &names);
    if let Some(all) = schema.pointer_mut("/$defs").and_then(Value::as_object_mut) {
        all.append(&mut definitions);
    }
}

/// The JSON schema of study files. The names of the exact solutions, with the schemas of their parameters and of the
/// quantities they give, come from their registry.
pub(crate) fn study_schema(solutions: &[SolutionSchema]) -> Value {
    let mut schema = STUDY_KEYS.schema.clone();
    let mut definitions = Map::new();
    let mut conditions = Vec::new();
    for solution in solutions {
        let prefix = format!("solution:{}:", solution.name);
        let parameters = embedded(&solution.parameters, &format!("{prefix}parameters:"), &mut definitions);
        let quantity = embedded(&solution.quantity, &format!("{prefix}quantity:"), &mut definitions);
        conditions.push(json!({
            "if": { "properties": { "solution": { "const": solution.name } }, "required": ["solution"] },
            "then": {
                "properties": { "parameters": parameters, "quantities": { "additionalProperties": quantity } },
                "required": ["parameters", "quantities"]
            }
        }));
    }
    if let Some(reference) = schema.pointer_mut("/$defs/Reference").and_then(Value::as_object_mut) {
        reference.insert("allOf".to_owned(), conditions.into());
    }
    let names: Vec<_> = solutions.iter().map(|solution| solution.name).collect();
    restrict(&mut schema, "/$defs/Reference/properties/solution", &names);
    if let Some(all) = schema.pointer_mut("/$defs").and_then(Value::as_object_mut) {
        all.append(&mut definitions);
    }
    schema
}

/// An exact solution as the schema of study files describes it.
pub(crate) struct SolutionSchema {
    pub(crate) name: &'static str,
    pub(crate) parameters: Value,
    pub(crate) quantity: Value,
}

/// A schema as part of another one: its own definitions move there, under names with a prefix.
fn embedded(schema: &Value, prefix: &str, definitions: &mut Map<String, Value>) -> Value {
    let mut schema = schema.clone();
    rename_references(&mut schema, prefix);
    if let Some(object) = schema.as_object_mut() {
        object.remove("$schema");
        if let Some(Value::Object(inner)) = object.remove("$defs") {
            definitions.extend(inner.into_iter().map(|(name, schema)| (format!("{prefix}{name}"), schema)));
        }
    }
    schema
}

/// If a table's key, such as the law of a material, has this name, its parameters are those of the name.
fn named_condition(key: &str, name: &str, parameters: &Value, definitions: &mut Map<String, Value>) -> Value {
    let prefix = format!("{key}:{}:", name.replace(['~', '/', '#', '%', ' '], "-"));
    let parameters = embedded(parameters, &prefix, definitions);
    let needs_some = parameters.get("required").and_then(Value::as_array).is_some_and(|required| !required.is_empty());
    let mut consequence = json!({ "properties": { "parameters": parameters } });
    if needs_some {
        consequence["required"] = json!(["parameters"]);
    }
    json!({ "if": { "properties": { (key): { "const": name } }, "required": [key] }, "then": consequence })
}

/// References to a schema's own definitions follow these to their new names.
fn rename_references(schema: &mut Value, prefix: &str) {
    match schema {
        Value::Object(object) => {
            if let Some(Value::String(reference)) = object.get_mut("$ref") {
                *reference = reference.replacen("#/$defs/", &format!("#/$defs/{prefix}"), 1);
            }
            object.values_mut().for_each(|value| rename_references(value, prefix));
        }
        Value::Array(array) => array.iter_mut().for_each(|value| rename_references(value, prefix)),
        _ => {}
    }
}

fn restrict(schema: &mut Value, pointer: &str, names: &[&str]) {
    if let Some(property) = schema.pointer_mut(pointer).and_then(Value::as_object_mut)
        && !names.is_empty()
    {
        property.insert("enum".to_owned(), json!(names));
    }
}

/// One key of the case file, for the reference page of the book.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyDocumentation {
    /// The table it stands in, in the manner of a path: `materials.<name>`, `bodies[]`; empty for the top level.
    pub table: String,
    /// The key.
    pub name: String,
    /// What its value is, in words: `number`, `array of whole numbers`, `table`.
    pub kind: String,
    /// What it means, with its unit.
    pub description: String,
    /// The words it may be, each with its meaning; empty if it is not a word from a list.
    pub words: Vec<(String, String)>,
    /// Its default, if it has one that can be written down.
    pub default: Option<Value>,
    /// Whether it has to be there.
    pub is_required: bool,
}

/// All keys of a case file, tables before what is in them.
pub fn key_documentation() -> &'static [KeyDocumentation] {
    &CASE_KEYS.keys
}

/// All keys of a study file, tables before what is in them.
pub fn study_key_documentation() -> &'static [KeyDocumentation] {
    &STUDY_KEYS.keys
}

/// The JSON schema of calibrations.
pub(crate) fn calibration_schema() -> Value {
    CALIBRATION_KEYS.schema.clone()
}

/// All keys of a calibration, tables before what is in them.
pub fn calibration_key_documentation() -> &'static [KeyDocumentation] {
    &CALIBRATION_KEYS.keys
}

/// All keys of an element test, tables before what is in them.
pub fn element_test_key_documentation() -> &'static [KeyDocumentation] {
    &ELEMENT_TEST_KEYS.keys
}

/// The keys of one kind of file.
pub(crate) struct Keys {
    schema: Value,
    keys: Vec<KeyDocumentation>,
}

pub(crate) static CASE_KEYS: LazyLock<Keys> = LazyLock::new(|| Keys::of(schemars::schema_for!(Case).to_value()));
pub(crate) static STUDY_KEYS: LazyLock<Keys> = LazyLock::new(|| Keys::of(schemars::schema_for!(StudyFile).to_value()));
pub(crate) static CALIBRATION_KEYS: LazyLock<Keys> =
    LazyLock::new(|| Keys::of(schemars::schema_for!(CalibrationFile).to_value()));
pub(crate) static ELEMENT_TEST_KEYS: LazyLock<Keys> =
    LazyLock::new(|| Keys::of(schemars::schema_for!(ElementTestFile).to_value()));

impl Keys {
    fn of(schema: Value) -> Self {
        let mut keys = Vec::new();
        Walk { root: &schema, keys: &mut keys }.collect_keys(&schema, String::new());
        Keys { schema, keys }
    }

    /// What a key in a table means.
    pub(crate) fn description_of(&self, table: &KeyPath, name: &str) -> Option<String> {
        let pattern = pattern_of(table);
        let key = self.keys.iter().find(|key| key.name == name && key.table == pattern)?;
        Some(key.description.clone()).filter(|description| !description.is_empty())
    }

    /// Whether a key at the top holds a list of tables, `[[bodies]]`.
    pub(crate) fn is_list_of_tables(&self, name: &str) -> bool {
        let table = format!("{name}[]");
        self.keys.iter().any(|key| key.table == table)
    }

    /// The tables in which a key of this name is known; the top level is the empty string.
    pub(crate) fn homes_of(&self, name: &str) -> Vec<String> {
        let homes: BTreeSet<_> = self.keys.iter().filter(|key| key.name == name).map(|key| key.table.clone()).collect();
        homes.into_iter().collect()
    }
}

/// A walk through a schema that collects its keys.
struct Walk<'a> {
    root: &'a Value,
    keys: &'a mut Vec<KeyDocumentation>,
}

impl<'a> Walk<'a> {
    fn collect_keys(&mut self, schema: &'a Value, table: String) {
        let schema = self.resolve(schema);
        let required: Vec<_> = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        for (name, property) in schema["properties"].as_object().into_iter().flatten() {
            let description = property["description"].as_str().or(self.resolve(property)["description"].as_str());
            self.keys.push(KeyDocumentation {
                table: table.clone(),
                name: name.clone(),
                kind: self.kind_of(property),
                description: one_line(description),
                words: self.words_of(property),
                default: property.get("default").cloned(),
                is_required: required.contains(&name.as_str()),
            });
        }
        for (name, property) in schema["properties"].as_object().into_iter().flatten() {
            let dot = if table.is_empty() { "" } else { "." };
            self.collect_inner(property, format!("{table}{dot}{name}"));
        }
        for variant in schema["oneOf"].as_array().into_iter().flatten() {
            self.collect_keys(variant, table.clone());
        }
    }

    fn collect_inner(&mut self, property: &'a Value, path: String) {
        let property = self.resolve(property);
        if property["items"].is_object() {
            self.collect_keys(&property["items"], format!("{path}[]"));
        } else if property["additionalProperties"].is_object() {
            self.collect_keys(&property["additionalProperties"], format!("{path}.<name>"));
        } else {
            self.collect_keys(property, path);
        }
    }

    fn kind_of(&self, property: &'a Value) -> String {
        let property = self.resolve(property);
        let kind = property["type"].as_str().or_else(|| property["type"][0].as_str());
        match kind {
            Some("integer") => "whole number".to_owned(),
            Some("object") => "table".to_owned(),
            Some("array") => match self.kind_of(&property["items"]) {
                inner if inner.starts_with("array") => inner.replacen("array", "array of arrays", 1),
                inner => format!("array of {inner}s"),
            },
            Some("boolean") => "true or false".to_owned(),
            Some(kind) => kind.to_owned(),
            None if property["oneOf"][0]["type"] == "number" => "number or string".to_owned(),
            None if property["oneOf"][0]["type"] == "array" => {
                format!("{} or table", self.kind_of(&property["oneOf"][0]))
            }
            None if property["oneOf"][0]["const"].is_string() => "word".to_owned(),
            None => "table".to_owned(),
        }
    }

    fn words_of(&self, property: &'a Value) -> Vec<(String, String)> {
        let property = self.resolve(property);
        let property = if property["items"].is_object() { self.resolve(&property["items"]) } else { property };
        let variants = property["oneOf"].as_array().into_iter().flatten();
        let word =
            |variant: &Value| Some((variant["const"].as_str()?.to_owned(), one_line(variant["description"].as_str())));
        variants.filter_map(word).collect()
    }

    /// Follows a reference, also that of an optional value.
    fn resolve(&self, schema: &'a Value) -> &'a Value {
        let optional =
            schema["anyOf"].as_array().and_then(|either| either.iter().find(|one| one.get("$ref").is_some()));
        let reference = optional.unwrap_or(schema)["$ref"].as_str().and_then(|reference| reference.strip_prefix('#'));
        reference.and_then(|pointer| self.root.pointer(pointer)).unwrap_or(schema)
    }
}

/// A text without its line breaks.
pub(crate) fn one_line(text: Option<&str>) -> String {
    text.unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

fn pattern_of(table: &KeyPath) -> String {
    let mut pattern = String::new();
    for (depth, segment) in table.segments().iter().enumerate() {
        match segment {
            Segment::Index(_) => pattern.push_str("[]"),
            Segment::Key(_) if depth == 1 && pattern == "materials" => pattern.push_str(".<name>"),
            Segment::Key(name) if depth == 0 => pattern.push_str(name),
            Segment::Key(name) => pattern.push_str(&format!(".{name}")),
        }
    }
    pattern
}
