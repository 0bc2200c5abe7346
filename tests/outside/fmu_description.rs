//! What an unpacked FMU of either version of FMI says about itself.

use std::path::{Path, PathBuf};

use super::xml::{Tag, attribute, tags};

/// A variable of the description.
#[derive(Clone, Debug)]
pub struct Variable {
    pub name: String,
    pub reference: u32,
    pub causality: String,
    pub variability: String,
    pub initial: Option<String>,
    pub start: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    /// What it is the derivative of: an index from 1 in FMI 2.0, a value reference in FMI 3.0.
    pub derivative: Option<u32>,
    /// May it be read in intermediate updates?
    #[allow(dead_code, reason = "there are none in FMI 2.0")]
    pub intermediate: bool,
}

/// The description, and the folder that it is in.
pub struct Description {
    pub folder: PathBuf,
    pub tags: Vec<Tag>,
    pub variables: Vec<Variable>,
}

impl Description {
    pub fn read(folder: &Path) -> Self {
        let document = std::fs::read(folder.join("modelDescription.xml")).expect("a description");
        let mut description = Self { folder: folder.to_owned(), tags: tags(&document), variables: vec![] };
        let join = |(scalar, real): (&Tag, &Tag)| (scalar.0.clone(), [&scalar.1[..], &real.1[..]].concat());
        let [scalars, reals] = ["/ScalarVariable", "/ScalarVariable/Real"].map(|end| description.below(end));
        let of_version_2 = scalars.into_iter().zip(reals).map(join);
        let of_version_3 = description.below("/ModelVariables/Float64").into_iter().cloned();
        description.variables = of_version_2.chain(of_version_3).map(|tag| variable(&tag)).collect();
        description
    }

    pub fn below(&self, end: &str) -> Vec<&Tag> {
        self.tags.iter().filter(|tag| tag.0.ends_with(end)).collect()
    }

    /// An attribute of the whole description.
    pub fn head(&self, name: &str) -> &str {
        attribute(&self.tags[0], name).expect("required")
    }

    /// A capability of an interface.
    pub fn flag(&self, interface: &str, name: &str) -> bool {
        let tags = self.below(&format!("fmiModelDescription/{interface}"));
        tags.first().is_some_and(|tag| attribute(tag, name) == Some("true"))
    }

    /// The name of the library.
    pub fn identifier(&self) -> &str {
        attribute(self.below("/CoSimulation")[0], "modelIdentifier").expect("required")
    }

    /// The library for the platform that this runs on.
    pub fn library_path(&self) -> PathBuf {
        let platform = cotree::export::runtime::Platform::host().expect("a platform with a name");
        let folder = if self.head("fmiVersion") == "2.0" { platform.folder } else { platform.tuple };
        self.folder.join(format!("binaries/{folder}/{}.{}", self.identifier(), platform.extension))
    }

    pub fn references(&self, wanted: impl Fn(&Variable) -> bool) -> Vec<u32> {
        self.variables.iter().filter(|variable| wanted(variable)).map(|variable| variable.reference).collect()
    }

    pub fn of_causality(&self, causality: &str) -> Vec<u32> {
        self.references(|variable| variable.causality == causality)
    }

    /// Inputs that are no derivatives of others.
    pub fn inputs(&self) -> Vec<u32> {
        self.references(|variable| variable.causality == "input" && variable.derivative.is_none())
    }

    pub fn parameters(&self, variability: &str) -> Vec<u32> {
        self.references(|variable| variable.causality == "parameter" && variable.variability == variability)
    }

    pub fn variable(&self, reference: u32) -> &Variable {
        self.variables.iter().find(|variable| variable.reference == reference).expect("known")
    }

    pub fn default(&self, reference: u32) -> f64 {
        self.variable(reference).start.expect("has a start value")
    }

    /// Another permitted value than the default: small, so that loops still close.
    pub fn other(&self, reference: u32) -> f64 {
        let start = self.default(reference);
        if start == 0.0 { 0.5 } else { start * 1.01 }
    }
}

fn variable(tag: &Tag) -> Variable {
    let text = |key| attribute(tag, key).map(str::to_owned);
    let number = |key| attribute(tag, key).map(|text| text.parse::<f64>().expect("a number"));
    Variable {
        name: text("name").expect("required"),
        reference: attribute(tag, "valueReference").expect("required").parse().expect("a number"),
        causality: text("causality").unwrap_or_else(|| "local".to_owned()),
        variability: text("variability").unwrap_or_else(|| "continuous".to_owned()),
        initial: text("initial"),
        start: number("start"),
        min: number("min"),
        max: number("max"),
        derivative: attribute(tag, "derivative").map(|text| text.parse().expect("a number")),
        intermediate: attribute(tag, "intermediateUpdate") == Some("true"),
    }
}

/// The functions of a shared library that the cases call.
#[macro_export]
macro_rules! library {
    ($($field:ident = $symbol:literal ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of the interface.
        pub struct Library {
            $(pub $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            _handle: libloading::Library,
        }

        impl Library {
            pub fn load(path: &Path) -> Self {
                // SAFETY: loading runs no code but that of the Rust runtime; the signatures are those of the standard.
                unsafe {
                    let handle = libloading::Library::new(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                    Self { $($field: *handle.get($symbol.as_bytes()).expect($symbol),)* _handle: handle }
                }
            }
        }

        /// Their names.
        #[allow(dead_code, reason = "where one list is of all functions of the standard")]
        pub const FUNCTIONS: &[&str] = &[$($symbol),*];
    };
}
