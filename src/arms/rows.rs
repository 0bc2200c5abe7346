//! Loop equations by arms. Constraints along directions of a turning frame become linear by auxiliary displacements, constraints on a distance by a massless rod.

use super::linear::{conjugate_product, linear};
use super::{
    Arm, ArmAuxiliary, ArmEquations, ArmFactor, ArmFriction, ArmLoopEquation, ArmRod, Arms, Equations, NoSeries,
};
use crate::equations::form::Coefficient;
use crate::equations::kinematics::{ScalarMotion, known_angle};
use crate::equations::vector::FrameId;
use crate::expr::{Arena, Expr};
use crate::network::{Angle, Constrained, Coupling, Curve, Direction, Element, Port, RNode, TNode};

impl Equations {
    pub(super) fn row(&mut self, index: usize, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        let element = self.system.element(self.constraints[index].element).clone();
        let Some(closed) = element.closed else { return self.row_of(index, element, arms) };
        let (is_coupled, slip) = (element.coupling.is_some(), element.slip);
        let (auxiliary, rods) = (arms.auxiliary.len(), arms.rods.len());
        self.row_of(index, element, arms)?;
        if arms.rods.len() > rods || !is_coupled && arms.auxiliary.len() > auxiliary {
            return Err(NoSeries(
                "a constraint that is not always active is not a constant combination of arms".to_owned(),
            ));
        }
        // Auxiliary displacements before it are there whether it holds or not.
        if let Some(row) = arms.rows.last_mut() {
            if let Some(direction) = slip {
                row.slide(&mut self.system.arena, direction);
            }
            row.hold_while(&mut self.system.arena, closed);
        }
        Ok(())
    }

