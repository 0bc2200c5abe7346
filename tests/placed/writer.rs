//! Random parts as texts: a few small mechanisms beside each other, with a load of each kind somewhere, on the ground or on a body that stands for it.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::split_mix::Random;

/// What a part may have.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// Forces and motions in the axes of the world.
    pub world: bool,
    /// Laws that depend on places and angles of bodies.
    pub absolute: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    Body,
    /// Its normal is fixed by the turn of its axis.
    Slide,
    Joint,
    Load,
}

/// Who has variables.
pub struct Owner {
    pub name: String,
    pub sort: Sort,
    /// 1 if its first end alone is the ground, -1 if its second is.
    pub from_ground: f64,
    /// May its angles differ by whole turns?
    pub turns: bool,
}

pub struct Written {
    pub text: String,
    /// The points of what stands for the ground, as entries of a table.
    pub points: String,
    pub owners: Vec<Owner>,
    pub kinds: BTreeSet<&'static str>,
}

struct Writer {
    random: Random,
    /// `ground`, or the body that stands for it.
    base: &'static str,
    allowed: Allowed,
    text: String,
    points: Vec<String>,
    initial: String,
    owners: Vec<Owner>,
    kinds: BTreeSet<&'static str>,
    count: usize,
    /// May initial values be left out?
    open: bool,
}

/// The part of a seed; on another base it is the same part.
pub fn write(seed: u64, base: &'static str, allowed: Allowed) -> Written {
    let mut writer = Writer {
        random: Random(seed),
        base,
        allowed,
        text: String::new(),
        points: Vec::new(),
        initial: String::new(),
        owners: Vec::new(),
        kinds: BTreeSet::new(),
        count: 0,
        open: false,
    };
    for _ in 0..3 {
        writer.mechanism();
    }
    let points = writer.points.join(", ");
    let ground = if base == "ground" { format!("[ground]\npoints = {{ {points} }}\n") } else { String::new() };
    Written {
        text: format!("{ground}{}[initial]\n{}", writer.text, writer.initial),
        points,
        owners: writer.owners,
        kinds: writer.kinds,
    }
}

impl Writer {
    fn mechanism(&mut self) {
        self.count += 1;
        let which = self.pick(13);
        self.open = self.allowed.absolute && which < 4;
        match which {
            0 | 1 => self.pendulum(),
            2 => self.slider(),
            3 => self.slot(),
            4 | 5 => self.rolling(),
            6 => self.planet(),
            7 => self.wheels(),
            8 | 9 => self.rack(),
            10 => self.welded(),
            11 => self.crank(),
            _ => self.cam(),
        }
        (self.count, self.open) = (self.count + 1, false);
        if self.allowed.world && self.chance(0.3) {
            if self.chance(0.5) { self.free() } else { self.led() }
        }
    }

    fn pick(&mut self, of: usize) -> usize {
        (self.random.unit() * of as f64) as usize
    }

    fn chance(&mut self, share: f64) -> bool {
        self.random.unit() < share
    }

    fn number(&mut self, low: f64, high: f64) -> f64 {
        self.random.between(low, high)
    }

    /// The name of something new.
    fn name(&self, what: &str) -> String {
        format!("{what}{}", self.count)
    }

    fn owner(&mut self, name: &str, sort: Sort, from_ground: f64) {
        self.owners.push(Owner { name: name.to_owned(), sort, from_ground, turns: false });
    }

    /// A point of the ground.
    fn point(&mut self, what: &str, at: [f64; 2]) -> String {
        let name = self.name(what);
        self.points.push(format!("{name} = [{:e}, {:e}]", at[0], at[1]));
        format!("{}.{name}", self.base)
    }

    fn place(&mut self) -> [f64; 2] {
        [self.number(-1.0, 1.0), self.number(-1.0, 1.0)]
    }

    fn bearing(&mut self, what: &str) -> String {
        let at = self.place();
        self.point(what, at)
    }

    fn axis(&mut self) -> [f64; 2] {
        let angle = self.number(-3.0, 3.0);
        [angle.cos(), angle.sin()]
    }

