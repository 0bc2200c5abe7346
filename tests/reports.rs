//! How results are written, whatever they are of: `cotree::report::data`.

use cotree::compile::unit;
use cotree::model::Units;
use cotree::report::data::{ReliableDigits, Report, Table, composed, named, number, per, plain, unit as unit_of};
use cotree::{line, row};
use serde_json::json;

fn units(names: &[&str]) -> Units {
    let mut units = Units::default();
    names.iter().for_each(|name| units.add(unit(name).unwrap()));
    units
}

/// A force and what rounding left of another, a derivative, and a value that is not there.
fn report() -> Report {
    let rows = [
        row!["pin.fx", number(1234.5678, "N"), unit_of("N"), number(0.25, &per("N", "m"))],
        row!["pin.fy", number(1e-12, "N"), unit_of("N"), number(f64::NAN, "")],
        row!["pin.angle", number(2e-14, "rad"), unit_of("rad"), number(1e-15, &per("rad", "m"))],
    ];
    let columns = row!["name", "value", "unit", line!["d/d(", named("reach", "m"), ")"]];
    let table = Table::new(columns, rows.clone());
    Report {
        tables: vec![Table { heading: Some("joints".into()), ..table }],
        notes: vec![line!["the largest is ", number(1234.5678, "N"), ", ", number(2.0, &per("N", "N.m"))]],
        sheet: Table::new(row!["name", "value"], rows.map(|row| row[..2].to_vec())),
        data: json!({ "a": 1 }),
        ..Report::new(row!["at rest"])
    }
}

#[test]
fn people_read_their_units_and_no_rounding_errors() {
    let si = "at rest\n\njoints\n  name         value  unit  d/d(reach [m])\n  pin.fx     1234.57     N            0.25\n  \
              pin.fy           0     N               -\n  pin.angle        0   rad     1.00000e-15\n\
              the largest is 1234.57 N, 2 N per N.m\n";
    assert_eq!(report().text(&Units::default()), si);
    let shown = "at rest\n\njoints\n  name         value  unit  d/d(reach [mm])\n  pin.fx     1.23457    kN       2.50000e-7\n  \
                 pin.fy           0    kN                -\n  pin.angle        0   deg      5.72958e-17\n\
                 the largest is 1.23457 kN, 0.002 kN per N.m\n";
    assert_eq!(report().text(&units(&["kN", "mm", "deg"])), shown);
}

#[test]
fn spreadsheets_read_exact_numbers() {
    let (si, shown) = (Units::default(), units(&["kN", "mm"]));
    let bare = "name,value\npin.fx,1234.5678\npin.fy,1e-12\npin.angle,2e-14\n";
    assert_eq!([report().csv(&si), report().csv(&shown)], [bare, bare], "no unit is named");
    let sheet = Table::new(
        row![named("pin.fx", "N"), "why, if not"],
        [row![number(1250.0, "N"), "\"odd\""], row![plain(f64::NAN, 0.0), 2]],
    );
    let titled = Report { sheet, ..Report::default() };
    assert_eq!(titled.csv(&shown), "pin.fx [kN],\"why, if not\"\n1.25,\"\"\"odd\"\"\"\n,2\n");
    assert_eq!(report().json(), "{\n  \"a\": 1\n}\n");
}

#[test]
fn numbers_have_the_digits_that_they_are_worth() {
    let numbers = [ReliableDigits::Noise(0.01), ReliableDigits::Noise(1e-9), ReliableDigits::Error(1e-4)];
    let rows = numbers.map(|accuracy| row!["x", number(1.0 / 300.0, "m").within(accuracy)]);
    let report = Report { tables: vec![Table::new(row![], rows)], ..Report::default() };
    assert_eq!(report.text(&Units::default()), "x           0\nx  0.00333333\nx    0.003333\n");
    // What is wide goes on below, beside the first column.
    let table = Table { width: Some(4), ..Table::new(row!["a", "b", "c"], [row![1, 2, 3]]) };
    let folded = Report { tables: vec![table], ..Report::default() };
    assert_eq!(folded.text(&Units::default()), "a  b\n1  2\n\na  c\n1  3\n");
}

#[test]
fn units_that_are_made_of_others_are_made_of_what_is_shown() {
    let units = units(&["kN", "mm", "deg"]);
    for (si, name, factor) in [
        ("m2", "mm2", 1e-6),
        ("m/rad2", "mm/rad2", 1e-3),
        ("rad/m", "rad/mm", 1e3),
        ("m/s", "mm/s", 1e-3),
        ("N/m", "N/m", 1.0),
        ("1/s", "1/s", 1.0),
    ] {
        let shown = composed(&units, si);
        assert!(shown.name == name && (shown.factor / factor - 1.0).abs() < 1e-12, "{si}: {shown:?}");
    }
    assert_eq!(composed(&units, &per("", "kg")).name, "1/(kg)");
    assert_eq!(composed(&units, &per("N", "")).name, "kN");
}
