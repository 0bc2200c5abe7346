//! The archive and the model description, by the rules of FMI 2.0 that an importer relies on.

use crate::support::ROOT;
use std::collections::BTreeSet;
use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;

use cotree::export::FmiVersion;
use cotree::export::archive::{Package, pack, write};
use cotree::export::description::{Causality, Description, ScalarVariable, StartValue, Type, Variability};
use cotree::export::runtime::{LIBRARY, Platform, Runtime};
use cotree::export::scene_text::SceneText;
use cotree::export::xml::fmi2 as xml;
use cotree::model::{DisplayUnit, Experiment, Exponents, Unit};
use cotree::scene::{Scene, Source};
use cotree_draw::drawing::{Drawing, DrawnBody};
use cotree_fmu::context::Statistics;
use cotree_fmu::instance::InstanceError;
use cotree_fmu::program::Engine;
use cotree_page::MotionlessError;
use cotree_page::accuracy::{Accuracy, Measurement};
use cotree_page::documentation::DocumentationPage;
use cotree_page::page::{Facts, Live, preformatted};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

fn unit(si: &str, exponents: Exponents, display: Option<(&str, f64)>) -> Unit {
    let display = display.map(|(name, factor)| DisplayUnit { name: name.into(), factor });
    Unit { exponents, si: si.into(), display }
}

fn variable(name: &str, unit: Unit, causality: Causality) -> ScalarVariable {
    ScalarVariable::new(name.into(), format!("the <{name}> & \"more\"\nof it"), unit, causality)
}

/// A pendulum: states angle and omega, an input torque, two parameters.
fn pendulum() -> Description {
    let rad = |si, exponents| unit(si, exponents, None);
    let length = Causality::Parameter { start: 0.5, min: Some(0.1), max: None };
    let damping = Causality::Parameter { start: 1e-7, min: None, max: Some(3.0) };
    let torque = Causality::Input { start: 0.0, min: None, max: None };
    let angle = ScalarVariable {
        state: None,
        dependencies: vec![4].into(),
        ..variable(
            "arm.angle",
            unit("rad", Exponents::RADIAN, Some(("deg", std::f64::consts::PI / 180.0))),
            Causality::Output,
        )
    };
    let omega = ScalarVariable {
        derivative_of: Some(4),
        dependencies: vec![5].into(),
        ..variable("arm.omega", rad("rad/s", Exponents::RADIAN.over(Exponents::SECOND)), Causality::Local)
    };
    let alpha = ScalarVariable {
        derivative_of: Some(5),
        dependencies: vec![5, 3, 4, 3].into(),
        state: None,
        ..variable("arm.alpha", rad("rad/s2", Exponents::RADIAN.over(Exponents::SECOND.squared())), Causality::Output)
    };
    Description {
        model_name: "pendulum".into(),
        identifier: "pendulum".into(),
        guid: "{0123}".into(),
        description: "A \"pendulum\" & its <arm>".into(),
        credits: Vec::new(),
        experiment: Experiment { start: 0.0, stop: 10.0, step: 1e-3, tolerance: 1e-6 },
        exchange: Some(2),
        exchange_with_rates: true,
        at_profile: None,
        indicators: 2,
        own_steps: true,
        followed: Vec::new(),
        moves_states: false,
        variables: vec![
            variable("time", unit("s", Exponents::SECOND, None), Causality::Independent),
            ScalarVariable {
                variability: Variability::Fixed,
                ..variable("length", unit("m", Exponents::METRE, Some(("mm", 1e-3))), length)
            },
            ScalarVariable {
                variability: Variability::Tunable,
                ..variable("damping", unit("N.m.s", Exponents::JOULE.times(Exponents::SECOND), None), damping)
            },
            variable("torque", unit("N.m", Exponents::JOULE, None), torque),
            angle,
            omega,
            alpha,
        ],
        terminals: vec![],
        sources: None,
    }
}

/// Every start tag of a document: path of names, and attributes.
fn tags(document: &[u8]) -> Vec<(String, Vec<(String, String)>)> {
    let mut reader = Reader::from_reader(document);
    let (mut tags, mut path, mut buffer) = (vec![], Vec::<String>::new(), vec![]);
    loop {
        match reader.read_event_into(&mut buffer).unwrap() {
            Event::Start(tag) => {
                path.push(name(&tag));
                tags.push((path.join("/"), attributes(&tag)));
            }
            Event::Empty(tag) => tags.push((format!("{}/{}", path.join("/"), name(&tag)), attributes(&tag))),
            Event::End(_) => drop(path.pop()),
            Event::Eof => return tags,
            _ => {}
        }
        buffer.clear();
    }
}

