//! Joints, drivers and loads: tables to parts, by the keys of their components.

use super::Resolver;
use super::context::Context;
use crate::component::{Component, Room, Section};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::{Span, Text};
use crate::diagnostic::suggest;
use crate::model::measure::{ANGLE, ANGULAR_VELOCITY};
use crate::model::{BodyId, Course, DriverId, JointId, KeyValue, LoadId, Owner, Part, Place, Range};
use crate::scene::decode::Fields;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::key::{Form, Key, Need};
use crate::scene::part as written;
use crate::scene::{QuantityReading, read};

impl written::Part {
    /// Its component: a driver's by the motion that it prescribes, else by its type.
    pub fn component(&self, section: Section) -> Option<&'static Component> {
        let kind = self.text("type");
        let mut found = section.components().filter(|component| match section {
            Section::Drivers => self.get(component.name).is_some(),
            _ => kind.as_ref().is_some_and(|kind| kind.text == component.name),
        });
        found.next().filter(|_| found.next().is_none())
    }
}

/// Who reads the values of keys.
pub(super) struct KeyReader<'r, 'n> {
    pub fields: &'r Fields<'n>,
    /// "joint `pin`"
    pub user: &'r str,
    /// What laws may depend on.
    pub context: Context,
}

/// A part that is being read: what is known of it and how messages call it.
struct PartReading<'n> {
    component: &'static Component,
    fields: Fields<'n>,
    /// "joint `pin`", "torsion spring `coil`"
    user: String,
    owner: Owner,
    span: Span,
    ends: Option<([Text; 2], [Place; 2])>,
    values: Vec<(&'static str, KeyValue)>,
    /// What it runs over.
    course: Course,
    complete: bool,
    /// Does it engage later, where it stands?
    engages_here: bool,
}

impl PartReading<'_> {
    /// True without pulleys and drums.
    fn is_straight(&self) -> bool {
        let has_drum = match self.fields.get("between").map(|node| &node.kind) {
            Some(Content::Array(items)) => items.iter().any(|item| matches!(item.kind, Content::Table(_))),
            _ => false,
        };
        !has_drum && self.fields.get("over").is_none()
    }
}

/// What types of joints and loads are called elsewhere.
const CALLED: [(&str, &[&str]); 7] = [
    ("revolute", &["hinge", "pin", "pivot", "rotary", "rotational", "pin_joint"]),
    ("prismatic", &["slider", "translational", "linear", "sliding", "guide"]),
    ("weld", &["fixed", "rigid", "welded"]),
    ("rope", &["cable", "string", "wire"]),
    ("torque", &["moment"]),
    ("torsion_spring", &["rotational_spring", "rotary_spring"]),
    ("torsion_damper", &["rotational_damper", "rotary_damper"]),
];

/// What people write for a driver's speed, and the motions that it can be of.
const RATES: [(&[&str], &[&str]); 2] = [
    (&["omega", "rpm", "angular_velocity", "rotational_speed", "frequency"], &["angle"]),
    (&["speed", "velocity", "rate", "v"], &["angle", "displacement"]),
];

impl<'s> Resolver<'s> {
    pub(super) fn parts(&mut self, section: Section) -> Vec<Part> {
        let scene = self.scene;
        let (parts, owner): (_, fn(usize) -> Owner) = match section {
            Section::Joints => (&scene.joints, |index| Owner::Joint(JointId(index))),
            Section::Drivers => (&scene.drivers, |index| Owner::Driver(DriverId(index))),
            Section::Loads => (&scene.loads, |index| Owner::Load(LoadId(index))),
        };
        parts.iter().enumerate().filter_map(|(index, part)| self.part(part, section, owner(index))).collect()
    }

    fn part(&mut self, part: &'s written::Part, section: Section, owner: Owner) -> Option<Part> {
        let read = self.within(part.within, |resolver| resolver.read(part, section, owner));
        self.incomplete |= read.is_none();
        if read.is_none() && section == Section::Drivers {
            // What it has depends on what it drives.
            self.names.spoil(&part.name.text);
        }
        read
    }

