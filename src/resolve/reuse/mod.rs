//! Scenes that are parts of others: a file is read, its names get the name of the part in front, and everything joins the scene that uses it. What
//! follows sees one scene, in which everything says whose text it is written in.

mod renamed;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use crate::diagnostic::fault::{Fault, Sink};
use crate::diagnostic::span::{Source, Text};
use crate::diagnostic::suggest;
use crate::files;
use crate::scene::Scene;
use crate::scene::decode::{is_json, text};
use crate::scene::model::{Point, Use, Within};

/// More parts are refused, or more elements of all of them: each file may use others twice, and so on.
const MOST_PARTS: usize = 10_000;
const MOST_ELEMENTS: usize = 1_000_000;

/// Puts the parts of a scene into it. False if one of them is missing.
pub(super) fn put_in(scene: &mut Scene, faults: &mut Sink) -> bool {
    if scene.uses.is_empty() {
        return true;
    }
    let path = PathBuf::from(&scene.source.name);
    let opened = path.canonicalize().into_iter().collect();
    let mut library =
        SceneLibrary { source: scene.source.clone(), faults, opened, known: HashMap::new(), parts: 0, elements: 0 };
    let complete = library.put_in(scene, &path);
    scene.source = library.source;
    complete
}

/// Gives the files of tables their paths from where the program runs: they are written as from the folder of the file that names them.
pub(super) fn find_files(scene: &mut Scene, path: &Path) {
    let folder = path.parent().unwrap_or(Path::new(""));
    renamed::with_files(scene, &mut |file| folder.join(file).display().to_string());
}

/// The files of tables that a scene uses.
pub(super) fn files_of_tables(scene: &mut Scene) -> Vec<String> {
    let mut files: Vec<String> = Vec::new();
    renamed::with_files(scene, &mut |file| {
        if files.iter().all(|known| known != file) {
            files.push(file.to_owned());
        }
        file.to_owned()
    });
    files
}

/// The files that have been read.
struct SceneLibrary<'f> {
    source: Source,
    faults: &'f mut Sink,
    /// Those that are being put together, each used by the one before.
    opened: Vec<PathBuf>,
    /// Whole scenes, by their true paths; none if they could not be read.
    known: HashMap<PathBuf, Option<Scene>>,
    parts: usize,
    elements: usize,
}