fn name(tag: &BytesStart) -> String {
    tag.name().as_ref().to_owned()
}

fn attributes(tag: &BytesStart) -> Vec<(String, String)> {
    tag.attributes()
        .map(|attribute| {
            let attribute = attribute.unwrap();
            let value = quick_xml::escape::unescape(&attribute.value).unwrap().into_owned();
            (attribute.key.as_ref().to_owned(), value)
        })
        .collect()
}

fn get<'a>(attributes: &'a [(String, String)], key: &str) -> Option<&'a str> {
    attributes.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
}

/// The tags whose path ends like this.
fn below(document: &[u8], end: &str) -> Vec<Vec<(String, String)>> {
    tags(document).into_iter().filter(|(path, _)| path.ends_with(end)).map(|(_, attributes)| attributes).collect()
}

fn document() -> Vec<u8> {
    xml::model_description(&pendulum()).unwrap()
}

#[test]
fn header_and_capabilities() {
    let document = document();
    let header = &below(&document, "fmiModelDescription")[0];
    assert_eq!(get(header, "fmiVersion"), Some("2.0"));
    assert_eq!(get(header, "guid"), Some("{0123}"));
    assert_eq!(get(header, "description"), Some("A \"pendulum\" & its <arm>"));
    assert_eq!(get(header, "variableNamingConvention"), Some("structured"));
    assert_eq!(get(header, "generationDateAndTime"), None);
    let flags = &below(&document, "/CoSimulation")[0];
    assert_eq!(get(flags, "modelIdentifier"), Some("pendulum"));
    assert_eq!(get(flags, "canSerializeFMUstate"), Some("true"));
    assert_eq!(get(flags, "canGetAndSetFMUstate"), Some("true"));
    let experiment = &below(&document, "/DefaultExperiment")[0];
    assert_eq!(get(experiment, "stopTime"), Some("10.0"));
    assert_eq!(get(experiment, "stepSize"), Some("0.001"));
}

#[test]
fn sections_stand_in_the_order_of_the_schema() {
    let order: Vec<String> = tags(&document())
        .into_iter()
        .filter_map(|(path, _)| path.strip_prefix("fmiModelDescription/").map(str::to_owned))
        .filter(|path| !path.contains('/'))
        .collect();
    let wanted = [
        "ModelExchange",
        "CoSimulation",
        "UnitDefinitions",
        "LogCategories",
        "DefaultExperiment",
        "ModelVariables",
        "ModelStructure",
    ];
    assert_eq!(order, wanted);
}

#[test]
fn start_values_exactly_where_they_belong() {
    let document = document();
    let scalars = below(&document, "/ScalarVariable");
    let reals = below(&document, "/ScalarVariable/Real");
    assert_eq!(scalars.len(), reals.len());
    for (index, (scalar, real)) in scalars.iter().zip(&reals).enumerate() {
        assert_eq!(get(scalar, "valueReference"), Some(index.to_string().as_str()));
        let settable = matches!(get(scalar, "causality"), Some("parameter" | "input"));
        assert_eq!(get(real, "start").is_some(), settable, "{scalar:?}");
        let initial = match get(scalar, "causality") {
            Some("parameter") => Some("exact"),
            Some("output" | "local") => Some("calculated"),
            _ => None,
        };
        assert_eq!(get(scalar, "initial"), initial, "{scalar:?}");
    }
    assert_eq!(get(&reals[1], "min"), Some("0.1"));
    assert_eq!(get(&reals[2], "start"), Some("1e-7"));
    assert_eq!(get(&scalars[1], "variability"), Some("fixed"));
    assert_eq!(get(&scalars[2], "variability"), Some("tunable"));
}