    fn read(&mut self, part: &written::Part, section: Section, owner: Owner) -> Option<Part> {
        let Some(component) = part.component(section) else {
            self.unrecognised(part, section);
            return None;
        };
        let name = &part.name;
        let called = format!("{} `{}`", component.words(), name.text);
        let fields = Fields::open(&part.node, &called, name.span, &keys(component), self.faults)?;
        let user = if section == Section::Joints { format!("joint `{}`", name.text) } else { called };
        let mut reading = PartReading {
            component,
            fields,
            user,
            owner,
            span: name.span,
            ends: None,
            values: Vec::new(),
            course: Course::default(),
            complete: true,
            engages_here: part.engages_here(),
        };
        self.room(&mut reading)?;
        self.one_of(&mut reading);
        // A third body must be neither of the two, so they come first.
        let (last, first): (Vec<&Key>, Vec<&Key>) = component.keys.iter().partition(|key| key.form.is_carrier());
        for key in first.into_iter().chain(last) {
            self.key(key, &mut reading);
        }
        reading.complete &= self.carrier_apart(&reading);
        let (_, between) = reading.ends.filter(|_| reading.complete)?;
        let PartReading { mut values, fields, course, user, .. } = reading;
        self.complete_profile(&mut values, &fields, &user)?;
        let course = self.course((component, course), between, (&user, name.span))?;
        values.extend(course.map(|course| ("over", course)));
        let mut part =
            Part { name: name.text.clone(), kind: component.kind(), owner, between, values, span: name.span };
        self.place_element(&mut part, &fields);
        Some(part)
    }

    fn unrecognised(&mut self, part: &written::Part, section: Section) {
        let called = format!("{} `{}`", section.word(), part.name.text);
        let names: Vec<&str> = section.components().map(|component| component.name).collect();
        let Some(fields) = Fields::open_any(&part.node, &called, part.name.span, self.faults) else { return };
        if section == Section::Drivers {
            self.motions(&fields, &names);
            return;
        }
        if let Some(key) = fields.misspelt("type").filter(|_| fields.get("type").is_none()) {
            let fault = Fault::new("scene::unknown_key", format!("{called} has no key `{}`", key.text), key.span);
            self.faults.push(fault.label("unknown key").help("did you mean `type`?"));
            return;
        }
        let known = suggest::list(names.iter().copied());
        let Some(node) = fields.required("type", &format!("the types are {known}"), self.faults) else { return };
        let Some(kind) = self.faults.text(node, &fields.name_of("type")) else { return };
        let meant = CALLED.iter().find(|(_, words)| words.contains(&kind.text.to_lowercase().as_str()));
        let help = match meant.filter(|(name, _)| names.contains(name)) {
            Some((name, _)) => format!("did you mean `{name}`?"),
            None => suggest::hint(&kind.text, names.iter().copied(), format!("the types are {known}")),
        };
        let message = format!("{called} has an unknown type: `{}`", kind.text);
        self.faults.push(Fault::new("scene::unknown_type", message, kind.span).label("no such type").help(help));
    }

    /// Says that a driver must prescribe exactly one motion.
    fn motions(&mut self, fields: &Fields<'_>, motions: &[&str]) {
        let given: Vec<&str> = motions.iter().copied().filter(|key| fields.get(key).is_some()).collect();
        let found = if given.is_empty() { "none of them".to_string() } else { suggest::list(given.iter().copied()) };
        let span = given.get(1).and_then(|key| fields.key_span(key)).unwrap_or(fields.span);
        let wanted = suggest::list(motions.iter().copied());
        let message = format!("{} must have exactly one of {wanted}, but has {found}", fields.owner);
        let drivers = Section::Drivers.components();
        let help: Vec<String> = drivers.map(|component| format!("`{}` {}", component.name, component.about)).collect();
        let rate = RATES.iter().find_map(|(rates, motions)| {
            let key = rates.iter().find(|key| fields.get(key).is_some())?;
            Some((*key, *motions))
        });
        if let Some((key, motions)) = rate.filter(|_| given.is_empty()) {
            self.refuse_rate(fields, key, motions);
            return;
        }
        let fault = Fault::new("scene::driver_motion", message, span).label("exactly one is needed");
        self.faults.push(fault.help(help.join(", ")));
    }

    /// A driver prescribes a motion over the time: of its speed that is the integral.
    fn refuse_rate(&mut self, fields: &Fields<'_>, key: &str, motions: &[&str]) {
        let message = format!("{} has no key `{key}`: a speed is written as a motion over time", fields.owner);
        let law = fields.get(key).and_then(|node| motion_of_rate(key, node));
        let (law, only) = law.unwrap_or_else(|| ("2*pi*t".to_owned(), None));
        let motions = if only.is_some() { only.as_slice() } else { motions };
        let help: Vec<String> = motions.iter().map(|motion| format!("`{motion} = \"{law}\"`")).collect();
        let span = fields.key_span(key).unwrap_or(fields.span);
        let fault = Fault::new("scene::driver_motion", message, span).label("unknown key");
        self.faults.push(fault.help(format!("write {}", help.join(" or "))));
    }

