//! One slip is one fault, in all models: what follows from it is not said.

use crate::support::run;

use cotree::scene::{Scene, Severity};

/// The errors of a scene.
fn errors(text: &str) -> Vec<String> {
    let faults = match Scene::from_toml(text).and_then(|scene| scene.resolve()) {
        Ok(_) => return Vec::new(),
        Err(faults) => faults.list,
    };
    let errors = faults.into_iter().filter(|fault| fault.severity == Severity::Error);
    errors.map(|fault| format!("{} {}", fault.code, fault.message)).collect()
}

/// The models with one line changed at a time, and what does not give one fault.
fn with_one_line(change: impl Fn(&str, &str) -> Option<String>) -> (usize, Vec<String>) {
    let (mut tried, mut odd) = (0, Vec::new());
    for model in run::models() {
        let text = run::scene_of(&model);
        let lines: Vec<&str> = text.lines().collect();
        let mut header = "";
        for (index, line) in lines.iter().enumerate() {
            if line.starts_with('[') {
                header = line;
            }
            let Some(changed) = change(header, line) else { continue };
            let mut wrong = lines.clone();
            wrong[index] = &changed;
            let errors = errors(&wrong.join("\n"));
            tried += 1;
            if errors.len() != 1 {
                odd.push(format!("{model}: {changed}: {errors:#?}"));
            }
        }
    }
    (tried, odd)
}

/// The key of a line in a table whose keys are known, and what follows it.
fn known_key<'l>(header: &str, line: &'l str) -> Option<(&'l str, &'l str)> {
    let own = ["[bodies.", "[joints.", "[drivers.", "[loads.", "[experiment]", "[solver]", "[ground]"];
    let (key, rest) = line.split_once('=')?;
    let is_key = key.trim().bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_') && !line.starts_with(' ');
    let is_known = header.is_empty() || own.iter().any(|own| header.starts_with(own)) && !header.contains(".points]");
    (is_key && is_known).then_some((key.trim(), rest))
}

#[test]
fn a_key_that_is_misspelt() {
    // What a part or a cam asks of an element whose key is misspelt may still be told beside it.
    let (tried, odd) = with_one_line(|header, line| {
        let (key, rest) = known_key(header, line)?;
        Some(format!("{key}q ={rest}"))
    });
    let odd: Vec<String> = odd
        .into_iter()
        .filter(|odd| !["cam_oscillating", "double_wishbone"].iter().any(|own| odd.starts_with(own)))
        .collect();
    assert!(tried > 500 && odd.is_empty(), "{} of {tried}:\n{}", odd.len(), odd.join("\n"));
}

#[test]
fn a_section_that_is_misspelt() {
    let (tried, odd) = with_one_line(|_, line| {
        let name = line.strip_prefix('[')?;
        let end = name.find(['.', ']'])?;
        Some(format!("[{}q{}", &name[..end], &name[end..]))
    });
    assert!(tried > 200 && odd.is_empty(), "{} of {tried}:\n{}", odd.len(), odd.join("\n"));
}