#[test]
fn every_unit_used_is_defined() {
    let document = document();
    let names = |end: &str| -> BTreeSet<String> {
        below(&document, end).iter().filter_map(|tag| get(tag, "name").map(str::to_owned)).collect()
    };
    for real in below(&document, "/Real") {
        assert!(names("/Unit").contains(get(&real, "unit").unwrap()), "{real:?}");
        assert!(get(&real, "displayUnit").is_none_or(|unit| names("/DisplayUnit").contains(unit)), "{real:?}");
    }
    let factor = |name: &str| {
        let displays = below(&document, "/DisplayUnit");
        let display = displays.iter().find(|tag| get(tag, "name") == Some(name)).unwrap();
        get(display, "factor").unwrap().parse::<f64>().unwrap()
    };
    assert_eq!(factor("mm"), 1000.0); // 1 m is 1000 mm
    assert!((factor("deg") - 57.295_779_513).abs() < 1e-9);
}

/// Index and dependencies of every unknown in a list.
fn unknowns(document: &[u8], list: &str) -> Vec<(usize, Vec<usize>)> {
    below(document, &format!("/{list}/Unknown"))
        .iter()
        .map(|unknown| {
            let on = get(unknown, "dependencies").unwrap().split_whitespace().map(|on| on.parse().unwrap()).collect();
            (get(unknown, "index").unwrap().parse().unwrap(), on)
        })
        .collect()
}

#[test]
fn model_structure_lists_what_the_standard_wants() {
    let document = document();
    assert_eq!(unknowns(&document, "Outputs"), [(5, vec![5]), (7, vec![4, 5, 6])]);
    assert_eq!(unknowns(&document, "Derivatives"), [(6, vec![6]), (7, vec![4, 5, 6])]);
    let initial = below(&document, "/InitialUnknowns/Unknown");
    assert_eq!(initial, [5, 6, 7].map(|index: usize| vec![("index".to_owned(), index.to_string())]));
}

/// As the pendulum, with a mode that counts and a contact that is open or closed, both read at events, and a switch that is set.
fn with_events() -> Description {
    let mut description = pendulum();
    let named = |name: &str, kind: Type, causality: Causality| ScalarVariable {
        kind,
        variability: Variability::Discrete,
        ..variable(name, Unit::length(), causality)
    };
    let switch = Causality::Input { start: 1.0, min: Some(0.0), max: Some(1.0) };
    let gear = Causality::Input { start: 3.0, min: Some(-1.0), max: Some(5.0) };
    description.variables.extend([
        named("mode", Type::Integer, Causality::Output),
        named("closed", Type::Boolean, Causality::Output),
        named("switch", Type::Boolean, switch),
        named("gear", Type::Integer, gear),
        named("sample", Type::Real, Causality::Output),
    ]);
    description
}

#[test]
fn integers_and_booleans_are_described_as_each_version_does() {
    let description = with_events();
    let second = xml::model_description(&description).unwrap();
    let third = cotree::export::xml::fmi3::model_description(&description).unwrap();
    let named = |tags: Vec<Vec<(String, String)>>, name: &str| {
        tags.into_iter().find(|tag| get(tag, "name") == Some(name)).expect("it is there")
    };
    for name in ["mode", "closed", "switch", "gear", "sample"] {
        let scalar = named(below(&second, "/ScalarVariable"), name);
        assert_eq!(get(&scalar, "variability"), Some("discrete"), "{name}");
    }
    // No unit, and of a Boolean no bounds.
    let tag = |pairs: &[(&str, &str)]| pairs.iter().map(|(a, b)| ((*a).into(), (*b).into())).collect::<Vec<_>>();
    let none = Vec::new;
    let bounded = tag(&[("min", "-1"), ("max", "5"), ("start", "3")]);
    assert_eq!(below(&second, "/ScalarVariable/Integer"), [none(), bounded]);
    assert_eq!(below(&second, "/ScalarVariable/Boolean"), [none(), tag(&[("start", "true")])]);
    for (element, name, wanted) in [
        ("Int32", "mode", vec![("causality", "output"), ("initial", "calculated")]),
        ("Boolean", "closed", vec![("causality", "output")]),
        ("Boolean", "switch", vec![("causality", "input"), ("start", "true")]),
        ("Int32", "gear", vec![("min", "-1"), ("max", "5"), ("start", "3")]),
        ("Float64", "sample", vec![("unit", "m"), ("causality", "output")]),
    ] {
        let found = named(below(&third, &format!("/ModelVariables/{element}")), name);
        wanted.into_iter().for_each(|(key, text)| assert_eq!(get(&found, key), Some(text), "{name}"));
        assert_eq!(get(&found, "variability"), Some("discrete"), "{name}");
        // What changes at events is read at events.
        assert_eq!(get(&found, "intermediateUpdate"), None, "{name}");
        assert_eq!(get(&found, "unit").is_some(), element == "Float64", "{name}");
    }
}

