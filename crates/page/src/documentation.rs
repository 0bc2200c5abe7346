//! `documentation/index.html`: what a user of the FMU wants to know, in one file without links: the page of `cotree view`, with more to read.

use cotree::cells;
use cotree::export::archive::Extra;
use cotree::export::description::{Causality, Description, ScalarVariable, StartValue, Variability};
use cotree::export::{ExportError, FmiVersion};
use cotree::model::{Credits, Unit};
use cotree::typeset::{between, short};
use cotree_draw::drawing::Drawing;
use cotree_draw::svg::escape;
use cotree_fmu::context::Statistics;
use cotree_fmu::instance::Inaccuracy;

use crate::MotionlessError;
use crate::accuracy::{Accuracy, FINEST, Measurement, REFERENCE};
use crate::icon;
use crate::page::{Facts, Live, Page as LivePage, preformatted, prose};

const STYLE: &str = ":root{color-scheme:light dark;--line:#8886;--soft:#8882}\
body{font:16px/1.5 system-ui,'Segoe UI',Helvetica,Arial,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;\
overflow-wrap:break-word}svg{max-width:100%;height:auto;border:1px solid var(--line);border-radius:6px}\
details,.wide{overflow-x:auto}\
table{border-collapse:collapse;width:100%;font-size:.92rem}th,td{text-align:left;padding:.3rem .7rem;\
border-bottom:1px solid var(--line);vertical-align:top}.n{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}\
code{font-size:.92em;background:var(--soft);padding:.1em .3em;border-radius:3px}\
pre{font-size:.86rem;background:var(--soft);padding:.7rem;border-radius:6px;overflow:auto;max-height:40rem}\
math{font-size:1.05em}";

/// What the page shows beside the description.
#[derive(Clone, Copy, Debug)]
pub struct DocumentationPage<'a> {
    /// The mechanism at its start.
    pub drawing: &'a Drawing,
    /// Figures, graphs and equations.
    pub facts: &'a Facts,
    /// What accuracy costs, or why it could not be measured.
    pub accuracy: &'a Result<Accuracy, MotionlessError>,
    /// The motion, or why there is none.
    pub live: &'a Result<Live, MotionlessError>,
}

impl DocumentationPage<'_> {
    /// What an FMU carries beside the model: this page, and the pictures where its version of FMI has them.
    ///
    /// # Errors
    /// The picture cannot be drawn.
    pub fn files(&self, description: &Description, version: FmiVersion) -> Result<Vec<Extra>, ExportError> {
        let picture = icon::png(self.drawing)?;
        let mut files = vec![("documentation/index.html", self.html(description, version).into_bytes())];
        files.extend(match version {
            FmiVersion::V2 => vec![("model.png", picture)],
            FmiVersion::V3 => vec![
                ("documentation/diagram.png", picture.clone()),
                ("documentation/diagram.svg", self.drawing.svg().into_bytes()),
                ("terminalsAndIcons/icon.png", picture),
            ],
        });
        Ok(files.into_iter().map(|(name, bytes)| Extra { name: name.to_owned(), bytes }).collect())
    }

    pub fn html(&self, description: &Description, version: FmiVersion) -> String {
        let sections = self.sections(description, version);
        match self.live {
            Ok(live) => LivePage {
                title: description.model_name.clone(),
                description: prose(&description.description),
                still: self.drawing.svg(),
                facts: self.facts.clone(),
                sections,
                live: live.clone(),
            }
            .html(),
            Err(why) => self.still(description, &why.to_string(), &sections),
        }
    }

    /// A page without scripts.
    fn still(&self, description: &Description, why: &str, sections: &str) -> String {
        let about = match description.description.as_str() {
            "" => String::new(),
            text => format!("<p>{}</p>\n", prose(text)),
        };
        let (picture, why, facts) = (self.drawing.svg(), escape(why), self.facts.html());
        let body = format!("{about}{picture}<p>The picture is not animated: {why}.</p>\n{sections}{facts}");
        cotree_text::html_page(&description.model_name, STYLE, &body)
    }

    /// How to use the FMU, its variables, what accuracy costs, licences.
    fn sections(&self, description: &Description, version: FmiVersion) -> String {
        let mut text = about(description, version);
        for (title, wanted) in SECTIONS {
            let wanted = description.variables.iter().filter(|variable| wanted(variable.causality));
            text.push_str(&variables(title, &wanted.collect::<Vec<_>>()));
        }
        text.push_str(&initial_values(&description.variables));
        text.push_str(&accuracy(self.accuracy, description.experiment.tolerance));
        text.push_str(LICENCES);
        text.push_str(&credits(&description.credits));
        text
    }
}

