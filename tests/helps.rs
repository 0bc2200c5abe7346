//! What a help shows in backticks, put in place of what is marked, mends that place: for slips of many kinds in every model of the gallery.

use crate::support::run;

use cotree::scene::{Fault, Scene, Severity};

fn errors(text: &str) -> Vec<Fault> {
    let list = match Scene::from_toml(text).and_then(|scene| scene.resolve()) {
        Ok(_) => Vec::new(),
        Err(faults) => faults.list,
    };
    list.into_iter().filter(|fault| fault.severity == Severity::Error).collect()
}

/// The text with the help of the first error applied, and where.
fn pasted(text: &str, fault: &Fault) -> Option<(String, usize)> {
    let shown = fault.help.split('`').nth(1)?;
    let (mut start, mut end) = (fault.span.start, fault.span.end);
    let is_quoted = text.get(start..=start) == Some("\"");
    // A text becomes a list without its quotes; a bare value that is to be one keeps them.
    let within_quotes = text[..start].ends_with('"') && text[end..].starts_with('"');
    if shown.starts_with('[') && within_quotes {
        (start, end) = (start - 1, end + 1);
    }
    let shown = if is_quoted && !shown.starts_with(['"', '[']) { format!("\"{shown}\"") } else { shown.to_owned() };
    Some((format!("{}{shown}{}", &text[..start], &text[end..]), start))
}

/// Why the help of a wrong text does not mend it; none: it does.
fn unmended(text: &str) -> Option<String> {
    let found = errors(text);
    let first = found.first()?;
    let Some((better, place)) = pasted(text, first) else {
        return Some(format!("{}: the help has nothing to paste: {}", first.message, first.help));
    };
    let still = errors(&better).into_iter().find(|fault| fault.span.start.abs_diff(place) <= 3)?;
    Some(format!("{} -> {}: then {}", first.message, first.help, still.message))
}

/// A name with two of its letters exchanged, as they are typed.
fn mistyped(name: &str) -> Option<String> {
    let letters: Vec<char> = name.chars().collect();
    let at = (1..letters.len().saturating_sub(1)).find(|&i| letters[i] != letters[i + 1] && letters.len() > 3)?;
    let mut letters = letters;
    letters.swap(at, at + 1);
    Some(letters.into_iter().collect())
}

/// Each model with one slip: the `which`th line that the slip fits to.
fn with_slip(text: &str, slip: &dyn Fn(&str, &str) -> Option<String>, which: usize) -> Option<String> {
    let mut header = "";
    let mut fitting = Vec::new();
    let lines: Vec<&str> = text.lines().collect();
    for (index, line) in lines.iter().enumerate() {
        if line.starts_with('[') {
            header = line;
        }
        fitting.extend(slip(header, line).filter(|wrong| wrong != line).map(|wrong| (index, wrong)));
    }
    let (index, wrong) = fitting.into_iter().nth(which)?;
    let mut lines: Vec<String> = lines.into_iter().map(str::to_owned).collect();
    lines[index] = wrong;
    Some(lines.join("\n"))
}

/// The first dotted name in quotes of a line, with the owner or the end mistyped.
fn dotted(line: &str, owner: bool) -> Option<String> {
    let name = line.split('"').skip(1).step_by(2).find(|name| name.contains('.') && !name.contains(' '))?;
    let (first, rest) = name.split_once('.')?;
    let wrong = if owner { format!("{}.{rest}", mistyped(first)?) } else { format!("{first}.{}", mistyped(rest)?) };
    Some(line.replacen(name, &wrong, 1))
}

