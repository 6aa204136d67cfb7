//! Links between the files of the repository lead somewhere, and the README says what CI runs.

use std::fs;

use crate::{files, read, root};

/// The targets of Markdown links and included files in a text.
fn targets(text: &str) -> Vec<String> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', ' ']).next());
    let includes = text.split("include ").skip(1).filter_map(|rest| rest.split(['}', ':']).next());
    let images = text.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next());
    links.chain(includes).chain(images).map(str::to_owned).collect()
}

#[test]
fn relative_links_lead_to_files() {
    let mut pages = files("book/src", "md");
    pages.extend(files("paper-cases", "md"));
    for name in ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"] {
        pages.push(root().join(name));
    }
    let mut broken = Vec::new();
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        let fenced = |(i, part): (usize, &str)| (i % 2 == 0).then(|| part.to_owned());
        let prose: String = text.split("```").enumerate().filter_map(fenced).collect();
        let with_includes = text.split("{{#").skip(1).filter(|part| part.contains("include ")).flat_map(targets);
        for target in targets(&prose).into_iter().chain(with_includes) {
            let path = target.split('#').next().unwrap();
            let elsewhere = path.is_empty() || path.contains("://") || path.starts_with("mailto:");
            let folder = page.parent().unwrap();
            if !elsewhere && !folder.join(path).exists() && !path.contains("$") && !path.contains('\\') {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    broken.dedup();
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_page_of_the_book_is_in_its_summary() {
    let summary = read("book/src/SUMMARY.md");
    let folder = root().join("book/src");
    for page in files("book/src", "md") {
        let name = page.strip_prefix(&folder).unwrap().display().to_string();
        assert!(
            name == "SUMMARY.md" || summary.contains(&format!("({name})")) || summary.contains(&format!("(./{name})")),
            "{name}"
        );
    }
}

/// `.ci/run` takes both commands from the README, where they stand between these marks.
#[test]
fn the_readme_has_the_commands_that_ci_runs() {
    let (readme, ci) = (read("README.md"), read(".ci/run"));
    for command in ["run", "test"] {
        let mark = format!("<!-- command: {command} -->");
        let rest = readme.split(&mark).nth(1).unwrap_or_else(|| panic!("the README lacks {mark}"));
        let line = rest.split("```sh\n").nth(1).unwrap().lines().next().unwrap();
        assert!(line.starts_with("cargo "), "{line}");
        assert!(ci.contains(&format!("readme_command {command}")), ".ci/run does not use the README's {command}");
    }
}