#[test]
fn empty_lists_are_left_out() {
    let variables = vec![variable("time", Unit::default(), Causality::Independent)];
    let document = xml::model_description(&Description { variables, ..pendulum() }).unwrap();
    for list in ["Outputs", "Derivatives", "InitialUnknowns", "UnitDefinitions"] {
        assert!(below(&document, &format!("/{list}")).is_empty(), "{list}");
    }
}

#[test]
fn names_outside_the_structured_convention_are_called_flat() {
    let mut description = pendulum();
    description.variables[1].name = "länge".into();
    let document = xml::model_description(&description).unwrap();
    assert_eq!(get(&below(&document, "fmiModelDescription")[0], "variableNamingConvention"), Some("flat"));
}

/// What the archive is made of, apart from the description.
struct Parts {
    source: Source,
    description: Description,
    drawing: Drawing,
    facts: Facts,
    live: Result<Live, MotionlessError>,
    accuracy: Result<Accuracy, MotionlessError>,
    runtimes: Vec<Runtime>,
}

impl Parts {
    fn new() -> Self {
        let body = DrawnBody {
            name: "arm".into(),
            points: vec![[0.0, 0.0], [1.0, 0.5]],
            centre: [0.5, 0.25],
            ..DrawnBody::default()
        };
        let measurement = |tolerance: f64, evaluations| Measurement {
            tolerance,
            error: 3.0 * tolerance,
            statistics: Statistics { steps: evaluations / 12, rejected: 1, evaluations, ..Statistics::default() },
        };
        Self {
            description: pendulum(),
            drawing: Drawing { bodies: vec![body], ..Drawing::default() },
            facts: Facts {
                summary: "freedoms 1".into(),
                graphs: String::new(),
                equations: preformatted("Q[1] = a < b\n  Q[2] = 0\n"),
            },
            live: Err(InstanceError::Calculated { name: "a < b".into() }.into()),
            accuracy: Ok(Accuracy {
                span: [0.0, 2.5],
                growing: false,
                engine: Engine::Dop853,
                measurements: vec![measurement(1e-4, 240), measurement(1e-6, 600)],
                attainable: 0.0,
                inaccuracy: None,
            }),
            runtimes: vec![Runtime::embedded().unwrap()],
            source: Source::new("scene.toml", "format = 1\n"),
        }
    }

    fn page(&self) -> DocumentationPage<'_> {
        DocumentationPage { drawing: &self.drawing, facts: &self.facts, accuracy: &self.accuracy, live: &self.live }
    }

    fn package(&self) -> Package<'_> {
        let scene = Some(SceneText { extension: "toml", source: &self.source });
        let Self { description, runtimes, .. } = self;
        let extras = self.page().files(description, FmiVersion::V2).unwrap();
        Package { version: FmiVersion::V2, description, program: b"program", scene, extras, runtimes }
    }
}

type Archive = zip::ZipArchive<Cursor<Vec<u8>>>;

fn packed(parts: &Parts) -> Archive {
    Archive::new(Cursor::new(pack(&parts.package()).unwrap())).unwrap()
}

fn names(archive: &Archive) -> Vec<String> {
    archive.file_names().map(|name| name.unwrap().into_owned()).collect()
}

fn content(archive: &mut Archive, name: &str) -> Vec<u8> {
    let mut content = vec![];
    archive.by_name(name).unwrap().read_to_end(&mut content).unwrap();
    content
}

#[test]
fn the_same_package_gives_the_same_bytes() {
    assert!(pack(&Parts::new().package()).unwrap() == pack(&Parts::new().package()).unwrap());
}

#[test]
fn the_archive_is_plain_and_complete() {
    let mut archive = packed(&Parts::new());
    let platform = Platform::host().unwrap();
    let library = format!("binaries/{}/pendulum.{}", platform.folder, platform.extension);
    let wanted = [
        library.as_str(),
        "documentation/index.html",
        "documentation/licenses/apache-2.0.txt",
        "documentation/licenses/license.txt",
        "documentation/licenses/sbom.cdx.json",
        "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml",
        "model.png",
        "modelDescription.xml",
        "resources/program.bin",
        "resources/scene.toml",
    ];
    assert_eq!(names(&archive), wanted);
    for index in 0..archive.len() {
        let file = archive.by_index(index).unwrap();
        assert_eq!(file.compression(), zip::CompressionMethod::Deflated);
        assert!(!file.is_symlink() && !file.encrypted());
    }
    // The folder of whoever built it is dots there.
    let packed = content(&mut archive, &library);
    assert_eq!(packed.len(), LIBRARY.len());
    assert!(packed.iter().zip(LIBRARY).all(|(byte, built)| byte == built || *byte == b'.'));
}

