//! temp
use cotree::{element::System, equations::Equations, scene::Scene, tree::Trees};
fn main() {
    for path in std::env::args().skip(1) {
    let s = Scene::read(&path).and_then(|s| s.resolve());
    let m = match s { Ok(m) => m.mechanism, Err(f) => { println!("{}", f.render(false, 100)); continue } };
    let system = System::new(&m);
    let trees = Trees::select(&system, &m.coordinates).unwrap();
    let mut e = Equations::new(system, trees);
    println!("{}", cotree::print::text(&mut e));
    }
}
