//! Scenes in which much cancels at the start, or is left open.

/// The coupler of a parallelogram does not turn, however long its bars are.
pub const PARALLELOGRAM: &str = r#"
format = 1
name = "parallelogram"
gravity = [0, -9.81]
[parameters]
bar = 0.4
width = 1.1
weight = 3.0
[ground.points]
left = [0, 0]
right = ["width", 0]
[bodies.crank]
mass = 1.0
inertia = 0.1
points = { low = [0, 0], high = ["bar", 0] }
[bodies.coupler]
mass = "weight"
inertia = 0.2
points = { left = ["-width/2", 0], right = ["width/2", 0] }
[bodies.rocker]
mass = 1.5
inertia = 0.1
points = { low = [0, 0], high = ["bar", 0] }
[joints.a]
type = "revolute"
between = ["ground.left", "crank.low"]
[joints.b]
type = "revolute"
between = ["crank.high", "coupler.left"]
[joints.c]
type = "revolute"
between = ["coupler.right", "rocker.high"]
[joints.d]
type = "revolute"
between = ["ground.right", "rocker.low"]
[initial]
"crank.angle" = "60 deg"
"crank.omega" = 2.0
"rocker.angle" = { guess = "60 deg" }
"coupler.angle" = { guess = 0 }
[outputs]
variables = ["coupler.angle", "coupler.omega", "coupler.x", "coupler.vx", "rocker.angle", "rocker.omega", "crank.alpha", "b.fx", "energy.potential"]
"#;

/// Nothing is known of a four-bar's position but guesses, and nothing at all of its rates; a spring knows its own length.
pub const HALF_KNOWN: &str = r#"
format = 1
name = "half_known"
gravity = [0, -9.81]
[parameters]
rod = 1.3
stiffness = 40.0
tilt = 0.2
[ground.points]
left = [0, 0]
right = [1, 0]
hook = [2, 1]
[bodies.crank]
mass = 1.0
inertia = 0.1
points = { low = [0, 0], high = [0.4, 0] }
[bodies.coupler]
mass = 2.0
inertia = 0.2
points = { left = [0, 0], right = ["rod", 0] }
[bodies.rocker]
mass = 1.5
inertia = 0.1
points = { low = [0, 0], high = [0.9, 0] }
[bodies.apart]
mass = 1.0
inertia = 0.3
points = { pin = [0, 0.5] }
[joints.a]
type = "revolute"
between = ["ground.left", "crank.low"]
[joints.b]
type = "revolute"
between = ["crank.high", "coupler.left"]
[joints.c]
type = "revolute"
between = ["coupler.right", "rocker.high"]
[joints.d]
type = "revolute"
between = ["ground.right", "rocker.low"]
[joints.e]
type = "revolute"
between = ["ground.hook", "apart.pin"]
[loads.spring]
type = "spring"
between = ["ground.hook", "coupler"]
stiffness = "stiffness"
length = 1.0
[initial]
"crank.angle" = { guess = "50 deg" }
"rocker.angle" = { guess = "80 deg" }
"apart.angle" = "tilt + 0.1"
[outputs]
variables = ["crank.angle", "coupler.omega", "rocker.alpha", "apart.angle", "apart.omega", "apart.alpha", "spring.force", "c.fy", "energy.kinetic"]
"#;

/// Drivers follow inputs: a position, a velocity and an acceleration.
pub const FOLLOWED: &str = r#"
format = 1
name = "followed"
[parameters]
arm = 0.7
[inputs]
place = 0.1
speed = 0.2
push = 0.3
[bodies.upper]
mass = 1.0
inertia = 0.1
points = { pin = [0, 0], tip = ["arm", 0] }
[bodies.lower]
mass = 2.0
inertia = 0.2
points = { pin = [0, 0], tip = [1, 0] }
[bodies.hand]
mass = 3.0
inertia = 0.3
points = { pin = [0, 0], tip = [1, 0] }
[joints.shoulder]
type = "revolute"
between = ["ground", "upper.pin"]
[joints.elbow]
type = "revolute"
between = ["upper.tip", "lower.pin"]
[joints.wrist]
type = "revolute"
between = ["lower.tip", "hand.pin"]
[drivers.first]
joint = "shoulder"
angle = { input = "place", as = "position" }
[drivers.second]
joint = "elbow"
angle = { input = "speed", as = "velocity" }
[drivers.third]
joint = "wrist"
angle = { input = "push", as = "acceleration" }
[initial]
"elbow.angle" = 0.4
"wrist.angle" = 0.6
"wrist.omega" = 0.5
[outputs]
variables = ["upper.angle", "upper.omega", "lower.angle", "lower.omega", "lower.alpha", "hand.omega", "hand.alpha", "hand.tip.x", "hand.tip.vx", "first.torque", "second.torque", "third.torque", "wrist.fx"]
"#;

/// A driven arm with a loose link behind: rates and accelerations of both kinds.
pub const DRIVEN_ARM: &str = r#"
format = 1
name = "driven_arm"
gravity = [0, -9.81]
[parameters]
speed = { value = "30 rpm", unit = "rad/s" }
drag = 0.2
[inputs]
wind = "2 N"
[bodies.arm]
mass = 1.0
inertia = 0.1
points = { pin = [-0.5, 0], tip = [0.5, 0] }
[bodies.link]
mass = 0.5
inertia = 0.05
points = { pin = [-0.3, 0], tip = [0.3, 0] }
[joints.motor_pin]
type = "revolute"
between = ["ground", "arm.pin"]
[joints.link_pin]
type = "revolute"
between = ["arm.tip", "link.pin"]
damping = "drag"
[drivers.motor]
joint = "motor_pin"
angle = "speed*t"
[loads.gust]
type = "force"
on = "link.tip"
vector = ["max(wind, 0)", 0]
[initial]
"link.angle" = "20 deg"
[outputs]
variables = ["arm.angle", "arm.omega", "link.omega", "link.alpha", "motor.torque", "link_pin.fx"]
"#;
