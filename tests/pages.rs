//! The pages say what works: every command in README, docs, examples and models is run as it is written, and the book has every page.
//!
//! A page is read from top to bottom in a folder of its own, which has what a clone has: models, examples, linkages, and stand-ins for runtimes of other
//! platforms. The word after the language of a block says what it is: a name writes the block to that file, `printed` compares it with what the commands
//! before it say, `no_run` leaves it out. A table whose rows begin with commands is run too.

use crate::outside::command;
use crate::support::ROOT;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cotree_fmu::program::storage::KIND;
use tempfile::TempDir;

/// What is not run, and how often: blocks of other programs, which build, install, or draw films.
const NOT_RUN: [(&str, usize); 10] = [
    ("README.md", 2),
    ("docs/constants.md", 1),
    ("docs/coupling.md", 2),
    ("docs/draw.md", 1),
    ("docs/fuzzing.md", 1),
    ("docs/platforms.md", 4),
    ("docs/python.md", 4),
    ("docs/sweep.md", 1),
    ("docs/view.md", 1),
    ("examples/README.md", 6),
];

/// What serves a page goes on until it is stopped: here as soon as it has said where its page is, and no browser is opened.
const PRELUDE: &str = r#"
cotree() {
    case "$*" in
        demo*) set -- "$@" --no-browser ;;
        watch* | draw) ;;
        *) "$COTREE" "$@"
           return ;;
    esac
    "$COTREE" "$@" >watch.log 2>&1 &
    while ! grep -q http://127.0.0.1 watch.log; do
        kill -0 $! || return
        sleep 0.02
    done
    kill $!
}
"#;

enum Step {
    /// A file that the reader saves.
    File(String, String),
    Run(String),
    NotRun(String),
    Printed(String),
}

/// What a page asks its reader to do, in its order.
fn steps(page: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(info) = line.strip_prefix("```") {
            let mut text = String::new();
            for line in lines.by_ref().take_while(|line| *line != "```") {
                writeln!(text, "{line}").unwrap();
            }
            let (language, word) = info.split_once(' ').unwrap_or((info, ""));
            match (language, word) {
                ("sh", "") => steps.push(Step::Run(text)),
                ("sh" | "python", "no_run") => steps.push(Step::NotRun(text)),
                ("text", "printed") => steps.push(Step::Printed(text)),
                (_, file) if file.contains('.') => steps.push(Step::File(file.to_owned(), text)),
                (language, word) => assert!(
                    word.is_empty() && !["console", "bash", "shell"].contains(&language),
                    "what is a block that begins with {line}?"
                ),
            }
        } else if line.starts_with("| `cotree ") {
            // A first cell such as "`cotree schema`, `cotree man pages`".
            let cell = line.split('|').nth(1).unwrap();
            let commands = cell.split('`').skip(1).step_by(2).filter(|code| code.starts_with("cotree "));
            steps.extend(commands.map(|command| Step::Run(command.to_owned())));
        }
    }
    steps
}

/// What a clone has and pages mention.
fn clone() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for part in ["models", "examples/coupled", "tests/import"] {
        let (from, to) = (Path::new(ROOT).join(part), folder.path().join(part));
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        command::printed(Command::new("cp").arg("-R").arg(from).arg(to));
    }
    let elf = [&b"\x7fELF"[..], &[0; 14], &[62, 0]].concat();
    let dll = [&b"MZ"[..], &[0; 58], &[64, 0, 0, 0], b"PE\0\0\x64\x86"].concat();
    for (file, head) in [
        ("linux64/cotree_runtime.so", elf),
        ("win64/cotree_runtime.dll", dll),
        ("web/cotree_runtime.wasm", b"\0asm".to_vec()),
    ] {
        let file = folder.path().join("target/runtimes").join(file);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, [&head[..], KIND.as_bytes()].concat()).unwrap();
    }
    folder
}

