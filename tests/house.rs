//! What a stranger can check of the structure of the sources.

use crate::support::ROOT;
use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => sources(&path, found),
            false if path.extension().is_some_and(|extension| extension == "rs") => found.push(path),
            false => {}
        }
    }
}

/// The names of the components, as their own files give them.
fn kinds(folder: &Path) -> Vec<String> {
    let mut files = Vec::new();
    sources(folder, &mut files);
    let constructors = ["Component::joint(\"", "Component::driver(\"", "Component::load(\""];
    let name = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let rest = constructors.iter().find_map(|start| text.split_once(start))?.1.to_string();
        rest.split_once('"').map(|(name, _)| name.to_string())
    };
    files.iter().filter_map(name).collect()
}

/// A component is one file: nothing outside `src/component` decides by the name of a kind, neither in a pattern nor in a comparison.
#[test]
fn no_other_room_decides_by_the_kind_of_a_component() {
    let root = Path::new(ROOT).join("src");
    let kinds = kinds(&root.join("component"));
    assert!(kinds.len() >= 17, "{kinds:?}");
    let mut files = Vec::new();
    sources(&root, &mut files);
    sources(&root.join("../crates"), &mut files);
    let mut named = Vec::new();
    for path in files.iter().filter(|path| !path.starts_with(root.join("component"))) {
        let text = std::fs::read_to_string(path).unwrap();
        for (number, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            let decides = |kind: &String| {
                let quoted = format!("\"{kind}\"");
                [format!("{quoted} =>"), format!("== {quoted}"), format!("{quoted} |")]
                    .iter()
                    .any(|use_of| code.contains(use_of))
            };
            let enumerates = ["JointKind::", "LoadKind::", "DriverKind::"].iter().any(|kind| code.contains(kind));
            if enumerates || code.contains(".kind ==") && kinds.iter().any(decides) {
                named.push(format!("{}:{}: {line}", path.display(), number + 1));
            }
        }
    }
    assert!(named.is_empty(), "a kind is named outside src/component:\n{}", named.join("\n"));
}

/// Words that the field does not use, or uses for something else, and what it says instead.
const WORDS: [(&str, &str); 15] = [
    ("borne", "carried"),
    ("chatter", "sliding mode"),
    ("closeness", "reciprocal pivot, distance to singularity"),
    ("detour", "branch switch"),
    ("front", "step end"),
    ("glide", "interpolate"),
    ("glides", "interpolates"),
    ("lack", "residual"),
    ("lacks", "residuals"),
    ("look", "test, monitor, predict, detect"),
    ("quick", "fast path"),
    ("refuge", "branch switch"),
    ("settle", "accept"),
    ("tell", "report"),
    ("told", "reported"),
];

/// The words of a name: `branch_switch`, `BranchSwitch`.
fn words_of(code: &str) -> Vec<String> {
    let names = code.split(|letter: char| !letter.is_ascii_alphabetic());
    let humps = |name: &str| {
        let mut words = vec![String::new()];
        for letter in name.chars() {
            if letter.is_ascii_uppercase() {
                words.push(String::new());
            }
            words.last_mut().unwrap().push(letter.to_ascii_lowercase());
        }
        words
    };
    names.flat_map(humps).collect()
}

