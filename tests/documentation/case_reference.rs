//! The book's reference page of case files is what the program says about its keys.

use std::fmt::Write;
use std::fs;

use tsutsumi_case::{KeyDocumentation, Registry, key_documentation};

use crate::{read, root};

const PAGE: &str = "book/src/case-reference.md";
const BEGIN: &str = "<!-- keys: begin -->";
const END: &str = "<!-- keys: end -->";

/// The tables of keys, one section per table of the case file, and the laws with their parameters.
fn keys() -> String {
    let mut text = String::new();
    let mut table = None;
    for key in key_documentation() {
        if table != Some(&key.table) {
            table = Some(&key.table);
            let heading =
                if key.table.is_empty() { "The top of the file".to_owned() } else { format!("`{}`", key.table) };
            write!(text, "\n### {heading}\n\n| key | kind | default | meaning |\n|---|---|---|---|\n").unwrap();
        }
        text += &row(key);
    }
    for law in Registry::built_in().laws() {
        write!(text, "\n### Parameters of `{}`\n\n{}\n\n| key | meaning |\n|---|---|\n", law.name, law.description())
            .unwrap();
        for (name, meaning) in law.parameters() {
            writeln!(text, "| `{name}` | {meaning} |").unwrap();
        }
    }
    text
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

/// Run with `TSUTSUMI_UPDATE_BOOK=1` to write the page anew.
#[test]
fn the_reference_page_lists_every_key() {
    let page = read(PAGE);
    let (head, rest) = page.split_once(BEGIN).expect("the mark where the keys begin");
    let (_, tail) = rest.split_once(END).expect("the mark where the keys end");
    let expected = format!("{head}{BEGIN}\n{}\n{END}{tail}", keys());
    if std::env::var_os("TSUTSUMI_UPDATE_BOOK").is_some() {
        fs::write(root().join(PAGE), expected).unwrap();
        return;
    }
    assert!(page == expected, "{PAGE} is out of date: run `TSUTSUMI_UPDATE_BOOK=1 cargo test -p tsutsumi-tests`");
}
