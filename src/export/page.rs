//! `documentation/index.html`: what a user of the FMU wants to know, in one file without scripts or links.

use std::fmt::Write;

use super::description::{Causality, Description, ScalarVariable};
use crate::report::drawing::Drawing;
use crate::report::svg::escape;

const STYLE: &str = "body{font:16px/1.5 system-ui,'Segoe UI',Helvetica,Arial,sans-serif;color:#1f2933;max-width:60rem;\
margin:2rem auto;padding:0 1rem}svg{max-width:100%;height:auto;border:1px solid #e6eaef;border-radius:6px}\
table{border-collapse:collapse;width:100%;font-size:.92rem}th,td{text-align:left;padding:.3rem .7rem;\
border-bottom:1px solid #e6eaef;vertical-align:top}td.n{text-align:right;font-variant-numeric:tabular-nums}\
code{font-size:.92em;background:#f3f5f8;padding:.1em .3em;border-radius:3px}";

/// The page.
pub fn html(description: &Description, drawing: &Drawing) -> String {
    let name = escape(&description.model_name);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{name}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n"
    );
    if !description.description.is_empty() {
        add(&mut page, format_args!("<p>{}</p>\n", escape(&description.description)));
    }
    page.push_str(&drawing.svg());
    page.push_str(&about(description));
    for (title, wanted) in SECTIONS {
        table(&mut page, title, description.variables.iter().filter(|variable| wanted(variable.causality)));
    }
    page.push_str("</body>\n</html>\n");
    page
}

type Section = (&'static str, fn(Causality) -> bool);

const SECTIONS: [Section; 4] = [
    ("Parameters", |causality| matches!(causality, Causality::Parameter { .. })),
    ("Inputs", |causality| matches!(causality, Causality::Input { .. })),
    ("Outputs", |causality| causality == Causality::Output),
    ("Other variables", |causality| causality == Causality::Local),
];

/// How to use it, and what it cannot do.
fn about(description: &Description) -> String {
    let experiment = description.experiment;
    let interfaces = match description.exchange {
        Some(_) => "for Co-Simulation, with the integrator inside, and for Model Exchange",
        None => "for Co-Simulation; the integrator is inside",
    };
    format!(
        "<h2>Use</h2>\n<p>FMI 2.0 {interfaces}. Default experiment: {:?} s to {:?} s, \
         communication step {:?} s, relative tolerance {:?}.</p>\n\
         <ul>\n<li>All values are in SI units; display units are in <code>modelDescription.xml</code>.</li>\n\
         <li>The solver chooses its own steps within a communication step and keeps the loops closed.</li>\n\
         <li>Between communication points an input keeps its value, or follows the rate given by \
         <code>fmi2SetRealInputDerivatives</code>. Two FMUs that exchange values once in a communication step see each \
         other one step late; this is a property of co-simulation.</li>\n\
         <li>Fixed parameters may be set until initialisation, tunable ones at any communication point.</li>\n\
         <li>The state can be saved, restored and serialised; derivatives along directions and of outputs by time are \
         exact.</li>\n</ul>\n",
        experiment.start, experiment.stop, experiment.step, experiment.tolerance
    )
}

/// A table of variables, if there are any.
fn table<'a>(page: &mut String, title: &str, variables: impl Iterator<Item = &'a ScalarVariable>) {
    let mut variables = variables.peekable();
    let Some(first) = variables.peek() else {
        return;
    };
    let range = range(first.causality).is_some();
    let columns = if range { "<th>default</th><th>permitted</th><th>may change</th>" } else { "" };
    add(
        page,
        format_args!("<h2>{title}</h2>\n<table>\n<tr><th>name</th><th>unit</th>{columns}<th>meaning</th></tr>\n"),
    );
    for variable in variables {
        let (name, unit) = (escape(&variable.name), escape(&variable.unit.si));
        add(page, format_args!("<tr><td><code>{name}</code></td><td>{unit}</td>"));
        if let Some((start, permitted, change)) = self::range(variable.causality) {
            add(page, format_args!("<td class=\"n\">{start:?}</td><td>{permitted}</td><td>{change}</td>"));
        }
        add(page, format_args!("<td>{}</td></tr>\n", escape(&variable.description)));
    }
    page.push_str("</table>\n");
}

/// Default, permitted values, and when it may be set, of what can be set.
fn range(causality: Causality) -> Option<(f64, String, &'static str)> {
    let (start, min, max, change) = match causality {
        Causality::Parameter { tunable: false, start, min, max } => (start, min, max, "before start"),
        Causality::Parameter { tunable: true, start, min, max } => (start, min, max, "any time"),
        Causality::Input { start, min, max } => (start, min, max, "any time"),
        Causality::Output | Causality::Local | Causality::Independent => return None,
    };
    let permitted = match (min, max) {
        (None, None) => "any".to_owned(),
        (Some(min), None) => format!("at least {min:?}"),
        (None, Some(max)) => format!("at most {max:?}"),
        (Some(min), Some(max)) => format!("{min:?} to {max:?}"),
    };
    Some((start, permitted, change))
}

fn add(page: &mut String, text: std::fmt::Arguments) {
    // Writing to a string cannot fail.
    let _ = page.write_fmt(text);
}
