//! Every law's page shows the law at work: a picture that the program draws from an element test which the page names.

use std::fs;

use crate::{files, read, root};

/// Pages without an element test: the list of laws, and foreign laws.
const WITHOUT: [&str; 2] = ["index.md", "umat.md"];

#[test]
fn every_law_has_an_element_test_and_its_picture() {
    let script = read("book/pictures.sh");
    for page in files("book/src/laws", "md") {
        let name = page.file_name().unwrap().to_string_lossy().into_owned();
        if WITHOUT.contains(&name.as_str()) {
            continue;
        }
        let text = fs::read_to_string(&page).unwrap();
        let tests: Vec<&str> = text
            .split("`tsutsumi element-test element-tests/")
            .skip(1)
            .map(|rest| rest.split(".toml`").next().unwrap())
            .collect();
        assert!(!tests.is_empty(), "{name} names no element test");
        for test in tests {
            assert!(root().join(format!("element-tests/{test}.toml")).exists(), "{name}: {test}");
            assert!(script.contains(test), "book/pictures.sh does not draw {test}, which {name} shows");
        }
        let pictures: Vec<&str> =
            text.split("src=\"../pictures/").skip(1).map(|rest| rest.split(".svg").next().unwrap()).collect();
        assert!(!pictures.is_empty(), "{name} has no picture");
        for picture in pictures {
            assert!(script.contains(&format!(" {picture}")), "book/pictures.sh does not draw {picture} of {name}");
        }
    }
}
