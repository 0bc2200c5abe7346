//! One page that shows a mechanism in motion: what it holds, put together. Nothing in it is fetched from anywhere.

mod draw;
mod facts;
mod pack;

use std::collections::BTreeMap;

use cotree::model::{DisplayUnit, Experiment, Mechanism};
use cotree::scene::Span;
use cotree_draw::drawing::Geometry;
use cotree_draw::svg::escape;
use serde::Serialize;

pub use draw::DrawingPage;
pub use facts::Facts;
use pack::{inert, packed, smooth_columns};

const TEMPLATE: &str = include_str!("template.html");
const STYLE: &str = include_str!("page.css");
/// With its licence, which asks to go along.
const UPLOT: &str = concat!(
    "/*! ",
    include_str!("../../vendor/uplot/LICENSE"),
    "*/\n",
    include_str!("../../vendor/uplot/uPlot.iife.min.js")
);
const UPLOT_STYLE: &str = include_str!("../../vendor/uplot/uPlot.min.css");
/// What the pages share.
const COMMON: &str = include_str!("common.js");
/// Renews the page while its scene is watched.
const LIVE: &str = include_str!("live.js");
const SERVED: &str = include_str!("served.js");
/// Modules that become one script, in this order.
const SCRIPTS: [&str; 14] = [
    COMMON,
    include_str!("data.js"),
    include_str!("solver.js"),
    include_str!("worker.js"),
    include_str!("canvas.js"),
    include_str!("figure.js"),
    include_str!("marks.js"),
    include_str!("plots.js"),
    include_str!("controls.js"),
    include_str!("handles.js"),
    include_str!("touch.js"),
    include_str!("edit.js"),
    include_str!("main.js"),
    include_str!("start.js"),
];

/// What a page shows.
#[derive(Clone, Debug)]
pub struct Page {
    /// The scene's name.
    pub title: String,
    /// One line as HTML; may be empty.
    pub description: String,
    /// The mechanism at its start, as SVG: for a browser that runs no scripts.
    pub still: String,
    /// Equations, graphs and figures.
    pub facts: Facts,
    /// What else there is to read, as HTML.
    pub sections: String,
    pub live: Live,
}

/// A mechanism and its motion.
#[derive(Clone, Debug)]
pub struct Live {
    /// What the scripts need.
    pub model: PageModel,
    pub motion: MotionSource,
}

/// The mechanism and its variables, as data for the scripts.
#[derive(Clone, Debug, Serialize)]
pub struct PageModel {
    /// The drawing in the bodies' axes.
    pub geometry: Geometry,
    /// Names of the points of each body.
    pub points: Vec<Vec<String>>,
    /// Points of the ground, and where they are at the start.
    pub ground: Vec<GroundPoint>,
    /// True for a mechanism on a line.
    pub line: bool,
    /// Every variable, in the order of the program.
    pub variables: Vec<PageVariable>,
    /// The units of the scene's `[display]`, by the SI units in whose place they stand.
    pub units: BTreeMap<String, Display>,
    /// What the scene asks for.
    pub outputs: Vec<String>,
    /// What a run records.
    pub recorded: Vec<String>,
    /// What the stored run holds, beside the times.
    pub stored: Vec<String>,
    /// Why the stored run ends early, if it does.
    pub cut: Option<String>,
    /// What the stored run warns of.
    pub warning: Option<String>,
    /// The command that makes the page anew, with the solver inside.
    pub renew: String,
    /// Times and tolerance.
    pub experiment: Times,
    /// What can be touched, where the solver is inside.
    pub touch: Option<Touch>,
}

/// What can be touched: the program in which the numbers of the scene are parameters, and where they are written.
#[derive(Clone, Debug, Serialize)]
pub struct Touch {
    /// The program; it goes beside the data.
    #[serde(skip)]
    pub program: Vec<u8>,
    /// Its variables, in its order.
    pub variables: Vec<String>,
    /// Its coordinates.
    pub coordinates: Vec<String>,
    /// Plain numbers of the scene: they can be changed.
    pub numbers: Vec<PlainNumber>,
    /// Lengths that are written as expressions.
    pub formulas: Vec<WrittenLength>,
    /// Laws of drivers: what pulls a body adds to them.
    pub laws: Vec<DriverLaw>,
    /// How the values of parameters, inputs and initial values are written.
    pub written: Vec<WrittenPlace>,
    /// What the text gives no value.
    pub absent: Vec<AbsentValue>,
    /// Where its tables get more entries.
    pub gaps: BTreeMap<&'static str, EntryGap>,
    /// The name of the scene's file and its text.
    pub file: String,
    pub text: String,
}

