//! No name of the user's can be taken for one of the page's own, and every page compiles, whatever the scene is called.

use std::path::Path;
use std::process::Command;

use cotree::scene::Scene;
use cotree_text::Prose;
use cotree_text::written::{self, EquationFormat};

/// A led arm with an odd name whose parameters are called like matrices, reactions, cosines and shared parts.
const ODD: &str = r#"
name = "滑块 «Größe» α₂ 😀 — 100 % & #co_\\^~{}\nline two"
gravity = [0, -9.81]

[parameters]
lambda1 = "2 N.m"
M = "1.2 kg"
Q_1 = 3.0
a = 0.25
v = 0.2
q1 = "0.03 kg.m^2"
lambda = "0.1 N.m.s"
c1 = 0.1
cos_1 = 0.3
cos__1 = 0.3
Phi_q = 0.2
Phi = 2.0
gamma1 = 2.0
T = 1.0

[bodies.upper]
mass = "M"
inertia = "q1"
points = { a = ["-a*Q_1/3", 0], b = ["a", 0] }

[bodies.fore]
mass = 0.8
inertia = 0.02
points = { a = ["-v", 0], hand = ["Phi_q", 0] }

[joints.lambda2]
type = "revolute"
between = ["ground", "upper.a"]
damping = "lambda"

[joints.elbow]
type = "revolute"
between = ["upper.b", "fore.a"]

[drivers.s1]
on = "fore.hand"
position = ["0.5*T + c1*cos(2*t*Phi/gamma1)", "cos_1 + cos__1*sin(2*t)/3"]

[loads.pull]
type = "torque"
on = "upper"
value = "lambda1"

[initial]
"upper.angle" = { guess = -0.3 }
"fore.angle" = { guess = 1.2 }
"#;

fn odd() -> Scene {
    Scene::from_toml(ODD).unwrap_or_else(|faults| panic!("{faults}"))
}

fn printed(notation: EquationFormat) -> String {
    written::equations(&odd(), notation).unwrap_or_else(|faults| panic!("{faults}"))
}

#[test]
fn the_own_symbols_of_plain_text_have_brackets_or_other_letters() {
    let text = printed(EquationFormat::Text);
    for line in [
        "[M]*{a} + [Phi_q]^T*{lambda} = {Q}",
        "M[1,1] = q1 + M*Q_1^2*a^2/9",
        "lambda[1]  `elbow`  N, force along x",
        "Q[1] = lambda1 - lambda*upper.omega",
        "cos___1 = cos(upper.angle)",
    ] {
        assert!(text.contains(line), "no {line} in\n{text}");
    }
}

#[test]
fn the_letters_of_the_lesson_are_no_parameters() {
    let scene = Scene::from_toml(
        "name = 'earth'\nparameters = { g = '9.81 m/s^2', F_h3 = '2 N.m', T_m1 = 1 }\ngravity = [0, '-g']\n\
         bodies.rod = { mass = 1, inertia = 'T_m1', points = { p = [1, 0] } }\n\
         joints.pin = { type = 'revolute', between = ['ground', 'rod.p'] }\n\
         loads.motor = { type = 'torque', on = 'rod', value = 'F_h3' }",
    )
    .unwrap_or_else(|faults| panic!("{faults}"));
    let text = written::steps(&scene, Prose::Text).unwrap_or_else(|faults| panic!("{faults}"));
    let text: String = text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ") + "\n").collect();
    for line in
        ["g_ = (0, -g)", "F[m1] = m_1*(g_ - a[m1])", "T[m1] = -T_m1*alpha[m1] - k . (r[r2] x F[r2])", "T[T4] = F_h3"]
    {
        assert!(text.contains(line), "no {line} in\n{text}");
    }
    let latex = written::steps(&scene, Prose::Latex).unwrap();
    assert!(latex.contains(r"\mathbf{g} &= ") && !latex.contains("g_{}"), "{latex}");
}

#[test]
fn json_names_are_those_of_the_text() {
    let json: serde_json::Value = serde_json::from_str(&printed(EquationFormat::Json)).unwrap();
    let names = |list: &str| -> Vec<String> {
        json[list].as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names("reactions"), ["lambda[1]", "lambda[2]"]);
    let parameters = names("parameters");
    for own in names("reactions").into_iter().chain(names("definitions")) {
        assert!(!parameters.contains(&own), "{own}");
    }
}

#[test]
fn latex_and_html_tell_matrices_from_parameters() {
    let latex = printed(EquationFormat::Latex);
    assert!(
        latex.contains(r"\mathbf{M}\,\mathbf{a} + \boldsymbol{\Phi}_{q}^{T}\,\boldsymbol{\lambda} &= \mathbf{Q}"),
        "{latex}"
    );
    assert!(latex.contains(r"\mathit{lambda1}") && latex.contains(r"\mathit{Phi\_q}"), "{latex}");
    let html = printed(EquationFormat::Html);
    assert!(html.contains("<mi>lambda1</mi>") && html.contains("<mi>Phi_q</mi>"), "{html}");
}

fn compile(folder: &Path, page: &str) {
    std::fs::write(folder.join("page.tex"), page).unwrap();
    let flags = ["-interaction=nonstopmode", "-halt-on-error", "page.tex"];
    let output = Command::new("pdflatex").current_dir(folder).args(flags).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn pages_compile_whatever_the_scene_is_called() {
    let lesson = written::steps(&odd(), Prose::Latex).unwrap();
    let equations = printed(EquationFormat::Latex);
    // Where there is no pdfLaTeX, at least every character that it does not know is explained to it.
    for page in [&equations, &lesson] {
        for declared in [r"{6ED1}{[U+6ED1]\allowbreak{}}", r"{03B1}{\ensuremath{\alpha}}", "{1F600}{", "{2014}{"] {
            assert!(page.contains(&format!(r"\DeclareUnicodeCharacter{declared}")), "{page}");
        }
    }
    if Command::new("pdflatex").arg("--version").output().is_err() {
        eprintln!("pdflatex is missing: the pages were not compiled");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    compile(folder.path(), &equations);
    compile(folder.path(), &lesson);
}
