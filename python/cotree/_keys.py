"""The keys of scenes, made by tools/python/keys.py from schema/scene.schema.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Required, TypedDict

import numpy as np

#: A number in SI units, a text with a unit, or an expression.
Quantity = float | str | np.floating[Any] | np.integer[Any]
#: Components.
Vector = Sequence[Quantity] | np.ndarray


class Shape(TypedDict, total=False):
    """Keys of the shapes of bodies."""

    #: the area of its cross-section, with a density in kg/m3 [m2]; required with a density in kg/m3 if absent
    area: Quantity
    #: its density: kg/m3, or per length or area in kg/m or kg/m2 [kg/m3]; mass of the body if absent
    density: Quantity
    #: its centre [m]
    disc: str | Vector
    #: two opposite corners; its sides are along the body's axes [m]
    plate: Sequence[str | Vector]
    #: its corners, counter-clockwise [m]
    polygon: Sequence[str | Vector]
    #: its radius [m]
    radius: Quantity
    #: its two ends [m]
    rod: Sequence[str | Vector]
    #: its thickness, with a density in kg/m3 [m]; required with a density in kg/m3 if absent
    thickness: Quantity


class SampledValue(TypedDict, total=False):
    """Keys of the values of samplers."""

    #: one line about it
    description: str
    #: its new value at a sample time: an expression of all variables just before it; new(x) is the new value of x of the same sampler; unchanged; events may set it if absent
    next: Quantity
    #: its value before the first sample: an expression of parameters, inputs, and positions, velocities and states at the start; 0 if absent
    start: Quantity
    #: its unit, that of numbers without one; that of its start if absent
    unit: str


class ParameterKeys(TypedDict, total=False):
    """Keys of a parameter."""

    #: one line about it
    description: str
    #: its largest value
    max: Quantity
    #: its smallest value
    min: Quantity
    #: whether it may change while the FMU runs; false if absent
    tunable: bool
    #: the unit of numbers without one; SI, as the value is used if absent
    unit: str


class InputKeys(TypedDict, total=False):
    """Keys of an input."""

    #: one line about it
    description: str
    #: its largest value
    max: Quantity
    #: its smallest value
    min: Quantity
    #: the unit of numbers without one; SI, as the value is used if absent
    unit: str


class StateKeys(TypedDict, total=False):
    """Keys of a state."""

    #: one line about it
    description: str
    #: its usual size: tolerances are relative to it; the size of its start, or 1 if absent
    nominal: Quantity
    #: its unit, that of numbers without one; that of its start if absent
    unit: str


class SignalKeys(TypedDict, total=False):
    """Keys of a signal."""

    #: the error before the start, for the first derivative; 0 if absent
    before: Quantity
    #: the cutoff angular frequency of a second-order filter [rad/s]
    cutoff: Quantity
    #: the damping ratio, with cutoff; 1/sqrt(2), maximally flat if absent
    damping: Quantity
    #: derivative gain: output per rate of the error
    derivative: Quantity
    #: one line about it
    description: str
    #: the control error: setpoint minus actual value
    error: Quantity
    #: time constant of the filter of the derivative part [s]; required with derivative, unless the controller is sampled if absent
    filter: Quantity
    #: its input: a law
    input: Quantity
    #: integral gain: output per error and time
    integral: Quantity
    #: upper limit of the output (saturation)
    max: Quantity
    #: lower limit of the output (saturation)
    min: Quantity
    #: its nominal value: tolerances are relative to it; the size of its limits or of its start, or 1 if absent
    nominal: Quantity
    #: the time of the first sample, if it is sampled [s]; 0 if absent
    offset: Quantity
    #: number of states of the approximation, an integer from 1 to 10; 4 if absent
    order: Quantity
    #: the sample time, if it is sampled: its output changes at sample times only [s]; it is continuous if absent
    period: Quantity
    #: proportional gain: output per error
    proportional: Quantity
    #: the integral part at the start; 0 if absent; its output at the start; 0 if absent; its input before the start; 0 if absent
    start: Quantity
    #: the time constant of a first-order filter [s]; the delay [s]
    time: Quantity
    #: anti-windup: the tracking time constant of the integral part at a limit; if sampled, at least the period [s]; proportional/integral if absent
    tracking: Quantity
    type: Literal['pid'] | Literal['filter'] | Literal['delay']
    #: its unit: the law must have it; a bare number is in it; the unit of the law if absent
    unit: str


class SamplerKeys(TypedDict, total=False):
    """Keys of a sampler."""

    #: the time of the first sample [s]; 0 if absent
    offset: Quantity


class EventKeys(TypedDict, total=False):
    """Keys of an event."""

    #: one line about it
    description: str
    #: names of joints that engage
    engage: Sequence[str]
    #: whether it happens only once; false, but true where it removes something if absent
    once: bool
    #: names of joints that are released, and may engage again
    release: Sequence[str]
    #: names of joints, drivers and loads that are removed
    remove: Sequence[str]
    #: new values of sampled values, states and rates such as "arm.omega", expressions of all variables just before the event
    set: Mapping[str, Quantity]
    #: whether it ends the run; false if absent
    stop: bool


class OutputKeys(TypedDict, total=False):
    """Keys of an output."""

    #: one line about it
    description: str
    #: the unit in which it is shown; the unit of its expression if absent
    unit: str


class PartKeys(TypedDict, total=False):
    """Keys of a part."""

    #: its angle of rotation [rad]; 0 if absent
    angle: Quantity
    #: the position of its origin [m]; [0, 0] if absent
    at: Vector
    #: whether it is mirrored left to right, before the rotation; false if absent
    mirror: bool
    #: the body of this scene to which its ground is fixed; "ground" if absent
    on: str
    #: new values of its parameters: expressions of the parameters of this file; its own if absent
    parameters: Mapping[str, Quantity]


class BodyKeys(TypedDict, total=False):
    """Keys of a body."""

    #: its mass centre in the frame of the points [m]; that of the shape, or the origin if absent
    com: Vector
    #: whether gravity acts on it; true if absent
    gravity: bool
    #: its moment of inertia about the mass centre [kg.m2]; that of the shape if absent
    inertia: Quantity
    #: its mass [kg]; that of the shape if absent
    mass: Quantity
    #: its outline in the frame of the points, for pictures and clearance; that of the shape if absent
    outline: Mapping[str, Any]
    #: its points, in a frame that is fixed in it [m]
    points: Mapping[str, Vector]
    #: a uniform shape in the frame of the points
    shape: Shape


class DriverKeys(TypedDict, total=False):
    """Keys of a driver."""

    #: the motion [rad]
    angle: Quantity | Mapping[str, Any]
    #: between = ["ground", "BODY"] turns the second body against the first
    between: Sequence[str]
    #: the motion [m]
    displacement: Quantity | Mapping[str, Any]
    #: joint = "JOINT" turns this joint; joint = "JOINT" slides along this joint
    joint: str
    #: on = "BODY.POINT" moves this point
    on: str
    #: the motion in the world [m]
    position: Vector


class SolverKeys(TypedDict, total=False):
    """Settings of the solver."""

    #: absolute tolerance of a step; the solver's if absent
    atol: Quantity
    #: the longest step [s]
    max_step: Quantity
    #: the integrator: automatic switching between stiff and non-stiff methods, or one of them
    method: Literal['auto', 'explicit', 'implicit']
    #: relative tolerance of a step; the solver's if absent
    rtol: Quantity
    #: limit of the computing time of one communication step; more is an error [s]
    time_budget: Quantity


#: The kinds of joints.
JointType = Literal["revolute", "prismatic", "weld", "slot", "rolling", "distance", "lock", "contact", "rope", "brake", "clutch", "one_way", "gear", "rack", "belt", "screw", "cam"]


class JointKeys(TypedDict, total=False):
    """Keys of joints, whatever their kind."""

    #: the second body's angle minus the first's [rad]; the angle that it holds, if it is engaged at the start or in its named pose [rad]; 0; an event engages it at any angle if absent; the second wheel's angle where the first's is zero [rad]; the second pulley's angle where the first's is zero [rad]
    angle: Quantity
    #: moment of inertia that turns with the joint's angle only, such as a geared rotor's times the square of its ratio [kg.m2]; mass that moves with the displacement only, such as a geared rotor's inertia over the square of its lead [kg]
    armature: Quantity
    #: where it engages: where it stands, or in the pose that its constants give
    at: Literal['here', 'named']
    #: the direction in the first body's frame; axis = [1.0, 0.0] is the direction of a line through the first point; the direction in the carrier's frame
    axis: Vector
    #: backlash of the second wheel against the first, with a coefficient of restitution [rad]; backlash of the displacement, with a coefficient of restitution [m]
    backlash: Mapping[str, Any]
    #: the radius of the base circle, on which the follower is where the law is zero [m]
    base: Quantity
    #: the body in which the wheels have their bearings; the ground if absent; the point from which the displacement counts; the ground's origin if absent
    carrier: str
    #: circle = "0.5 m" is the radius of a circle about the first point [m]
    circle: Quantity
    #: true for a profile whose last corner leads to the first; false if absent
    closed: bool
    #: what keeps the follower on the cam: a force, or the form of a groove or of a conjugate cam, which also pulls
    closure: Literal['force', 'form']
    #: viscous friction [N.m.s]; viscous friction [N.s/m]
    damping: Quantity
    #: the direction in which the second body may turn against the first
    direction: Literal['counterclockwise', 'clockwise']
    #: the displacement where the angle is zero [m]; the displacement that it holds of a prismatic joint, likewise [m]; 0; an event engages it at any displacement if absent
    displacement: Quantity
    #: whether it is engaged at the start; events engage and release it; true if absent
    engaged: bool
    #: the direction of a flat follower's face in its frame; the follower is on its left
    face: Vector
    #: the radius of the first pulley [m]
    first_radius: Quantity
    #: dry friction [N.m, rad/s]; dry friction [N, m/s]; the Coulomb friction of the contact: with it the disc may slip; if absent, it does not slip [N, m/s]; Coulomb friction along the line or the circle [N, m/s]; friction of the mesh: mu is its torque on the first wheel per torque of the mesh; from 1 on it is self-locking [N.m, rad/s]; the torque on the second pulley at which the belt slips, or what it follows from: coefficient of friction, the smaller angle of wrap, mean tension; if absent, the belt does not slip [N.m, rad/s]; friction of a square thread at radius, along its helix [N, m/s]
    friction: Any
    #: the joint in which the follower moves on the carrier: prismatic, from the carrier to the follower, or revolute
    guide: str
    #: joint = "JOINT" holds the motion of this joint
    joint: str
    #: how far the follower rises, in terms of angle, the cam's from 0 to 360 deg against the carrier [m or rad]
    law: Quantity
    #: how far the nut moves in one turn; negative for a left-hand thread [m]
    lead: Quantity
    #: the length of the rod [m]; the length of the rope; a rope over pulleys or onto a drum without it is taut at the start [m]
    length: Quantity
    #: the friction torque limit: the torque while it slips [N.m]
    level: Quantity
    #: hard stops at the ends of its motion [rad]; hard stops at the ends of its motion [m]
    limits: Any
    #: the pulleys that it runs over, from the first end to the last
    over: Sequence[Mapping[str, Any]]
    #: profile = [[0, 0], [0.1, 0], { to = [0.2, 0.1], radius = "0.1 m" }] is a chain of lines and arcs from the first point, in the axes of its body [m]
    profile: Sequence[Vector | Mapping[str, Any]]
    #: the radius of the disc [m]; the radius of a disc about the second point [m]; the radius of the pinion; negative if the rack goes back when the pinion turns forward [m]
    radius: Quantity
    #: the second wheel's turns for one of the first; negative for external teeth
    ratio: Quantity
    #: the coefficient of restitution; the coefficient of restitution when it becomes taut
    restitution: Quantity
    #: the radius of the follower's roller; a knife edge if absent [m]
    roller: Quantity
    #: whether the belt is open or crossed
    run: Literal['open', 'crossed']
    #: the radius of the second pulley [m]
    second_radius: Quantity
    #: the revolute joint in which the cam turns on the carrier
    shaft: str
    #: on which side of the line the disc rolls, seen along the axis; on which side of the line the point stays, seen along the axis, or of the profile, seen along it; or of the circle, outside by default; where a turning follower touches, seen from the shaft towards its pivot
    side: Literal['left', 'right'] | Literal['left', 'right', 'outside', 'inside']
    #: ratio of the static to the kinetic friction torque limit; 1 if absent
    static: Quantity
    #: allows lift-off: a unilateral contact with the coefficient of restitution restitution
    unilateral: Mapping[str, Any]


class RevoluteKeys(TypedDict, total=False):
    """Keys of a revolute joint."""

    #: moment of inertia that turns with the joint's angle only, such as a geared rotor's times the square of its ratio [kg.m2]
    armature: Quantity
    #: where it engages: where it stands, or in the pose that its constants give
    at: Literal['here', 'named']
    #: viscous friction [N.m.s]
    damping: Quantity
    #: whether it is engaged at the start; events engage and release it; true if absent
    engaged: bool
    #: dry friction [N.m, rad/s]
    friction: Any
    #: hard stops at the ends of its motion [rad]
    limits: Any


class PrismaticKeys(TypedDict, total=False):
    """Keys of a prismatic joint."""

    #: the second body's angle minus the first's [rad]
    angle: Quantity
    #: mass that moves with the displacement only, such as a geared rotor's inertia over the square of its lead [kg]
    armature: Quantity
    #: where it engages: where it stands, or in the pose that its constants give
    at: Literal['here', 'named']
    #: viscous friction [N.s/m]
    damping: Quantity
    #: whether it is engaged at the start; events engage and release it; true if absent
    engaged: bool
    #: dry friction [N, m/s]
    friction: Any
    #: hard stops at the ends of its motion [m]
    limits: Any


class WeldKeys(TypedDict, total=False):
    """Keys of a weld joint."""

    #: the second body's angle minus the first's [rad]
    angle: Quantity
    #: where it engages: where it stands, or in the pose that its constants give
    at: Literal['here', 'named']
    #: whether it is engaged at the start; events engage and release it; true if absent
    engaged: bool


#: The kinds of loads.
LoadType = Literal["force", "torque", "spring", "torsion_spring", "actuator", "damper", "torsion_actuator", "gas_spring", "constant_force_spring", "torsion_damper", "bushing", "dc_motor", "cylinder"]


class LoadKeys(TypedDict, total=False):
    """Keys of loads, whatever their kind."""

    #: the free angle [rad]
    angle: Quantity
    #: the areas of the piston: behind it, and around the rod [m2]
    areas: Vector
    #: between = ["BODY", "BODY"] turns the second against the first; the two ends: points, or drums: { drum = "BODY", radius = "60 mm", side = "right" }; the two bodies; the two points
    between: Sequence[str] | Sequence[str | Mapping[str, Any]]
    #: the bulk modulus of the oil [Pa]
    bulk: Quantity
    #: the length of the column of gas there: its volume over the area of the piston [m]
    column: Quantity
    #: its torque per current, which is also its voltage per angular velocity [N.m/A]
    constant: Quantity
    #: the cubic stiffness [N/m3]; the cubic stiffness [N.m/rad3]
    cubic: Quantity
    #: its current at the start [A]; 0 if absent
    current: Quantity
    #: the damping coefficient [N.s/m]; the damping coefficient [N.m.s]
    damping: Quantity
    #: the exponent of the volume in p V^n: 1 at constant temperature, 1.4 for air without exchange of heat
    exponent: Quantity
    #: the law; positive pushes the points apart [N]
    force: Quantity
    #: whose axes the components are along
    frame: Literal['world', 'body']
    #: the inductance of its winding [H]
    inductance: Quantity
    #: leakage past the piston per pressure difference [m3/s per Pascal]; 0 if absent
    leakage: Quantity
    #: the free length [m]; the distance between the points where the force is push [m]
    length: Quantity
    #: the point; on = "BODY" turns a body
    on: str
    #: the opening of its valve, from -1 to 1: a law; positive lets the supply into the cap
    opening: Quantity
    #: the pulleys that it runs over, from the first end to the last
    over: Sequence[Mapping[str, Any]]
    #: the pressures at the start: behind the piston, and around the rod [Pa]
    pressures: Vector
    #: the force that pulls the points together [N]
    pull: Quantity
    #: the force that pushes the points apart at length [N]
    push: Quantity
    #: turns of its rotor per turn between the bodies; its gear has no inertia and no backlash; 1 if absent
    ratio: Quantity
    #: the resistance of its winding [ohm]
    resistance: Quantity
    #: the length at which the volumes are these [m]
    retracted: Quantity
    #: whether it acts above its free length or angle, below it, or both
    side: Literal['both', 'above', 'below']
    #: the stiffness [N/m]; the stiffness [N.m/rad]; the stiffness, the same in all directions [N/m]
    stiffness: Quantity
    #: the pressure of the pump [Pa]
    supply: Quantity
    #: the pressure of the tank [Pa]; 0 if absent
    tank: Quantity
    #: the law [N.m]
    torque: Quantity
    #: the torsional damping [N.m.s]
    torsion_damping: Quantity
    #: the torsional stiffness [N.m/rad]
    torsion_stiffness: Quantity
    #: the torque [N.m]
    value: Quantity
    #: flow through the open valve per square root of the pressure drop [m3/s per square root of a Pascal]
    valve: Quantity
    #: the components [N]
    vector: Vector
    #: the voltage at its terminals: a law [V]
    voltage: Quantity
    #: the volumes of oil, pipes included, where its length is retracted: behind the piston, and around the rod [m3]
    volumes: Vector
