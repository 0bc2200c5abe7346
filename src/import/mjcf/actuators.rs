//! Actuators as inputs with their laws.

use super::MjcfReader;
use super::resolve::ResolvedElement;
use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::robot::{Activation, JointMotion, SpatialActuator, Transmission};
use crate::import::xml::XmlElement;

/// Gain, gain by the rate, bias, and what follows the input.
struct ActuatorLaw {
    gain: f64,
    rate_gain: f64,
    bias: [f64; 3],
    activation: Activation,
}

impl ActuatorLaw {
    fn direct(gain: f64, bias: [f64; 3]) -> Self {
        ActuatorLaw { gain, rate_gain: 0.0, bias, activation: Activation::Direct }
    }
}

/// MuJoCo has one default for all kinds of actuators, which each of these elements in a default changes.
const KINDS: &[&str] = &[
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
];
/// Attributes that are of one kind, and set what the others read by other names.
const LAWS: &[&str] =
    &["gainprm", "biasprm", "gaintype", "biastype", "dyntype", "dynprm", "kp", "kv", "timeconst", "dampratio"];

impl<'a> MjcfReader<'a> {
    pub fn actuators(&mut self, root: &'a XmlElement) -> Fallible<()> {
        for section in root.all("actuator") {
            for element in &section.children {
                let before = self.model.actuators.len();
                let states = self.states_of(element)?;
                self.actuator(element)?;
                let imported = (self.model.actuators.len() > before).then_some(before);
                self.controls.push((imported, states));
            }
        }
        Ok(())
    }

    /// How many numbers a keyframe's `act` has for an actuator.
    fn states_of(&self, element: &'a XmlElement) -> Fallible<usize> {
        let resolved = self.defaults.of(element, &element.name, None)?;
        let has =
            |name: &str, without: &str| resolved.attribute(name).is_some_and(|attribute| attribute.value != without);
        Ok(match element.name.as_str() {
            "muscle" | "intvelocity" | "cylinder" => 1,
            "general" | "plugin" if has("dyntype", "none") => resolved.number("actdim", 1.0)?.max(1.0) as usize,
            "position" if resolved.number("timeconst", 0.0)? > 0.0 => 1,
            _ => 0,
        })
    }