/// A plain number of the scene.
#[derive(Clone, Debug, Serialize)]
pub struct PlainNumber {
    /// What it is of the scene.
    pub name: String,
    /// As a parameter.
    pub variable: PageVariable,
    pub written: WrittenPlace,
}

/// A length that is written as an expression.
#[derive(Clone, Debug, Serialize)]
pub struct WrittenLength {
    /// What it is of the scene.
    pub name: String,
    pub text: String,
    /// The variable that has its value.
    pub output: String,
}

/// The law of a driver.
#[derive(Clone, Debug, Serialize)]
pub struct DriverLaw {
    pub driver: String,
    /// What is added to it; or the input that is the motion itself.
    pub parameter: String,
    /// Is it an angle?
    pub angle: bool,
    /// The variable that has its value.
    pub output: String,
    /// Bytes of the text.
    pub place: [usize; 2],
    /// The law, to which a number with its sign is added, and its closing quote.
    pub before: String,
    pub after: String,
}

/// How a number is written.
#[derive(Clone, Debug, Serialize)]
pub struct WrittenPlace {
    /// Its variable.
    pub name: String,
    /// Bytes of the text, with quotes.
    pub place: [usize; 2],
    /// What stands before the number and behind it.
    pub before: String,
    pub after: String,
    /// The SI value of one of what it counts.
    pub factor: f64,
}

/// A variable for which the text has no value yet: what stands around the number in an entry of its table.
#[derive(Clone, Debug, Serialize)]
pub struct AbsentValue {
    pub name: String,
    /// `inputs` or `initial`.
    pub table: &'static str,
    /// As a known value.
    pub known: Around,
    /// As a guess.
    pub guess: Around,
}

/// What stands around a number.
#[derive(Clone, Debug, Serialize)]
pub struct Around {
    pub before: String,
    pub after: String,
}

/// Where a table gets more entries, and what stands around them.
#[derive(Clone, Debug, Serialize)]
pub struct EntryGap {
    pub at: usize,
    pub head: String,
    pub separator: String,
    pub tail: String,
}

impl WrittenPlace {
    /// The number at a place of a text. It has a unit there if letters stand in its quotes; a bare one counts that unit too if `bare`, else SI units.
    pub fn new(name: String, text: &str, place: Span, unit: &DisplayUnit, bare: bool) -> Self {
        let written = text.get(place.start..place.end).unwrap_or_default();
        let quote = written.get(..1).filter(|quote| matches!(*quote, "\"" | "'")).unwrap_or_default();
        let inner = written.strip_prefix(quote).and_then(|written| written.strip_suffix(quote)).unwrap_or_default();
        let has_unit =
            !quote.is_empty() && inner.contains(|letter: char| letter.is_alphabetic() || "°%\"″".contains(letter));
        let after = if has_unit { format!(" {}{quote}", unit.name) } else { quote.to_owned() };
        let factor = if has_unit || bare { unit.factor } else { 1.0 };
        WrittenPlace { name, place: [place.start, place.end], before: quote.to_owned(), after, factor }
    }
}

/// A point of the ground.
#[derive(Clone, Debug, Serialize)]
pub struct GroundPoint {
    /// The user's name.
    pub name: String,
    pub at: [f64; 2],
}

/// A variable as the page shows it. Values are SI.
#[derive(Clone, Debug, Serialize)]
pub struct PageVariable {
    /// The structured name.
    pub name: String,
    /// One line.
    pub text: String,
    /// Such as `parameter`.
    pub kind: &'static str,
    /// SI unit.
    pub unit: String,
    /// The unit that is shown instead.
    pub display: Option<Display>,
    /// Value until it is set, of what can be set.
    pub start: Option<f64>,
    /// Smallest permitted value.
    pub min: Option<f64>,
    /// Largest permitted value.
    pub max: Option<f64>,
    /// Is `start` a known initial value of something that is calculated?
    pub initial: bool,
}

/// A unit and the SI value of one of it.
#[derive(Clone, Debug, Serialize)]
pub struct Display {
    name: String,
    factor: f64,
}

/// Times of a run \[s\] and its tolerance.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Times {
    start: f64,
    stop: f64,
    step: f64,
    tolerance: f64,
}

/// Where the motion comes from.
#[derive(Clone, Debug)]
pub enum MotionSource {
    /// The runtime for browsers, and the program that it runs.
    Solver {
        /// The WebAssembly module.
        module: Vec<u8>,
        /// The program, as in an FMU.
        program: Vec<u8>,
    },
    /// A run that was made beforehand.
    Stored(StoredRun),
    /// The program that has made the page runs it, as long as it lasts; afterwards the run plays.
    Elsewhere {
        /// The program, as in an FMU.
        program: Vec<u8>,
        /// The run.
        run: StoredRun,
    },
}