    /// A body with the points `o`, its frame's origin, and `e`.
    fn body(&mut self, what: &str, e: [f64; 2]) -> String {
        let name = self.name(what);
        let (mass, shape) = (self.number(0.5, 2.0), self.pick(4));
        let rest = match shape {
            0 => format!("inertia = {:e}\ncom = [{:e}, {:e}]\n", 0.3 * mass, 0.4 * e[0], 0.05),
            1 => "shape = { polygon = [\"o\", [0.3, -0.1], [0.25, 0.2]] }\n".to_owned(),
            2 => "shape = { rod = [\"o\", [0.3, 0.12]] }\n".to_owned(),
            _ => format!("inertia = {:e}\n", 0.1 * mass),
        };
        let _ = write!(
            self.text,
            "[bodies.{name}]\nmass = {mass:e}\n{rest}points = {{ o = [0, 0], e = [{:e}, {:e}] }}\n",
            e[0], e[1]
        );
        self.owner(&name, Sort::Body, 0.0);
        for point in ["o", "e"] {
            self.owner(&format!("{name}.{point}"), Sort::Body, 0.0);
        }
        name
    }

    /// A joint between two points, of which the first is on the ground, in either order.
    fn joint(&mut self, what: &str, kind: &'static str, ends: [&str; 2], keys: &str) -> String {
        let on_ground = ends.map(|end| end.split('.').next() == Some(self.base));
        let sort = if matches!(kind, "prismatic" | "slot") { Sort::Slide } else { Sort::Joint };
        self.entry(
            "joints",
            what,
            kind,
            sort,
            on_ground,
            &format!("between = [\"{}\", \"{}\"]\n{keys}", ends[0], ends[1]),
        )
    }

    fn entry(
        &mut self,
        section: &str,
        what: &str,
        kind: &'static str,
        sort: Sort,
        on_ground: [bool; 2],
        keys: &str,
    ) -> String {
        let name = self.name(what);
        self.kinds.insert(kind);
        let kind = if section == "drivers" { String::new() } else { format!("type = \"{kind}\"\n") };
        let _ = write!(self.text, "[{section}.{name}]\n{kind}{keys}");
        let from_ground = f64::from(u8::from(on_ground[0])) - f64::from(u8::from(on_ground[1]));
        self.owner(&name, sort, from_ground);
        name
    }

