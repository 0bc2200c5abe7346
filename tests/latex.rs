//! Pages in LaTeX can be compiled: by pdflatex where it is installed, and everywhere all of their commands are known ones, which end before the next letter.

use crate::outside::command;
use crate::support::ROOT;
use crate::support::run::RUBBING_IN_DRIVEN;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use command::{code, cotree, stderr, stdout};

/// The commands of pages: those of LaTeX, and of the packages that the pages name.
const COMMANDS: &str = "Big Bigl Bigr DeclareUnicodeCharacter Phi Theta allowbreak allowdisplaybreaks alpha arccos arcsin arctan arraybackslash begin \
    beta bfseries boldsymbol cdot cos ddot documentclass dot end ensuremath exp fi fontsize frac gamma hline ifdefined mu lambda le left lfloor linewidth ln \
    mathbf mathit mathrm max min node noalign nopagebreak omega operatorname parindent path phi pi quad raggedright rfloor right section selectfont \
    setlength sffamily sin smallskip sqrt subsection tan tanh textbf texttt theta times to usepackage";

/// Every page in LaTeX of every model, with a name.
fn pages() -> Vec<(String, String)> {
    let mut pages = Vec::new();
    for entry in fs::read_dir(Path::new(ROOT).join("models")).unwrap() {
        let folder = entry.unwrap().path();
        let name = folder.file_name().unwrap().to_str().unwrap().to_owned();
        if name == RUBBING_IN_DRIVEN {
            continue;
        }
        for options in [&["--equations", "latex"][..], &["--equations", "latex", "--symbols"], &["--steps", "latex"]] {
            let output = cotree(&folder, &[&["show", "scene.toml"], options].concat());
            assert_eq!(code(&output), 0, "{name} {options:?}: {}", stderr(&output));
            pages.push((format!("{name}{}", options.concat().replace("--", "-")), stdout(&output)));
        }
    }
    pages
}

/// The names of commands in a text: letters after a backslash. A single other character is a command, too, such as a second backslash.
fn commands(text: &str) -> BTreeSet<&str> {
    let mut commands = BTreeSet::new();
    let mut rest = text;
    while let Some((_, after)) = rest.split_once('\\') {
        let end = after.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after.len());
        let (name, behind) = after.split_at(end);
        rest = if name.is_empty() { behind.get(1..).unwrap_or_default() } else { behind };
        commands.extend(Some(name).filter(|name| !name.is_empty()));
    }
    commands
}

#[test]
fn commands_are_known_ones_and_the_pages_can_be_compiled() {
    let pages = pages();
    let known: BTreeSet<&str> = COMMANDS.split_whitespace().collect();
    for (name, page) in &pages {
        let unknown: Vec<&str> = commands(page).into_iter().filter(|command| !known.contains(command)).collect();
        assert!(unknown.is_empty(), "{name}: {unknown:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let there = Command::new("pdflatex").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    // Each takes a second: half of them suffice for what the list of commands does not see.
    for (name, page) in pages.iter().step_by(2).filter(|_| there) {
        fs::write(folder.path().join("page.tex"), page).unwrap();
        let run = Command::new("pdflatex")
            .args(["-interaction=nonstopmode", "-halt-on-error", "page.tex"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(run.status.success(), "{name}: {}", String::from_utf8_lossy(&run.stdout));
    }
}
