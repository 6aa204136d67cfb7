//! The book's reference pages of case files, study files, element tests and calibrations are what the program says about their keys.

use std::fmt::Write;
use std::fs;

use serde_json::Value;
use tsutsumi_case::study::schema;
use tsutsumi_case::{
    KeyDocumentation, Registry, calibration_key_documentation, element_test_key_documentation, key_documentation,
    study_key_documentation,
};

use crate::{read, root};

const CASE_PAGE: &str = "book/src/case-reference.md";
const STUDY_PAGE: &str = "book/src/study-reference.md";
const ELEMENT_TEST_PAGE: &str = "book/src/element-test-reference.md";
const CALIBRATION_PAGE: &str = "book/src/calibration-reference.md";
const BEGIN: &str = "<!-- keys: begin -->";
const END: &str = "<!-- keys: end -->";

/// The tables of keys, one section per table of the file.
fn tables(keys: &[KeyDocumentation]) -> String {
    let mut text = String::new();
    let mut table = None;
    for key in keys {
        if table != Some(&key.table) {
            table = Some(&key.table);
            let heading =
                if key.table.is_empty() { "The top of the file".to_owned() } else { format!("`{}`", key.table) };
            write!(text, "\n### {heading}\n\n| key | kind | default | meaning |\n|---|---|---|---|\n").unwrap();
        }
        text += &row(key);
    }
    text
}

/// The keys of a case file, and the laws with their parameters.
fn case_keys() -> String {
    let mut text = tables(key_documentation());
    for law in Registry::built_in().laws() {
        write!(text, "\n### Parameters of `{}`\n\n{}\n\n| key | meaning |\n|---|---|\n", law.name, law.description())
            .unwrap();
        for (name, meaning) in law.parameters() {
            writeln!(text, "| `{name}` | {meaning} |").unwrap();
        }
    }
    let schema = Registry::built_in().schema();
    for condition in schema["$defs"]["ExactMotion"]["allOf"].as_array().unwrap() {
        let name = condition["if"]["properties"]["solution"]["const"].as_str().unwrap();
        let parameters = &condition["then"]["properties"]["parameters"];
        let description = parameters["description"].as_str().unwrap().split("\n\n").next().unwrap();
        write!(text, "\n### Parameters of the exact motion `{name}`\n\n{description}\n").unwrap();
        text += "\n| key | meaning |\n|---|---|\n";
        for (name, parameter) in parameters["properties"].as_object().unwrap() {
            writeln!(text, "| `{name}` | {} |", parameter["description"].as_str().unwrap()).unwrap();
        }
    }
    text
}

/// The keys of a study file, and the exact solutions with their parameters and quantities.
fn study_keys() -> String {
    let mut text = tables(study_key_documentation());
    let schema = schema();
    for condition in schema["$defs"]["Reference"]["allOf"].as_array().unwrap() {
        let name = condition["if"]["properties"]["solution"]["const"].as_str().unwrap();
        let (parameters, quantities) = (
            &condition["then"]["properties"]["parameters"],
            &condition["then"]["properties"]["quantities"]["additionalProperties"],
        );
        let description = parameters["description"].as_str().unwrap().split("\n\n").next().unwrap();
        write!(text, "\n### The exact solution `{name}`\n\n{description}\n").unwrap();
        text += "\n| parameter | meaning |\n|---|---|\n";
        for (name, parameter) in parameters["properties"].as_object().unwrap() {
            writeln!(text, "| `{name}` | {} |", parameter["description"].as_str().unwrap()).unwrap();
        }
        text += "\n| quantity | meaning |\n|---|---|\n";
        for quantity in quantities["oneOf"].as_array().unwrap() {
            writeln!(text, "| `{}` | {} |", quantity_name(quantity), quantity["description"].as_str().unwrap())
                .unwrap();
        }
    }
    text
}

/// How a quantity is written: a word, or a table with one key.
fn quantity_name(quantity: &Value) -> String {
    match quantity["const"].as_str() {
        Some(word) => format!("\"{word}\""),
        None => format!("{{ {} = … }}", quantity["required"][0].as_str().unwrap()),
    }
}

fn row(key: &KeyDocumentation) -> String {
    let default = match (&key.default, key.is_required) {
        (_, true) => "required".to_owned(),
        (Some(default), _) => format!("`{default}`"),
        (None, _) => String::new(),
    };
    let words: String = key.words.iter().map(|(word, meaning)| format!("<br>`\"{word}\"`: {meaning}")).collect();
    format!("| `{}` | {} | {default} | {}{words} |\n", key.name, key.kind, key.description)
}

/// Run with `TSUTSUMI_UPDATE_BOOK=1` to write the pages anew.
#[test]
fn the_reference_pages_list_every_key() {
    let element_test_keys = tables(element_test_key_documentation());
    let calibration_keys = tables(calibration_key_documentation());
    for (page, keys) in [
        (CASE_PAGE, case_keys()),
        (STUDY_PAGE, study_keys()),
        (ELEMENT_TEST_PAGE, element_test_keys),
        (CALIBRATION_PAGE, calibration_keys),
    ] {
        let text = read(page);
        let (head, rest) = text.split_once(BEGIN).expect("the mark where the keys begin");
        let (_, tail) = rest.split_once(END).expect("the mark where the keys end");
        let expected = format!("{head}{BEGIN}\n{keys}\n{END}{tail}");
        if std::env::var_os("TSUTSUMI_UPDATE_BOOK").is_some() {
            fs::write(root().join(page), expected).unwrap();
            continue;
        }
        assert!(text == expected, "{page} is out of date: run `TSUTSUMI_UPDATE_BOOK=1 cargo test -p tsutsumi-tests`");
    }
}
