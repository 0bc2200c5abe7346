//! Tasks for which a linkage is sought, as they are written: poses, a function, a path or a stroke, and limits.
//!
//! Bare numbers are in SI units: lengths in metres, angles in radians. Poses, pairs, paths and limits are those of the crate that looks for the linkages.

mod schema;

use std::path::Path;

use cotree_synthesis::path::CouplerPath;
use cotree_synthesis::{DyadCondition, LinkageLimits, Pair, Point, Pose, Region, Zero, reach};

use crate::diagnostic::fault::{Fault, Faults, Sink};
use crate::diagnostic::span::{Source, Span, Text};
use crate::diagnostic::{degrees, metres};
use crate::files;
use crate::model::{Formula, ParameterId, Unit};
use crate::scene::constant::evaluate;
use crate::scene::decode::Fields;
use crate::scene::document::{self, Content, DocumentNode};
use crate::scene::expression::{self, SyntaxKind, SyntaxTree};
use crate::scene::key::{Key, names};
use crate::scene::{QuantityReading, Value, read};
use crate::sheet::{Sheet, SheetError};
use crate::typeset::number;
pub use schema::schema;

/// A task.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Its name.
    pub name: String,
    /// What is to be done.
    pub kind: TaskKind,
    /// What else is asked of a linkage.
    pub limits: Demands,
    /// What is chosen where the task leaves it free.
    pub choose: Choose,
    /// Its text, for faults.
    pub source: Source,
    /// Where what is to be done is written.
    pub span: Span,
    /// What is odd but not an error.
    pub warnings: Option<Faults>,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskKind {
    /// A body takes poses.
    Poses {
        /// The poses.
        at: Vec<Pose>,
        /// How near each pose is to be met \[m\], if not exactly.
        tolerance: Option<Vec<f64>>,
        /// How much each pose counts, if they are met nearly.
        weight: Option<Vec<f64>>,
    },
    /// An output follows an input.
    Function {
        /// Turns of the input and turns or ways of the output, from the first position.
        pairs: Vec<Pair>,
        /// Does a slider follow?
        is_slider: bool,
        /// The angles of both bars at the first position, as far as they are given.
        zero: Zero,
        /// The length of the ground of a four-bar \[m\].
        ground: f64,
    },
    /// A point follows a path.
    Path(CouplerPath),
    /// A swing of a rocker or a stroke of a slider during a turn of the crank.
    Stroke {
        /// \[rad\]
        crank_turn: f64,
        /// \[rad\], or \[m\] of a slider
        way: f64,
        /// Is it a slider?
        is_slider: bool,
        /// Of the slider's line from the crank's pivot \[m\].
        offset: Option<f64>,
        /// The length of the ground of a four-bar \[m\].
        ground: f64,
    },
}

/// What else is asked of a linkage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demands {
    /// Bounds on the linkage itself.
    pub linkage: LinkageLimits,
    /// An error that is small enough \[m or rad\]: what is preferred then decides.
    pub within: Option<f64>,
    /// What is preferred of linkages that meet the task so well.
    pub prefer: Preference,
    /// How many bars a linkage has: four, six for those too.
    pub bars: Option<usize>,
}

/// What is preferred of linkages whose error is small enough.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preference {
    /// A small linkage.
    #[default]
    Size,
    /// A large transmission angle.
    Transmission,
}

/// Pins that are chosen, of the first and of the second bar \[m\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choose {
    /// Pins in the ground.
    pub ground: [Option<Point>; 2],
    /// Pins in the body, in its frame.
    pub moving: [Option<Point>; 2],
    /// Lines `x = value` or `y = value` on which a pin is, for four poses.
    pub lines: Vec<DyadCondition>,
}