    fn row_of(&mut self, index: usize, element: Element, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        let held = self.constraints[index].constrained;
        if let (Some(coupling), false) = (element.coupling, self.constraints[index].coupled.is_empty()) {
            return self.coupled_row(index, &coupling, arms);
        }
        match (held, element.translation, element.rotation) {
            (Constrained::Along(direction), Some(row), _) => {
                let mut gap = self.kinematics.known(&mut self.system, &row.known).position;
                let across = self.kinematics.across(&mut self.system.arena, row.ends).position;
                let minus = self.system.arena.constant(-1.0);
                let across = across.scaled(&mut self.system.arena, minus);
                gap.accumulate(&mut self.system.arena, &across);
                let gap = self.decompose(&gap)?;
                let (frame, along) = self.along(direction);
                self.translational_row(index, gap, (frame, along), arms);
            }
            (Constrained::Angle, _, Some(row)) => {
                let ends = row.ends.map(|node| self.kinematics.placement(node));
                self.rotational_row(index, &row.angle, ends, arms)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn along(&mut self, direction: Direction) -> (FrameId, [Expr; 2]) {
        let (frame, along) = self.kinematics.direction(&mut self.system, direction);
        (frame, along.parts().next().map_or([Expr::ZERO; 2], |(_, components)| components))
    }

    fn coupled_row(&mut self, constraint: usize, coupling: &Coupling, arms: &mut ArmEquations) -> Result<(), NoSeries> {
        let mut row = ArmLoopEquation { constraint, constant: vec![coupling.offset], ..ArmLoopEquation::default() };
        for term in &coupling.terms {
            let factor = self.system.arena.negate(term.factor);
            match term.port {
                Port::Angle(ends) => self.angle_between(ends, factor, arms, &mut row),
                Port::Along(ends, direction) => self.displacement_between(ends, direction, factor, arms, &mut row)?,
                Port::Curve(ends, curve) => self.function_of_angle(ends, &curve, factor, arms, &mut row),
                Port::Length(ends) => return self.rod(constraint, ends, coupling, arms),
                Port::Feature(..) => return Err(NoSeries("a contact follows a profile".to_owned())),
                Port::Span(..) => return Err(NoSeries("a rope runs over pulleys".to_owned())),
                Port::Heading(_) => {
                    return Err(NoSeries(
                        "the friction of a circle depends on the direction to another point".to_owned(),
                    ));
                }
            }
        }
        arms.rows.push(row);
        Ok(())
    }

    /// factor x the angle of the second node relative to the first.
    fn angle_between(&mut self, ends: [RNode; 2], factor: Expr, arms: &ArmEquations, row: &mut ArmLoopEquation) {
        let arena = &mut self.system.arena;
        let minus = arena.negate(factor);
        for (node, factor) in ends.into_iter().zip([minus, factor]) {
            let (frame, offset) = self.kinematics.placement(node);
            row.constant.push(arena.multiply(factor, offset));
            if let Some(turning) = arms.place(frame).map(|place| &arms.frames[place]) {
                row.angles.push((frame, factor));
                row.signals.push((turning.signal, factor));
            }
        }
    }

    /// factor x a function of the angle of the second node relative to the first.
    fn function_of_angle(
        &mut self,
        ends: [RNode; 2],
        curve: &Curve,
        factor: Expr,
        arms: &ArmEquations,
        row: &mut ArmLoopEquation,
    ) {
        let arena = &mut self.system.arena;
        let angle = self.kinematics.angle_across(arena, ends).position.total(arena);
        let [value, slope, _] = curve.value.map(|expr| Curve::at(arena, expr, angle));
        row.signals.push((value, factor));
        let minus = arena.negate(factor);
        for (node, factor) in ends.into_iter().zip([minus, factor]) {
            let (frame, _) = self.kinematics.placement(node);
            if arms.place(frame).is_some() {
                row.slopes.push((frame, slope, factor));
            }
        }
    }

    /// factor x the component along a direction of the displacement from the first node to the second.
    fn displacement_between(
        &mut self,
        ends: [TNode; 2],
        direction: Direction,
        factor: Expr,
        arms: &mut ArmEquations,
        row: &mut ArmLoopEquation,
    ) -> Result<(), NoSeries> {
        let gap = self.kinematics.across(&mut self.system.arena, ends).position;
        let gap = self.decompose(&gap)?;
        let (frame, line) = self.along(direction);
        let arena = &mut self.system.arena;
        let along = line.map(|component| arena.multiply(factor, component));
        let Some(part) = linear_row(arena, row.constraint, &gap, (frame, along)) else {
            // With displacements along the line and across it both components of the gap vanish.
            let across = [arena.negate(line[1]), line[0]];
            let first = self.close(row.constraint, gap, frame, &[line, across], arms);
            let [square, _] = conjugate_product(&mut self.system.arena, line, along);
            row.displacements.push((first, self.system.arena.negate(square)));
            return Ok(());
        };
        row.arms.extend(part.arms);
        row.displacements.extend(part.displacements);
        row.signals.extend(part.signals);
        row.constant.extend(part.constant);
        Ok(())
    }

    /// Closes a gap by displacements in directions fixed in a frame, so that both of its components vanish. Returns the number of
    /// the first displacement.
    fn close(
        &mut self,
        constraint: usize,
        mut gap: Arms,
        frame: FrameId,
        directions: &[[Expr; 2]],
        arms: &mut ArmEquations,
    ) -> usize {
        let first = self.motion_layout().count() + arms.auxiliary.len();
        for (displacement, &free) in (first..).zip(directions) {
            arms.auxiliary.push(ArmAuxiliary { displacement, free, row: arms.rows.len() });
            gap.insert(Arm { frame, factor: ArmFactor::Displacement(displacement) }, free);
        }
        self.vanishes(constraint, gap, arms);
        first
    }

    fn vanishes(&mut self, constraint: usize, gap: Arms, arms: &mut ArmEquations) {
        for axis in [[Expr::ONE, Expr::ZERO], [Expr::ZERO, Expr::ONE]] {
            arms.rows.push(projected_row(&mut self.system.arena, constraint, gap.clone(), axis));
        }
    }

    /// offset - factor x the distance of two points: a massless rod lies between them.
    fn rod(
        &mut self,
        constraint: usize,
        ends: [TNode; 2],
        coupling: &Coupling,
        arms: &mut ArmEquations,
    ) -> Result<(), NoSeries> {
        let [term] = &coupling.terms[..] else {
            return Err(NoSeries("a distance is coupled to another quantity".to_owned()));
        };
        let gap = self.kinematics.across(&mut self.system.arena, ends).position;
        let mut gap = self.decompose(&gap)?;
        let length = self.system.arena.divide(coupling.offset, term.factor);
        let frame = self.kinematics.frames.other(arms.rods.len());
        arms.rods.push(ArmRod { frame, row: arms.rows.len(), length });
        gap.insert(Arm::of(frame), [self.system.arena.negate(length), Expr::ZERO]);
        self.vanishes(constraint, gap, arms);
        Ok(())
    }

    fn translational_row(
        &mut self,
        constraint: usize,
        gap: Arms,
        (frame, along): (FrameId, [Expr; 2]),
        arms: &mut ArmEquations,
    ) {
        let arena = &mut self.system.arena;
        match linear_row(arena, constraint, &gap, (frame, along)) {
            Some(row) => arms.rows.push(row),
            None => {
                // The gap is free across the direction: with a displacement both of its components vanish.
                let free = [arena.negate(along[1]), along[0]];
                self.close(constraint, gap, frame, &[free], arms);
            }
        }
    }

    fn rotational_row(
        &mut self,
        constraint: usize,
        angle: &Angle,
        ends: [(FrameId, Expr); 2],
        arms: &mut ArmEquations,
    ) -> Result<(), NoSeries> {
        let arena = &mut self.system.arena;
        let mut row = ArmLoopEquation { constraint, ..ArmLoopEquation::default() };
        let known: ScalarMotion = known_angle(arena, angle);
        let known = known.position.total(arena);
        let mut terms = Vec::new();
        linear(arena, known, Expr::ONE, &mut terms)?;
        for ((frame, offset), sign) in ends.into_iter().zip([1.0, -1.0]) {
            let sign = arena.constant(sign);
            terms.push((ArmFactor::One, arena.multiply(sign, offset)));
            if let Some(turning) = arms.place(frame).map(|place| &arms.frames[place]) {
                row.angles.push((frame, sign));
                terms.push((ArmFactor::Signal(turning.signal), sign));
            }
        }
        for (factor, coefficient) in terms {
            match factor {
                ArmFactor::One => row.constant.push(coefficient),
                ArmFactor::Signal(signal) => row.signals.push((signal, coefficient)),
                ArmFactor::Displacement(_) => {
                    return Err(NoSeries("a prescribed angle depends on a coordinate".to_owned()));
                }
            }
        }
        arms.rows.push(row);
        Ok(())
    }
}

impl ArmLoopEquation {
    /// Notes what the friction limit acts on, unless that changes with a function of angles.
    fn slide(&mut self, arena: &mut Arena, direction: Expr) {
        if !self.slopes.is_empty() {
            return;
        }
        let (mut arms, mut displacements, mut angles) =
            (self.arms.clone(), self.displacements.clone(), self.angles.clone());
        let parts = arms.values_mut().flatten().chain(displacements.iter_mut().map(|(_, factor)| factor));
        let parts = parts.chain(angles.iter_mut().map(|(_, factor)| factor));
        parts.for_each(|part| *part = arena.multiply(direction, *part));
        self.friction = Some(ArmFriction { arms, displacements, angles });
    }

    /// This loop equation while `closed` is 1; where that is 0 nothing is left of it.
    fn hold_while(&mut self, arena: &mut Arena, closed: Expr) {
        let parts = self.arms.values_mut().flatten().chain(self.displacements.iter_mut().map(|(_, factor)| factor));
        let parts = parts.chain(self.angles.iter_mut().map(|(_, factor)| factor));
        let parts = parts.chain(self.signals.iter_mut().map(|(_, factor)| factor)).chain(&mut self.constant);
        let parts = parts.chain(self.slopes.iter_mut().map(|(.., factor)| factor));
        parts.for_each(|part| *part = arena.multiply(closed, *part));
        self.closed = Some(closed);
    }
}

/// direction . gap, where it is linear in the arms: the direction is fixed in the world, or in the frame of the gap.
fn linear_row(
    arena: &mut Arena,
    constraint: usize,
    gap: &Arms,
    (frame, along): (FrameId, [Expr; 2]),
) -> Option<ArmLoopEquation> {
    match frame == FrameId::WORLD {
        true => Some(projected_row(arena, constraint, gap.clone(), along)),
        false => row_in_frame(arena, constraint, gap.clone(), (frame, along)),
    }
}

/// direction . gap, with the direction fixed in the world.
fn projected_row(arena: &mut Arena, constraint: usize, gap: Arms, direction: [Expr; 2]) -> ArmLoopEquation {
    let mut row = ArmLoopEquation { constraint, ..ArmLoopEquation::default() };
    for (arm, z) in gap {
        // Re(conj(n) z b) = p . b with p = conj(conj(n) z) = conj(z) n
        let p = conjugate_product(arena, z, direction);
        if arm.is_constant() {
            row.constant.push(p[0]);
        } else {
            row.arms.insert(arm, p);
        }
    }
    row
}

/// direction . gap, if the gap and its direction are fixed in the same turning frame but for displacements.
fn row_in_frame(
    arena: &mut Arena,
    constraint: usize,
    gap: Arms,
    (frame, along): (FrameId, [Expr; 2]),
) -> Option<ArmLoopEquation> {
    let mut row = ArmLoopEquation { constraint, ..ArmLoopEquation::default() };
    for (arm, z) in gap {
        if arm.frame != frame {
            return None;
        }
        let [factor, _] = conjugate_product(arena, along, z);
        match arm.factor {
            ArmFactor::One => row.constant.push(factor),
            ArmFactor::Displacement(index) => row.displacements.push((index, factor)),
            ArmFactor::Signal(signal) => row.signals.push((signal, factor)),
        }
    }
    Some(row)
}
