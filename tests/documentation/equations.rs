//! "Where is equation (9)?": the tags in the code and the book's index say the same.

use std::collections::BTreeSet;
use std::fs;

use crate::{files, read};

/// An equation's number and an item that carries its tag.
type Tag = (u32, String);

/// `#[doc(alias = "Eq. (9)")]` and the name of the item below it.
fn tags_in_code() -> BTreeSet<Tag> {
    let mut tags = BTreeSet::new();
    for file in files("crates/tsutsumi/src", "rs") {
        let text = fs::read_to_string(&file).unwrap();
        let mut waiting = Vec::new();
        for line in text.lines().map(str::trim) {
            if let Some(rest) = line.strip_prefix("#[doc(alias = \"Eq. (") {
                waiting.push(rest.split(')').next().unwrap().parse::<u32>().unwrap());
            } else if !line.starts_with("///") && !line.starts_with("#[") && !waiting.is_empty() {
                let item = item_name(line).unwrap_or_else(|| panic!("{}: no item in `{line}`", file.display()));
                tags.extend(waiting.drain(..).map(|number| (number, item.clone())));
            }
        }
    }
    tags
}

/// The name that a line declares: of a type, a trait, a function or a field.
fn item_name(line: &str) -> Option<String> {
    let line = line.strip_prefix("pub ").unwrap_or(line);
    let name = ["struct ", "trait ", "fn ", "enum "].iter().find_map(|word| line.strip_prefix(word)).unwrap_or(line);
    let name: String = name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then_some(name)
}

/// Rows `| (9) | what | `Item`, `item` | … |` of the index.
fn tags_in_book() -> BTreeSet<Tag> {
    let mut tags = BTreeSet::new();
    for line in read("book/src/equations.md").lines() {
        let Some(rest) = line.strip_prefix("| (") else { continue };
        let Some(number) = rest.split(')').next().and_then(|number| number.parse::<u32>().ok()) else { continue };
        tags.extend(line.split('`').skip(1).step_by(2).map(|item| (number, item.to_owned())));
    }
    tags
}

#[test]
fn the_index_lists_the_tags_of_the_code() {
    let (code, book) = (tags_in_code(), tags_in_book());
    let missing: Vec<_> = code.difference(&book).collect();
    let stale: Vec<_> = book.difference(&code).collect();
    assert!(missing.is_empty() && stale.is_empty(), "not in the book: {missing:?}; not in the code: {stale:?}");
}

#[test]
fn every_equation_of_the_paper_is_tagged() {
    let numbers: BTreeSet<u32> = tags_in_code().into_iter().map(|(number, _)| number).collect();
    assert_eq!(numbers, (1..=10).collect());
}