/// A run that was made beforehand.
#[derive(Clone, Debug)]
pub struct StoredRun {
    /// Its times \[s\].
    pub times: Vec<f64>,
    /// A column of values for each name in [`PageModel::stored`]: to be looked at, so seven digits will do.
    pub columns: Vec<Vec<f32>>,
}

impl StoredRun {
    /// As the page carries it.
    fn packed(&self) -> String {
        let times = self.times.iter().flat_map(|time| time.to_le_bytes());
        let bytes: Vec<u8> = times.chain(smooth_columns(&self.columns)).collect();
        packed(&bytes)
    }
}

impl From<DisplayUnit> for Display {
    fn from(DisplayUnit { name, factor }: DisplayUnit) -> Self {
        Display { name, factor }
    }
}

impl From<Experiment> for Times {
    fn from(Experiment { start, stop, step, tolerance }: Experiment) -> Self {
        Times { start, stop, step, tolerance }
    }
}

/// Names of the points of each body.
pub fn point_names(mechanism: &Mechanism) -> Vec<Vec<String>> {
    let names = |body: &cotree::model::Body| body.points.iter().map(|point| point.name.clone()).collect();
    mechanism.bodies.iter().map(names).collect()
}

impl Page {
    /// The page while its scene is watched: it hears of news from the server that it comes from.
    pub fn live_html(&self) -> String {
        let page = live(&self.html());
        match &self.live.motion {
            MotionSource::Solver { module, .. } if module.is_empty() => served(&page, None),
            _ => page,
        }
    }

    /// The page as this machine serves it, with its solver in the program that does.
    pub fn served_html(&self) -> String {
        served(&self.html(), None)
    }

    /// The page as a file or in a frame, with its solver in the program that answers at this address.
    pub fn html_served_from(&self, address: &str) -> String {
        served(&self.html(), Some(address))
    }

    pub fn html(&self) -> String {
        let live = &self.live;
        let Live { model, motion } = live;
        let model = serde_json::to_string(model).unwrap_or_default();
        let (module, program, run) = match motion {
            MotionSource::Solver { module, program } => (packed(module), packed(program), String::new()),
            MotionSource::Stored(run) => (String::new(), String::new(), run.packed()),
            MotionSource::Elsewhere { program, run } => (String::new(), packed(program), run.packed()),
        };
        let loose = live.model.touch.as_ref().map_or(String::new(), |touch| packed(&touch.program));
        let script = scope(&SCRIPTS);
        let parts = [
            ("title", escape(&self.title)),
            ("description", self.description.clone()),
            ("still", self.still.clone()),
            ("uplot_style", UPLOT_STYLE.to_owned()),
            ("style", STYLE.to_owned()),
            ("facts", self.facts.html()),
            ("sections", self.sections.clone()),
            ("model", inert(&model)),
            ("run", run),
            ("program", program),
            ("loose", loose),
            ("solver", module),
            ("uplot", UPLOT.to_owned()),
            ("script", script),
        ];
        fill(TEMPLATE, &parts)
    }
}

/// Modules in one scope of their own: no name is in two of them, so that what they import from each other is there.
fn scope(modules: &[&str]) -> String {
    let script: String = modules.iter().map(|module| without_imports(module)).collect();
    format!("(() => {{\n\"use strict\";\n{script}}})();\n")
}

/// A module without what it says to other modules and to whoever checks it; `deno fmt` gives all of that its place at the beginning of lines.
fn without_imports(module: &str) -> String {
    let (mut script, mut imports) = (String::with_capacity(module.len()), false);
    for line in module.lines() {
        imports |= line.starts_with("import ");
        if !imports && line != "// @ts-check" {
            script += line.strip_prefix("export ").unwrap_or(line);
            script.push('\n');
        }
        imports &= !line.ends_with(';');
    }
    script
}

/// Text as HTML, with names between backticks as code.
pub fn prose(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return escape(text);
    }
    let part = |(index, part): (usize, &&str)| match index % 2 {
        0 => escape(part),
        _ => format!("<code>{}</code>", escape(part)),
    };
    parts.iter().enumerate().map(part).collect()
}

/// Text as HTML that keeps its lines and spaces.
pub fn preformatted(text: &str) -> String {
    let lines: Vec<String> = text.lines().map(escape).collect();
    format!("<pre>{}</pre>\n", lines.join("\n"))
}

