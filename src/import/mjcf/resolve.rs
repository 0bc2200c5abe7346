//! Attributes with the defaults of classes: that of the element wins, then that of the nearest class.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::import::refusal::{Fallible, ImportRefusal};
use crate::import::xml::{Attribute, XmlElement};

/// A class of defaults: its element and the class that it is in.
struct DefaultClass<'a> {
    element: &'a XmlElement,
    parent: Option<String>,
}

/// All classes by their names; the outermost is `main`, or what the file calls it.
pub struct Defaults<'a> {
    classes: BTreeMap<String, DefaultClass<'a>>,
    main: Vec<&'a XmlElement>,
}

impl<'a> Defaults<'a> {
    /// # Errors
    /// A class inside another without a name.
    pub fn new(root: &'a XmlElement) -> Fallible<Self> {
        let mut defaults = Defaults { classes: BTreeMap::new(), main: root.all("default").collect() };
        for main in root.all("default") {
            let name = main.get("class").unwrap_or("main").to_owned();
            defaults.add(main, name, None)?;
        }
        Ok(defaults)
    }

    fn add(&mut self, element: &'a XmlElement, name: String, parent: Option<String>) -> Fallible<()> {
        for child in element.all("default") {
            let class_name =
                child.get("class").ok_or_else(|| child.refuse("a default inside another needs a `class`"))?;
            self.add(child, class_name.to_owned(), Some(name.clone()))?;
        }
        self.classes.insert(name, DefaultClass { element, parent });
        Ok(())
    }

    /// The elements whose attributes count for one: itself, then the defaults of this kind from its class outwards.
    ///
    /// # Errors
    /// A class that the file does not define.
    pub fn of(&self, element: &'a XmlElement, kind: &str, childclass: Option<&str>) -> Fallible<ResolvedElement<'a>> {
        self.chain(element, &[kind], childclass)
    }

    /// The same with the defaults of several kinds, which are one in MuJoCo.
    ///
    /// # Errors
    /// A class that the file does not define.
    pub fn of_any(&self, element: &'a XmlElement, kinds: &[&str]) -> Fallible<ResolvedElement<'a>> {
        self.chain(element, kinds, None)
    }

    fn chain(
        &self,
        element: &'a XmlElement,
        kinds: &[&str],
        childclass: Option<&str>,
    ) -> Fallible<ResolvedElement<'a>> {
        let counts = |child: &&XmlElement| kinds.contains(&child.name.as_str());
        let mut chain = vec![element];
        let mut class = match (element.get("class"), childclass) {
            (Some(class_name), _) => Some(class_name.to_owned()),
            (None, outer) => outer.map(str::to_owned),
        };
        if let Some(name) = class.as_ref().filter(|name| !self.classes.contains_key(*name)) {
            return Err(
                element.refuse(format!("{} has the class `{name}`, which no default defines", element.called()))
            );
        }
        let mut outermost = true;
        while let Some(defaults) = class.and_then(|name| self.classes.get(&name)) {
            outermost &= defaults.parent.is_some();
            chain.extend(defaults.element.children.iter().rev().filter(counts));
            class = defaults.parent.clone();
        }
        if outermost {
            chain.extend(self.main.iter().rev().flat_map(|main| main.children.iter().rev().filter(counts)));
        }
        Ok(ResolvedElement { element, chain })
    }
}

/// An element with its defaults.
pub struct ResolvedElement<'a> {
    pub element: &'a XmlElement,
    chain: Vec<&'a XmlElement>,
}

