//! A scene that can be touched: its plain numbers are parameters, and something can be added to the laws of its drivers.

use crate::component::Section;
use crate::component::body::KEYS as BODY;
use crate::diagnostic::span::{Span, Text};
use crate::model::measure::{LENGTH, Wanted};
use crate::scene::document::{Content, DocumentNode};
use crate::scene::key::{Form, Key};
use crate::scene::model::{Parameter, Scene, Signal};
use crate::scene::part::Part;
use crate::scene::quantity::{Quantity, Value};
use crate::scene::{QuantityReading, read};

/// The same scene with parameters for what is written in it.
#[derive(Clone, Debug)]
pub struct Loosened {
    pub scene: Scene,
    pub numbers: Vec<Loose>,
    pub laws: Vec<LooseLaw>,
    pub formulas: Vec<LooseFormula>,
}

/// A length that is written as an expression.
#[derive(Clone, Debug)]
pub struct LooseFormula {
    /// What it is of the scene, such as `rod.pin.x`.
    pub name: String,
    pub text: String,
    /// The output that has its value.
    pub output: String,
}

/// A plain number that has become a parameter.
#[derive(Clone, Debug)]
pub struct Loose {
    pub parameter: String,
    /// What it is of the scene, such as `ground.hinge.x` or `strut.length`.
    pub name: String,
    /// Where it is written, without quotes.
    pub span: Span,
}

/// The law of a driver, to which a parameter is added.
#[derive(Clone, Debug)]
pub struct LooseLaw {
    pub driver: String,
    /// What is added, zero as the scene is; or the input that is the motion itself.
    pub parameter: String,
    /// The variable that has the value of the law.
    pub output: String,
    /// Where the law is written, without its quotes.
    pub span: Span,
}

impl Scene {
    /// The scene with a parameter for each plain number of its own text: coordinates of points and mass centres, and what its parts have of masses, lengths,
    /// stiffnesses. Laws of drivers have a parameter added to them. The numbers of the files that it uses stay.
    pub fn loosened(&self) -> Loosened {
        let mut prefix = "loose_".to_owned();
        while self.source.text.contains(&prefix) {
            prefix.push('_');
        }
        let mut scene = self.clone();
        let mut loosening = Loosening { prefix, ..Loosening::default() };
        for point in scene.ground.iter_mut().filter(|point| point.within == 0) {
            for (component, axis) in point.at.components.iter_mut().zip(["x", "y"]) {
                let mut node = DocumentNode::from(component.clone());
                loosening.number(&mut node, LENGTH, format!("ground.{}.{axis}", point.name.text), true);
                if let Content::Text(text) = node.kind {
                    component.value = Value::Text(text);
                }
            }
        }
        for body in scene.bodies.iter_mut().filter(|body| body.within == 0) {
            loosening.part(body, BODY, None);
        }
        for (section, parts) in [
            (Section::Joints, &mut scene.joints),
            (Section::Drivers, &mut scene.drivers),
            (Section::Loads, &mut scene.loads),
        ] {
            for part in parts.iter_mut().filter(|part| part.within == 0) {
                if let Some(component) = part.component(section) {
                    loosening.part(part, component.keys, Some(section));
                }
            }
        }
        scene.parameters.append(&mut loosening.parameters);
        scene.outputs.expressions.append(&mut loosening.outputs);
        let Loosening { numbers, laws, formulas, .. } = loosening;
        Loosened { scene, numbers, laws, formulas }
    }
}

#[derive(Default)]
struct Loosening {
    /// Begins the names of the parameters; nothing of the scene begins so.
    prefix: String,
    parameters: Vec<Parameter>,
    outputs: Vec<Signal>,
    numbers: Vec<Loose>,
    laws: Vec<LooseLaw>,
    formulas: Vec<LooseFormula>,
}

impl Loosening {
    fn part(&mut self, part: &mut Part, keys: &[Key], section: Option<Section>) {
        let drives = section == Some(Section::Drivers);
        let owner = part.name.text.clone();
        let Content::Table(entries) = &mut part.node.kind else { return };
        for (name, node) in entries {
            let Some(key) = keys.iter().find(|key| key.name == name.text) else { continue };
            match key.form {
                Form::Constant(wanted, _) => self.number(node, wanted, format!("{owner}.{}", key.name), false),
                Form::ConstantVector(wanted) => self.vector(node, wanted, &format!("{owner}.{}", key.name)),
                Form::NamedPoints => self.points(node, &owner),
                Form::Motion([wanted, ..]) if drives => self.law(node, wanted, &owner),
                Form::Vector(wanted) if drives => self.law_of_two(node, wanted, &owner),
                _ => {}
            }
        }
    }

