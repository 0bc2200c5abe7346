//! Shapes of bodies: their places, their density, and what they give the body.

use cotree_fmu::program::domain::Limit;

use super::context::Context;
use super::parts::KeyReader;
use super::{Resolver, UNKNOWN};
use crate::component::PartFrame;
use crate::component::shape::{ALL, DENSITY_KEY, Flaw, Shape, Solid};
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::model::measure::{ANYTHING, DENSITY, LENGTH};
use crate::model::{Body, Exponents, Formula, KeyValue, Range};
use crate::scene::decode::Fields;
use crate::scene::document::{Content, DocumentNode};
use crate::scene::key::{Form, Key, Need, names};
use crate::scene::unit::from_exponents;

/// A shape, and the mass that its density gives it.
pub(super) struct Shaped {
    pub solid: Solid,
    pub mass: Option<Formula>,
}

impl Resolver<'_> {
    /// The shape of a body whose points are in the frame in which they are written.
    pub(super) fn shape(
        &mut self,
        node: &DocumentNode,
        body_fields: &Fields<'_>,
        body: &Body,
        has_centre: bool,
    ) -> Option<Shaped> {
        let owner = body_fields.name_of("shape");
        self.must_have_plane(&owner, node.span);
        let component = self.kind_of_shape(node, &owner)?;
        let keys = component.all_keys();
        let fields = Fields::open(node, &owner, node.span, &names(&keys), self.faults)?;
        let corners = self.corners(&component.place, &fields, body, None)?;
        self.check_corners(component, &corners, &fields)?;
        if has_centre && body.inertia.is_none() {
            let message = format!("{} has a shape and `com`, but no `inertia`", body_fields.owner);
            let span = body_fields.key_span("com").unwrap_or(node.span);
            let help = "remove `com`: the mass centre is that of the shape; or give `inertia` about the mass centre, if the mass is not uniform";
            self.faults.push(Fault::new("scene::shape", message, span).label("not the shape's own").help(help));
        }
        let mut values: Vec<(&str, Formula)> = Vec::new();
        for key in component.keys {
            let Need::Required(help) = key.need else { continue };
            let node = fields.required(key.name, help, self.faults)?;
            values.push((key.name, self.shape_number(key, node, &fields)?));
        }
        let value =
            |name: &str| values.iter().find(|(key, _)| *key == name).map_or(UNKNOWN, |(_, value)| value.clone());
        let solid = (component.solid)(&corners, &value);
        self.keep_size(&solid, &owner);
        let mass = self.mass_of_shape(component, &fields, body).map(|density| density * solid.size.clone());
        Some(Shaped { solid, mass })
    }

    /// The shape that a table names.
    fn kind_of_shape(&mut self, node: &DocumentNode, owner: &str) -> Option<&'static Shape> {
        let fields = Fields::open_any(node, owner, node.span, self.faults)?;
        let given: Vec<_> = ALL.iter().filter(|shape| fields.get(shape.place.name).is_some()).collect();
        if let [only] = given[..] {
            return Some(*only);
        }
        let kinds = || ALL.iter().map(|shape| shape.place.name);
        let found = match given.is_empty() {
            true => "none of them".to_string(),
            false => suggest::list(given.iter().map(|shape| shape.place.name)),
        };
        let message = format!("{owner} must have exactly one of {}, but has {found}", suggest::list(kinds()));
        let span = given.get(1).and_then(|shape| fields.key_span(shape.place.name)).unwrap_or(node.span);
        let help = "such as `shape = { rod = [\"POINT\", \"POINT\"], density = \"2.1 kg/m\" }`";
        self.faults.push(Fault::new("scene::shape", message, span).label("exactly one is needed").help(help));
        None
    }

    fn shape_number(&mut self, key: &'static Key, node: &DocumentNode, fields: &Fields<'_>) -> Option<Formula> {
        let reader = KeyReader { fields, user: &fields.owner, context: Context::Constant };
        match self.value_of(key, node, &reader)? {
            KeyValue::Formula(formula) => Some(formula),
            _ => None,
        }
    }

    /// The places that a shape's or an outline's first key names. Coordinates are in a frame, or else in that of the body's points.
    pub(super) fn corners(
        &mut self,
        key: &Key,
        fields: &Fields<'_>,
        body: &Body,
        frame: Option<&PartFrame>,
    ) -> Option<Vec<[Formula; 2]>> {
        let (node, what) = (fields.get(key.name)?, fields.name_of(key.name));
        let Form::Corners(least, most) = key.form else {
            return Some(vec![self.corner(node, &what, body, frame)?]);
        };
        let Content::Array(items) = &node.kind else {
            let message = format!("{what} is {}, but must be a list of points", node.kind.name());
            let help = "write each point by its name or by two coordinates: `[\"POINT\", [0.2, 0.1]]`";
            self.faults.push(Fault::new("scene::wrong_type", message, node.span).label("not a list").help(help));
            return None;
        };
        if items.len() < least || items.len() > most {
            let wanted = match least == most {
                true => format!("{least} points"),
                false => format!("{least} to {most} points"),
            };
            let message = format!("{what} has {}, but must have {wanted}", items.len());
            self.faults
                .push(Fault::new("scene::wrong_value", message, node.span).label(format!("{wanted} are needed")));
            return None;
        }
        let corners: Vec<Option<_>> = items.iter().map(|item| self.corner(item, &what, body, frame)).collect();
        corners.into_iter().collect()
    }

    /// A point of the body by its name, or two coordinates.
    fn corner(
        &mut self,
        node: &DocumentNode,
        what: &str,
        body: &Body,
        frame: Option<&PartFrame>,
    ) -> Option<[Formula; 2]> {
        let Content::Text(name) = &node.kind else {
            let at = self.faults.vector(node, what)?;
            let at = self.vector(&at, what, &LENGTH, Context::Constant);
            return Some(frame.map_or_else(|| at.clone(), |frame| frame.place(at.clone())));
        };
        if let Some(point) = body.points.iter().find(|point| point.name == *name) {
            return Some(point.at.clone());
        }
        if !self.is_reported(&Text::new(name.as_str(), node.span), &format!("{}.{name}", body.name)) {
            let names = || body.points.iter().map(|point| point.name.as_str());
            let whose = if body.name == "ground" { "the ground".to_owned() } else { format!("body `{}`", body.name) };
            let otherwise = match body.points.is_empty() {
                true => format!("give it in `points` of {whose}, or write two coordinates"),
                false => format!("{whose} has the points {}", suggest::list(names())),
            };
            let message = format!("{what} uses a point that {whose} does not have: `{name}`");
            let fault = Fault::new("scene::unknown_point", message, node.span).label("no such point");
            self.faults.push(fault.help(suggest::hint(name, names(), otherwise)));
        }
        None
    }

    /// A shape that parameters turn inside out has no mass.
    fn keep_size(&mut self, solid: &Solid, owner: &str) {
        let sizes = [
            ("size", &solid.size, Limit::Positive),
            ("square of the gyration radius", &solid.gyration, Limit::NotNegative),
        ];
        for (what, value, limit) in sizes {
            if limit.allows(self.value(value)) {
                self.keep_within(format!("the {what} of {owner}"), value, limit);
            }
        }
    }

    /// Refuses corners that make no shape with the default parameters.
    fn check_corners(&mut self, shape: &Shape, corners: &[[Formula; 2]], fields: &Fields<'_>) -> Option<()> {
        let values: Vec<[f64; 2]> = corners.iter().map(|at| at.each_ref().map(|x| self.value(x))).collect();
        if values.iter().flatten().any(|x| !x.is_finite()) {
            return Some(()); // has a fault of its own
        }
        let Some(flaw) = (shape.flaw)(&values) else { return Some(()) };
        self.refuse_corners(shape.place.name, flaw, fields)
    }

    /// Says what is wrong with the corners under a key.
    pub(super) fn refuse_corners(&mut self, name: &str, flaw: Flaw, fields: &Fields<'_>) -> Option<()> {
        let (index, problem, help) = flaw;
        let node = fields.get(name)?;
        let span = match &node.kind {
            Content::Array(items) => items.get(index).map_or(node.span, |item| item.span),
            _ => node.span,
        };
        let message = format!("{} {problem}", fields.name_of(name));
        self.faults.push(Fault::new("scene::shape", message, span).label("here").help(help));
        None
    }

    /// The mass of one unit of size, if a density gives it.
    fn mass_of_shape(&mut self, shape: &Shape, fields: &Fields<'_>, body: &Body) -> Option<Formula> {
        let depth_key = &shape.depth;
        let depth = fields.get(depth_key.name);
        if body.mass.is_some() || fields.get(DENSITY_KEY.name).is_none() {
            let why = if body.mass.is_some() { "beside `mass` of the body" } else { "without `density`" };
            for key in [DENSITY_KEY.name, depth_key.name] {
                if let Some(span) = fields.key_span(key) {
                    self.without_effect(&format!("`{key}`"), &fields.owner, why, span);
                }
            }
            return None;
        }
        // What is wrong with it is no lack of mass.
        Some(self.density_of_size(shape, fields, depth).unwrap_or(UNKNOWN))
    }

    fn density_of_size(&mut self, shape: &Shape, fields: &Fields<'_>, depth: Option<&DocumentNode>) -> Option<Formula> {
        let depth_key = &shape.depth;
        let (density, is_per_size) = self.density(shape, fields)?;
        match (depth, is_per_size) {
            (Some(node), false) => {
                let form = depth_key.form;
                let Form::Constant(wanted, _) = form else { return None };
                let quantity = self.faults.quantity(node, &fields.name_of(depth_key.name))?;
                let what = fields.name_of(depth_key.name);
                Some(density * self.constant_in(Range::Positive, &quantity, &what, &wanted))
            }
            (None, true) => Some(density),
            (Some(_), true) => {
                let unit = shape.density.si;
                let message =
                    format!("{} has `{}`, but its density is in `{unit}` already", fields.owner, depth_key.name);
                let span = fields.key_span(depth_key.name).unwrap_or(fields.span);
                let help = format!("remove `{}`, or give the density in `kg/m3`", depth_key.name);
                self.faults.push(Fault::new("scene::shape", message, span).label("one too many").help(help));
                None
            }
            (None, false) => {
                let unit = shape.density.si;
                let message = format!("{} has a density in `kg/m3`, but no `{}`", fields.owner, depth_key.name);
                let span = fields.key_span(DENSITY_KEY.name).unwrap_or(fields.span);
                let help = format!("give `{}` too, or the density in `{unit}` with its unit", depth_key.name);
                self.faults.push(Fault::new("scene::shape", message, span).label("per volume").help(help));
                None
            }
        }
    }

    /// The density, and whether it is that of the size: per length or area. A number without a unit is in kg/m3.
    fn density(&mut self, shape: &Shape, fields: &Fields<'_>) -> Option<(Formula, bool)> {
        let (key, what) = (DENSITY_KEY.name, fields.name_of(DENSITY_KEY.name));
        let quantity = self.faults.quantity(fields.get(key)?, &what)?;
        let (formula, unit) = self.formula_and_unit(&quantity, &what, &ANYTHING, Context::Constant);
        let density = shape.density;
        let exponents = unit.map(|unit| unit.exponents);
        let is = |wanted: Option<Exponents>| wanted.zip(exponents).is_some_and(|(a, b)| a.is_compatible(b));
        if exponents.is_some() && !is(DENSITY.exponents) && !is(density.exponents) {
            let found = exponents.map(|exponents| from_exponents(exponents).si).unwrap_or_default();
            let message = format!("{what} must be a density, but is in `{found}`");
            let help = format!("give it in `kg/m3` with `{}`, or in `{}` without", shape.depth.name, density.si);
            let fault = Fault::new("scene::wrong_unit", message, quantity.span).label("not a density of this shape");
            self.faults.push(fault.help(help));
            return None;
        }
        let is_per_size = is(density.exponents);
        let wanted = if is_per_size { density } else { DENSITY };
        Some((self.check_positive(formula, &quantity, &what, &wanted), is_per_size))
    }
}