impl<'a> ResolvedElement<'a> {
    pub fn attribute(&self, name: &str) -> Option<&'a Attribute> {
        self.chain.iter().find_map(|element| element.attribute(name))
    }

    pub fn get(&self, name: &str) -> Option<&'a str> {
        self.attribute(name).map(Attribute::value)
    }

    /// The first of some attributes that more defaults have and these do not.
    pub fn foreign(&self, more: &Self, names: &'static [&'static str]) -> Option<&'static str> {
        names.iter().copied().find(|name| self.attribute(name).is_none() && more.attribute(name).is_some())
    }

    /// # Errors
    /// It is not one number.
    pub fn number(&self, name: &str, default: f64) -> Fallible<f64> {
        self.attribute(name).map_or(Ok(default), Attribute::number)
    }

    /// # Errors
    /// It is not so many numbers.
    pub fn array<const N: usize>(&self, name: &str) -> Fallible<Option<[f64; N]>> {
        self.attribute(name).map(Attribute::array).transpose()
    }

    /// Numbers that may be fewer than MuJoCo has; the others are those of the default.
    ///
    /// # Errors
    /// What is not a number, or too many.
    pub fn some<const N: usize>(&self, name: &str, default: [f64; N]) -> Fallible<[f64; N]> {
        let Some(attribute) = self.attribute(name) else { return Ok(default) };
        let numbers = attribute.numbers()?;
        if numbers.len() > N {
            return Err(ImportRefusal::new(format!("`{name}` is `{}`, but has at most {N} numbers", attribute.value))
                .at(&attribute.place));
        }
        let mut values = default;
        values.iter_mut().zip(numbers).for_each(|(value, number)| *value = number);
        Ok(values)
    }

    /// # Errors
    /// It is neither `true` nor `false`.
    pub fn flag(&self, name: &str, default: bool) -> Fallible<bool> {
        match self.attribute(name).map(|attribute| (attribute, attribute.value())) {
            None => Ok(default),
            Some((_, "true")) => Ok(true),
            Some((_, "false")) => Ok(false),
            Some((attribute, value)) => {
                Err(ImportRefusal::new(format!("`{name}` is `{value}`, but must be `true` or `false`"))
                    .at(&attribute.place))
            }
        }
    }

    /// A range that counts where a key says so, or where it is given.
    ///
    /// # Errors
    /// A range that MuJoCo would not take.
    pub fn range(&self, range: &str, limited: &str, autolimits: bool) -> Fallible<Option<[f64; 2]>> {
        let interval = self.array::<2>(range)?;
        let wanted = match self.get(limited) {
            None | Some("auto") => None,
            Some("true") => Some(true),
            Some("false") => Some(false),
            Some(other) => {
                return Err(self
                    .element
                    .refuse(format!("`{limited}` is `{other}`, but must be `true`, `false` or `auto`")));
            }
        };
        let called = self.element.called();
        match (wanted, interval) {
            (Some(false), _) | (None, None) => Ok(None),
            (None, Some(_)) if !autolimits => Err(self
                .element
                .refuse(format!("{called} has `{range}`, but autolimits is false and `{limited}` is not given"))),
            (_, Some([low, high])) if low < high => Ok(Some([low, high])),
            (_, Some([low, high])) => {
                Err(self.element.refuse(format!("{called}: `{range}` is {low} {high}, but must increase")))
            }
            (Some(true), None) => Err(self.element.refuse(format!("{called} is limited, but has no `{range}`"))),
        }
    }

    /// Where its frame is.
    ///
    /// # Errors
    /// A rotation that is none.
    pub fn pose(&self, angles: &AngleUnits) -> Fallible<Isometry3<f64>> {
        let position = self.array::<3>("pos")?.map_or(Vector3::zeros(), Vector3::from);
        Ok(Isometry3::from_parts(Translation3::from(position), self.rotation(angles)?))
    }

    /// The rotation of its frame by one of the five ways of MJCF.
    ///
    /// # Errors
    /// Two of them, or an axis of length zero.
    pub fn rotation(&self, angles: &AngleUnits) -> Fallible<UnitQuaternion<f64>> {
        const WAYS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];
        // Whatever the element itself gives wins over its class.
        let given_ways: Vec<&str> = WAYS.into_iter().filter(|way| self.element.attribute(way).is_some()).collect();
        let given = if given_ways.is_empty() {
            WAYS.into_iter().filter(|way| self.attribute(way).is_some()).collect()
        } else {
            given_ways
        };
        let zero = |name: &str| self.element.refuse(format!("{}: `{name}` has the length zero", self.element.called()));
        match given[..] {
            [] => Ok(UnitQuaternion::identity()),
            ["quat"] => {
                let [w, x, y, z] = self.array::<4>("quat")?.unwrap_or_default();
                let quaternion = nalgebra::Quaternion::new(w, x, y, z);
                UnitQuaternion::try_new(quaternion, 1e-12).ok_or_else(|| zero("quat"))
            }
            ["axisangle"] => {
                let [x, y, z, angle] = self.array::<4>("axisangle")?.unwrap_or_default();
                let axis = Unit::try_new(Vector3::new(x, y, z), 1e-12).ok_or_else(|| zero("axisangle"))?;
                Ok(UnitQuaternion::from_axis_angle(&axis, angle * angles.unit))
            }
            ["euler"] => Ok(angles.euler(self.array::<3>("euler")?.unwrap_or_default())),
            ["xyaxes"] => {
                let [a, b, c, d, e, f] = self.array::<6>("xyaxes")?.unwrap_or_default();
                let x = Vector3::new(a, b, c).try_normalize(1e-12).ok_or_else(|| zero("xyaxes"))?;
                let y = Vector3::new(d, e, f);
                let y = (y - x * x.dot(&y)).try_normalize(1e-12).ok_or_else(|| zero("xyaxes"))?;
                let turn = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)]));
                Ok(UnitQuaternion::from_rotation_matrix(&turn))
            }
            ["zaxis"] => {
                along_z(Vector3::from(self.array::<3>("zaxis")?.unwrap_or_default())).ok_or_else(|| zero("zaxis"))
            }
            _ => Err(self.element.refuse(format!(
                "{} has more than one orientation: {}",
                self.element.called(),
                given.join(", ")
            ))),
        }
    }
}

/// The smallest rotation that takes z to a direction.
pub fn along_z(direction: Vector3<f64>) -> Option<UnitQuaternion<f64>> {
    let direction = direction.try_normalize(1e-12)?;
    let half = std::f64::consts::PI;
    Some(
        UnitQuaternion::rotation_between(&Vector3::z(), &direction)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), half)),
    )
}

/// How angles are written.
#[derive(Clone, Debug)]
pub struct AngleUnits {
    /// Radians of one unit.
    pub unit: f64,
    /// Three of `xyz` (axes of the body) or `XYZ` (fixed axes).
    pub sequence: String,
}

impl AngleUnits {
    fn euler(&self, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let mut turned = UnitQuaternion::identity();
        for (letter, angle) in self.sequence.chars().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            let turn = UnitQuaternion::from_axis_angle(&axis, angle * self.unit);
            turned = if letter.is_ascii_lowercase() { turned * turn } else { turn * turned };
        }
        turned
    }
}