/// The folder after everything on a page was done, what was said, and how many blocks were run and were not.
fn follow(page: &str) -> (TempDir, String, [usize; 2]) {
    let text = fs::read_to_string(Path::new(ROOT).join(page)).unwrap();
    let (folder, mut said, mut counts) = (clone(), String::new(), [0, 0]);
    for step in steps(&text) {
        match step {
            Step::File(name, text) => fs::write(folder.path().join(name), text).unwrap(),
            Step::Run(script) => {
                let mut shell = Command::new("sh");
                shell.args(["-euc", &format!("{PRELUDE}{script}")]).env("COTREE", env!("CARGO_BIN_EXE_cotree"));
                let output = shell.current_dir(folder.path()).stdin(Stdio::null()).output().unwrap();
                assert!(output.status.success(), "{page} says\n{script}\nwhich fails:\n{}", command::stderr(&output));
                said += &command::stdout(&output);
                counts[0] += 1;
            }
            Step::NotRun(script) => {
                let own = script.lines().find(|line| line.trim_start().starts_with("cotree "));
                assert_eq!(own, None, "{page}: cotree can be run");
                counts[1] += 1;
            }
            Step::Printed(lines) => {
                for line in lines.lines() {
                    assert!(said.contains(line), "{page}: nothing prints\n{line}\nbut\n{said}");
                }
            }
        }
    }
    (folder, said, counts)
}

/// The names of the pages in a folder.
fn pages(folder: &str) -> Vec<String> {
    let names = Path::new(ROOT).join(folder).read_dir().unwrap().map(|entry| entry.unwrap().file_name());
    let names = names.map(|name| name.into_string().unwrap());
    let mut pages: Vec<String> = match folder {
        "models" => names.map(|name| format!("models/{name}/README.md")).collect(),
        _ => names.filter(|name| name.ends_with(".md")).map(|name| format!("{folder}/{name}")).collect(),
    };
    pages.retain(|page| Path::new(ROOT).join(page).exists());
    pages.sort();
    pages
}

/// Follows all these pages; they run at least so many blocks.
fn follow_all(pages: &[String], least: usize) {
    let mut run = 0;
    for page in pages {
        let (_, _, [ran, not_run]) = follow(page);
        let allowed = NOT_RUN.iter().find(|(name, _)| name == page).map_or(0, |(_, count)| *count);
        assert_eq!(not_run, allowed, "blocks of {page} that are not run");
        run += ran;
    }
    assert!(run >= least, "{run}");
}

#[test]
fn every_command_of_the_overview_works() {
    follow_all(&["README.md".to_owned(), "examples/README.md".to_owned()], 3);
}

#[test]
fn every_command_of_the_book_works() {
    follow_all(&pages("docs"), 25);
}

#[test]
fn every_command_of_the_models_works() {
    follow_all(&pages("models"), 30);
}

#[test]
fn the_tutorial_gives_what_it_promises() {
    let (folder, said, _) = follow("docs/tutorial.md");
    for claim in
        ["no errors", "close in 2 assembly modes", "crank-rocker", "transmission angle at `arm_pin`", "drive torque"]
    {
        assert!(said.contains(claim), "{claim}\n{said}");
    }
    for file in ["wiper.html", "wiper.png", "motion.png", "motion.csv", "path.svg", "wiper.fmu"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

/// The size of a file that a page names, within a fifth.
#[test]
fn sizes_are_what_the_pages_say() {
    let (folder, _, _) = follow("docs/view.md");
    let text = fs::read_to_string(Path::new(ROOT).join("docs/view.md")).unwrap();
    let said = text.lines().find_map(|line| line.strip_prefix("| page with a stored run, `four_bar` | ")).unwrap();
    let said: f64 = said.strip_suffix(" kB |").unwrap().parse().unwrap();
    let size = fs::metadata(folder.path().join("scene.html")).unwrap().len() as f64 / 1000.0;
    assert!((size / said - 1.0).abs() < 0.2, "{size} kB");
}

#[test]
fn the_book_has_every_page() {
    let summary = fs::read_to_string(Path::new(ROOT).join("docs/SUMMARY.md")).unwrap();
    for page in pages("docs").iter().filter(|page| *page != "docs/SUMMARY.md") {
        let name = PathBuf::from(page).file_name().unwrap().to_string_lossy().into_owned();
        assert!(summary.contains(&format!("]({name})")), "docs/SUMMARY.md lacks {name}");
    }
}