impl SceneLibrary<'_> {
    fn put_in(&mut self, scene: &mut Scene, path: &Path) -> bool {
        renamed::with_underscores(scene);
        self.check_names(scene);
        let mut complete = true;
        for (index, used) in scene.uses.clone().iter().enumerate() {
            match self.read(used, path) {
                Some(part) if self.has_room(&part, used) => self.join(scene, part, index),
                _ => complete = false,
            }
        }
        complete
    }

    /// A part's name must not be that of an element: `left.arm` would be two things.
    fn check_names(&mut self, scene: &Scene) {
        let taken = renamed::names(scene);
        for used in &scene.uses {
            super::names::check_identifier(&used.name, "part", self.faults);
            if taken.contains(&used.name.text) {
                let message = format!("the name `{}` is used twice: for a part and for something else", used.name.text);
                self.faults.push(
                    Fault::new("scene::duplicate_name", message, used.name.span)
                        .label("a part")
                        .help("choose another name"),
                );
            }
        }
    }

    fn has_room(&mut self, part: &Scene, used: &Use) -> bool {
        self.parts += 1;
        self.elements += part.bodies.len() + part.joints.len() + part.drivers.len() + part.loads.len();
        let fits = self.parts <= MOST_PARTS && self.elements <= MOST_ELEMENTS;
        if !fits {
            let message = "the scene has too many nested parts";
            let fault = Fault::new("scene::too_large", message, used.file.span).label("one too many");
            self.faults.push(fault.help(format!("use at most {MOST_PARTS} parts with {MOST_ELEMENTS} elements")));
        }
        fits
    }

    /// The scene of a part's file, whole.
    fn read(&mut self, used: &Use, user: &Path) -> Option<Scene> {
        let path = user.parent().unwrap_or(Path::new("")).join(&used.file.text);
        let real = path.canonicalize().unwrap_or_else(|_| path.clone());
        if let Some(first) = self.opened.iter().position(|open| *open == real) {
            self.refuse_circle(used, first);
            return None;
        }
        if let Some(known) = self.known.get(&real) {
            return known.clone();
        }
        self.opened.push(real.clone());
        let part = self.read_anew(used, &path);
        self.opened.pop();
        self.known.insert(real, part.clone());
        part
    }

    fn read_anew(&mut self, used: &Use, path: &Path) -> Option<Scene> {
        let name = path.display().to_string();
        let unreadable = |message: String| {
            Fault::new("scene::unreadable", message, used.file.span)
                .label("this file")
                .help("check the path: it is relative to the folder of the file that names it")
        };
        let known = self.source.text_of(&name).map(|(text, start)| (text.to_owned(), start));
        let (text, start) = known.filter(|(text, _)| !text.is_empty()).or_else(|| {
            let bytes = files::read(path, Scene::LARGEST);
            let bytes = bytes.map_err(|error| unreadable(format!("`{name}` cannot be read: {error}")));
            let read = bytes.and_then(|bytes| {
                text(path, bytes).map_err(|fault| Fault { span: used.file.span, ..fault }.label("this file"))
            });
            // A file that is not there belongs to the scene all the same: who watches it waits for it.
            let start = self.source.append(&name, read.as_deref().unwrap_or_default());
            Some((read.map_err(|fault| self.faults.push(fault)).ok()?, start))
        })?;
        if !is_like_a_scene(&text) {
            // It may be any file of this machine: nothing of it is shown to whoever has sent the scene.
            let message = format!("`{name}` is not a scene: it has no bodies, joints, loads or other parts of one");
            let fault = Fault::new("scene::not_a_scene", message, used.file.span).label("this file");
            self.faults.push(fault.help("give the path of a scene file"));
            return None;
        }
        let mut part = Scene::decode(&text, is_json(path), start, true, self.faults)?;
        find_files(&mut part, path);
        self.put_in(&mut part, path).then_some(part)
    }

    fn refuse_circle(&mut self, used: &Use, first: usize) {
        let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut names: Vec<String> = self.opened[first..].iter().map(name).collect();
        names.extend(names.first().cloned());
        let message = format!("files include each other in a cycle: {}", names.join(" -> "));
        let fault = Fault::new("scene::cycle", message, used.file.span).label("part of the cycle");
        self.faults.push(fault.help("a file cannot be a part of itself"));
    }

    /// Adds a part to the scene, which uses it as the one with this index.
    fn join(&mut self, scene: &mut Scene, mut part: Scene, index: usize) {
        let used = scene.uses[index].clone();
        if part.dimension != scene.dimension {
            let message =
                format!("part `{}` and the scene that uses it have different values of `dimension`", used.name.text);
            let fault = Fault::new("scene::one_dimension", message, used.file.span).label("this file");
            self.faults.push(fault.help("give both the same"));
            return;
        }
        self.set_parameters(&mut part, &used);
        renamed::with_prefix(&mut part, &used.name.text);
        // Its own parts follow those of the scene.
        let further = scene.uses.len();
        part.belong(|within| if within == 0 { index + 1 } else { within + further });
        scene.uses[index].origin = origin(&mut part, &used, index + 1);
        if let Some(on) = &used.on {
            self.fix(scene, &mut part, index, on);
        }
        scene.uses.append(&mut part.uses);
        scene.parameters.append(&mut part.parameters);
        scene.inputs.append(&mut part.inputs);
        scene.states.append(&mut part.states);
        scene.sampled.append(&mut part.sampled);
        scene.events.append(&mut part.events);
        scene.signals.append(&mut part.signals);
        scene.ground.append(&mut part.ground);
        scene.ground_outlines.append(&mut part.ground_outlines);
        scene.bodies.append(&mut part.bodies);
        scene.joints.append(&mut part.joints);
        scene.drivers.append(&mut part.drivers);
        scene.loads.append(&mut part.loads);
        scene.initial.append(&mut part.initial);
        // What the scene reports already, such as the energy of everything, it reports once.
        let listed: HashSet<&str> = scene.outputs.variables.iter().map(|known| known.text.as_str()).collect();
        part.outputs.variables.retain(|variable| !listed.contains(variable.text.as_str()));
        scene.outputs.variables.append(&mut part.outputs.variables);
        scene.outputs.expressions.append(&mut part.outputs.expressions);
        scene.broken.append(&mut part.broken);
    }

    /// Makes the points of the part's ground points of a body.
    fn fix(&mut self, scene: &mut Scene, part: &mut Scene, index: usize, on: &Text) {
        let used = &mut scene.uses[index];
        let Some(body) = scene.bodies.iter_mut().find(|body| body.name.text == on.text) else {
            if !scene.broken.contains(&on.text) {
                let message = format!("part `{}` is on a body that is not in the scene: `{}`", used.name.text, on.text);
                let fault = Fault::new("scene::unknown_body", message, on.span).label("no such body");
                self.faults.push(fault.help("name a body of this scene, or of a part that stands before this one"));
            }
            return;
        };
        for outline in part.ground_outlines.drain(..) {
            let message = format!("part `{}` is on body `{}`, but its ground has an outline", used.name.text, on.text);
            let fault = Fault::new("scene::placed_part", message, outline.node.span).label("of its ground");
            self.faults.push(fault.help(format!("give the outline to body `{}`, or to a body of the part", on.text)));
        }
        part.ground.drain(..).for_each(|point| body.carry(point));
        renamed::with_ground(part, &on.text);
        used.origin.text = used.origin.text.replacen("ground", &on.text, 1);
    }

    fn set_parameters(&mut self, part: &mut Scene, used: &Use) {
        for (name, value) in &used.parameters {
            match part.parameters.iter_mut().find(|parameter| parameter.name.text == name.text) {
                Some(parameter) => parameter.value = value.clone(),
                None if part.broken.contains(&name.text) => {}
                None => self.faults.push(unknown_parameter(part, used, name)),
            }
        }
    }
}