/// The manifest of FMI-LS-REF: its files are there, each with its role.
#[test]
fn other_tools_find_the_scene_and_the_page_by_their_roles() {
    let mut archive = packed(&Parts::new());
    let place = "extra/org.fmi-standard.fmi-ls-ref";
    let manifest = content(&mut archive, &format!("{place}/fmi-ls-manifest.xml"));
    let head = &below(&manifest, "fmiReferences")[0];
    assert_eq!(get(head, "fmi-ls:fmi-ls-name"), Some("org.fmi-standard.fmi-ls-ref"));
    let related = below(&manifest, "fmiReferences/Related");
    let roles: Vec<[&str; 2]> = related.iter().map(|tag| ["role", "type"].map(|key| get(tag, key).unwrap())).collect();
    assert_eq!(roles, [["model", "application/toml"], ["report", "text/html"]]);
    for tag in related {
        let name = get(&tag, "source").unwrap().strip_prefix("../../").unwrap().to_owned();
        assert!(!content(&mut archive, &name).is_empty(), "{name}");
    }
}

#[test]
fn a_scene_says_who_made_it_and_how_it_may_be_used() {
    let given =
        [("author", "A. <Watt>"), ("version", "1.2"), ("license", "CC-BY-4.0"), ("copyright", "2026 Watt & Co")];
    let keys: String = given.iter().map(|(key, text)| format!("{key} = \"{text}\"\n")).collect();
    let text = fs::read_to_string(Path::new(ROOT).join("models/pendulum/scene.toml")).unwrap();
    let scene =
        Scene::from_toml(&format!("{keys}{text}")).unwrap_or_else(|faults| panic!("{}", faults.render(false, 100)));
    let built = Scene::new("built")
        .author("nobody")
        .author(given[0].1)
        .version("1.2")
        .license("CC-BY-4.0")
        .copyright(given[3].1);
    assert_eq!(built.credits, scene.credits);
    let folder = tempfile::tempdir().unwrap();
    for version in [FmiVersion::V2, FmiVersion::V3] {
        let file = folder.path().join("model.fmu");
        cotree_page::export_fmu(&scene, version, &file).unwrap();
        let mut archive = Archive::new(Cursor::new(fs::read(&file).unwrap())).unwrap();
        let document = content(&mut archive, "modelDescription.xml");
        let head = &below(&document, "fmiModelDescription")[0];
        for (key, text) in given {
            assert_eq!(get(head, key), Some(text));
        }
        let page = String::from_utf8(content(&mut archive, "documentation/index.html")).unwrap();
        assert!(page.contains("<td>author</td><td>A. &lt;Watt&gt;</td>"), "{page}");
        let contents = cotree::report::inspect::Contents::read(&file).unwrap();
        assert!(contents.to_string().contains("  copyright   2026 Watt & Co\n"), "{contents}");
    }
}

#[test]
fn every_platform_has_its_folder() {
    let runtime =
        |name, library: &'static [u8]| Runtime { platform: Platform::named(name).unwrap(), library: library.into() };
    let runtimes = vec![runtime("win64", b"dll"), runtime("aarch64-linux", b"so")];
    let mut archive = packed(&Parts { runtimes, ..Parts::new() });
    let binaries: Vec<String> = names(&archive).into_iter().filter(|name| name.starts_with("binaries/")).collect();
    assert_eq!(binaries, ["binaries/aarch64-linux/pendulum.so", "binaries/win64/pendulum.dll"]);
    assert_eq!(content(&mut archive, &binaries[1]), b"dll");
}

/// A stand-in for a library of macOS: its header alone.
fn mac(platform: &str, processor: u8) -> Runtime {
    let library = [[0xcf, 0xfa, 0xed, 0xfe], [processor, 0, 0, 1], [3, 0, 0, 0]].concat();
    Runtime { platform: Platform::named(platform).unwrap(), library: library.into() }
}

