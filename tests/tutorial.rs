//! The tutorial works as it is written, and the book has every page.

use crate::outside::command;
use crate::support::ROOT;

use std::path::Path;

use command::{code, cotree, stderr, stdout};

fn docs() -> std::path::PathBuf {
    Path::new(ROOT).join("docs")
}

/// The blocks of code in a language.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let start = format!("```{language}\n");
    text.split(&start).skip(1).map(|rest| rest.split("```").next().unwrap().to_string()).collect()
}

/// The words of a command line, with quotes.
fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (index, part) in line.split('"').enumerate() {
        match index % 2 {
            0 => words.extend(part.split_whitespace().map(str::to_string)),
            _ => words.push(part.to_string()),
        }
    }
    words
}

#[test]
fn every_command_of_the_tutorial_works() {
    let text = std::fs::read_to_string(docs().join("tutorial.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("wiper.toml"), &blocks(&text, "toml")[0]).unwrap();
    let mut said = String::new();
    let mut commands = 0;
    for line in blocks(&text, "sh").iter().flat_map(|block| block.lines()) {
        let words = words(line);
        assert_eq!(words[0], "cotree", "{line}");
        let arguments: Vec<&str> = words[1..].iter().map(String::as_str).collect();
        let output = cotree(folder.path(), &arguments);
        assert_eq!(code(&output), 0, "{line}: {}", stderr(&output));
        said += &stdout(&output);
        commands += 1;
    }
    assert!(commands >= 10);
    for claim in ["no errors", "close in 2 ways", "crank-rocker", "transmission angle at `arm_pin`", "drive torque"] {
        assert!(said.contains(claim), "{claim}\n{said}");
    }
    for file in ["wiper.png", "motion.png", "motion.csv", "path.svg", "wiper.fmu"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

#[test]
fn the_book_has_every_page() {
    let summary = std::fs::read_to_string(docs().join("SUMMARY.md")).unwrap();
    for entry in docs().read_dir().unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") && name != "SUMMARY.md" {
            assert!(summary.contains(&format!("]({name})")), "docs/SUMMARY.md lacks {name}");
        }
    }
}
