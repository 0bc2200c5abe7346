//! What the shared libraries inside an FMU are made of: for the licence text, and as a bill of materials that tools read (CycloneDX 1.5).

use serde_json::{Value, json};

/// The versions that the runtime is built from, a line `name version` for each package of the lock file.
const VERSIONS: &str = include_str!(concat!(env!("OUT_DIR"), "/versions"));

/// A library inside the runtime.
struct LinkedLibrary {
    /// Its name as a crate.
    name: &'static str,
    /// Under what it comes, as an SPDX expression.
    license: &'static str,
    /// Its own copyright line, or who wrote it where it has none.
    copyright: &'static str,
}

const fn library(name: &'static str, license: &'static str, copyright: &'static str) -> LinkedLibrary {
    LinkedLibrary { name, license, copyright }
}

const MIT_OR_APACHE: &str = "MIT OR Apache-2.0";
const ZLIB_TOO: &str = "Zlib OR Apache-2.0 OR MIT";
const NUM: &str = "Copyright (c) 2014 The Rust Project Developers";

/// All of them, without the standard library of Rust.
const LIBRARIES: [LinkedLibrary; 19] = [
    library("approx", "Apache-2.0", "Copyright 2015 Brendan Zabarauskas"),
    library("bytemuck", ZLIB_TOO, "Copyright (c) 2019 Daniel \"Lokathor\" Gee."),
    library("cobs", MIT_OR_APACHE, "Copyright (c) 2015 The cobs.rs Developers"),
    library("libm", "MIT", "Copyright (c) 2018 Jorge Aparicio; and see the notice of libm below"),
    library(
        "matrixmultiply",
        MIT_OR_APACHE,
        "Copyright (c) 2016 - 2023 Ulrik Sverdrup \"bluss\", (c) 2018 R. Janis Goldschmidt, (c) 2021 DutchGhost [constparse.rs]",
    ),
    library("nalgebra", "Apache-2.0", "Copyright 2020 Sébastien Crozet"),
    library("num-complex", MIT_OR_APACHE, NUM),
    library("num-integer", MIT_OR_APACHE, NUM),
    library("num-rational", MIT_OR_APACHE, NUM),
    library("num-traits", MIT_OR_APACHE, NUM),
    library("postcard", MIT_OR_APACHE, "Copyright (c) 2019 Anthony James Munns"),
    library("rawpointer", MIT_OR_APACHE, "Copyright (c) 2015 bluss"),
    library("safe_arch", ZLIB_TOO, "Copyright (c) 2023 Daniel \"Lokathor\" Gee."),
    library("serde", MIT_OR_APACHE, "Erick Tryzelaar and David Tolnay"),
    library("serde_core", MIT_OR_APACHE, "Erick Tryzelaar and David Tolnay"),
    library("simba", "Apache-2.0", "Copyright 2020 Sébastien Crozet"),
    library("thiserror", MIT_OR_APACHE, "David Tolnay"),
    library("typenum", MIT_OR_APACHE, "Copyright (c) 2014 Paho Lurie-Gregg"),
    library("wide", ZLIB_TOO, "Copyright (c) 2020 Daniel \"Lokathor\" Gee"),
];

impl LinkedLibrary {
    /// The version in the lock file of this build.
    fn version(&self) -> &'static str {
        let mut lines = VERSIONS.lines().filter_map(|line| line.split_once(' '));
        lines.find(|(name, _)| *name == self.name).map_or("", |(_, version)| version)
    }
}

/// A line or two for each library, for the licence text.
pub(super) fn notices() -> String {
    let one = |library: &LinkedLibrary| {
        format!("  {} {}, {}\n      {}\n", library.name, library.version(), library.license, library.copyright)
    };
    let standard = library("the Rust standard library", MIT_OR_APACHE, "Copyright (c) The Rust Project Contributors");
    let last = format!("  {}, {}\n      {}\n", standard.name, standard.license, standard.copyright);
    LIBRARIES.iter().map(one).chain([last]).collect()
}

/// The bill of materials. It has no date and no serial number: the same FMU has the same.
pub(super) fn bill_of_materials() -> String {
    let components: Vec<Value> = LIBRARIES.iter().map(component).collect();
    let runtime = json!({
        "type": "library",
        "bom-ref": "cotree-runtime",
        "name": "cotree-runtime",
        "version": env!("CARGO_PKG_VERSION"),
        "licenses": [{ "expression": env!("CARGO_PKG_LICENSE") }],
    });
    let on: Vec<&Value> = components.iter().map(|component| &component["bom-ref"]).collect();
    let bill = json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": { "component": runtime },
        "dependencies": [{ "ref": "cotree-runtime", "dependsOn": on }],
        "components": components,
    });
    format!("{bill:#}\n")
}

fn component(linked_library: &LinkedLibrary) -> Value {
    let reference = format!("pkg:cargo/{}@{}", linked_library.name, linked_library.version());
    json!({
        "type": "library",
        "bom-ref": reference,
        "name": linked_library.name,
        "version": linked_library.version(),
        "licenses": [{ "expression": linked_library.license }],
        "copyright": linked_library.copyright,
        "purl": reference,
    })
}