type Section = (&'static str, fn(Causality) -> bool);

const SECTIONS: [Section; 4] = [
    ("Parameters", |causality| matches!(causality, Causality::Parameter { .. })),
    ("Inputs", |causality| matches!(causality, Causality::Input { .. })),
    ("Outputs", |causality| causality == Causality::Output),
    ("Other variables", |causality| {
        matches!(causality, Causality::CalculatedParameter | Causality::Local | Causality::Independent)
    }),
];

const LICENCES: &str = "<h2>Licences</h2>\n<p>The shared libraries in <code>binaries/</code> are the cotree runtime, under the MIT \
or the Apache 2.0 licence. The texts, and those of the libraries in it, are in <code>documentation/licenses/</code>. The model itself \
belongs to whoever wrote its scene.</p>\n";

/// Who made the model, and how it may be used.
fn credits(given: &Credits) -> String {
    let rows: Vec<String> =
        given.iter().map(|(key, text)| format!("<tr><td>{key}</td><td>{}</td></tr>\n", escape(text))).collect();
    if rows.is_empty() { String::new() } else { format!("<table>\n{}</table>\n", rows.concat()) }
}

/// How to use it, and what it cannot do.
fn about(description: &Description, version: FmiVersion) -> String {
    let experiment = description.experiment;
    let exchange = match version {
        FmiVersion::V2 => description.exchange.is_some(),
        FmiVersion::V3 => description.exchange_with_rates,
    };
    const ALONE: &str = "for Co-Simulation, with the integrator inside. No Model Exchange:";
    let interfaces = match (exchange, &description.at_profile, version) {
        (true, ..) => "for Co-Simulation, with the integrator inside, and for Model Exchange".to_owned(),
        (false, Some(name), _) => format!(
            "{ALONE} <code>{}</code> touches a profile, and where it does is searched for within the solver's own steps",
            escape(name)
        ),
        (false, None, FmiVersion::V2) => {
            format!("{ALONE} a driver follows an input, whose rate an importer does not provide")
        }
        (false, None, FmiVersion::V3) => format!("{ALONE} a driver integrates an input"),
    };
    let rates = match version {
        FmiVersion::V2 => "<code>fmi2SetRealInputDerivatives</code>",
        FmiVersion::V3 => "the inputs <code>der(...)</code>",
    };
    let number = version.number();
    format!(
        "<h2>Use</h2>\n<p>FMI {number} {interfaces}. Default experiment: {} s to {} s, communication step {} s, \
         relative tolerance {:?}. In Python, with fmpy:</p>\n{}\
         <ul>\n<li>All values are in SI units. In brackets: the display units of tools.</li>\n\
         <li>The solver chooses its own steps within a communication step and keeps the loops closed.</li>\n\
         {}<li>Between communication points an input keeps its value, or follows the rate given by {rates}. Two FMUs that exchange values once per communication step see each other's values one step late; this is a property of co-simulation.</li>\n\
         <li>Fixed parameters may be set until initialisation, tunable ones at any communication point.</li>\n\
         <li>The state can be saved, restored and serialised; derivatives along directions, and of outputs by time up to \
         the fourth order, are exact.</li>\n</ul>\n",
        short(experiment.start),
        short(experiment.stop),
        short(experiment.step),
        experiment.tolerance,
        preformatted(&fmpy(description)),
        if exchange { importers_tolerance(description) } else { String::new() }
    )
}

/// The tolerance recommended for the integrator of an importer.
fn importers_tolerance(description: &Description) -> String {
    /// Coarser than this the energy of a pendulum grows visibly within seconds: see docs/fmu.md.
    const COARSEST: f64 = 1e-8;
    let tolerance = description.experiment.tolerance.min(COARSEST);
    let has_inputs = description.variables.iter().any(|variable| matches!(variable.causality, Causality::Input { .. }));
    let inputs = if has_inputs { FMPY_INPUTS } else { "" };
    format!(
        "<li>In Model Exchange the importer integrates, and the motion and the loops are as good as its tolerance: give it {tolerance:e} or \
         less, relative and absolute. It must handle events: there the loops are closed again.{inputs}</li>\n         "
    )
}

/// What its simulator does with inputs: see docs/fmu.md.
const FMPY_INPUTS: &str = " Inputs that change all the time are better served by Co-Simulation: fmpy (0.3.32) holds them from one output interval \
to the next, and in Model Exchange with tolerances below 1e-8 its integrator may stop there (<code>error test failed repeatedly</code>).";

/// A script that runs the FMU, with one of its parameters and one of its results.
fn fmpy(description: &Description) -> String {
    let first =
        |wanted: fn(Causality) -> bool| description.variables.iter().find(|variable| wanted(variable.causality));
    let Description { identifier, experiment, .. } = description;
    let start = match first(|causality| matches!(causality, Causality::Parameter { .. })) {
        Some(ScalarVariable { name, causality: Causality::Parameter { start, .. }, .. }) => {
            format!("    start_values={{{name:?}: {start:?}}},\n")
        }
        _ => String::new(),
    };
    let result = first(|causality| causality == Causality::Output);
    let shown = result.map_or("result".into(), |variable| format!("result[\"time\"], result[{:?}]", variable.name));
    format!(
        "from fmpy import simulate_fmu\n\nresult = simulate_fmu(\n    \"{identifier}.fmu\",\n    stop_time={:?},\n    \
         output_interval={:?},\n{start})\nprint({shown})\n",
        experiment.stop, experiment.step
    )
}

/// What accuracy costs.
fn accuracy(measured: &Result<Accuracy, MotionlessError>, default: f64) -> String {
    let mut text = String::from("<h2>Accuracy and work</h2>\n");
    let accuracy = match measured {
        Ok(accuracy) => accuracy,
        Err(reason) => return text + &format!("<p>Not measured: {}.</p>\n", escape(&reason.to_string())),
    };
    let [from, to] = accuracy.span.map(short);
    text += &format!(
        "<p>Measured with this model from {from} s to {to} s, at default parameters and inputs. The error is the largest of any \
         output at any time, relative to the output's largest value, and against a run with tolerance {REFERENCE:e}. The default tolerance \
         is {default:e}.</p>\n"
    );
    if accuracy.attainable > FINEST {
        let (attainable, help) = (accuracy.attainable, escape(Inaccuracy::ROUNDING));
        text += &format!(
            "<p><strong>Rounding errors leave a relative accuracy of about {attainable:.0e}</strong>, at smaller tolerances too: {help}.</p>\n"
        );
    }
    if let Some(curve) = accuracy.curve() {
        text.push_str(&curve.svg());
    }
    let row = |Measurement { tolerance, error, statistics }: &Measurement| {
        let Statistics { steps, rejected, evaluations, .. } = statistics;
        cells![format!("{tolerance:e}"), format!("{error:.1e}"), steps, rejected, evaluations]
    };
    let heads = ["tolerance", "error", "steps", "rejected", accuracy.work()].map(|head| (head, NUMBER));
    text + &table(&heads, accuracy.measurements.iter().map(row))
}

const TEXT: &str = "";
const NUMBER: &str = " class=\"n\"";

/// A table that scrolls where it is too wide: the columns by their heads and kinds, and cells as HTML.
fn table(columns: &[(&str, &str)], rows: impl Iterator<Item = Vec<String>>) -> String {
    let heads: String = columns.iter().map(|(head, kind)| format!("<th{kind}>{head}</th>")).collect();
    let row = |row: Vec<String>| {
        let cells = row.iter().zip(columns).map(|(cell, (_, kind))| format!("<td{kind}>{cell}</td>"));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = rows.map(row).collect();
    format!("<div class=\"wide\"><table>\n<tr>{heads}</tr>\n{rows}</table></div>\n")
}

fn code(name: &str) -> String {
    format!("<code>{}</code>", escape(name))
}

/// A table of variables, if there are any.
fn variables(title: &str, variables: &[&ScalarVariable]) -> String {
    let Some(first) = variables.first() else { return String::new() };
    let mut columns = vec![("name", TEXT), ("unit", TEXT)];
    if range(first).is_some() {
        columns.extend([("default", NUMBER), ("permitted", TEXT), ("may change", TEXT)]);
    }
    columns.push(("meaning", TEXT));
    let row = |variable: &&ScalarVariable| {
        let mut row = vec![code(&variable.name), escape(&shown_unit(&variable.unit))];
        row.extend(range(variable).into_iter().flat_map(|range| range.map(|text| escape(&text))));
        row.push(prose(&variable.description));
        row
    };
    format!("<h2>{title}</h2>\n{}", table(&columns, variables.iter().map(row)))
}

/// The initial values that can be set.
fn initial_values(variables: &[ScalarVariable]) -> String {
    let rows = variables.iter().filter_map(|variable| {
        let (value, kind) = match variable.start? {
            StartValue::Exact(value) => (value, "known"),
            StartValue::Approximate(value) => (value, "a guess that chooses the assembly mode"),
        };
        let [unit, value] = [shown_unit(&variable.unit), shown(value, &variable.unit)].map(|text| escape(&text));
        Some(vec![code(&variable.name), unit, value, kind.to_owned()])
    });
    let mut rows = rows.peekable();
    if rows.peek().is_none() {
        return String::new();
    }
    let table = table(&[("name", TEXT), ("unit", TEXT), ("default", NUMBER), ("is", TEXT)], rows);
    format!("<h2>Initial values</h2>\n<p>They may be set before initialisation.</p>\n{table}")
}

/// Default, permitted values, and when it may be set, of what can be set.
fn range(variable: &ScalarVariable) -> Option<[String; 3]> {
    let (start, ends) = variable.causality.range()?;
    let is_fixed = variable.variability == Variability::Fixed;
    let change = if is_fixed { "before start" } else { "any time" };
    let shown = |value: f64| shown(value, &variable.unit);
    let permitted = between(ends.map(|end| end.map(shown))).unwrap_or_else(|| "any".to_owned());
    Some([shown(start), permitted, change.to_owned()])
}

/// A unit, and in brackets the one that tools show.
fn shown_unit(unit: &Unit) -> String {
    match &unit.display {
        Some(display) => format!("{} ({})", unit.si, display.name),
        None => unit.si.clone(),
    }
}

/// A value, and in brackets as tools show it: without the last digits, in which a conversion rounds.
fn shown(value: f64, unit: &Unit) -> String {
    match &unit.display {
        Some(display) => {
            let converted = format!("{:.14e}", value / display.factor).parse().unwrap_or(value / display.factor);
            format!("{value:?} ({converted:?} {})", display.name)
        }
        None => format!("{value:?}"),
    }
}