/// The largest task file \[bytes\].
const LARGEST: u64 = 16 << 20;
const KINDS: [&str; 4] = ["poses", "function", "path", "stroke"];
const TOP: [&str; 9] = ["$schema", "name", "description", "poses", "function", "path", "stroke", "limits", "choose"];
/// What is written in each table.
const POSES: &[TaskKey] = &[
    Key::required(
        "at",
        ValueForm::Poses,
        "[x, y, angle] of each pose [m, rad], or a CSV file with the columns x, y, angle, and perhaps tolerance and weight",
        "write `at = [[x, y, angle], ...]`, or the name of a CSV file",
    ),
    Key::optional("tolerance", ValueForm::Each, "tolerance of the poses [m], for all or for each"),
    Key::optional("weight", ValueForm::Each, "weight of the poses, for all or for each"),
];
const FUNCTION: &[TaskKey] = &[
    Key::required(
        "input",
        ValueForm::Numbers,
        "angles of the input from the first position [rad]; for a law its first and last value",
        "write turns of the input: `input = [0, 0.4, ...]`",
    ),
    Key::required(
        "output",
        ValueForm::NumbersOrLaw,
        "angles [rad] or displacements [m] of the output from the first position, or a law of x",
        "write turns of the output, or a law such as \"x^1.5\"",
    ),
    Key::optional("x", ValueForm::Pair, "first and last x of the law"),
    Key::optional("range", ValueForm::Pair, "first and last value of the output for the law [rad or m]"),
    Key::optional("input_zero", ValueForm::Number, "the angle of the input bar at the first position [rad]"),
    Key::optional("output_zero", ValueForm::Number, "the angle of the output bar at the first position [rad]"),
    Key::optional("ground", ValueForm::Number, "the length of the ground [m]; 1 m if absent"),
];
const PATH: &[TaskKey] = &[
    Key::required(
        "points",
        ValueForm::PointsOrTable,
        "[x, y] of each point [m], or a CSV file with the columns x, y, and perhaps crank",
        "write `points = [[x, y], ...]`, or the name of a CSV file",
    ),
    Key::optional(
        "closed",
        ValueForm::Flag,
        "whether the curve is closed: the last point is next to the first; false if absent",
    ),
    Key::optional("crank", ValueForm::Numbers, "the turn of the crank at each point from the first one on [rad]"),
    Key::optional("pivots", ValueForm::TwoPoints, "the pivots in the ground, if they are given [m]"),
];
const STROKE: &[TaskKey] = &[
    Key::optional("crank_turn", ValueForm::Number, "angle of the crank during the forward stroke [rad]"),
    Key::optional(
        "time_ratio",
        ValueForm::Number,
        "time ratio: time of the forward stroke per time of the return stroke",
    ),
    Key::optional("swing", ValueForm::Number, "angle of swing of a rocker [rad]"),
    Key::optional("stroke", ValueForm::Number, "stroke of a slider [m]"),
    Key::optional("offset", ValueForm::Number, "distance of the line of the slider from the pivot of the crank [m]"),
    Key::optional("ground", ValueForm::Number, "the length of the ground [m]; 1 m if absent"),
];
const LIMITS: &[TaskKey] = &[
    Key::optional("ground", ValueForm::Area, "where pins in the ground may be: a box or the corners of a polygon [m]"),
    Key::optional("moving", ValueForm::Area, "where pins in the body may be, in its frame [m]"),
    Key::optional(
        "length",
        ValueForm::Pair,
        "length of the shortest bar, and largest distance of two points of a link, the point that draws a path included [m]",
    ),
    Key::optional(
        "transmission",
        ValueForm::Number,
        "minimum transmission angle over the part of the motion that is used [rad]",
    ),
    Key::optional("crank", ValueForm::Flag, "whether the input must turn fully; false if absent"),
    Key::optional(
        "within",
        ValueForm::Number,
        "largest accepted error of a path or function [m or rad]; `prefer` ranks the linkages that meet it",
    ),
    Key::optional(
        "bars",
        ValueForm::Bars,
        "6: six-bars too; if absent, only where `within` is given and no four-bar is so accurate. For paths, poses and functions",
    ),
    Key::optional(
        "prefer",
        ValueForm::Preference,
        "with `within`: \"size\" (the smallest linkage; if absent) or \"transmission\"",
    ),
];
const CHOOSE: &[TaskKey] = &[
    Key::optional("ground_a", ValueForm::Point, "a pin in the ground, of the first bar [m]"),
    Key::optional("ground_b", ValueForm::Point, "a pin in the ground, of the second bar [m]"),
    Key::optional("moving_a", ValueForm::Point, "a pin in the body, of the first bar [m]"),
    Key::optional("moving_b", ValueForm::Point, "a pin in the body, of the second bar [m]"),
    Key::optional("ground_x", ValueForm::Number, "a line x = ... for a pin in the ground, for four poses [m]"),
    Key::optional("ground_y", ValueForm::Number, "a line y = ... for a pin in the ground, for four poses [m]"),
    Key::optional("moving_x", ValueForm::Number, "a line x = ... for a pin in the body, for four poses [m]"),
    Key::optional("moving_y", ValueForm::Number, "a line y = ... for a pin in the body, for four poses [m]"),
];

/// A key of a task.
type TaskKey = Key<ValueForm>;

/// How a value is written.
#[derive(Clone, Copy)]
enum ValueForm {
    Number,
    Numbers,
    /// A number for all, or one for each.
    Each,
    Pair,
    NumbersOrLaw,
    Flag,
    Preference,
    Bars,
    Point,
    TwoPoints,
    PointsOrTable,
    Poses,
    Area,
}

/// Points of a law that are looked at.
const LAW: usize = 25;

impl Task {
    /// Reads a task file: TOML, or JSON if it begins with `{`.
    ///
    /// # Errors
    /// A file that cannot be read, and everything that is wrong with the task.
    pub fn read(path: &Path) -> Result<Task, Faults> {
        let name = path.display().to_string();
        let alone = |fault| Faults::new(Source::new(name.clone(), ""), vec![fault]);
        let bytes = files::read(path, LARGEST).map_err(|error| {
            let message = format!("`{name}` cannot be read: {error}");
            alone(Fault::new("scene::unreadable", message, Span::default()))
        })?;
        let text = crate::scene::decode::text(path, bytes).map_err(alone)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Task::from_source(Source::new(name.clone(), text), folder)
    }

    /// Reads a task from a text; tables that it names are in the working folder.
    ///
    /// # Errors
    /// Everything that is wrong with the task.
    pub fn from_text(text: &str) -> Result<Task, Faults> {
        Task::from_source(Source::new("", text), Path::new(""))
    }

    fn from_source(source: Source, folder: &Path) -> Result<Task, Faults> {
        let mut faults = Sink::default();
        let text = source.own_text().to_owned();
        let document = if text.trim_start().starts_with('{') {
            document::from_json(&text, &mut faults)
        } else {
            document::from_toml(&text, &TOP, &mut faults)
        };
        let task = document
            .and_then(|document| TaskReader { faults: &mut faults, folder, suspected: None }.task(&document, &source));
        let (has_errors, faults) = (faults.has_errors(), faults.into_faults(source));
        match task {
            Some(task) if !has_errors => Ok(Task { warnings: (!faults.is_empty()).then_some(faults), ..task }),
            _ => Err(faults),
        }
    }

    /// Are its errors angles? Else they are lengths.
    pub fn is_angular(&self) -> bool {
        matches!(self.kind, TaskKind::Function { is_slider: false, .. })
    }

    /// A fault of the task as a whole.
    pub fn fault(&self, message: &str, help: &str) -> Faults {
        let fault = Fault::new("scene::wrong_value", message, self.span).help(help);
        Faults::new(self.source.clone(), vec![fault])
    }
}