    /// Refuses what a scene of one dimension has no room for; none if nothing of it is worth reading.
    fn room(&mut self, reading: &mut PartReading<'_>) -> Option<()> {
        let called = reading.fields.owner.clone();
        match reading.component.room {
            Room::Turning => self.must_not_turn(&called, reading.span),
            Room::Plane => self.must_have_plane(&reading.user, reading.span),
            Room::Needless(help) if self.one_dimensional() => {
                let message = format!("{called} is not needed in one dimension");
                let fault = Fault::new("scene::one_dimension", message, reading.span);
                self.faults.push(fault.label("not with `dimension = 1`").help(help));
                return None;
            }
            Room::Line | Room::Needless(_) => {}
        }
        Some(())
    }

    /// Exactly one of the keys that stand for one another must be there.
    fn one_of(&mut self, reading: &mut PartReading<'_>) {
        let keys: Vec<&Key> = alternatives(reading.component).collect();
        if keys.is_empty() {
            return;
        }
        let all = match reading.component.section {
            Section::Drivers => drivers_keys(|key| matches!(key.need, Need::OneOf(_))),
            _ => keys.iter().map(|key| key.name).collect(),
        };
        let given: Vec<&str> = all.into_iter().filter(|key| reading.fields.get(key).is_some()).collect();
        let permitted = |name: &str| keys.iter().any(|key| key.name == name);
        if matches!(given[..], [one] if permitted(one)) {
            return;
        }
        reading.complete = false;
        let wanted: Vec<String> = keys.iter().map(|key| format!("`{}`", key.name)).collect();
        let wanted = wanted.join(" or ");
        let wrong = given.iter().rev().find(|key| given.len() > 1 || !permitted(key));
        let span = wrong.and_then(|key| reading.fields.key_span(key)).unwrap_or(reading.span);
        let called = &reading.fields.owner;
        let fault = if reading.component.section == Section::Drivers {
            let message = format!("{called} has `{}`, so it needs {wanted} and no other key", reading.component.name);
            Fault::new("scene::driver_target", message, span).help(driver_targets())
        } else {
            let message = match given.is_empty() {
                true => format!("{called} has neither {}", wanted.replace(" or ", " nor ")),
                false => format!("{called} has both of {wanted}"),
            };
            Fault::new("scene::torque_target", message, span).help(helps(keys.into_iter()).join(", "))
        };
        self.faults.push(fault.label(format!("{wanted} is needed")));
    }

    fn key(&mut self, key: &'static Key, reading: &mut PartReading<'_>) {
        let node = match key.need {
            Need::Required(help) => reading.fields.required(key.name, help, self.faults),
            Need::Captured(help) if !reading.engages_here => reading.fields.required(key.name, help, self.faults),
            Need::RequiredAlone(help) if reading.is_straight() => {
                let node = reading.fields.required(key.name, help, self.faults);
                reading.complete &= node.is_some();
                node
            }
            Need::Optional | Need::Default(_) | Need::OneOf(_) | Need::Captured(_) | Need::RequiredAlone(_) => {
                reading.fields.get(key.name)
            }
        };
        let Some(node) = node else {
            let is_needed = matches!(key.need, Need::Captured(_)) && !reading.engages_here;
            reading.complete &= !is_needed && !matches!(key.need, Need::Required(_));
            reading.values.extend(self.carrier(key.form).map(|carrier| (key.name, KeyValue::Place(carrier))));
            return;
        };
        if let Form::Course = key.form {
            let pulleys = self.pulleys(node, &reading.fields.name_of(key.name), &reading.user);
            reading.complete &= pulleys.is_some();
            reading.course.over = pulleys.unwrap_or_default();
            return;
        }
        if let Form::Ends = key.form {
            let ends = self.course_ends((key, node), (&reading.fields, &reading.user));
            reading.complete &= ends.is_some();
            if let Some([first, second]) = ends {
                reading.ends = Some(([first.name, second.name], [first.at, second.at]));
                reading.course.drums = [first.drum, second.drum];
            }
            return;
        }
        let read = match key.form.is_end() {
            true => self.ends(key, node, reading).map(|(ends, value)| {
                reading.ends = Some(ends);
                reading.values.extend(value.map(|value| (key.name, value)));
            }),
            false => {
                let context = match reading.owner {
                    Owner::Load(load) => Context::Law(load),
                    Owner::Joint(joint) if matches!(key.form, Form::Curve(..)) => Context::Curve(joint),
                    Owner::Joint(_) if matches!(key.form, Form::Law(_)) => Context::Level,
                    Owner::Joint(_) | Owner::Driver(_) | Owner::Place(_) | Owner::System => Context::Driver,
                };
                let reader = KeyReader { fields: &reading.fields, user: &reading.user, context };
                self.value_of(key, node, &reader).map(|value| reading.values.push((key.name, value)))
            }
        };
        reading.complete &= read.is_some();
    }