    fn either_way<'a>(&mut self, ends: [&'a str; 2]) -> [&'a str; 2] {
        if self.chance(0.7) { ends } else { [ends[1], ends[0]] }
    }

    /// An initial value; of what stands on the ground and moves by itself some are left open.
    fn start(&mut self, variable: &str, low: f64, high: f64) {
        let value = self.number(low, high);
        if self.open && self.chance(0.3) {
            return;
        }
        let _ = writeln!(self.initial, "\"{variable}\" = {value:e}");
    }

    fn resistance(&mut self) -> String {
        let mut keys = String::new();
        if self.chance(0.4) {
            keys += &format!("damping = {:e}\n", self.number(0.05, 0.5));
        }
        if self.chance(0.3) {
            keys += &format!("friction = {{ coulomb = {:e}, velocity = 0.1 }}\n", self.number(0.05, 0.3));
        }
        keys
    }

    /// A joint that turns, with its start; or a driver that turns it.
    fn hinge(&mut self, what: &str, ends: [&str; 2]) -> String {
        let keys = self.resistance();
        let ends = self.either_way(ends);
        let pin = self.joint(what, "revolute", ends, &keys);
        if self.chance(0.2) {
            let (from, rate) = (self.number(-2.0, 2.0), self.number(-3.0, 3.0));
            let bodies = ends.map(|end| end.split('.').next().unwrap());
            let on = match self.chance(0.5) {
                true => format!("joint = \"{pin}\"\n"),
                false => format!("between = [\"{}\", \"{}\"]\n", bodies[0], bodies[1]),
            };
            let keys = format!("{on}angle = \"{from:e} + {rate:e}*t + 0.3*sin(2*t)\"\n");
            self.entry("drivers", &format!("turn_{what}"), "angle", Sort::Joint, [false; 2], &keys);
        } else {
            self.start(&format!("{pin}.angle"), -2.5, 2.5);
            self.start(&format!("{pin}.omega"), -3.0, 3.0);
        }
        pin
    }

    /// One or two loads of those that turn a body against the ground, and of those along a line.
    fn loads(&mut self, body: &str, pin: Option<&str>, guide: Option<&str>) {
        for _ in 0..3 {
            self.count += 1;
            match self.pick(3) {
                0 => self.turning(body, pin),
                1 => self.line(body),
                _ => self.applied(body, pin, guide),
            }
        }
    }

    fn turning(&mut self, body: &str, pin: Option<&str>) {
        let base = self.base;
        let ends = self.either_way([base, body]);
        let between = format!("between = [\"{}\", \"{}\"]\n", ends[0], ends[1]);
        let (stiffness, damping) = (self.number(5.0, 50.0), self.number(0.1, 1.0));
        let (kind, keys): (&'static str, String) = match self.pick(5) {
            0 | 1 => {
                let side = ["both", "above", "below"][self.pick(3)];
                let free = self.number(-1.0, 1.0);
                (
                    "torsion_spring",
                    format!(
                        "stiffness = {stiffness:e}\ndamping = {damping:e}\ncubic = 3\nangle = {free:e}\nside = \"{side}\"\n"
                    ),
                )
            }
            2 if stiffness < 27.5 => ("torsion_damper", format!("damping = {damping:e}\n")),
            2 => {
                let winding = "resistance = 0.8\ninductance = 0.05\nconstant = 0.3\nratio = 2\ncurrent = 0.4\n";
                ("dc_motor", format!("voltage = \"3 - {damping:e}*omega + 0.2*current\"\n{winding}"))
            }
            3 => {
                let more = match (pin, self.allowed.absolute) {
                    (Some(pin), true) => {
                        format!(" + 0.5*{pin}.angle*{body}.omega + 0.3*{body}.angle - 2*{body}.e.x*{body}.vy")
                    }
                    (Some(pin), false) => format!(" + 0.5*{pin}.angle*{pin}.omega"),
                    (None, true) => format!(" + 0.2*{body}.y"),
                    _ => String::new(),
                };
                ("torsion_actuator", format!("torque = \"2 - {stiffness:e}*angle - {damping:e}*omega{more}\"\n"))
            }
            _ => {
                let law = format!("value = \"{damping:e} + sin(9*t)\"\n");
                if self.chance(0.5) {
                    // Where it stands on the ground it can be written so.
                    let on = match self.base {
                        "ground" => format!("on = \"{body}\"\n"),
                        base => format!("between = [\"{base}\", \"{body}\"]\n"),
                    };
                    self.entry("loads", "moment", "torque", Sort::Load, [true, false], &format!("{on}{law}"));
                    return;
                }
                ("torque", law)
            }
        };
        let on_ground = ends.map(|end| end == base);
        self.entry("loads", "turning", kind, Sort::Load, on_ground, &format!("{between}{keys}"));
    }

    fn line(&mut self, body: &str) {
        // Far from everything that moves.
        let far = self.axis().map(|x| 6.0 * x);
        let anchor = self.point("anchor", far);
        let [a, b] = self.either_way([&anchor, &format!("{body}.e")]).map(str::to_owned);
        let between = format!("between = [\"{a}\", \"{b}\"]\n");
        let some = self.number(1.0, 30.0);
        let (kind, keys): (&'static str, String) = match self.pick(6) {
            5 => {
                let turning = format!("torsion_stiffness = {:e}\nangle = {:e}\n", 0.5 * some, self.number(-1.0, 1.0));
                let keys = format!("{between}stiffness = {some:e}\ndamping = 0.7\ntorsion_damping = 0.2\n{turning}");
                let on_ground = [&a, &b].map(|end| *end == anchor);
                self.entry("loads", "ring", "bushing", Sort::Load, on_ground, &keys);
                return;
            }
            0 => {
                let side = ["both", "above", "below"][self.pick(3)];
                ("spring", format!("stiffness = {some:e}\nlength = 5\ndamping = 0.7\nside = \"{side}\"\n"))
            }
            1 if some < 15.5 => ("damper", format!("damping = {some:e}\n")),
            1 => {
                let chambers = "areas = [1e-3, 8e-4]\nvolumes = [0.02, 0.025]\nretracted = 6\nbulk = 1e7\npressures = [1e4, 1.2e4]\n";
                let valve = "opening = \"0.3 + 0.1*sin(t)\"\nvalve = 1e-7\nsupply = 1e5\nleakage = 1e-9\n";
                ("cylinder", format!("{chambers}{valve}"))
            }
            2 => ("gas_spring", format!("push = {some:e}\nlength = 6\ncolumn = 4\nexponent = 1.3\n")),
            3 => ("constant_force_spring", format!("pull = {some:e}\n")),
            _ => {
                let more =
                    if self.allowed.absolute { format!(" - 2*{body}.x + 1.1*{anchor}.x") } else { String::new() };
                ("actuator", format!("force = \"{some:e} - 3*length - 0.5*rate{more}\"\n"))
            }
        };
        self.entry("loads", "line", kind, Sort::Load, [false; 2], &format!("{between}{keys}"));
    }

    fn applied(&mut self, body: &str, pin: Option<&str>, guide: Option<&str>) {
        let law = match (pin, guide, self.allowed.absolute) {
            (.., true) => format!("3*{body}.x - 2*{body}.vy + 1.3*{body}.angle"),
            (Some(pin), ..) => format!("3*{pin}.angle - 0.4*{pin}.omega"),
            (_, Some(guide), _) => format!("3 - 2*{guide}.s - 0.4*{guide}.v"),
            _ => "3*cos(5*t)".to_owned(),
        };
        let frame = if self.allowed.world && self.chance(0.5) { "world" } else { "body" };
        let some = self.number(-5.0, 5.0);
        let keys = format!("on = \"{body}.e\"\nvector = [\"{law}\", {some:e}]\nframe = \"{frame}\"\n");
        self.entry("loads", "push", "force", Sort::Load, [false; 2], &keys);
    }

    fn pendulum(&mut self) {
        let (bearing, e) = (self.bearing("bearing"), self.place());
        let arm = self.body("arm", e);
        let pin = self.hinge("pin", [&bearing, &format!("{arm}.o")]);
        if self.chance(0.4) {
            self.count += 1;
            let second = self.body("second", [0.4, 0.2]);
            self.hinge("elbow", [&format!("{arm}.e"), &format!("{second}.o")]);
            self.loads(&second, None, None);
        }
        self.loads(&arm, Some(&pin), None);
    }

    fn guide(&mut self, what: &str, ends: [&str; 2], [x, y]: [f64; 2]) -> String {
        let keys = format!("axis = [{x:e}, {y:e}]\nangle = {:e}\n{}", self.number(-2.0, 2.0), self.resistance());
        let ends = self.either_way(ends);
        self.joint(what, "prismatic", ends, &keys)
    }

    fn slider(&mut self) {
        let (bearing, e, axis) = (self.bearing("rail"), self.place(), self.axis());
        let slider = self.body("slider", e);
        let guide = self.guide("guide", [&bearing, &format!("{slider}.o")], axis);
        self.slides(&guide);
        self.loads(&slider, None, Some(&guide));
    }

    fn slides(&mut self, guide: &str) {
        if self.chance(0.2) {
            let keys = format!("joint = \"{guide}\"\ndisplacement = \"{:e} + 0.3*sin(4*t)\"\n", self.number(-0.5, 0.5));
            self.entry("drivers", "shift", "displacement", Sort::Joint, [false; 2], &keys);
        } else {
            self.start(&format!("{guide}.s"), -0.5, 0.5);
            self.start(&format!("{guide}.v"), -2.0, 2.0);
        }
    }

    fn slot(&mut self) {
        let (bearing, e, [x, y]) = (self.bearing("rail"), self.place(), self.axis());
        let slider = self.body("shoe", e);
        let keys = format!("axis = [{x:e}, {y:e}]\n{}", self.resistance());
        let other = format!("{slider}.o");
        let ends = self.either_way([&bearing, &other]);
        let slot = self.joint("slot", "slot", ends, &keys);
        self.slides(&slot);
        self.start(&format!("{slot}.angle"), -2.0, 2.0);
        self.start(&format!("{slot}.omega"), -2.0, 2.0);
        self.loads(&slider, Some(&slot), None);
    }

    fn rolling(&mut self) {
        let (bearing, e, [x, y]) = (self.bearing("line"), self.place(), self.axis());
        let disc = self.body("disc", e);
        let (radius, zero) = (self.number(0.1, 0.5), self.number(-0.3, 0.3));
        let zero = if self.chance(0.5) { format!("displacement = {zero:e}\n") } else { String::new() };
        let side = if self.chance(0.3) { "side = \"right\"\n" } else { "" };
        let keys = format!("axis = [{x:e}, {y:e}]\nradius = {radius:e}\n{zero}{side}");
        let contact = self.joint("contact", "rolling", [&bearing, &format!("{disc}.o")], &keys);
        self.start(&format!("{contact}.angle"), -2.0, 2.0);
        self.start(&format!("{contact}.omega"), -2.0, 2.0);
        self.loads(&disc, Some(&contact), None);
    }

    /// A carrier that is the ground may be left out.
    fn carrier(&mut self, carrier: &str) -> String {
        let is_left_out = self.chance(0.5) && carrier == "ground";
        // The same draws on every base.
        if is_left_out { String::new() } else { format!("carrier = \"{carrier}\"\n") }
    }

    /// A gear or a belt.
    fn mesh(&mut self, wheels: [&str; 2], carrier: &str) {
        let ends = self.either_way(wheels);
        let offset = if self.chance(0.5) { format!("angle = {:e}\n", self.number(-1.0, 1.0)) } else { String::new() };
        let (kind, keys) = match self.chance(0.6) {
            true => {
                ("gear", format!("ratio = {:e}\n", self.number(0.4, 2.0) * if self.chance(0.5) { -1.0 } else { 1.0 }))
            }
            false => {
                let run = ["open", "crossed"][self.pick(2)];
                ("belt", format!("first_radius = 0.1\nsecond_radius = {:e}\nrun = \"{run}\"\n", self.number(0.05, 0.3)))
            }
        };
        let carrier = self.carrier(carrier);
        self.joint("mesh", kind, ends, &format!("{carrier}{offset}{keys}"));
    }

    fn planet(&mut self) {
        let (bearing, base) = (self.bearing("hub"), self.base);
        let arm = self.body("carrier", [0.5, 0.1]);
        let planet = self.body("planet", [0.2, 0.0]);
        let pin = self.hinge("main", [&bearing, &format!("{arm}.o")]);
        self.joint("axle", "revolute", [&format!("{arm}.e"), &format!("{planet}.o")], "");
        self.mesh([base, &planet], &arm);
        self.loads(&planet, Some(&pin), None);
    }

    fn wheels(&mut self) {
        let (first, second, base) = (self.bearing("first"), self.bearing("second"), self.base);
        let [a, b] = ["wheel_a", "wheel_b"].map(|what| self.body(what, [0.2, 0.1]));
        let pin = self.hinge("pin_a", [&first, &format!("{a}.o")]);
        self.joint("pin_b", "revolute", [&second, &format!("{b}.o")], "");
        self.mesh([&a, &b], base);
        self.loads(&b, Some(&pin), None);
    }

    /// A rack or a screw on the ground or on an arm that turns.
    fn rack(&mut self) {
        let (bearing, [x, y]) = (self.bearing("bench"), self.axis());
        let on_arm = self.chance(0.4);
        let carrier = if on_arm {
            let arm = self.body("bench_arm", [0.4, -0.3]);
            self.hinge("swing", [&bearing, &format!("{arm}.o")]);
            format!("{arm}.e")
        } else {
            bearing
        };
        let (pinion, rack) = (self.body("pinion", [0.1, 0.0]), self.body("bar", [0.3, 0.1]));
        let pin = self.hinge("spindle", [&carrier, &format!("{pinion}.o")]);
        let angle = format!("axis = [{x:e}, {y:e}]\nangle = {:e}\n", self.number(-1.0, 1.0));
        self.joint("rail", "prismatic", [&carrier, &format!("{rack}.o")], &angle);
        let factor = self.number(0.1, 0.5) * if self.chance(0.5) { -1.0 } else { 1.0 };
        let zero =
            if self.chance(0.5) { format!("displacement = {:e}\n", self.number(-0.3, 0.3)) } else { String::new() };
        let carrier = match on_arm {
            true => format!("carrier = \"{carrier}\"\n"),
            false if self.chance(0.5) => format!("carrier = \"{carrier}\"\n"),
            false => {
                let base = self.base;
                self.carrier(base)
            }
        };
        let (kind, key) = [("rack", "radius"), ("screw", "lead")][self.pick(2)];
        let keys = format!("{carrier}axis = [{x:e}, {y:e}]\n{key} = {factor:e}\n{zero}");
        self.joint("mesh", kind, [&pinion, &format!("{rack}.o")], &keys);
        self.loads(&rack, None, None);
        self.loads(&pinion, Some(&pin), None);
    }

    fn welded(&mut self) {
        let bearing = self.bearing("post");
        let post = self.body("post", [0.3, 0.4]);
        let angle = format!("angle = {:e}\n", self.number(-2.0, 2.0));
        let other = format!("{post}.o");
        let ends = self.either_way([&bearing, &other]);
        self.joint("foot", "weld", ends, &angle);
        let arm = self.body("swing", [0.4, 0.0]);
        let hook = self.body("hook", [0.2, 0.2]);
        self.hinge("hinge", [&format!("{post}.e"), &format!("{arm}.o")]);
        let angle = format!("angle = {:e}\n", self.number(-2.0, 2.0));
        self.joint("stuck", "weld", [&format!("{arm}.e"), &format!("{hook}.o")], &angle);
        self.loads(&hook, None, None);
    }

    /// A crank and a slider with a massless rod.
    fn crank(&mut self) {
        let (x, y) = (self.number(-1.0, 1.0), self.number(-1.0, 1.0));
        let (bearing, rail) = (self.point("bearing", [x, y]), self.point("rail", [x, y + 0.1]));
        let (crank, slider) = (self.body("crank", [0.3, 0.0]), self.body("slider", [0.2, 0.2]));
        let pin = self.hinge("pin", [&bearing, &format!("{crank}.o")]);
        let guide = self.joint("guide", "prismatic", [&rail, &format!("{slider}.o")], "axis = [1, 0]\n");
        let link = format!("length = {:e}\n", self.number(0.9, 1.2));
        self.joint("link", "distance", [&format!("{crank}.e"), &format!("{slider}.o")], &link);
        let _ = writeln!(self.initial, "\"{guide}.s\" = {{ guess = 1.1 }}");
        self.loads(&slider, None, Some(&guide));
        self.loads(&crank, Some(&pin), None);
    }

    fn cam(&mut self) {
        let first = self.owners.len();
        let (x, y) = (self.number(-1.0, 1.0), self.number(-1.0, 1.0));
        let hub = self.point("hub", [x, y]);
        let cam = self.body("cam", [0.05, 0.0]);
        let shaft = self.hinge("shaft", [&hub, &format!("{cam}.o")]);
        let law = [
            "0.02*(1 - cos(angle)) + 0.01*sin(angle)",
            "0.05*(cycloidal((angle - 0.5)/1.5) - cycloidal((angle - 3)/2))",
        ][self.pick(2)];
        let touch = ["roller = 0.05\n", "face = [0.1, 1]\n", ""][self.pick(3)];
        let follower = if self.chance(0.5) {
            let (follower, axis) = (self.body("follower", [0.2, 0.1]), self.axis());
            let keys = format!("axis = [{:e}, {:e}]\n", axis[0], axis[1]);
            // A face that is upright to the axis, with the follower on its left.
            let touch = match touch.starts_with("face") {
                true => format!("face = [{:e}, {:e}]\n", axis[1], -axis[0]),
                false => touch.to_owned(),
            };
            let guide = self.joint("lift", "prismatic", [&hub, &format!("{follower}.o")], &keys);
            (format!("{follower}.o"), guide, touch)
        } else {
            let side = ["left", "right"][self.pick(2)];
            let given =
                if side == "right" || self.chance(0.5) { format!("side = \"{side}\"\n") } else { String::new() };
            let pivot = self.point("pivot", [x + 0.4, y + 0.1]);
            let follower = self.body("rocker", [0.38, 0.02]);
            let ends = [pivot.as_str(), &format!("{follower}.o")].map(str::to_owned);
            let guide = self.joint("rock", "revolute", [&ends[0], &ends[1]], "");
            let touch = if touch.starts_with("face") { "" } else { touch };
            (format!("{follower}.e"), guide, format!("{touch}{given}"))
        };
        let (tip, guide, touch) = follower;
        let keys = format!("shaft = \"{shaft}\"\nguide = \"{guide}\"\nbase = 0.15\nlaw = \"{law}\"\n{touch}");
        let contact = self.joint("contact", "cam", [&cam, &tip], &keys);
        for own in &mut self.owners[first..] {
            own.from_ground = if own.name == contact { 1.0 } else { own.from_ground };
            own.turns = true;
        }
        self.loads(&cam, Some(&shaft), None);
    }

    /// A body that nothing holds.
    fn free(&mut self) {
        let e = self.place();
        let body = self.body("free", e);
        for word in ["x", "y", "angle", "vx", "vy", "omega"] {
            self.start(&format!("{body}.{word}"), -1.0, 1.0);
        }
        self.loads(&body, None, None);
    }

    /// A body of which one point is led.
    fn led(&mut self) {
        let body = self.body("led", [0.3, 0.1]);
        let keys = format!("on = \"{body}.e\"\nposition = [\"0.3*sin(3*t)\", {:e}]\n", self.number(-1.0, 1.0));
        self.entry("drivers", "lead", "position", Sort::Joint, [false; 2], &keys);
        self.start(&format!("{body}.angle"), -2.0, 2.0);
        self.start(&format!("{body}.omega"), -2.0, 2.0);
    }
}