/// True for a text with a section of scenes.
fn is_like_a_scene(text: &str) -> bool {
    const SECTIONS: [&str; 10] =
        ["format", "bodies", "joints", "drivers", "loads", "parts", "ground", "parameters", "states", "signals"];
    let begins = |line: &str, section: &str| line.trim_start().trim_start_matches('[').starts_with(section);
    let has =
        |section: &str| text.lines().any(|line| begins(line, section)) || text.contains(&format!("\"{section}\""));
    SECTIONS.into_iter().any(has)
}

/// How a part calls its origin: if that is another point than the ground's, and something may use it, it becomes one of its points.
fn origin(part: &mut Scene, used: &Use, within: Within) -> Text {
    let is_used = [&part.joints, &part.drivers, &part.loads].iter().any(|parts| !parts.is_empty());
    if !is_used || used.at.is_none() && used.on.is_none() {
        return used.origin.clone();
    }
    let name = Text::from(format!("{}_ground", used.name.text));
    let origin = Text::from(format!("ground.{}", name.text));
    part.ground.push(Point { name, at: [0.0, 0.0].into(), within });
    origin
}

impl Scene {
    /// Changes whose text its elements are written in.
    fn belong(&mut self, whose: impl Fn(Within) -> Within) {
        let parts = [&mut self.bodies, &mut self.joints, &mut self.drivers, &mut self.loads].into_iter().flatten();
        let parts = parts.flat_map(|part| {
            std::iter::once(&mut part.within).chain(part.carried.iter_mut().map(|(_, within)| within))
        });
        let others = (self.uses.iter_mut().map(|used| &mut used.within))
            .chain(self.states.iter_mut().map(|state| &mut state.within))
            .chain(self.sampled.iter_mut().map(|sampler| &mut sampler.within))
            .chain(self.events.iter_mut().map(|event| &mut event.within))
            .chain(self.signals.iter_mut().map(|signal| &mut signal.within))
            .chain(self.ground.iter_mut().map(|point| &mut point.within))
            .chain(self.ground_outlines.iter_mut().map(|outline| &mut outline.within))
            .chain(self.initial.iter_mut().map(|initial| &mut initial.within));
        parts.chain(others).for_each(|within| *within = whose(*within));
    }
}

fn unknown_parameter(part: &Scene, used: &Use, name: &Text) -> Fault {
    let names = || part.parameters.iter().map(|parameter| parameter.name.text.as_str());
    let otherwise = match part.parameters.is_empty() {
        true => "it has no parameters".to_owned(),
        false => format!("its parameters are {}", suggest::list(names())),
    };
    let message = format!("`{}` has no parameter `{}`", used.file.text, name.text);
    let fault = Fault::new("scene::unknown_name", message, name.span).label("no such parameter");
    fault.help(suggest::hint(&name.text, names(), otherwise))
}