    fn points(&mut self, node: &mut DocumentNode, owner: &str) {
        let Content::Table(points) = &mut node.kind else { return };
        for (name, at) in points {
            self.vector(at, LENGTH, &format!("{owner}.{}", name.text));
        }
    }

    fn vector(&mut self, node: &mut DocumentNode, wanted: Wanted, name: &str) {
        let Content::Array(components) = &mut node.kind else { return };
        for (component, axis) in components.iter_mut().zip(["x", "y"]) {
            self.number(component, wanted, format!("{name}.{axis}"), true);
        }
    }

    /// A zero that is no coordinate says that something is not there: it stays.
    fn number(&mut self, node: &mut DocumentNode, wanted: Wanted, name: String, even_zero: bool) {
        let Some(PlainValue { value, number, bare }) = plain(node) else { return self.formula(node, wanted, name) };
        if number == 0.0 && !even_zero {
            return;
        }
        let parameter = self.parameter(Quantity { value, span: node.span }, wanted, bare);
        self.numbers.push(Loose { parameter: parameter.clone(), name, span: node.span });
        node.kind = Content::Text(parameter);
    }

    fn formula(&mut self, node: &DocumentNode, wanted: Wanted, name: String) {
        if let (Some(Text { text, .. }), true) = (node.text(), wanted.si == LENGTH.si) {
            let output = format!("{}formula{}", self.prefix, self.formulas.len());
            self.outputs.push(Signal { name: Text::from(output.as_str()), ..Signal::new(text.as_str()) });
            self.formulas.push(LooseFormula { name, text, output });
        }
    }

    fn law_of_two(&mut self, node: &mut DocumentNode, wanted: Wanted, driver: &str) {
        let Content::Array(components) = &mut node.kind else { return };
        components.iter_mut().for_each(|component| self.law(component, wanted, driver));
    }

    fn law(&mut self, node: &mut DocumentNode, wanted: Wanted, driver: &str) {
        let law = match &node.kind {
            Content::Text(law) => law.clone(),
            Content::Number(law) => format!("{law:?}"),
            Content::Table(entries) => return self.followed(entries, driver),
            Content::Array(_) | Content::Boolean(_) | Content::Date | Content::Null => return,
        };
        // A sum binds least of all.
        let law = match plain(node) {
            Some(PlainValue { value: value @ Value::Text(_), bare, .. }) => {
                self.parameter(Quantity { value, span: node.span }, wanted, bare)
            }
            _ => law,
        };
        let parameter = self.parameter(Quantity::from(0.0), wanted, true);
        let changed = format!("{law} + {parameter}");
        let output = format!("{parameter}_law");
        self.outputs.push(Signal { name: Text::from(output.as_str()), ..Signal::new(changed.as_str()) });
        self.laws.push(LooseLaw { driver: driver.to_owned(), parameter, output, span: node.span });
        node.kind = Content::Text(changed);
    }

    /// An input that is the motion itself is its own law.
    fn followed(&mut self, entries: &[(Text, DocumentNode)], driver: &str) {
        let text = |key: &str| entries.iter().find(|(name, _)| name.text == key).and_then(|(_, node)| node.text());
        if let (Some(input), Some("position")) = (text("input"), text("as").as_ref().map(|text| text.text.as_str())) {
            let [parameter, output] = [input.text.clone(), input.text];
            self.laws.push(LooseLaw { driver: driver.to_owned(), parameter, output, span: Span::default() });
        }
    }

    fn parameter(&mut self, value: Quantity, wanted: Wanted, bare: bool) -> String {
        let name = format!("{}{}", self.prefix, self.parameters.len());
        let unit = (bare && !wanted.si.is_empty()).then(|| Text::from(wanted.si));
        self.parameters.push(Parameter { name: Text::from(name.as_str()), value, unit, ..Parameter::default() });
        name
    }
}

/// A number with a unit or without.
struct PlainValue {
    /// As it is written.
    value: Value,
    number: f64,
    /// Has it no unit?
    bare: bool,
}

fn plain(node: &DocumentNode) -> Option<PlainValue> {
    let bare = |number| PlainValue { value: Value::Number(number), number, bare: true };
    match &node.kind {
        Content::Number(number) => Some(bare(*number)),
        Content::Text(text) => match read(&Text::new(text.as_str(), node.span)).ok()? {
            QuantityReading::Number(number) => Some(bare(number)),
            QuantityReading::Measure(number, _) => {
                Some(PlainValue { value: Value::Text(text.clone()), number, bare: false })
            }
            QuantityReading::Expression => None,
        },
        Content::Table(_) | Content::Array(_) | Content::Boolean(_) | Content::Date | Content::Null => None,
    }
}