/// What may slip in a line of a table with this header.
type Slip = (&'static str, fn(&str, &str) -> Option<String>);

const SLIPS: [Slip; 14] = [
    ("owner of an output", |header, line| dotted(line, true).filter(|_| header == "[outputs]")),
    ("variable of an output", |header, line| dotted(line, false).filter(|_| header == "[outputs]")),
    ("owner of an initial value", |header, line| dotted(line, true).filter(|_| header == "[initial]")),
    ("point", |_, line| dotted(line, false).filter(|_| line.starts_with("between"))),
    ("body of a point", |_, line| dotted(line, true).filter(|_| line.starts_with("between"))),
    ("key", |header, line| {
        let (key, rest) =
            line.split_once('=').filter(|_| header.starts_with("[joints.") || header.starts_with("[loads."))?;
        Some(format!("{} ={rest}", mistyped(key.trim())?))
    }),
    ("type", |_, line| {
        let kind = line.strip_prefix("type")?.split('"').nth(1)?;
        Some(line.replacen(kind, &mistyped(kind)?, 1))
    }),
    ("hinge", |header, line| header.starts_with("[joints.").then(|| line.replace("\"revolute\"", "\"hinge\""))),
    ("slider", |header, line| header.starts_with("[joints.").then(|| line.replace("\"prismatic\"", "\"slider\""))),
    ("k", |header, line| {
        line.strip_prefix("stiffness").filter(|_| header.starts_with("[loads.")).map(|rest| format!("k{rest}"))
    }),
    ("theta", |_, line| Some(line.replacen(".angle\"", ".theta\"", 1)).filter(|_| line.starts_with('"'))),
    ("gravity", |_, line| line.starts_with("gravity").then(|| "gravity = 9.81".to_owned())),
    ("axis", |_, line| line.starts_with("axis").then(|| "axis = \"x\"".to_owned())),
    ("mass", |header, line| {
        let is_number = line.split_once('=').is_some_and(|(_, value)| value.trim().parse::<f64>().is_ok());
        (header.starts_with("[bodies.") && line.starts_with("mass") && is_number).then(|| line.replacen("= ", "= -", 1))
    }),
];

#[test]
fn helps_mend_what_they_are_about() {
    let (mut tried, mut odd) = (0, Vec::new());
    for model in run::models() {
        let text = run::scene_of(&model);
        if !errors(&text).is_empty() {
            continue;
        }
        for (kind, slip) in SLIPS {
            for which in 0..2 {
                let Some(wrong) = with_slip(&text, &slip, which) else { break };
                tried += usize::from(!errors(&wrong).is_empty());
                odd.extend(unmended(&wrong).map(|why| format!("{model}, {kind}: {why}")));
            }
        }
    }
    println!("{} of {tried} helps mend", tried - odd.len());
    assert!(tried >= 300, "{tried}");
    assert!(odd.is_empty(), "{} of {tried}:\n{}", odd.len(), odd.join("\n"));
}

/// A pendulum with a value in a place.
fn pendulum(old: &str, new: &str) -> String {
    let text = "name = \"pendulum\"\ngravity = [0, -9.81]\n[parameters]\nL = \"0.5 m\"\nturn = \"0.3 rad\"\n[bodies.bar]\nmass = \"2 kg\"\ninertia = \"0.0417 kg.m2\"\n\
                com = [0, 0]\npoints = { top = [\"-L/2\", 0], tip = [\"L/2\", 0] }\n[joints.hinge]\ntype = \"revolute\"\nbetween = [\"ground\", \"bar.top\"]\n\
                [drivers.motor]\njoint = \"hinge\"\nangle = \"turn*sin(2*pi*t)\"\n[outputs]\nvariables = [\"bar.angle\", \"hinge.fx\", \"bar.tip.x\"]\n";
    assert!(text.contains(old), "{old}");
    text.replacen(old, new, 1)
}

#[test]
fn helps_of_values_mend() {
    let slips = [
        ("com = [0, 0]", "com = \"middle\""),
        ("com = [0, 0]", "com = \"50 mm\""),
        ("gravity = [0, -9.81]", "gravity = \"9.81 m/s2\""),
        ("gravity = [0, -9.81]", "gravity = \"down\""),
        ("\"2 kg\"", "\"-2 kg\""),
        ("\"2 kg\"", "-2"),
        ("\"0.0417 kg.m2\"", "\"-0.0417 kg.m2\""),
        ("\"0.3 rad\"", "\"sin(110 deg)\""),
        ("\"turn*sin(2*pi*t)\"", "\"turn*sind(30)\""),
        ("\"turn*sin(2*pi*t)\"", "\"turn*cosd(30 + (2 + t)*5)\""),
        ("bar.tip.x", "bar.tpi.x"),
        ("bar.tip.x", "bra.tip.x"),
        ("hinge.fx", "hinje.fx"),
        ("bar.angle", "bar.theta"),
        ("\"revolute\"", "\"pin\""),
    ];
    let odd: Vec<String> =
        slips.iter().filter_map(|(old, new)| Some(format!("{new}: {}", unmended(&pendulum(old, new))?))).collect();
    assert!(odd.is_empty(), "{}", odd.join("\n"));
}

/// A header that is missing is named, and gravity that acts upwards is a warning with what to write.
#[test]
fn what_is_missing_or_upside_down_is_named() {
    let found = errors(&pendulum("[joints.hinge]\n", ""));
    assert!(found[0].help.contains("write its header above this line, such as `[joints.NAME]`"), "{found:#?}");
    let warnings = |gravity: &str| {
        let mechanism =
            Scene::from_toml(&pendulum("[0, -9.81]", gravity)).and_then(|scene| cotree::compile(&scene)).unwrap();
        mechanism.warnings.map_or_else(Vec::new, |warnings| warnings.list)
    };
    let upwards = warnings("[0, 9.81]");
    assert!(
        upwards.iter().any(|fault| fault.code == "scene::upwards" && &*fault.help == "write `[0, -9.81]`"),
        "{upwards:#?}"
    );
    assert!(warnings("[0, -9.81]").is_empty() && warnings("[0, 0]").is_empty());
}