#[test]
fn macs_of_both_processors_find_their_library_in_the_one_folder_of_fmi_2() {
    let (intel, apple) = (mac("darwin64", 7), mac("aarch64-darwin", 12));
    let in_binaries = |version, runtimes: &[Runtime]| {
        let parts = Parts { runtimes: runtimes.to_vec(), ..Parts::new() };
        let package = Package { version, ..parts.package() };
        let mut archive = Archive::new(Cursor::new(pack(&package).unwrap())).unwrap();
        let names: Vec<String> = names(&archive).into_iter().filter(|name| name.starts_with("binaries/")).collect();
        names.into_iter().map(|name| (name.clone(), content(&mut archive, &name))).collect::<Vec<_>>()
    };
    let at = |folder: &str, library: &[u8]| (format!("binaries/{folder}/pendulum.dylib"), library.to_vec());
    let both = [intel.clone(), apple.clone()];
    assert_eq!(
        in_binaries(FmiVersion::V3, &both),
        [at("aarch64-darwin", &apple.library), at("x86_64-darwin", &intel.library)]
    );
    assert_eq!(in_binaries(FmiVersion::V2, &both[..1]), [at("darwin64", &intel.library)]);
    assert_eq!(
        in_binaries(FmiVersion::V2, &both[1..]),
        [at("aarch64-darwin", &apple.library), at("darwin64", &apple.library)]
    );
    let [alone, (name, universal)] = in_binaries(FmiVersion::V2, &both).try_into().unwrap();
    assert_eq!((alone, &*name), (at("aarch64-darwin", &apple.library), "binaries/darwin64/pendulum.dylib"));
    assert!(universal.starts_with(&[0xca, 0xfe, 0xba, 0xbe, 0, 0, 0, 2, 1, 0, 0, 7]));
    assert!([intel, apple].iter().all(|own| universal.windows(12).any(|bytes| bytes == &*own.library)));
}

#[test]
fn the_icon_is_a_small_picture_that_is_not_blank() {
    let icon = content(&mut packed(&Parts::new()), "model.png");
    let picture = resvg::tiny_skia::Pixmap::decode_png(&icon).unwrap();
    assert_eq!(picture.width().max(picture.height()), 320);
    let colours: BTreeSet<[u8; 4]> =
        picture.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue(), pixel.alpha()]).collect();
    assert!(colours.len() > 8, "{colours:?}");
}

#[test]
fn nothing_to_draw_is_a_picture_too() {
    assert!(!content(&mut packed(&Parts { drawing: Drawing::default(), ..Parts::new() }), "model.png").is_empty());
}

