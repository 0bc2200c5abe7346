//! The models' programs, stored, make the motions that were found without them: `models/*/expected.csv` come from closed forms, absolute coordinates or
//! equations by hand.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cotree_fmu::instance::Instance;
use cotree_fmu::model::Model;
use cotree_fmu::program::{Engine, Program};

/// The runs' tolerance, and what they may miss, relative to the largest value of an output.
const TOLERANCE: f64 = 1e-10;
const MISSED: f64 = 1e-7;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Names, and rows that begin with the time.
fn expected(model: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let path = folder("../models").join(model).join("expected.csv");
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut lines = text.lines();
    let names = lines.next().expect("a header").split(',').skip(1).map(str::to_owned).collect();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
    (names, lines.map(row).collect())
}

/// The largest difference of any output, relative to its largest value.
fn missed(model: &Arc<Model>, engine: Option<Engine>, name: &str) -> Result<f64, String> {
    let (names, rows) = expected(name);
    let mut instance = Instance::new(model.clone());
    let stop = rows.last().expect("rows")[0];
    instance.setup(rows[0][0], Some(stop), Some(TOLERANCE)).expect("times");
    if let Some(engine) = engine {
        instance.set_engine(engine).expect("not begun");
    }
    instance.initialise().map_err(|error| error.to_string())?;
    let variables: Vec<usize> = names.iter().map(|name| instance.variable(name).expect("an output")).collect();
    let mut worst = 0.0_f64;
    for row in &rows {
        if row[0] > instance.time() {
            instance.step_to(row[0]).map_err(|error| error.to_string())?;
        }
        for (column, &variable) in variables.iter().enumerate() {
            let size = rows.iter().fold(1.0, |size: f64, row| size.max(row[column + 1].abs()));
            worst = worst.max((instance.get(variable).expect("defined") - row[column + 1]).abs() / size);
        }
    }
    Ok(worst)
}

#[test]
fn stored_programs_move_as_expected_by_every_method() {
    let mut count = 0;
    for entry in fs::read_dir(folder("tests/programs")).expect("stored programs") {
        let path = entry.expect("an entry").path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let program = Program::from_bytes(&fs::read(&path).expect("a file")).unwrap_or_else(|error| {
            panic!("{name}: {error:?}; write the programs anew, as tests/stored_programs.rs says")
        });
        let model = Arc::new(Model::new(program).expect("a sound program"));
        let engines = [None, Some(Engine::Dop853), Some(Engine::Radau)];
        for engine in engines {
            let missed = missed(&model, engine, &name).unwrap_or_else(|error| panic!("{name} by {engine:?}: {error}"));
            assert!(missed < MISSED, "{name} by {engine:?}: {missed:e}");
        }
        count += 1;
    }
    assert!(count > 30, "{count}");
}