    #[allow(clippy::type_complexity, reason = "words, points and the joint that a driver moves")]
    fn ends(
        &mut self,
        key: &Key,
        node: &DocumentNode,
        reading: &PartReading<'_>,
    ) -> Option<(([Text; 2], [Place; 2]), Option<KeyValue>)> {
        let (user, what) = (&reading.user, reading.fields.name_of(key.name));
        if let Form::Points | Form::Bodies | Form::BodyAndPoint = key.form {
            let help = if let Need::Required(help) | Need::OneOf(help) = key.need { help } else { "" };
            let names = self.faults.pair(node, &what, help)?;
            let places = match key.form {
                Form::Points => self.places(&names, user)?,
                Form::Bodies => self.body_pair(&names, user)?.map(centre),
                _ => {
                    let (body, point) = (self.body(&names[0], user), self.place(&names[1], user));
                    let (body, point) = (body?, point?);
                    self.different(body, point.body(), &names, user)?;
                    [centre(body), point]
                }
            };
            return Some(((names, places), None));
        }
        let name = self.faults.text(node, &what)?;
        let ground = Text::new("ground", name.span);
        match key.form {
            Form::Body => {
                let names = [ground, name];
                let places = self.body_pair(&names, user)?.map(centre);
                Some(((names, places), None))
            }
            Form::Joint => {
                let joint = self.joint_named(&name, user, reading.component.name)?;
                let names = self.scene.joints[joint.0].between()?;
                let known = |resolver: &mut Self| names.each_ref().map(|name| resolver.known_place(&name.text));
                let [first, second] = self.within(self.scene.joints[joint.0].within, known);
                let places = [first?, second?];
                Some(((names, places), Some(KeyValue::Joint(joint))))
            }
            _ => {
                let place = self.moving_place(&name, user)?;
                Some((([ground, name], [Place::Origin, place]), None))
            }
        }
    }

    /// Where a part counts from if it names no third body.
    fn carrier(&self, form: Form) -> Option<Place> {
        let frame = self.frame();
        let carrier = match form {
            Form::CarrierBody => centre(frame.on),
            Form::CarrierPoint => frame.origin,
            _ => return None,
        };
        Some(carrier).filter(|carrier| *carrier != Place::Origin)
    }

    /// The value of a key that says nothing of what a part is between.
    pub(super) fn value_of(
        &mut self,
        key: &'static Key,
        node: &DocumentNode,
        reader: &KeyReader<'_, '_>,
    ) -> Option<KeyValue> {
        let &KeyReader { fields, user, context } = reader;
        let written = fields.name_of(key.name);
        let what = format!("`{}` of {user}", key.name);
        match key.form {
            Form::Constant(wanted, range) => {
                let quantity = self.faults.quantity(node, &written)?;
                if wanted.exponents == ANGLE.exponents && self.one_dimensional() {
                    self.must_not_turn(&what, quantity.span);
                }
                let formula = match range {
                    Range::Any => {
                        let formula = self.constant(&quantity, &what, &wanted);
                        self.suspect_growth(&formula, &what, &wanted, quantity.span);
                        formula
                    }
                    _ => self.constant_in(range, &quantity, &what, &wanted),
                };
                Some(KeyValue::Formula(formula))
            }
            Form::Law(wanted) => {
                let quantity = self.faults.quantity(node, &written)?;
                Some(KeyValue::Formula(self.formula(&quantity, &what, &wanted, context)))
            }
            Form::Curve(guide, wanted) => {
                let quantity = self.faults.quantity(node, &written)?;
                let turns = self.turns(fields.get(guide));
                Some(KeyValue::Formula(self.formula(&quantity, &what, &wanted[usize::from(turns)], context)))
            }
            Form::OtherJoint => {
                let name = self.faults.text(node, &written)?;
                let Some(super::names::Named::Joint(id)) = self.names.get(&name.text) else {
                    self.unknown_joint(&name, user);
                    return None;
                };
                Some(KeyValue::Joint(id))
            }
            Form::Vector(wanted) => {
                let vector = self.faults.vector(node, &written)?;
                Some(KeyValue::Vector(self.vector(&vector, &what, &wanted, context)))
            }
            Form::ConstantVector(wanted) => {
                let vector = self.faults.vector(node, &written)?;
                Some(KeyValue::Vector(self.vector(&vector, &what, &wanted, Context::Constant)))
            }
            Form::Switch => self.faults.boolean(node, &written).map(KeyValue::Switch),
            Form::Axis => {
                let vector = self.faults.vector(node, &written)?;
                Some(KeyValue::Vector(self.axis(&vector, &what)))
            }
            Form::Record(record) => self.record(record, node, &written, user),
            Form::Profile => self.profile(node, &written, user).map(KeyValue::Contour),
            Form::Motion(wanted) => self.motion(node, key.name, &what, &wanted).map(KeyValue::Motion),
            Form::Choice(words, help) => self.choice(node, fields, key.name, words, help),
            Form::CarrierBody | Form::CarrierPoint => {
                let name = self.faults.text(node, &written)?;
                let place = match key.form {
                    Form::CarrierBody => centre(self.body(&name, user)?),
                    _ => self.place(&name, user)?,
                };
                Some(KeyValue::Place(place))
            }
            _ => None,
        }
    }