#[test]
fn the_page_says_what_a_user_wants_to_know() {
    let mut description = pendulum();
    description.variables[4].start = Some(StartValue::Exact(std::f64::consts::FRAC_PI_6));
    description.variables[5].start = Some(StartValue::Approximate(2.0));
    let page = Parts::new().page().html(&description, FmiVersion::V2);
    let initial = ["rad (deg)", "(30.0 deg)</td><td>known", "2.0</td><td>a guess"];
    let parameters = [
        "<code>length</code>",
        "m (mm)",
        "0.5 (500.0 mm)",
        "at least 0.1 (100.0 mm)",
        "at most 3.0",
        "any time",
        "&lt;arm&gt;",
    ];
    let script = ["&quot;pendulum.fmu&quot;", "stop_time=10.0", "{&quot;length&quot;: 0.5}", "arm.angle"];
    let measured =
        ["from 0.0 s to 2.5 s", "<td class=\"n\">1e-4</td><td class=\"n\">3.0e-4</td><td class=\"n\">20</td>"];
    for text in parameters.iter().chain(&initial).chain(&script).chain(&measured).chain(&[
        "a &lt; b\n  Q[2]",
        "documentation/licenses/",
        "give it 1e-8 or",
        "fmpy (0.3.32) holds them from one output interval",
        "The picture is not animated: `a &lt; b` is calculated: only parameters, inputs and initial values can be set.",
        "freedoms 1",
    ]) {
        assert!(page.contains(text), "{text}\n{page}");
    }
    assert_eq!(page.matches("<svg").count(), 2, "the drawing and the curve");
    for foreign in ["<script", "href=", "src=", "url("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}

#[test]
fn a_model_that_cannot_be_measured_says_why() {
    let why = InstanceError::Undefined { name: "a < b".into(), time: 0.5 };
    let parts = Parts { accuracy: Err(why.into()), ..Parts::new() };
    let told = "Not measured: at t = 0.5 s `a &lt; b` has no finite value.";
    assert!(parts.page().html(&pendulum(), FmiVersion::V2).contains(told));
}

#[test]
fn a_missing_folder_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing/pendulum.fmu");
    let error = write(&Parts::new().package(), &path).unwrap_err();
    let told = error.to_string();
    assert!(told.starts_with("cannot write `") && told.contains("pendulum.fmu"), "{told}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// The packages that are compiled into the runtime, with their versions and licences.
fn packages_of_the_runtime() -> BTreeSet<[String; 3]> {
    let arguments = "tree --locked --package cotree-fmu --edges normal,no-proc-macro --prefix none --format {p}|{l}";
    let mut cargo = std::process::Command::new(env!("CARGO"));
    let output = cargo.args(arguments.split(' ')).current_dir(ROOT).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).unwrap();
    let lines = lines.lines().filter(|line| !line.starts_with("cotree-fmu") && !line.trim().is_empty());
    let package = |line: &str| {
        let (name, license) = line.trim_end_matches(" (*)").split_once('|').unwrap();
        let mut words = name.split_whitespace();
        let (name, version) = (words.next().unwrap(), words.next().unwrap().trim_start_matches('v'));
        [name, version, &license.replace('/', " OR ")].map(str::to_owned)
    };
    lines.map(package).collect()
}

#[test]
fn every_library_inside_the_runtime_is_in_the_licences_and_in_the_bill_of_materials() {
    let mut archive = packed(&Parts::new());
    let text = |archive: &mut Archive, name: &str| {
        String::from_utf8(content(archive, &format!("documentation/licenses/{name}"))).unwrap()
    };
    let bill: serde_json::Value = serde_json::from_str(&text(&mut archive, "sbom.cdx.json")).unwrap();
    let string = |value: &serde_json::Value| value.as_str().unwrap().to_owned();
    let components = bill["components"].as_array().unwrap();
    let listed = components.iter().map(|own| {
        assert_eq!(own["purl"], format!("pkg:cargo/{}@{}", string(&own["name"]), string(&own["version"])));
        [&own["name"], &own["version"], &own["licenses"][0]["expression"]].map(string)
    });
    let packages = packages_of_the_runtime();
    assert_eq!(listed.collect::<BTreeSet<_>>(), packages);
    assert_eq!((&bill["bomFormat"], &bill["specVersion"]), (&"CycloneDX".into(), &"1.5".into()));
    let licences = text(&mut archive, "license.txt");
    for ([name, version, license], own) in packages.iter().zip(components) {
        let wanted = format!("  {name} {version}, {license}\n      {}\n", string(&own["copyright"]));
        assert!(licences.contains(&wanted), "{wanted}");
    }
    for notice in ["Sun Microsystems", "Rich Felker", "Arm Limited", "freely granted"] {
        assert!(licences.contains(notice), "{notice}");
    }
}

/// A variable is shown in the unit that its initial value is written in, whether it is a state, an output or neither.
#[test]
fn initial_values_give_display_units() {
    let scene = cotree::scene::Scene::from_toml(
        r#"
        format = 1
        name = "rotor"
        [bodies.rotor]
        inertia = 2.0
        points = { tip = [1, 0] }
        [joints.pin]
        type = "revolute"
        between = ["ground", "rotor"]
        [bodies.sledge]
        mass = 1.0
        [joints.rail]
        type = "prismatic"
        between = ["ground", "sledge"]
        axis = [1, 0]
        [initial]
        "rotor.angle" = "60 deg"
        "pin.omega" = "300 rpm"
        "sledge.x" = "20 mm"
        "sledge.vx" = "0.5 m/s"
        [outputs]
        variables = ["rotor.angle"]
        "#,
    );
    let description = cotree::compile::compile(&scene.unwrap()).unwrap().description;
    let display = |name: &str| {
        let variable = description.variables.iter().find(|variable| variable.name == name);
        variable.unwrap_or_else(|| panic!("no {name}")).unit.display.as_ref().map(|display| display.name.clone())
    };
    let found = ["rotor.angle", "pin.omega", "sledge.x", "sledge.vx", "rail.s"].map(display);
    let wanted = [Some("deg"), Some("rpm"), Some("mm"), None, None].map(|name: Option<&str>| name.map(str::to_owned));
    assert_eq!(found, wanted);
}