    fn actuator(&mut self, element: &'a XmlElement) -> Fallible<()> {
        let kind = element.name.as_str();
        let resolved = self.defaults.of(element, kind, None)?;
        let shared = self.defaults.of_any(element, KINDS)?;
        if !self.enabled.actuation {
            element.mark();
            self.report
                .idle(format!("actuator `{}`, as actuation is disabled", element.get("name").unwrap_or_default()));
            return Ok(());
        }
        let law = match kind {
            "motor" => Some(ActuatorLaw::direct(1.0, [0.0; 3])),
            "position" => Some(self.position(&resolved)?),
            "velocity" => {
                let kv = resolved.number("kv", 1.0)?;
                Some(ActuatorLaw::direct(kv, [0.0, 0.0, -kv]))
            }
            "intvelocity" => {
                let (kp, kv) = (resolved.number("kp", 1.0)?, resolved.number("kv", 0.0)?);
                let range = resolved.range("actrange", "actlimited", self.settings.autolimits)?;
                let activation = Activation::Integrator(range, 0.0);
                Some(ActuatorLaw { activation, ..ActuatorLaw::direct(kp, [0.0, -kp, -kv]) })
            }
            "damper" => {
                Some(ActuatorLaw { rate_gain: -resolved.number("kv", 1.0)?, ..ActuatorLaw::direct(0.0, [0.0; 3]) })
            }
            "general" => self.general(&resolved)?,
            _ => None,
        };
        let Some(law) = law else {
            self.refuse_or_leave(element, kind, format!("actuator {} acts and has no counterpart", element.called()));
            return Ok(());
        };
        let leading = match kind {
            "motor" => None,
            "velocity" | "damper" => Some("kv"),
            "general" => Some("gainprm"),
            _ => Some("kp"),
        };
        if leading.is_some_and(|name| resolved.attribute(name).is_none())
            && let Some(other) = resolved.foreign(&shared, LAWS)
        {
            let why = format!("{} has `{other}` from the default of another kind of actuator", element.called());
            return Err(element.refuse(why).help(format!("write it in a default of <{kind}>, or at the actuator")));
        }
        let Some(transmission) = self.transmission(element)? else { return Ok(()) };
        let gear = shared.some("gear", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?[0];
        let control = match self.inherited(element, &resolved, &transmission)? {
            Some(range) => Some(range),
            None if kind == "damper" => shared.array::<2>("ctrlrange")?,
            None => shared.range("ctrlrange", "ctrllimited", self.settings.autolimits)?,
        };
        let force = shared.range("forcerange", "forcelimited", self.settings.autolimits)?;
        let control = control.filter(|_| self.enabled.clamp);
        let ActuatorLaw { gain, rate_gain, bias, activation } = law;
        // An input without a name is known by the joint that it moves.
        let moved = element.get("joint").or_else(|| element.get("jointinparent")).or_else(|| element.get("tendon"));
        let name = element.get("name").or(moved).unwrap_or_default().to_owned();
        let start = 0.0;
        let place = element.place.clone();
        let actuator = SpatialActuator {
            name,
            place,
            transmission,
            gear,
            gain,
            rate_gain,
            bias,
            activation,
            control,
            force,
            start,
        };
        self.model.actuators.push(actuator);
        Ok(())
    }

    fn position(&self, resolved: &ResolvedElement) -> Fallible<ActuatorLaw> {
        let (kp, kv) = (resolved.number("kp", 1.0)?, resolved.number("kv", 0.0)?);
        let time = resolved.number("timeconst", 0.0)?;
        let activation = if time > 0.0 { Activation::Filter(time, None, 0.0) } else { Activation::Direct };
        Ok(ActuatorLaw { activation, ..ActuatorLaw::direct(kp, [0.0, -kp, -kv]) })
    }

    /// Gain and bias that are constant or affine, dynamics that are none, an integrator or a filter.
    fn general(&self, resolved: &ResolvedElement) -> Fallible<Option<ActuatorLaw>> {
        let numbers = |name: &str, default: [f64; 3]| -> Fallible<[f64; 3]> {
            let Some(attribute) = resolved.attribute(name) else { return Ok(default) };
            let mut values = default;
            values.iter_mut().zip(attribute.numbers()?).for_each(|(value, number)| *value = number);
            Ok(values)
        };
        let (gain, bias) = (numbers("gainprm", [1.0, 0.0, 0.0])?, numbers("biasprm", [0.0; 3])?);
        let time = numbers("dynprm", [1.0, 0.0, 0.0])?[0];
        let range = resolved.range("actrange", "actlimited", self.settings.autolimits)?;
        let gain = match resolved.get("gaintype").unwrap_or("fixed") {
            "fixed" => Some([gain[0], 0.0]),
            "affine" if gain[1] == 0.0 => Some([gain[0], gain[2]]),
            _ => None,
        };
        let bias = match resolved.get("biastype").unwrap_or("none") {
            "none" => Some([0.0; 3]),
            "affine" => Some(bias),
            _ => None,
        };
        let activation = match resolved.get("dyntype").unwrap_or("none") {
            "none" => Some(Activation::Direct),
            "integrator" => Some(Activation::Integrator(range, 0.0)),
            "filter" | "filterexact" if time > 0.0 => Some(Activation::Filter(time, range, 0.0)),
            _ => None,
        };
        let (Some([gain, rate_gain]), Some(bias), Some(activation)) = (gain, bias, activation) else { return Ok(None) };
        Ok(Some(ActuatorLaw { gain, rate_gain, bias, activation }))
    }

    fn transmission(&mut self, element: &'a XmlElement) -> Fallible<Option<Transmission>> {
        let joint = element.get("joint").or_else(|| element.get("jointinparent"));
        if let Some(name) = joint {
            let joint = self.joint_named(element, name)?;
            let kind = self.model.joints[joint].kind;
            if matches!(kind, JointMotion::Hinge | JointMotion::Slide) {
                return Ok(Some(Transmission::Joints(vec![(joint, 1.0)])));
            }
            self.refuse_or_leave(
                element,
                "actuator",
                format!("actuator {} moves `{name}`, which is neither a hinge nor a slide", element.called()),
            );
            return Ok(None);
        }
        let Some(name) = element.get("tendon") else {
            self.refuse_or_leave(
                element,
                "actuator",
                format!(
                    "actuator {} acts on a site, a body or a slider-crank, which has no counterpart",
                    element.called()
                ),
            );
            return Ok(None);
        };
        if let Some(tendon) = self.fixed_tendons.get(name) {
            return Ok(Some(Transmission::Joints(tendon.terms.clone())));
        }
        if let Some(course) = self.spatial_tendons.get(name) {
            return Ok(Some(Transmission::Along(course.clone())));
        }
        self.refuse_or_leave(
            element,
            "actuator",
            format!("actuator {} pulls the tendon `{name}`, which is not imported", element.called()),
        );
        Ok(None)
    }

    /// The range of the joint, scaled about its middle.
    fn inherited(
        &self,
        element: &'a XmlElement,
        resolved: &ResolvedElement,
        transmission: &Transmission,
    ) -> Fallible<Option<[f64; 2]>> {
        let scale = resolved.number("inheritrange", 0.0)?;
        let Transmission::Joints(terms) = transmission else { return Ok(None) };
        if scale == 0.0 {
            return Ok(None);
        }
        let joint = &self.model.joints[terms[0].0];
        let Some([low, high]) = joint.laws.range.filter(|_| terms.len() == 1) else {
            return Err(ImportRefusal::new(format!(
                "{} inherits a range, but what it moves has none",
                element.called()
            ))
            .at(&element.place));
        };
        let (middle, half) = ((low + high) / 2.0 + joint.zero, (high - low) / 2.0 * scale);
        Ok(Some([middle - half, middle + half]))
    }
}