    fn choice(
        &mut self,
        node: &DocumentNode,
        fields: &Fields<'_>,
        key: &str,
        words: &'static [&'static str],
        help: &str,
    ) -> Option<KeyValue> {
        let text = self.faults.text(node, &fields.name_of(key))?;
        let word = words.iter().copied().find(|word| *word == text.text);
        if word.is_none() {
            let message = format!("`{key}` of {} is `{}`", fields.owner, text.text);
            let fault = Fault::new("scene::wrong_value", message, text.span).label(format!("no such {key}"));
            self.faults.push(fault.help(suggest::hint(&text.text, words.iter().copied(), help.to_string())));
        }
        word.map(KeyValue::Choice)
    }

    /// The carrier must be neither of what it carries.
    fn carrier_apart(&mut self, reading: &PartReading<'_>) -> bool {
        let has_carrier = reading.component.keys.iter().any(|key| key.form.is_carrier());
        let Some((names, places)) = reading.ends.as_ref().filter(|_| has_carrier) else { return true };
        let carrier = reading.values.iter().find_map(|(_, value)| match value {
            KeyValue::Place(place) => Some(place.body()),
            _ => None,
        });
        let carrier = carrier.flatten();
        let Some(end) = (0..2).find(|&end| places[end].body() == carrier) else { return true };
        let name = carrier.map_or("ground", |body| self.scene.bodies[body.0].name.text.as_str());
        let message = format!("{} moves `{name}`, which is its carrier", reading.user);
        let help =
            "name the body that carries the bearings of the wheels: `carrier = \"BODY\"`; the default is the ground";
        let fault = Fault::new("scene::self_connection", message, names[end].span);
        self.faults.push(fault.label("is the carrier").help(help));
        false
    }

    /// The joint that a driver names; it must permit the motion.
    fn joint_named(&mut self, name: &Text, user: &str, motion: &str) -> Option<JointId> {
        let Some(super::names::Named::Joint(id)) = self.names.get(&name.text) else {
            self.unknown_joint(name, user);
            return None;
        };
        let component = self.scene.joints[id.0].component(Section::Joints)?;
        let is_locked = motion == "lock";
        if component.drivers.contains(&motion) || is_locked && component.drivers.len() == 1 {
            return Some(id);
        }
        if is_locked {
            let message = format!("{user} locks joint `{}`, which is of type `{}`", name.text, component.name);
            let fault = Fault::new("scene::engage", message, name.span).label("not revolute or prismatic");
            self.faults.push(
                fault.help("name a revolute or a prismatic joint, or two bodies: `between = [\"BODY\", \"BODY\"]`"),
            );
            return None;
        }
        let [found, help] = component.undriven;
        let message = format!("{user} prescribes `{motion}`, but joint `{}` is {found}", name.text);
        let fault = Fault::new("scene::driver_joint", message, name.span);
        self.faults.push(fault.label(format!("this joint is {found}")).help(help));
        None
    }

    /// Does this key name a joint that turns, and does not slide?
    pub(super) fn turns(&self, joint: Option<&DocumentNode>) -> bool {
        let Some(DocumentNode { kind: Content::Text(name), .. }) = joint else { return false };
        let Some(super::names::Named::Joint(id)) = self.names.get(name) else { return false };
        let component = self.scene.joints[id.0].component(Section::Joints);
        component.is_some_and(|component| component.drivers == ["angle"])
    }

    fn unknown_joint(&mut self, name: &Text, user: &str) {
        if self.is_reported(name, &name.text) {
            return;
        }
        let joints = self.names.all(|named| matches!(named, super::names::Named::Joint(_)));
        let otherwise = match joints.is_empty() {
            true => {
                "the scene has no joints; a driver between bodies takes `between = [\"ground\", \"BODY\"]`".to_string()
            }
            false => format!("the joints are {}", suggest::list(joints.iter().copied())),
        };
        let help = suggest::hint(&name.text, joints.iter().copied(), otherwise);
        let message = format!("{user} uses a joint that is not in the scene: `{}`", name.text);
        let fault = Fault::new("scene::unknown_joint", message, name.span).label("no such joint");
        self.faults.push_about(&name.text, fault.help(help));
    }
}

