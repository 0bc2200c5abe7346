//! A linkage as a scene that moves it through its task.

use std::fmt::Write;

use cotree_synthesis::{Dyad, Linkage, Point, Pose};

/// What a scene has to do.
pub struct DrivenLinkage<'s> {
    pub name: &'s str,
    /// One line about it.
    pub about: &'s str,
    pub linkage: &'s Linkage,
    /// The pose from which it starts.
    pub start: Pose,
    /// The input at the start and at the end of the scene.
    pub way: [f64; 2],
    /// How long that takes \[s\].
    pub duration: f64,
}

/// A point as a scene has it.
pub(super) fn point(at: Point) -> String {
    format!("[{:?}, {:?}]", at.re, at.im)
}

/// The text of the scene: bars, body and joints, a driver, the pose of the body's frame as outputs.
///
/// The body's frame is that of the task.
pub fn text(driven: &DrivenLinkage<'_>) -> String {
    let mut bodies = String::new();
    let mut joints = String::new();
    let mut ground = String::new();
    let mut guesses = String::new();
    let mut pins = vec![("origin", Point::new(0.0, 0.0))];
    for (which, dyad) in [driven.linkage.first, driven.linkage.second].into_iter().enumerate() {
        let side = DyadSide { letter: ["a", "b"][which], bar: ["first", "second"][which], start: &driven.start };
        match dyad {
            Dyad::Bar { moving, ground: pivot, length } => {
                pins.push((side.letter, moving));
                side.bar(&mut ground, &mut bodies, &mut joints, &mut guesses, moving, pivot, length);
            }
            Dyad::Slider { moving, normal, offset } => {
                pins.push((side.letter, moving));
                let _ = writeln!(ground, "{} = {}", side.letter, point(normal * offset));
                let axis = point(normal * Point::new(0.0, 1.0));
                side.slot(&mut joints, &format!("ground.{}", side.letter), &format!("coupler.{}", side.letter), &axis);
            }
            Dyad::Slot { ground: pivot, normal, offset } => {
                let _ = writeln!(ground, "{} = {}", side.letter, point(pivot));
                pins.push((side.letter, normal * offset));
                let axis = point(normal * Point::new(0.0, 1.0));
                side.slot(&mut joints, &format!("coupler.{}", side.letter), &format!("ground.{}", side.letter), &axis);
            }
        }
    }
    let points: Vec<String> = pins.iter().map(|(name, at)| format!("{name} = {}", point(*at))).collect();
    let start = driven.start.angle;
    format!(
        "format      = 1\nname        = {:?}\ndescription = {:?}\n\n[ground.points]\n{ground}\n{bodies}\n[bodies.coupler]\nmass    = 1.0\ninertia = 0.01\npoints  = \
         {{ {} }}\n\n{joints}\n{}\n[initial]\n\"coupler.angle\" = {{ guess = {start:?} }}\n{guesses}\n[outputs]\nvariables = [\"coupler.origin.x\", \
         \"coupler.origin.y\", \"coupler.angle\"]\n\n[experiment]\nstop = {:?}\nstep = {:?}\n",
        driven.name,
        driven.about,
        points.join(", "),
        driver(driven),
        driven.duration,
        driven.duration / 200.0,
    )
}

/// The motion of the input, even in time.
fn driver(driven: &DrivenLinkage<'_>) -> String {
    let [from, to] = driven.way;
    let rate = (to - from) / driven.duration;
    match driven.linkage.first {
        Dyad::Bar { .. } => format!("[drivers.motor]\njoint = \"first_pivot\"\nangle = \"{from:?} + ({rate:?})*t\"\n"),
        Dyad::Slider { .. } | Dyad::Slot { .. } => {
            format!("[drivers.motor]\njoint = \"first_slot\"\ndisplacement = \"{from:?} + ({rate:?})*t\"\n")
        }
    }
}

/// One of the two dyads.
struct DyadSide<'s> {
    letter: &'static str,
    bar: &'static str,
    start: &'s Pose,
}

impl DyadSide<'_> {
    #[expect(clippy::too_many_arguments, reason = "the four parts of the text, and the three numbers of a bar")]
    fn bar(
        &self,
        ground: &mut String,
        bodies: &mut String,
        joints: &mut String,
        guesses: &mut String,
        moving: Point,
        pivot: Point,
        length: f64,
    ) {
        let DyadSide { letter, bar, start } = self;
        let angle = (start.carry(moving) - pivot).arg();
        // Writing to a string cannot fail.
        let _ = writeln!(ground, "{letter} = {}", point(pivot));
        let _ = writeln!(
            bodies,
            "[bodies.{bar}]\nmass    = 1.0\ninertia = 0.01\npoints  = {{ pivot = [0, 0], pin = [{length:?}, 0] }}\n"
        );
        let _ = writeln!(
            joints,
            "[joints.{bar}_pivot]\ntype    = \"revolute\"\nbetween = [\"ground.{letter}\", \"{bar}.pivot\"]\n\n\
             [joints.{bar}_pin]\ntype    = \"revolute\"\nbetween = [\"{bar}.pin\", \"coupler.{letter}\"]\n"
        );
        let _ = writeln!(guesses, "\"{bar}.angle\" = {{ guess = {angle:?} }}");
    }

    fn slot(&self, joints: &mut String, line: &str, pin: &str, axis: &str) {
        let _ = writeln!(
            joints,
            "[joints.{}_slot]\ntype    = \"slot\"\nbetween = [\"{line}\", \"{pin}\"]\naxis    = {axis}\n",
            self.bar
        );
    }
}