struct TaskReader<'f> {
    faults: &'f mut Sink,
    /// Where tables are.
    folder: &'f Path,
    /// The last numbers of which it was said that they look like degrees or millimetres: those of a list are one warning.
    suspected: Option<String>,
}

/// Points of a table, and the angles of the crank beside them if it has any.
type Tabled = (Vec<Point>, Option<Vec<f64>>);

impl TaskReader<'_> {
    fn task(&mut self, document: &DocumentNode, source: &Source) -> Option<Task> {
        self.is_not_a_scene(document)?;
        let top = Fields::open(document, "the task", Span::new(0, 0), &TOP, self.faults)?;
        let name = top.get("name").and_then(|node| self.faults.text(node, "`name`"));
        let there: Vec<&str> = KINDS.into_iter().filter(|kind| top.get(kind).is_some()).collect();
        let &[kind] = &there[..] else {
            let list: Vec<String> = there.iter().map(|kind| format!("`[{kind}]`")).collect();
            let (message, span) = match there.get(1) {
                None => (
                    "the task has no table `[poses]`, `[function]`, `[path]` or `[stroke]`".to_owned(),
                    Span::default(),
                ),
                Some(second) => {
                    let message =
                        format!("a task has one kind, but {} tables are written: {}", list.len(), list.join(", "));
                    (message, top.key_span(second).unwrap_or_default())
                }
            };
            let help = if there.is_empty() {
                "write one of them, such as `[path]` with `points = [[x, y], ...]`"
            } else {
                "keep one of them, and write a file for each of the others"
            };
            self.faults.push(Fault::new("scene::wrong_value", message, span).help(help));
            return None;
        };
        let (node, span) = (top.get(kind)?, top.key_span(kind).unwrap_or_default());
        let read = match kind {
            "poses" => self.poses(node, span),
            "function" => self.function(node, span),
            "path" => self.path(node, span),
            _ => self.stroke(node, span),
        };
        let mut limits = top.get("limits").map(|node| self.limits(node, read.as_ref())).unwrap_or_default();
        if let Some(TaskKind::Path(path)) = &read {
            limits.linkage.tracer = true;
            self.is_within_reach(node, path, limits.linkage.length)?;
        }
        let choose = top.get("choose").map(|node| self.choose(node)).unwrap_or_default();
        let is_free = match &read {
            Some(TaskKind::Poses { at, tolerance, weight }) => at.len() <= 4 && tolerance.is_none() && weight.is_none(),
            Some(TaskKind::Function { .. } | TaskKind::Path(_) | TaskKind::Stroke { .. }) => false,
            None => true,
        };
        if !is_free {
            self.without(&top, &["choose"], "this task: it fixes what two to four exact poses leave free")?;
        }
        let name = name.map_or_else(|| kind.to_owned(), |name| name.text);
        Some(Task { name, kind: read?, limits, choose, source: source.clone(), span, warnings: None })
    }

    /// Tables of scenes do not stand in tasks.
    fn is_not_a_scene(&mut self, document: &DocumentNode) -> Option<()> {
        let Content::Table(entries) = &document.kind else { return Some(()) };
        let of_scene = |name: &str| ["format", "bodies", "joints", "gravity", "ground"].contains(&name);
        let Some((key, _)) = entries.iter().find(|(key, _)| of_scene(&key.text)) else { return Some(()) };
        let message = format!("this is a scene, not a task: it has the key `{}`", key.text);
        let help = "a task has one table `[poses]`, `[function]`, `[path]` or `[stroke]`; `cotree check` and `cotree simulate` take scenes";
        self.faults.push(Fault::new("scene::wrong_value", message, key.span).help(help));
        None
    }

    fn wrong<T>(&mut self, node: &DocumentNode, message: String, help: &str) -> Option<T> {
        self.faults.push(Fault::new("scene::wrong_value", message, node.span).help(help));
        None
    }

    /// Keys that would have no effect are refused.
    fn without(&mut self, fields: &Fields<'_>, keys: &[&str], other: &str) -> Option<()> {
        let written: Vec<(&str, &DocumentNode)> =
            keys.iter().filter_map(|key| Some((*key, fields.get(key)?))).collect();
        for (key, node) in &written {
            let message = format!("{} has no effect on {other}", fields.name_of(key));
            self.faults.push(Fault::new("scene::wrong_value", message, node.span).help("leave it out"));
        }
        written.is_empty().then_some(())
    }

    /// The value of a key of the table that must be there.
    fn required<'n>(&mut self, fields: &Fields<'n>, keys: &[TaskKey], name: &str) -> Option<&'n DocumentNode> {
        let key = keys.iter().find(|key| key.name == name)?;
        fields.required(name, key.help(), self.faults)
    }

    fn number(&mut self, node: &DocumentNode, what: &str, unit: &Unit) -> Option<f64> {
        let quantity = self.faults.quantity(node, what)?;
        let text = match quantity.value {
            Value::Number(number) => {
                self.suspect_unit(node, what, number, unit);
                return Some(number);
            }
            Value::Text(text) => Text::new(text, node.span),
        };
        let wanted = format!("a number in {}, alone or with its unit", unit.si);
        match read(&text) {
            Err(fault) => {
                self.faults.push(fault);
                None
            }
            Ok(QuantityReading::Number(number)) => {
                self.suspect_unit(node, what, number, unit);
                Some(number)
            }
            Ok(QuantityReading::Measure(number, given)) if given.exponents == unit.exponents => Some(number),
            Ok(QuantityReading::Measure(..)) => {
                self.wrong(node, format!("{what} is not in {}", unit.si), &format!("write {wanted}"))
            }
            Ok(QuantityReading::Expression) => {
                self.wrong(node, format!("{what} is not a number"), &format!("write {wanted}"))
            }
        }
    }

    /// Warns of a bare angle that is a usual number of degrees, and of a bare length that is too large for metres.
    fn suspect_unit(&mut self, node: &DocumentNode, what: &str, number: f64, unit: &Unit) {
        let warning = if unit.exponents == Unit::angle().exponents && degrees::is_usual(number) {
            degrees::warning(what, number, node.span)
        } else if unit.exponents == Unit::length().exponents && metres::is_unusual(number) {
            metres::warning(what, number, node.span)
        } else {
            return;
        };
        if self.suspected.as_deref() != Some(what) {
            self.faults.push(warning);
            self.suspected = Some(what.to_owned());
        }
    }

    fn items<'n>(&mut self, node: &'n DocumentNode, what: &str) -> Option<&'n [DocumentNode]> {
        match &node.kind {
            Content::Array(items) => Some(&items[..]),
            other => {
                self.wrong(node, format!("{what} is {}, but must be a list", other.name()), "write a list in brackets")
            }
        }
    }

    fn numbers(&mut self, node: &DocumentNode, what: &str, unit: &Unit) -> Option<Vec<f64>> {
        let items = self.items(node, what)?;
        let numbers: Vec<Option<f64>> = items.iter().map(|item| self.number(item, what, unit)).collect();
        numbers.into_iter().collect()
    }

    fn point(&mut self, node: &DocumentNode, what: &str) -> Option<Point> {
        let numbers = self.numbers(node, what, &Unit::length())?;
        let &[x, y] = &numbers[..] else {
            let message = format!("{what} has {} numbers, but must have two", numbers.len());
            return self.wrong(node, message, "write `[x, y]`");
        };
        Some(Point::new(x, y))
    }

    fn points(&mut self, node: &DocumentNode, what: &str) -> Option<Vec<Point>> {
        let items = self.items(node, what)?;
        let points: Vec<Option<Point>> = items.iter().map(|item| self.point(item, what)).collect();
        points.into_iter().collect()
    }

    fn range(&mut self, node: &DocumentNode, what: &str, unit: &Unit) -> Option<[f64; 2]> {
        let numbers = self.numbers(node, what, unit)?;
        match numbers[..] {
            [low, high] if low <= high => Some([low, high]),
            [_, _] => self.wrong(
                node,
                format!("{what} is empty: its lower bound is above the upper one"),
                "write the lower bound first",
            ),
            _ => self.wrong(
                node,
                format!("{what} has {} numbers, but must have two", numbers.len()),
                "write `[lower, upper]`",
            ),
        }
    }

    /// A number for each of `count`, where one stands for all.
    fn each(&mut self, node: &DocumentNode, what: &str, unit: &Unit, count: usize) -> Option<Vec<f64>> {
        if !matches!(node.kind, Content::Array(_)) {
            return self.number(node, what, unit).map(|number| vec![number; count]);
        }
        let numbers = self.numbers(node, what, unit)?;
        self.count(node, what, numbers, count)
    }

    fn count(&mut self, node: &DocumentNode, what: &str, numbers: Vec<f64>, count: usize) -> Option<Vec<f64>> {
        if numbers.len() == count {
            return Some(numbers);
        }
        let found = numbers.len();
        self.wrong(node, format!("{what} has {found} numbers, but must have {count}"), "write one number for each")
    }

    fn above_zero(&mut self, node: &DocumentNode, what: &str, numbers: &[f64]) -> Option<()> {
        let wrong = numbers.iter().find(|number| !(**number > 0.0 && number.is_finite()));
        let Some(wrong) = wrong else { return Some(()) };
        let message = format!("{what} is {}, but must be positive", number(*wrong, 1e-9 * wrong.abs()));
        self.wrong(node, message, "remove it, or write a positive number")
    }

    fn poses(&mut self, node: &DocumentNode, span: Span) -> Option<TaskKind> {
        let fields = Fields::open(node, "`poses`", span, &names(POSES), self.faults)?;
        let at = self.required(&fields, POSES, "at")?;
        let (poses, [of_table, weights]) = match at.kind {
            Content::Text(_) => self.tabled_poses(&fields, at)?,
            _ => (self.listed_poses(at)?, [None, None]),
        };
        if poses.len() < 2 {
            return self.wrong(at, format!("a task needs at least two poses, but has {}", poses.len()), "add poses");
        }
        let mut list = |key: &str, unit: &Unit| match fields.get(key) {
            None => Some(None),
            Some(node) => {
                let what = format!("`{key}`");
                let numbers = self.each(node, &what, unit, poses.len())?;
                self.above_zero(node, &what, &numbers)?;
                Some(Some(numbers))
            }
        };
        let tolerance = list("tolerance", &Unit::length())?.or(of_table);
        let weight = list("weight", &Unit::default())?.or(weights);
        Some(TaskKind::Poses { at: poses, tolerance, weight })
    }

    fn listed_poses(&mut self, at: &DocumentNode) -> Option<Vec<Pose>> {
        let mut poses = Vec::new();
        for item in self.items(at, "`at`")? {
            let parts = self.items(item, "a pose")?;
            let [x, y, angle] = parts else {
                let message = format!("a pose has {} numbers, but must have three", parts.len());
                return self.wrong(item, message, "write `[x, y, angle]`");
            };
            let place = [x, y].map(|part| self.number(part, "a place of a pose", &Unit::length()));
            let angle = self.number(angle, "the angle of a pose", &Unit::angle());
            poses.push(Pose::new(place[0]?, place[1]?, angle?));
        }
        Some(poses)
    }

    /// The poses of a table, with its tolerances and weights.
    fn tabled_poses(&mut self, fields: &Fields<'_>, at: &DocumentNode) -> Option<TabledPoses> {
        let (length, angle, plain) = (Unit::length(), Unit::angle(), Unit::default());
        let columns = [
            ExpectedColumn { name: "x", unit: length.clone(), is_needed: true },
            ExpectedColumn { name: "y", unit: length.clone(), is_needed: true },
            ExpectedColumn { name: "angle", unit: angle, is_needed: true },
            ExpectedColumn { name: "tolerance", unit: length, is_needed: false },
            ExpectedColumn { name: "weight", unit: plain, is_needed: false },
        ];
        let [x, y, angle, tolerance, weight] = self.table(at, columns)?;
        for (key, column) in [("tolerance", &tolerance), ("weight", &weight)] {
            let Some(numbers) = column else { continue };
            self.without(fields, &[key], "poses whose table has it")?;
            self.above_zero(at, &format!("`{key}` of the table"), numbers)?;
        }
        let poses = x?.into_iter().zip(y?).zip(angle?).map(|((x, y), angle)| Pose::new(x, y, angle));
        Some((poses.collect(), [tolerance, weight]))
    }

    /// The columns of a CSV file that is named instead of numbers.
    fn table<const N: usize>(
        &mut self,
        node: &DocumentNode,
        columns: [ExpectedColumn; N],
    ) -> Option<[Option<Vec<f64>>; N]> {
        let path = self.folder.join(node.text()?.text);
        let bytes = files::read(&path, LARGEST).map_err(|error| error.to_string());
        let text = bytes.and_then(|bytes| String::from_utf8(bytes).map_err(|_| "it is not a text".to_owned()));
        let found = text.and_then(|text| tabled(&text, &columns).map_err(|error| error.to_string()));
        match found {
            Ok((found, bare)) => {
                for (index, column) in columns.iter().enumerate().filter(|(index, _)| bare[*index]) {
                    let of = |unit: Unit| found[index].as_deref().filter(|_| column.unit.exponents == unit.exponents);
                    let what = format!("`{}` of `{}`", column.name, path.display());
                    if let Some(angle) = of(Unit::angle()).and_then(degrees::among) {
                        self.faults.push(degrees::of_column(&what, column.name, angle, node.span));
                    }
                    if let Some(length) = of(Unit::length()).and_then(metres::among) {
                        self.faults.push(metres::of_column(&what, column.name, length, node.span));
                    }
                }
                Some(found)
            }
            Err(message) => {
                let known: Vec<&str> = columns.iter().map(|column| column.name).collect();
                let help = format!("write a CSV file with the columns {}", known.join(", "));
                self.wrong(node, format!("`{}`: {message}", path.display()), &help)
            }
        }
    }

    fn optional(&mut self, fields: &Fields<'_>, key: &str, unit: &Unit) -> Option<Option<f64>> {
        match fields.get(key) {
            None => Some(None),
            Some(node) => self.number(node, &fields.name_of(key), unit).map(Some),
        }
    }

    fn ground(&mut self, fields: &Fields<'_>) -> Option<f64> {
        let ground = self.optional(fields, "ground", &Unit::length())?;
        if let (Some(length), Some(node)) = (ground, fields.get("ground")) {
            self.above_zero(node, "`ground`", &[length])?;
        }
        Some(ground.unwrap_or(1.0))
    }

    fn function(&mut self, node: &DocumentNode, span: Span) -> Option<TaskKind> {
        let fields = Fields::open(node, "`function`", span, &names(FUNCTION), self.faults)?;
        let input = self.required(&fields, FUNCTION, "input")?;
        let output = self.required(&fields, FUNCTION, "output")?;
        let ground = self.ground(&fields)?;
        let zero = Zero {
            input: self.optional(&fields, "input_zero", &Unit::angle())?,
            output: self.optional(&fields, "output_zero", &Unit::angle())?,
        };
        if let Content::Text(_) = output.kind {
            let (pairs, is_slider) = self.law(&fields, input, output)?;
            self.of_slider(&fields, is_slider)?;
            return Some(TaskKind::Function { pairs, is_slider, zero, ground });
        }
        self.without(&fields, &["x", "range"], "outputs that are numbers")?;
        let turns = self.numbers(input, "`input`", &Unit::angle())?;
        let (ways, is_slider) = self.ways(output, "`output`")?;
        let ways = self.count(output, "`output`", ways, turns.len())?;
        self.of_slider(&fields, is_slider)?;
        Some(TaskKind::Function { pairs: turns.into_iter().zip(ways).map(pair).collect(), is_slider, zero, ground })
    }

    fn of_slider(&mut self, fields: &Fields<'_>, is_slider: bool) -> Option<()> {
        let keys: &[&str] = if is_slider { &["ground", "output_zero"] } else { &[] };
        self.without(fields, keys, "a slider")
    }

    /// Lengths if one of them has a unit of length, else angles.
    fn ways(&mut self, node: &DocumentNode, what: &str) -> Option<(Vec<f64>, bool)> {
        let items = self.items(node, what)?;
        let is_slider = items.iter().any(is_length);
        let unit = if is_slider { Unit::length() } else { Unit::angle() };
        Some((self.numbers(node, what, &unit)?, is_slider))
    }

    /// `output = "x^1.5"`, `x = [1, 4]`, `input = ["0 deg", "90 deg"]`, `range = ["0 deg", "90 deg"]`: turns of input and output from the first position.
    fn law(&mut self, fields: &Fields<'_>, input: &DocumentNode, output: &DocumentNode) -> Option<(Vec<Pair>, bool)> {
        let x = fields.required("x", "write first and last x of the law: `x = [1, 4]`", self.faults)?;
        let range =
            fields.required("range", "give the range of the output: `range = [\"0 deg\", \"90 deg\"]`", self.faults)?;
        let plain = Unit::default();
        let ends = self.numbers(x, "`x`", &plain)?;
        let turn = self.numbers(input, "`input`", &Unit::angle())?;
        let (ways, is_slider) = self.ways(range, "`range`")?;
        let (&[x0, x1], &[from, to], &[low, high]) = (&ends[..], &turn[..], &ways[..]) else {
            return self.wrong(
                output,
                "a law needs two numbers for each of `x`, `input` and `range`".to_owned(),
                "write `[first, last]`",
            );
        };
        let text = output.text()?;
        let tree = match expression::parse(&text) {
            Ok(tree) => tree,
            Err(fault) => {
                self.faults.push(fault);
                return None;
            }
        };
        let Some(formula) = formula(&tree) else {
            return self.wrong(
                output,
                "the law uses names other than x".to_owned(),
                "write a formula of x, such as \"x^1.5\"",
            );
        };
        let share = |i: usize| i as f64 / (LAW - 1) as f64;
        let values: Vec<f64> = (0..LAW).map(|i| evaluate(&formula, &[x0 + (x1 - x0) * share(i)])).collect();
        let (first, last) = (values[0], values[LAW - 1]);
        if values.iter().any(|value| !value.is_finite()) || first == last {
            return self.wrong(
                output,
                "the law has no finite value somewhere, or equal values at both ends".to_owned(),
                "change `x`",
            );
        }
        let inputs = (0..LAW).map(|i| (to - from) * share(i));
        let outputs = values.iter().map(|value| (high - low) * (value - first) / (last - first));
        Some((inputs.zip(outputs).map(pair).collect(), is_slider))
    }

    fn path(&mut self, node: &DocumentNode, span: Span) -> Option<TaskKind> {
        let fields = Fields::open(node, "`path`", span, &names(PATH), self.faults)?;
        let points = self.required(&fields, PATH, "points")?;
        let (mut list, turns) = match points.kind {
            Content::Text(_) => self.tabled_points(&fields, points)?,
            _ => (self.points(points, "`points`")?, None),
        };
        let closed = match fields.get("closed") {
            Some(node) => self.faults.boolean(node, "`closed`")?,
            None => false,
        };
        if closed && list.len() > 3 && list.first() == list.last() {
            list.pop();
        }
        if list.len() < 3 {
            return self.wrong(
                points,
                format!("a path needs at least three points, but has {}", list.len()),
                "add points",
            );
        }
        let turns = match fields.get("crank") {
            None => turns,
            Some(node) => {
                let numbers = self.numbers(node, "`crank`", &Unit::angle())?;
                Some(self.count(node, "`crank`", numbers, list.len())?)
            }
        };
        let from_first = |turns: Vec<f64>| -> Vec<f64> {
            let first = turns.first().copied().unwrap_or(0.0);
            turns.into_iter().take(list.len()).map(|turn| turn - first).collect()
        };
        let crank = turns.map(from_first);
        let pivots = match fields.get("pivots") {
            None => None,
            Some(node) => {
                let found = self.points(node, "`pivots`")?;
                let count = found.len();
                let pair: Option<[Point; 2]> = found.try_into().ok();
                match pair {
                    Some(pair) => Some(pair),
                    None => {
                        return self.wrong(
                            node,
                            format!("`pivots` has {count} points, but must have two"),
                            "write `[[x, y], [x, y]]`",
                        );
                    }
                }
            }
        };
        Some(TaskKind::Path(CouplerPath { points: list, closed, crank, pivots }))
    }

    /// The points of a table, with its turns of the crank.
    fn tabled_points(&mut self, fields: &Fields<'_>, points: &DocumentNode) -> Option<Tabled> {
        let columns = [
            ExpectedColumn { name: "x", unit: Unit::length(), is_needed: true },
            ExpectedColumn { name: "y", unit: Unit::length(), is_needed: true },
            ExpectedColumn { name: "crank", unit: Unit::angle(), is_needed: false },
        ];
        let [x, y, crank] = self.table(points, columns)?;
        if crank.is_some() {
            self.without(fields, &["crank"], "points whose table has it")?;
        }
        Some((x?.into_iter().zip(y?).map(|(x, y)| Point::new(x, y)).collect(), crank))
    }

    fn stroke(&mut self, node: &DocumentNode, span: Span) -> Option<TaskKind> {
        let fields = Fields::open(node, "`stroke`", span, &names(STROKE), self.faults)?;
        let turn = self.optional(&fields, "crank_turn", &Unit::angle())?;
        let plain = Unit::default();
        let ratio = self.optional(&fields, "time_ratio", &plain)?;
        let swing = self.optional(&fields, "swing", &Unit::angle())?;
        let stroke = self.optional(&fields, "stroke", &Unit::length())?;
        let offset = self.optional(&fields, "offset", &Unit::length())?;
        let ground = self.ground(&fields)?;
        let half = std::f64::consts::PI;
        let bounded = [("crank_turn", turn, 2.0 * half), ("swing", swing, half)];
        let checked = bounded.map(|(key, angle, most)| {
            let Some(angle) = angle.filter(|angle| !(*angle > 0.0 && *angle < most)) else { return Some(()) };
            let given = number(angle.to_degrees(), 1e-9 * angle.to_degrees().abs().max(1.0));
            let message = format!("`{key}` is {given} deg, but must be between 0 and {} deg", most.to_degrees());
            self.wrong(fields.get(key)?, message, &format!("write, for example, `{key} = \"40 deg\"`"))
        });
        checked.into_iter().collect::<Option<Vec<()>>>()?;
        for (key, value) in [("time_ratio", ratio), ("stroke", stroke)] {
            if let (Some(value), Some(node)) = (value, fields.get(key)) {
                self.above_zero(node, &format!("`{key}`"), &[value])?;
            }
        }
        let turn = match (turn, ratio) {
            (Some(turn), None) => turn,
            (None, Some(ratio)) => 2.0 * half * ratio / (1.0 + ratio),
            _ => {
                return self.wrong(
                    node,
                    "a stroke has either a `crank_turn` or a `time_ratio`".to_owned(),
                    "write one of them, positive",
                );
            }
        };
        match (swing, stroke) {
            (Some(way), None) => {
                self.without(&fields, &["offset"], "a swing")?;
                Some(TaskKind::Stroke { crank_turn: turn, way, is_slider: false, offset, ground })
            }
            (None, Some(way)) => {
                self.without(&fields, &["ground"], "a slider")?;
                Some(TaskKind::Stroke { crank_turn: turn, way, is_slider: true, offset, ground })
            }
            _ => self.wrong(
                node,
                "a stroke has either a `swing` or a `stroke`".to_owned(),
                "write `swing`, the angle of a rocker, or `stroke`, the displacement of a slider",
            ),
        }
    }

    fn region(&mut self, fields: &Fields<'_>, key: &str) -> Option<Region> {
        let node = fields.get(key)?;
        let what = fields.name_of(key);
        if let Content::Array(_) = node.kind {
            let corners = self.points(node, &what)?;
            if corners.len() < 3 {
                return self.wrong(
                    node,
                    format!("{what} is not a polygon: it has {} corners", corners.len()),
                    "write at least three corners",
                );
            }
            return Some(Region::Polygon(corners));
        }
        let sides = Fields::open(node, &what, node.span, &["x", "y"], self.faults)?;
        let mut side = |key: &str| match sides.get(key) {
            Some(node) => self.range(node, &sides.name_of(key), &Unit::length()),
            None => Some([f64::NEG_INFINITY, f64::INFINITY]),
        };
        let ([left, right], [bottom, top]) = (side("x")?, side("y")?);
        Some(Region::Box(Point::new(left, bottom), Point::new(right, top)))
    }

    /// A point of a link is within two sizes of the linkage from the crank's pivot, so that its curve is at most four sizes long.
    fn is_within_reach(&mut self, node: &DocumentNode, path: &CouplerPath, length: Option<[f64; 2]>) -> Option<()> {
        let (long, [_, most]) = (reach(&path.points), length.unwrap_or([0.0, f64::INFINITY]));
        if long <= 4.0 * most {
            return Some(());
        }
        let points = match &node.kind {
            Content::Table(entries) => entries.iter().find(|(key, _)| key.text == "points").map(|(_, points)| points),
            _ => None,
        };
        let bare = points.and_then(bare_number);
        let message = format!(
            "the path is {} m long, but no link may be longer than {} m (`length` of `[limits]`)",
            number(long, 0.0),
            number(most, 0.0)
        );
        let help = match bare {
            Some(bare) => format!(
                "numbers without a unit are in metres: for millimetres write `\"{bare} mm\"` instead of `{bare}`"
            ),
            None => "make `length` longer".to_owned(),
        };
        self.wrong(points.unwrap_or(node), message, &help)
    }

    fn limits(&mut self, node: &DocumentNode, kind: Option<&TaskKind>) -> Demands {
        let Some(fields) = Fields::open(node, "`limits`", node.span, &names(LIMITS), self.faults) else {
            return Demands::default();
        };
        let length = fields.get("length").and_then(|node| self.range(node, "`length`", &Unit::length()));
        let transmission = fields.get("transmission").and_then(|node| {
            let angle = self.number(node, "`transmission`", &Unit::angle())?;
            if (0.0..std::f64::consts::FRAC_PI_2).contains(&angle) {
                return Some(angle);
            }
            self.wrong(
                node,
                "a transmission angle must be from 0 to below 90 degrees".to_owned(),
                "write a smaller one, such as \"35 deg\"",
            )
        });
        let crank = fields.get("crank").and_then(|node| self.faults.boolean(node, "`crank`")).unwrap_or(false);
        let [ground, moving] = ["ground", "moving"].map(|key| self.region(&fields, key));
        let within = fields.get("within").and_then(|node| self.within(node, kind));
        let prefer = fields.get("prefer").and_then(|node| self.preference(node)).unwrap_or_default();
        if let (None, Some(_)) = (fields.get("within"), fields.get("prefer")) {
            let _ = self.without(&fields, &["prefer"], "a task without `within`");
        }
        let bars = fields.get("bars").and_then(|node| self.bars(node, kind));
        let linkage = LinkageLimits { ground, moving, length, transmission, crank, ..LinkageLimits::default() };
        Demands { linkage, within, prefer, bars }
    }

    /// The error that is accepted, in the unit of the task's errors.
    fn within(&mut self, node: &DocumentNode, kind: Option<&TaskKind>) -> Option<f64> {
        let unit = match kind? {
            TaskKind::Function { is_slider: false, .. } => Unit::angle(),
            TaskKind::Function { .. } | TaskKind::Path(_) => Unit::length(),
            TaskKind::Poses { .. } => {
                return self.wrong(
                    node,
                    "`within` has no effect on poses".to_owned(),
                    "remove it; give `tolerance` in `[poses]`",
                );
            }
            TaskKind::Stroke { .. } => {
                return self.wrong(
                    node,
                    "`within` has no effect on a stroke, which is met exactly".to_owned(),
                    "leave it out",
                );
            }
        };
        let error = self.number(node, "`within`", &unit)?;
        self.above_zero(node, "`within`", &[error])?;
        Some(error)
    }

    fn bars(&mut self, node: &DocumentNode, kind: Option<&TaskKind>) -> Option<usize> {
        let bars = self.number(node, "`bars`", &Unit::default())?;
        match kind? {
            _ if bars == 4.0 => Some(4),
            TaskKind::Path(_) | TaskKind::Function { is_slider: false, .. } | TaskKind::Poses { .. } if bars == 6.0 => {
                Some(6)
            }
            TaskKind::Path(_) | TaskKind::Function { is_slider: false, .. } | TaskKind::Poses { .. } => {
                let message = format!("`bars` is {}, but must be 4 or 6", number(bars, 0.0));
                self.wrong(node, message, "write `bars = 6` for six-bars too")
            }
            TaskKind::Function { .. } | TaskKind::Stroke { .. } => {
                let message =
                    "six-bars are found for paths, poses and functions of a rocker, not for this task".to_owned();
                self.wrong(node, message, "remove `bars`")
            }
        }
    }

    fn preference(&mut self, node: &DocumentNode) -> Option<Preference> {
        let text = self.faults.text(node, "`prefer`")?.text;
        match text.as_str() {
            "size" => Some(Preference::Size),
            "transmission" => Some(Preference::Transmission),
            other => self.wrong(
                node,
                format!("`prefer` is {other:?}, but must be \"size\" or \"transmission\""),
                "write `prefer = \"size\"` or `prefer = \"transmission\"`",
            ),
        }
    }

    fn choose(&mut self, node: &DocumentNode) -> Choose {
        let points = ["ground_a", "ground_b", "moving_a", "moving_b"];
        let Some(fields) = Fields::open(node, "`choose`", node.span, &names(CHOOSE), self.faults) else {
            return Choose::default();
        };
        let [a, b, c, d] = points.map(|key| fields.get(key).and_then(|node| self.point(node, &fields.name_of(key))));
        let mut line = |key: &str| self.number(fields.get(key)?, &fields.name_of(key), &Unit::length());
        let (x, y) = (Point::new(1.0, 0.0), Point::new(0.0, 1.0));
        let lines = [
            line("ground_x").map(|value| DyadCondition::Ground { direction: x, value }),
            line("ground_y").map(|value| DyadCondition::Ground { direction: y, value }),
            line("moving_x").map(|value| DyadCondition::Moving { direction: x, value }),
            line("moving_y").map(|value| DyadCondition::Moving { direction: y, value }),
        ];
        Choose { ground: [a, b], moving: [c, d], lines: lines.into_iter().flatten().collect() }
    }
}

