//! The JSON schema of case files, and the documentation of their keys, both from the types in [`schema`](crate::schema).

use std::collections::BTreeSet;
use std::sync::LazyLock;

use serde_json::{Map, Value, json};

use crate::key_path::{KeyPath, Segment};
use crate::schema::Case;

/// The JSON schema of case files. The names of the laws with the schemas of their parameters, of the shape functions, of the
/// velocity updates and of the laws of the conductivity come from the registry.
pub fn case_schema(
    laws: &[(&str, Value)],
    shapes: &[&str],
    velocity_updates: &[&str],
    conductivity_laws: &[&str],
) -> Value {
    let mut schema = BARE_SCHEMA.clone();
    let mut definitions = Map::new();
    let conditions: Vec<_> = laws.iter().map(|(name, law)| law_condition(name, law, &mut definitions)).collect();
    if let Some(material) = schema.pointer_mut("/$defs/Material").and_then(Value::as_object_mut) {
        material.insert("allOf".to_owned(), conditions.into());
    }
    let law_names: Vec<_> = laws.iter().map(|(name, _)| *name).collect();
    restrict(&mut schema, "/$defs/Material/properties/law", &law_names);
    restrict(&mut schema, "/$defs/Material/properties/conductivity_law", conductivity_laws);
    restrict(&mut schema, "/$defs/Method/properties/shape", shapes);
    restrict(&mut schema, "/$defs/Method/properties/velocity_update", velocity_updates);
    if let Some(all) = schema.pointer_mut("/$defs").and_then(Value::as_object_mut) {
        all.append(&mut definitions);
    }
    schema
}

/// If a material has this law, its parameters are those of the law.
fn law_condition(name: &str, law: &Value, definitions: &mut Map<String, Value>) -> Value {
    let mut law = law.clone();
    let prefix = format!("law:{}:", name.replace(['~', '/', '#', '%', ' '], "-"));
    rename_references(&mut law, &prefix);
    if let Some(object) = law.as_object_mut() {
        object.remove("$schema");
        if let Some(Value::Object(inner)) = object.remove("$defs") {
            definitions.extend(inner.into_iter().map(|(name, schema)| (format!("{prefix}{name}"), schema)));
        }
    }
    let needs_some = law.get("required").and_then(Value::as_array).is_some_and(|required| !required.is_empty());
    let mut consequence = json!({ "properties": { "parameters": law } });
    if needs_some {
        consequence["required"] = json!(["parameters"]);
    }
    json!({ "if": { "properties": { "law": { "const": name } }, "required": ["law"] }, "then": consequence })
}

/// A law's own definitions move to the schema's, under a name that no other law has.
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
    &KEYS
}

static BARE_SCHEMA: LazyLock<Value> = LazyLock::new(|| schemars::schema_for!(Case).to_value());

static KEYS: LazyLock<Vec<KeyDocumentation>> = LazyLock::new(|| {
    let mut keys = Vec::new();
    collect_keys(&BARE_SCHEMA, String::new(), &mut keys);
    keys
});

fn collect_keys(schema: &Value, table: String, keys: &mut Vec<KeyDocumentation>) {
    let schema = resolve(schema);
    let required: Vec<_> = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    for (name, property) in schema["properties"].as_object().into_iter().flatten() {
        let description = property["description"].as_str().or(resolve(property)["description"].as_str());
        keys.push(KeyDocumentation {
            table: table.clone(),
            name: name.clone(),
            kind: kind_of(property),
            description: one_line(description),
            words: words_of(property),
            default: property.get("default").cloned(),
            is_required: required.contains(&name.as_str()),
        });
    }
    for (name, property) in schema["properties"].as_object().into_iter().flatten() {
        let dot = if table.is_empty() { "" } else { "." };
        collect_inner(property, format!("{table}{dot}{name}"), keys);
    }
    for variant in schema["oneOf"].as_array().into_iter().flatten() {
        collect_keys(variant, table.clone(), keys);
    }
}

fn one_line(text: Option<&str>) -> String {
    text.unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

fn kind_of(property: &Value) -> String {
    let property = resolve(property);
    let kind = property["type"].as_str().or_else(|| property["type"][0].as_str());
    match kind {
        Some("integer") => "whole number".to_owned(),
        Some("object") => "table".to_owned(),
        Some("array") => match kind_of(&property["items"]) {
            inner if inner.starts_with("array") => inner.replacen("array", "array of arrays", 1),
            inner => format!("array of {inner}s"),
        },
        Some("boolean") => "true or false".to_owned(),
        Some(kind) => kind.to_owned(),
        None if property["oneOf"][0]["type"] == "number" => "number or string".to_owned(),
        None if property["oneOf"][0]["type"] == "array" => format!("{} or table", kind_of(&property["oneOf"][0])),
        None if property["oneOf"][0]["const"].is_string() => "word".to_owned(),
        None => "table".to_owned(),
    }
}

fn words_of(property: &Value) -> Vec<(String, String)> {
    let property = resolve(property);
    let property = if property["items"].is_object() { resolve(&property["items"]) } else { property };
    let variants = property["oneOf"].as_array().into_iter().flatten();
    let word =
        |variant: &Value| Some((variant["const"].as_str()?.to_owned(), one_line(variant["description"].as_str())));
    variants.filter_map(word).collect()
}

fn collect_inner(property: &Value, path: String, keys: &mut Vec<KeyDocumentation>) {
    let property = resolve(property);
    if property["items"].is_object() {
        collect_keys(&property["items"], format!("{path}[]"), keys);
    } else if property["additionalProperties"].is_object() {
        collect_keys(&property["additionalProperties"], format!("{path}.<name>"), keys);
    } else {
        collect_keys(property, path, keys);
    }
}

/// Follows a reference, also that of an optional value.
fn resolve(schema: &Value) -> &Value {
    let optional = schema["anyOf"].as_array().and_then(|either| either.iter().find(|one| one.get("$ref").is_some()));
    let reference = optional.unwrap_or(schema)["$ref"].as_str().and_then(|reference| reference.strip_prefix('#'));
    reference.and_then(|pointer| BARE_SCHEMA.pointer(pointer)).unwrap_or(schema)
}

/// What a key in a table of a case means.
pub(crate) fn description_of(table: &KeyPath, name: &str) -> Option<String> {
    let pattern = pattern_of(table);
    let key = KEYS.iter().find(|key| key.name == name && key.table == pattern)?;
    Some(key.description.clone()).filter(|description| !description.is_empty())
}

/// Whether a key at the top holds a list of tables, `[[bodies]]`.
pub(crate) fn is_list_of_tables(name: &str) -> bool {
    let table = format!("{name}[]");
    KEYS.iter().any(|key| key.table == table)
}

/// The tables in which a key of this name is known; the top level is the empty string.
pub(crate) fn homes_of(name: &str) -> Vec<String> {
    let homes: BTreeSet<_> = KEYS.iter().filter(|key| key.name == name).map(|key| key.table.clone()).collect();
    homes.into_iter().collect()
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
