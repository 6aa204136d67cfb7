//! Syntax errors of TOML in plain words.

use crate::error::quoted;
use crate::tree::SyntaxFault;

/// A syntax error in the words of people who write case files.
pub(crate) fn explain_syntax(fault: &SyntaxFault, text: &str) -> (String, Option<String>) {
    let span = fault.span.clone().unwrap_or(0..0);
    let found = text.get(span.clone()).unwrap_or("").trim();
    let next = text.get(span.start..).and_then(|rest| rest.chars().next());
    let said = fault.message.as_str();
    let (message, help) = match said {
        _ if said.starts_with("string values must be quoted") => explain_bare_value(found),
        _ if said.starts_with("duplicate key") => (
            format!("`{}` is given twice", quoted(found)),
            "keys and [tables] stand once; elements of lists are written with double brackets: [[loads]]",
        ),
        _ if said.starts_with("invalid mantissa") => {
            ("a number must begin with a digit".to_owned(), "write 0.5, not .5")
        }
        _ if said.starts_with("invalid fraction") => {
            ("a decimal point must stand between digits".to_owned(), "write 1.0e5 or 1e5, not 1.e5 or 1.")
        }
        _ if said.starts_with("unexpected key or value") && next == Some(',') => (
            "unexpected comma after the value".to_owned(),
            "decimals are written with a point: 0.5; lists in brackets: [1, 2]",
        ),
        _ if said.starts_with("unexpected key or value") => {
            ("something stands behind the value".to_owned(), "each `key = value` has a line of its own")
        }
        _ if said.contains("recursion") || said.contains("recurse") => {
            ("tables and arrays are nested too deeply".to_owned(), "")
        }
        _ if said.starts_with("invalid boolean") => explain_bare_value(found),
        _ if said.starts_with("missing comma between array elements") => (
            "the array before this is not finished".to_owned(),
            "close it with `]`, or put a comma between its elements",
        ),
        _ if said.contains(" string, expected `\"`") && next.is_none_or(|next| next == '\n' || next == '\r') => {
            ("the string does not end on this line".to_owned(), "close it with \"")
        }
        _ if said.starts_with("unexpected content") && next == Some(',') => (
            "unexpected comma after the value".to_owned(),
            "decimals are written with a point: 0.5; lists in brackets: [1, 2]",
        ),
        _ if said.starts_with("unexpected content") => {
            ("there is more than one value".to_owned(), "lists are written in brackets: [1, 2]")
        }
        _ if said.starts_with("key with no value") => {
            ("there is no `=` after the key".to_owned(), "a line is `key = value`, a [table] or a # comment")
        }
        _ if said.starts_with("unclosed") => (said.to_owned(), "close it on the same line"),
        _ if said.starts_with("invalid unquoted key") => {
            (said.to_owned(), "other characters are for keys in quotes: \"粘土\" = …")
        }
        _ => (said.to_owned(), ""),
    };
    (message, Some(help.to_owned()).filter(|help| !help.is_empty()))
}

fn explain_bare_value(found: &str) -> (String, &'static str) {
    let begins_as_number = found.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+');
    match found {
        "" => ("there is no value after the `=`".to_owned(), "write one, or put a # before the line"),
        "True" | "TRUE" | "False" | "FALSE" => {
            (format!("`{found}` is not a value"), "write true or false, in lower case")
        }
        _ if begins_as_number => (
            format!("`{}` is not a number", quoted(found)),
            "a number such as 1500.0 or 4.35e6; units are SI and not written",
        ),
        _ => (format!("`{}` is not a value", quoted(found)), "words are written in double quotes: \"auto\""),
    }
}