/// What is served before there is a page: it waits for one.
pub fn waiting_html() -> String {
    live(&format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:\"><title>cotree</title>\
         <link rel=\"icon\" href=\"data:,\"><style>{STYLE}</style></head><body><p class=\"notice\" id=\"notice\"></p></body></html>\n"
    ))
}

/// May ask its server, and does.
fn live(page: &str) -> String {
    let allowed = page.replacen("default-src 'none'", "default-src 'none'; connect-src 'self'", 1);
    let (start, end) = allowed.rsplit_once("</body>").unwrap_or((&allowed, ""));
    format!("{start}<script>{LIVE}</script>\n</body>{end}")
}

/// Has its solver and front end in the program that serves it, or in the one at another address.
fn served(page: &str, elsewhere: Option<&str>) -> String {
    let allowed = if page.contains("connect-src") {
        page.to_owned()
    } else {
        let sources = elsewhere.unwrap_or("'self'");
        page.replacen("default-src 'none'", &format!("default-src 'none'; connect-src {sources}"), 1)
    };
    let server = elsewhere.map_or(String::new(), |address| format!("window.cotreeServer = \"{address}\";\n"));
    let (start, end) = allowed.split_once("</head>").unwrap_or(("", &allowed));
    format!("{start}<script>{server}{SERVED}</script>\n</head>{end}")
}

/// Puts the parts where the template names them. What a part holds is not looked at again.
fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let mut pieces = template.split("{{");
    let mut page = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or(("", piece));
        if let Some((_, part)) = parts.iter().find(|(known, _)| *known == name) {
            page.push_str(part);
        }
        page.push_str(rest);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_put_in_once() {
        let parts = [("a", "{{b}}".to_owned()), ("b", "2".to_owned())];
        assert_eq!(fill("<{{a}}|{{b}}>", &parts), "<{{b}}|2>");
    }

    #[test]
    fn every_place_of_the_template_is_filled() {
        let names: Vec<&str> =
            TEMPLATE.split("{{").skip(1).filter_map(|rest| rest.split_once("}}")).map(|(name, _)| name).collect();
        let known = [
            "title",
            "description",
            "still",
            "uplot_style",
            "style",
            "facts",
            "sections",
            "model",
            "run",
            "program",
            "loose",
            "solver",
            "uplot",
            "script",
        ];
        assert!(
            names.iter().all(|name| known.contains(name)) && known.iter().all(|name| names.contains(name)),
            "{names:?}"
        );
    }

    #[test]
    fn a_watched_page_may_ask_its_server_and_no_other_page_may() {
        assert!(!TEMPLATE.contains("connect-src"));
        for page in [live(TEMPLATE), waiting_html()] {
            assert_eq!(page.matches("connect-src 'self'").count(), 1);
            assert_eq!(page.matches("EventSource").count(), 1);
        }
    }

    #[test]
    fn modules_become_one_script() {
        let first = "// @ts-check\n// What it is.\nimport {\n  a,\n} from \"./a.js\";\nimport { b } from \"./b.js\";\nexport const c = a + b;\nexport function d() {\n  return c;\n}\n";
        let expected =
            "(() => {\n\"use strict\";\n// What it is.\nconst c = a + b;\nfunction d() {\n  return c;\n}\n})();\n";
        assert_eq!(scope(&[first]), expected);
    }

    /// Two modules with the same name at their top would be no script at all once they are one.
    #[test]
    fn no_name_is_in_two_modules() {
        let pages: [&[&str]; 2] = [&SCRIPTS, &draw::SCRIPTS];
        for modules in pages {
            let script = scope(modules);
            let begins = |line: &str| {
                ["const ", "let ", "function ", "async function ", "class "]
                    .iter()
                    .find_map(|word| line.strip_prefix(*word).map(str::to_owned))
            };
            let mut names: Vec<String> = script
                .lines()
                .filter_map(begins)
                .map(|line| {
                    line.split(|letter: char| !letter.is_alphanumeric() && !"_$".contains(letter))
                        .next()
                        .unwrap_or_default()
                        .to_owned()
                })
                .filter(|name| !name.is_empty())
                .collect();
            let count = names.len();
            names.sort();
            names.dedup();
            assert!(count > 50 && names.len() == count, "{} of {count} names", names.len());
        }
    }

    #[test]
    fn no_script_ends_the_element_that_it_is_in() {
        for script in SCRIPTS.into_iter().chain(draw::SCRIPTS).chain([UPLOT, LIVE, SERVED]) {
            assert!(!script.contains("</script") && !script.contains("<!--"));
        }
    }
}