/// What stands for a whole body.
fn centre(body: Option<BodyId>) -> Place {
    body.map_or(Place::Origin, Place::Centre)
}

/// The keys that a part may have: any driver's, so that one of the wrong motion is told from one that does not exist.
fn keys(component: &Component) -> Vec<&'static str> {
    match component.section {
        Section::Drivers => drivers_keys(|_| true),
        _ => std::iter::once("type").chain(component.keys.iter().map(|key| key.name)).collect(),
    }
}

/// The keys of drivers that `select` selects: what they move before how.
fn drivers_keys(select: impl Fn(&Key) -> bool) -> Vec<&'static str> {
    let drivers = || Section::Drivers.components();
    let all = drivers().flat_map(|component| component.keys).filter(|key| select(key));
    let (targets, motions): (Vec<&Key>, Vec<&Key>) = all.partition(|key| matches!(key.need, Need::OneOf(_)));
    let mut names: Vec<&str> = Vec::new();
    for key in targets.into_iter().chain(motions) {
        if !names.contains(&key.name) {
            names.push(key.name);
        }
    }
    names
}

fn alternatives(component: &'static Component) -> impl Iterator<Item = &'static Key> {
    component.keys.iter().filter(|key| matches!(key.need, Need::OneOf(_)))
}

fn helps<'k>(keys: impl Iterator<Item = &'k Key>) -> Vec<&'static str> {
    keys.filter_map(|key| if let Need::OneOf(help) = key.need { Some(help) } else { None }).collect()
}

fn driver_targets() -> String {
    let target = |key: &Key| match key.form {
        Form::Bodies => format!("`{}` (two bodies)", key.name),
        Form::Point => format!("`{}` (a point)", key.name),
        _ => format!("`{}`", key.name),
    };
    let of = |component: &'static Component| {
        let targets: Vec<String> = alternatives(component).map(target).collect();
        format!("`{}` needs {}", component.name, targets.join(" or "))
    };
    let all: Vec<String> = Section::Drivers.components().map(of).collect();
    all.join(", ")
}

/// The law that a speed makes over the time, and the one motion that it can be of if its unit says so.
fn motion_of_rate(key: &str, node: &DocumentNode) -> Option<(String, Option<&'static str>)> {
    let before = if key == "frequency" { "2*pi*" } else { "" };
    let unit = if key == "rpm" { "[rpm]" } else { "" };
    let bare = |number: f64| (format!("{before}{number}{unit}*t"), None);
    let text = match &node.kind {
        Content::Number(number) => return Some(bare(*number)),
        Content::Text(_) => node.text()?,
        _ => return None,
    };
    Some(match read(&text).ok()? {
        QuantityReading::Number(number) => bare(number),
        QuantityReading::Measure(number, _) if key == "frequency" => (format!("{before}{number}*t"), None),
        QuantityReading::Measure(_, measure) => {
            let (number, unit) = text.text.trim().split_once(' ')?;
            let turns = ANGULAR_VELOCITY.exponents == Some(measure.exponents);
            let motion = if turns { "angle" } else { "displacement" };
            (format!("{number}[{}]*t", unit.trim()), Some(motion))
        }
        QuantityReading::Expression => {
            let unit = if unit.is_empty() { "" } else { "*1[rpm]" };
            (format!("{before}({}){unit}*t", text.text.trim()), None)
        }
    })
}