#[test]
fn names_in_the_runtime_are_words_of_the_field() {
    let mut files = Vec::new();
    sources(&root().join("fmu/src"), &mut files);
    let mut found = Vec::new();
    for path in files {
        for (number, line) in read(&path).lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            // What stands between quotes is no name.
            let names: Vec<String> = code.split('"').step_by(2).flat_map(words_of).collect();
            let wrong = WORDS.iter().filter(|(word, _)| names.iter().any(|name| name == word));
            found.extend(wrong.map(|(word, field)| format!("{}:{}: {word} ({field})", path.display(), number + 1)));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Names that do not say what they name, and how often each stands as a name of its own in the sources outside of the tests: a count that may only fall. Write the noun of the thing instead.
const UNCLEAR: [(&str, usize); 6] =
    [("own", 154), ("asked", 9), ("told", 56), ("beside", 120), ("led", 7), ("reach", 162)];

/// How often a word stands as a whole name in a source; comments and texts are left out.
fn count_name(source: &str, word: &str) -> usize {
    let code = source.lines().map(|line| line.split("//").next().unwrap_or_default());
    let names = code.flat_map(|code| code.split('"').step_by(2));
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    names.flat_map(|code| code.split(|letter: char| !is_part(letter))).filter(|name| *name == word).count()
}

#[test]
fn unclear_names_become_fewer() {
    let mut files = Vec::new();
    ["src", "crates", "fmu/src"].iter().for_each(|folder| sources(&root().join(folder), &mut files));
    let all: Vec<String> = files.iter().map(|path| read(path)).collect();
    let count = |word: &str| all.iter().map(|source| count_name(source, word)).sum::<usize>();
    let now: Vec<(&str, usize)> = UNCLEAR.iter().map(|(word, _)| (*word, count(word))).collect();
    let grown = now.iter().zip(&UNCLEAR).any(|((_, now), (_, most))| now > most);
    assert!(!grown, "now {now:?}, at most {UNCLEAR:?}: name the thing, or lower the bound if it fell");
}

fn root() -> PathBuf {
    PathBuf::from(ROOT)
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Texts between backticks that name a file or folder of the project, those with a pattern left out.
fn paths(text: &str) -> Vec<&str> {
    let codes = text.split('`').skip(1).step_by(2);
    let folders = ["src/", "crates/", "fmu/", "tests/", "docs/", "models", "tools/", "benches", "examples", ".ci/"];
    let is_path = |code: &&str| {
        let path = folders.iter().any(|folder| code.starts_with(folder)) || *code == "fmu" || *code == "docs";
        path && !code.contains(['*', ' ', '='])
    };
    codes.filter(is_path).collect()
}

/// `docs/walk.md` follows the library and `docs/step.md` the runtime: places as `file.rs::function`, in `src` and `fmu/src`.
#[test]
fn the_pages_that_follow_the_code_name_places_that_are_there() {
    for (page, folder) in [("docs/walk.md", "src"), ("docs/step.md", "fmu/src")] {
        let text = read(&root().join(page));
        let codes = text.split('`').skip(1).step_by(2);
        let places: Vec<(&str, &str)> = codes.filter_map(|code| code.split_once("::")).collect();
        assert!(places.len() > 30, "{page}: {places:?}");
        for (file, function) in places {
            let source = read(&root().join(folder).join(file));
            let is_there =
                [format!("fn {function}("), format!("fn {function}<")].iter().any(|own| source.contains(own));
            assert!(is_there, "{page}: {folder}/{file} has no `{function}`");
        }
    }
}

/// `docs/words.md` gives each word a type and the file that defines it; no two words share a type, and no word stands twice.
#[test]
fn words_have_the_types_that_their_page_names() {
    let text = read(&root().join("docs/words.md"));
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains("` in `"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 40, "{rows:?}");
    let (mut words, mut types) = (std::collections::BTreeSet::new(), std::collections::BTreeSet::new());
    for row in rows {
        let [word, meaning, carrier, _] = row[..] else { panic!("four columns: {row:?}") };
        let codes: Vec<&str> = carrier.split('`').skip(1).step_by(2).collect();
        let [name, file] = codes[..] else { panic!("a type in a file: {carrier}") };
        let source = read(&root().join(file));
        let defines = |kind: &str| source.lines().any(|line| defined(line, kind) == Some(name));
        assert!(["struct", "enum", "trait", "type"].into_iter().any(defines), "{word}: {file} does not define {name}");
        assert!(
            !meaning.is_empty() && words.insert(word) && types.insert((name, file)),
            "{word} or {name} stands twice"
        );
    }
}

/// The type that a line defines: `pub struct Body {`.
fn defined<'a>(line: &'a str, kind: &str) -> Option<&'a str> {
    let rest = line.split_once(&format!("{kind} "))?;
    let public = rest.0.trim_end();
    let is_item = public.is_empty() || public == "pub" || public.starts_with("pub(") && public.ends_with(')');
    let end = rest.1.find(|letter: char| !letter.is_alphanumeric()).unwrap_or(rest.1.len());
    is_item.then_some(&rest.1[..end])
}

/// The words that `docs/words.md` names as not used: those in backticks in the last column of its tables.
fn unused_words() -> Vec<String> {
    let text = read(&root().join("docs/words.md"));
    let rows = text.lines().filter(|line| line.starts_with("| "));
    let last = rows.filter_map(|line| line.trim_end_matches([' ', '|']).rsplit('|').next());
    let is_unused = |cell: &&str| cell.trim().starts_with('`') && !cell.contains("` in `");
    let words = last.filter(is_unused).flat_map(|cell| cell.split('`').skip(1).step_by(2).map(str::to_owned));
    words.collect()
}

/// Where a word stands in a text as a word of its own. "there is no" is English, and so is "is no longer".
fn has_word(text: &str, word: &str) -> bool {
    let is_part = |letter: char| letter.is_alphanumeric() || ['_', '-', '`'].contains(&letter);
    text.match_indices(word).any(|(at, _)| {
        let (before, after) = (&text[..at], &text[at + word.len()..]);
        let alone = !before.ends_with(is_part) && !after.starts_with(is_part);
        let article = word == "is no"
            && (before.trim_end().to_lowercase().ends_with("there")
                || ["longer", "more", "less", "other"].iter().any(|next| after.trim_start().starts_with(next)));
        alone && !article
    })
}

/// The texts between quotes of a source, its comments and its unit tests left out, each with its line; lines that are joined by `\` are one.
fn quoted(source: &str) -> Vec<(usize, String)> {
    let source = source.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut texts = Vec::new();
    let mut rest = source;
    while let Some(at) = rest.find(['"', '\'', '/']) {
        let (found, behind) = (&rest[at..at + 1], &rest[at + 1..]);
        rest = match found {
            "/" if behind.starts_with('/') => behind.split_once('\n').map_or("", |(_, next)| next),
            "'" if behind.starts_with("\"'") || behind.starts_with("\\\"'") => &behind[2..],
            "\"" => {
                let mut escaped = false;
                let end = behind.find(|letter| {
                    let ends = letter == '"' && !escaped;
                    escaped = letter == '\\' && !escaped;
                    ends
                });
                let end = end.unwrap_or(behind.len());
                let line = source.len() - rest.len() + at;
                let joined: Vec<&str> = behind[..end].split("\\\n").map(str::trim_start).collect();
                texts.push((source[..line].lines().count(), joined.concat()));
                behind.get(end + 1..).unwrap_or_default()
            }
            _ => behind,
        };
    }
    texts
}

/// A page without its blocks of code and what stands between backticks.
fn prose(page: &str) -> String {
    page.split("```").step_by(2).map(|part| part.split('`').step_by(2).collect::<Vec<_>>().join("_")).collect()
}

/// Messages and pages use the words of the field. What is left out here names a thing of another program, or shows the word.
#[test]
fn messages_and_pages_use_the_words_of_the_field() {
    let words = unused_words();
    assert!(words.len() >= 20, "{words:?}");
    let mut files = Vec::new();
    ["src", "crates", "fmu/src", "python/src"].iter().for_each(|folder| sources(&root().join(folder), &mut files));
    let is_test = |path: &PathBuf| path.components().any(|part| part.as_os_str() == "tests");
    files.retain(|path| !is_test(path) && !path.ends_with("tests.rs"));
    let mut found = Vec::new();
    let mut look = |path: &Path, line: usize, text: &str| {
        let wrong = words.iter().filter(|word| has_word(text, word));
        found.extend(wrong.map(|word| format!("{}:{line}: {word}: {text:.90}", path.display())));
    };
    for path in &files {
        let source = read(path);
        // A single word is a key or a name of a mode; what stands in braces is filled in.
        let texts = quoted(&source).into_iter().filter(|(_, text)| text.trim().contains(' '));
        texts.for_each(|(line, text)| look(path, line, &text.replace(['{', '}'], "_")));
    }
    let faults = root().join("docs/faults").read_dir().unwrap().map(|entry| entry.unwrap().path());
    let shows = ["docs/words.md", "docs/style.md", "CHANGELOG.md"];
    let pages = documents().into_iter().chain(faults).filter(|path| shows.iter().all(|shown| !path.ends_with(shown)));
    for path in pages {
        let text = prose(&read(&path));
        text.lines().enumerate().for_each(|(line, text)| look(&path, line + 1, text));
    }
    assert!(found.is_empty(), "docs/words.md has other words for these:\n{}", found.join("\n"));
}

#[test]
fn what_the_map_lists_is_there_and_nothing_is_missing() {
    let text = read(&root().join("CONTRIBUTING.md"));
    // Blocks of code have backticks of their own.
    let prose: String = text.split("```").step_by(2).collect();
    let listed = paths(&prose);
    assert!(listed.len() > 50, "{listed:?}");
    let missing: Vec<&&str> = listed.iter().filter(|path| !root().join(path).exists()).collect();
    assert!(missing.is_empty(), "CONTRIBUTING.md names what is not there: {missing:?}");
    for folder in ["src", "crates", "crates/study/src", "fmu/src"] {
        for entry in root().join(folder).read_dir().unwrap() {
            let entry = entry.unwrap();
            let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
            let is_room = entry.path().is_dir() || folder != "fmu/src" && !name.ends_with("lib.rs");
            assert!(!is_room || listed.contains(&name.as_str()), "CONTRIBUTING.md does not name {name}");
        }
    }
}

/// The documents for readers: at the top, in `docs`, with the models and the examples.
fn documents() -> Vec<PathBuf> {
    let markdown = |folder: PathBuf| {
        let entries = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect::<Vec<_>>()
    };
    let models = root().join("models").read_dir().unwrap().map(|entry| markdown(entry.unwrap().path()));
    [root(), root().join("docs"), root().join("examples")].map(markdown).into_iter().chain(models).flatten().collect()
}

/// The anchor that a heading gets.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn links_of_the_documents_lead_somewhere() {
    let mut broken = Vec::new();
    for document in documents() {
        let text = read(&document);
        for link in text.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(link, _)| link)) {
            if link.contains("://") || link.contains(' ') {
                continue;
            }
            let (path, place) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() { document.clone() } else { document.parent().unwrap().join(path) };
            let there = target.exists()
                && (place.is_empty()
                    || read(&target).lines().any(|line| line.starts_with('#') && anchor(line) == place));
            if !there {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn the_page_of_models_shows_every_model() {
    let text = read(&root().join("docs/models.md"));
    for entry in root().join("models").read_dir().unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(text.contains(&format!("(../models/{name})")), "docs/models.md does not name the model {name}");
    }
}

/// Whoever comes first reads a page that fits a screen or two.
#[test]
fn the_readme_is_short() {
    let text = read(&root().join("README.md"));
    let longest = text.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(text.lines().count() < 150 && longest <= 120, "{} lines, up to {longest} characters", text.lines().count());
}

/// Name, file and value of each scalar constant of the modules of the runtime, but for mathematics and numbers of interfaces; tests are left out. As in
/// `tools/constants/constants.py`.
fn tuning_constants() -> Vec<[String; 3]> {
    let runtime = root().join("fmu/src");
    let mut files = Vec::new();
    sources(&runtime, &mut files);
    let mut found = Vec::new();
    for path in files {
        let file = path.strip_prefix(&runtime).unwrap().to_string_lossy().replace('\\', "/");
        let others = ["coefficients.rs", "/math.rs", "/fmi2/", "/fmi3/"];
        if others.iter().any(|other| format!("/{file}").contains(other)) {
            continue;
        }
        let text = read(&path);
        let code = text.lines().zip(text.lines().skip(1).chain([""]));
        let code = code
            .take_while(|(line, next)| *line != "#[cfg(test)]" || !next.starts_with("mod ") || !next.ends_with('{'));
        for (line, _) in code {
            let constant = match line.split_once("const ") {
                Some(("", rest)) => rest,
                Some(("pub " | "pub(crate) " | "pub(super) ", rest)) => rest,
                _ => continue,
            };
            let Some((name, rest)) = constant.split_once(": ") else { continue };
            let Some((kind, value)) = rest.split_once(" = ") else { continue };
            let is_number = ["f64", "usize", "u32", "u64", "i32", "u8"].contains(&kind);
            if let Some(value) = value.strip_suffix(';').filter(|_| is_number) {
                found.push([name.to_owned(), file.clone(), value.to_owned()]);
            }
        }
    }
    found
}

/// A name that stands for several values has to be looked up in each file: a constant says what it is of.
#[test]
fn a_name_stands_for_one_constant_of_the_runtime() {
    let constants = tuning_constants();
    let others = |name: &str| constants.iter().filter(|[other, ..]| other == name).count() > 1;
    let several: Vec<_> = constants.iter().filter(|[name, ..]| others(name)).collect();
    assert!(several.is_empty(), "give each a name that says what it is of: {several:#?}");
}

/// `docs/constants.md` says of every constant of the runtime what it does, or why it was not varied.
#[test]
fn every_constant_of_the_runtime_has_its_measurement() {
    let text = read(&root().join("docs/constants.md"));
    let row = |[name, file, value]: &[String; 3]| format!("| `{name}` | `{file}` | `{value}` |");
    let known: Vec<String> = tuning_constants().iter().map(row).collect();
    assert!(known.len() > 100, "{}", known.len());
    let missing: Vec<&String> =
        known.iter().filter(|row| text.lines().filter(|line| line.starts_with(row.as_str())).count() != 1).collect();
    assert!(missing.is_empty(), "docs/constants.md has no row, or another value, of {missing:#?}");
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    let gone: Vec<&str> = rows.filter(|line| !known.iter().any(|row| line.starts_with(row.as_str()))).collect();
    assert!(gone.is_empty(), "docs/constants.md has rows of what is no more: {gone:#?}");
}

/// The first paragraph of a module's documentation, as one line.
fn purpose(path: &Path) -> String {
    let text = read(path);
    let lines = text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim);
    lines.take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}