/// The first number in a list of lists that is not zero and has no unit.
fn bare_number(node: &DocumentNode) -> Option<f64> {
    match &node.kind {
        Content::Array(items) => items.iter().find_map(bare_number),
        Content::Number(number) if *number != 0.0 => Some(*number),
        _ => None,
    }
}

fn pair((input, output): (f64, f64)) -> Pair {
    Pair { input, output }
}

fn is_length(node: &DocumentNode) -> bool {
    let Some(text) = node.text() else { return false };
    matches!(read(&text), Ok(QuantityReading::Measure(_, unit)) if unit.exponents == Unit::length().exponents)
}

/// An expression of x alone.
fn formula(tree: &SyntaxTree) -> Option<Formula> {
    let all = |parts: &[SyntaxTree]| parts.iter().map(formula).collect::<Option<Vec<Formula>>>();
    match &tree.kind {
        SyntaxKind::Number(number) | SyntaxKind::Measure(number, _) => Some(Formula::Number(*number)),
        SyntaxKind::Name(name) if name == "x" => Some(Formula::Parameter(ParameterId(0))),
        SyntaxKind::Name(name) if name == "pi" => Some(Formula::Number(std::f64::consts::PI)),
        SyntaxKind::Name(_) | SyntaxKind::New(_) | SyntaxKind::Table(..) => None,
        SyntaxKind::Call(function, arguments) => Some(Formula::Call(*function, all(arguments)?)),
        SyntaxKind::If(comparison, parts) => {
            let parts: [Formula; 4] = all(&parts[..])?.try_into().ok()?;
            Some(Formula::If(*comparison, Box::new(parts)))
        }
    }
}

