//! Random trees of bars that hang from each other, without loops: on the ground, on a cart, on a point or a bar that is moved, or floating.

use super::random::Random;

/// What a tree hangs from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Root {
    Ground,
    Cart,
    ShakenGround,
    DrivenBar,
    Floating,
}

pub const ROOTS: [Root; 5] = [Root::Ground, Root::Cart, Root::ShakenGround, Root::DrivenBar, Root::Floating];

/// A tree of so many bars, each from one of the last `spread` before it, at random places with random masses; with springs, dampers, a load that follows a bar,
/// bars welded to others, a wheel, and bars without weight.
pub fn hanging(seed: u64, bars: usize, spread: usize, root: Root) -> String {
    let mut random = Random(seed);
    let mut number = move |low: f64, high: f64| random.between(low, high);
    let text = String::from("format = 1\nname = \"hanging\"\ngravity = [0.3, -9.81]\n");
    let mut bodies: Vec<String> = Vec::new();
    let mut start = String::from("[initial]\n");
    for bar in 0..bars {
        let before = bar.saturating_sub(1 + (number(0.0, spread as f64) as usize).min(spread - 1));
        let [mass, inertia] = [number(0.5, 2.0), number(0.02, 0.2)];
        let weight = if bar % 11 == 5 { "gravity = false\n" } else { "" };
        let points = [(); 3].map(|()| [number(-0.5, 0.5), number(-0.5, 0.5)]);
        let [a, b, c] = points.map(|[x, y]| format!("[{x}, {y}]"));
        let com = format!("[{}, {}]", number(-0.2, 0.2), number(-0.2, 0.2));
        let mut own = format!("[bodies.b{bar}]\nmass = {mass}\ninertia = {inertia}\ncom = {com}\n{weight}");
        own += &format!("points = {{ a = {a}, b = {b}, c = {c} }}\n");
        let at = match (bar, root) {
            (0, Root::Cart) => "cart.p".to_string(),
            (0, _) => "ground".to_string(),
            _ => format!("b{before}.{}", if number(0.0, 1.0) < 0.7 { "b" } else { "c" }),
        };
        let welded = bar % 9 == 4;
        match (bar, root) {
            (0, Root::Floating) => {}
            (0, Root::ShakenGround) => {
                own += "[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"hanger\"]\naxis = [0.6, -0.8]\n";
                own += "[bodies.hanger]\nmass = 0.3\ninertia = 0.1\n[bodies.hanger.points]\np = [0.1, 0.2]\n";
                own += "[drivers.shake]\njoint = \"rail\"\ndisplacement = \"0.1*sin(7*t)\"\n";
                own += "[joints.j0]\ntype = \"revolute\"\nbetween = [\"hanger.p\", \"b0.a\"]\n";
            }
            _ => {
                let kind = if welded { "weld" } else { "revolute" };
                own += &format!("[joints.j{bar}]\ntype = \"{kind}\"\nbetween = [\"{at}\", \"b{bar}.a\"]\n");
            }
        }
        if (bar, root) == (0, Root::DrivenBar) {
            own += "[drivers.motor]\njoint = \"j0\"\nangle = \"0.4 + 0.3*sin(5*t)\"\n";
        } else if !welded {
            start += &format!("\"b{bar}.angle\" = {}\n\"b{bar}.omega\" = {}\n", number(-3.0, 3.0), number(-2.0, 2.0));
        }
        if bar % 5 == 2 {
            own += &format!(
                "[loads.damper{bar}]\ntype = \"torsion_damper\"\nbetween = [\"b{before}\", \"b{bar}\"]\ndamping = 0.2\n"
            );
        }
        if bar % 10 == 7 {
            own += &format!(
                "[loads.spring{bar}]\ntype = \"spring\"\nbetween = [\"ground\", \"b{bar}.c\"]\nstiffness = 3\nlength = 0.2\n"
            );
        }
        bodies.push(own);
    }
    if root == Root::Cart {
        bodies.push(
            "[bodies.cart]\nmass = 3\ninertia = 1\npoints = { p = [0.1, 0.3] }\n[joints.rail]\ntype = \"prismatic\"\nbetween = [\"ground\", \"cart\"]\naxis = [0.8, 0.6]\n"
                .into(),
        );
    }
    // The order of the file is not that of the bars.
    bodies.reverse();
    text + &bodies.concat() + &start + "[experiment]\nstop = 0.2\n"
}