/// `tests/README.md` lists the modules of the tests with what each is about; `COTREE_WRITE_REFERENCE=1` writes it.
#[test]
fn the_list_of_tests_is_that_of_their_modules() {
    let folder = root().join("tests");
    let mut modules: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    modules.retain(|path| {
        path.extension().is_some_and(|extension| extension == "rs")
            && !["main.rs", "library.rs"].iter().any(|main| path.ends_with(main))
    });
    modules.sort();
    let mut list = "# Tests\n\nMade from the modules; `cargo test --test library house::` compares. Two programs hold them: `library`, whose modules need nothing above the library, and `all`.\n\n| module | what it tests |\n|---|---|\n".to_owned();
    for path in &modules {
        let purpose = purpose(path);
        assert!(!purpose.is_empty(), "{} does not say what it tests", path.display());
        let name = path.file_stem().unwrap().to_string_lossy();
        list += &format!("| [{name}]({name}.rs) | {} |\n", purpose.replace('|', "\\|"));
    }
    let page = folder.join("README.md");
    if std::env::var_os("COTREE_WRITE_REFERENCE").is_some() {
        std::fs::write(&page, &list).unwrap();
    }
    assert_eq!(read(&page), list, "tests/README.md: COTREE_WRITE_REFERENCE=1 writes it");
}