/// A column of a table: its name, the unit of what it has, and whether it has to be there.
struct ExpectedColumn {
    name: &'static str,
    unit: Unit,
    is_needed: bool,
}

/// The numbers of each column in SI, as far as it is there, and whether its heading says no unit.
fn tabled<const N: usize>(text: &str, columns: &[ExpectedColumn; N]) -> Result<Columns<N>, SheetError> {
    let mut bare = [false; N];
    let sheet = Sheet::read(text)?;
    let mut found: [Option<Vec<f64>>; N] = std::array::from_fn(|_| None);
    for (place, heading) in sheet.headings().iter().enumerate() {
        let (name, said) = heading.read()?;
        let Some(index) = columns.iter().position(|column| column.name == name) else {
            return Err(heading.fault(format!("no task has a column `{name}`")));
        };
        let unit = &columns[index].unit;
        if said.as_ref().is_some_and(|said| said.exponents != unit.exponents) {
            let wanted = if unit.si.is_empty() { "a pure number".to_owned() } else { format!("in {}", unit.si) };
            return Err(heading.fault(format!("`{}` must be {wanted}", heading.text)));
        }
        if found[index].is_some() {
            return Err(heading.fault(format!("two columns are `{name}`")));
        }
        bare[index] = said.is_none();
        let factor = said.and_then(|said| said.display).map_or(1.0, |display| display.factor);
        let value = |row: usize| {
            sheet.has_cells(row, sheet.headings().len())?;
            Ok(sheet.number(row, place)? * factor)
        };
        found[index] = Some((0..sheet.rows()).map(value).collect::<Result<_, SheetError>>()?);
    }
    match columns.iter().zip(&found).find(|(column, found)| column.is_needed && found.is_none()) {
        Some((column, _)) => Err(SheetError::new(1, 1, format!("no column is `{}`", column.name))),
        None => Ok((found, bare)),
    }
}

type Columns<const N: usize> = ([Option<Vec<f64>>; N], [bool; N]);

/// Poses, and what their table has of tolerances and weights.
type TabledPoses = (Vec<Pose>, [Option<Vec<f64>>; 2]);
