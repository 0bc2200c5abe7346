//! What must hold for an arm form, so that finding series cannot fail.

use super::{
    ArmForm, Cause, CoordinatePlace, Factor, Frame, Friction, Given, MAX_SWITCHES, NormalForce, SeriesOperation,
    SeriesStep, Slope, Slot, Solved, SolvedSum, Source,
};
use crate::program::Program;

/// Holds, or what does not.
type Check = Result<(), &'static str>;

fn holds(condition: bool, what: &'static str) -> Check {
    if condition { Ok(()) } else { Err(what) }
}

impl ArmForm {
    /// Checks everything but the tape of the coefficients, as a part of a program.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, program: &Program) -> Check {
        let constraints = program.constraints.len();
        holds(self.unit_of_mass.is_normal() && self.unit_of_mass > 0.0, "the unit of mass")?;
        self.check_unknowns(program.coordinates.len())?;
        let given = self.tape.given.iter().all(|(_, given)| match *given {
            Given::Time => true,
            Given::Input(index, _) => (index as usize) < program.inputs.len(),
            Given::Follower(index, _) => (index as usize) < program.followers.len(),
        });
        holds(given, "what a series is given by")?;
        let written = self.check_tape()?;
        let signal = |slot: Slot| self.is_signal(slot) && written.get(slot as usize) == Some(&true);
        let position = |slot: Slot| !self.is_rate(slot) && written.get(slot as usize) == Some(&true);
        let coefficient = |place: &u32| (*place as usize) < self.coefficients.results.len();
        for frame in &self.frames {
            holds(frame.signal.is_none_or(signal) && coefficient(&frame.inertia), "a frame")?;
        }
        let factors = self.products.iter().map(|product| &product.factor).chain(&self.world);
        for factor in factors {
            holds(!matches!(factor, Factor::Signal(slot) if !signal(*slot)), "the length of an arm")?;
        }
        for entry in &self.coupling {
            let places = self.is_arm(entry.on) && self.is_arm(entry.from);
            holds(places && entry.mass.iter().all(coefficient), "a mass")?;
        }
        self.check_links()?;
        for row in &self.rows {
            let arms = row.arms.iter().all(|(arm, p)| self.is_arm(*arm) && p.iter().all(coefficient));
            let unknowns = row.unknowns.iter().all(|(unknown, c)| self.is_unknown(*unknown) && coefficient(c));
            let signals = row.signals.iter().all(|(slot, c)| position(*slot) && coefficient(c));
            let is_valid = (row.constraint as usize) < constraints && coefficient(&row.constant);
            holds(arms && unknowns && signals && is_valid, "a loop equation")?;
        }
        for contact in &self.contacts {
            let is_row = (contact.row as usize) < self.rows.len() && coefficient(&contact.open);
            holds(is_row, "a loop equation that does not always hold")?;
            let series = |slot: Slot| written.get(slot as usize) == Some(&true);
            let friction = contact.friction.as_ref();
            holds(friction.is_none_or(|friction| self.is_friction(friction, constraints, series)), "a friction")?;
        }
        for load in &self.loads {
            let value = load.value.is_none_or(|slot| written.get(slot as usize) == Some(&true));
            holds(self.is_arm(load.arm) && value && load.along.iter().all(coefficient), "a load")?;
        }
        for push in &self.pushes {
            let value = match push.value {
                Cause::One => true,
                Cause::Series(slot) => written.get(slot as usize) == Some(&true),
                Cause::Reaction { row, slope } => (row as usize) < self.rows.len() && position(slope),
            };
            holds(self.is_unknown(push.unknown) && value && coefficient(&push.factor), "a load")?;
        }
        Ok(())
    }

    fn is_friction(&self, friction: &Friction, constraints: usize, series: impl Fn(Slot) -> bool) -> bool {
        let coefficient = |place: &u32| (*place as usize) < self.coefficients.results.len();
        let is_solved = |solved: Solved| match solved {
            Solved::Unknown(unknown) => self.is_unknown(unknown),
            Solved::X(arm) | Solved::Y(arm) => (arm as usize) < self.frames.len() && self.is_unknown(arm),
            Solved::Row(row) => (row as usize) < self.rows.len(),
            Solved::Limit(contact) => self.contacts.get(contact as usize).is_some_and(|it| it.friction.is_some()),
        };
        let is_slope = |slope: Slope| match slope {
            Slope::Constant(place) => coefficient(&place),
            Slope::Series(slot) => series(slot),
        };
        let is_sum = |sum: &SolvedSum| {
            let is_term = |&(solved, slope): &(Solved, Slope)| {
                let is_arm = matches!(solved, Solved::X(_) | Solved::Y(_));
                is_slope(slope) && is_solved(solved) && !(is_arm && matches!(slope, Slope::Series(_)))
            };
            series(sum.rest) && sum.terms.iter().all(is_term)
        };
        let is_normal = |force: &NormalForce| match force {
            NormalForce::Signed(sign, sum) => coefficient(sign) && is_sum(sum),
            NormalForce::Magnitude(components) => (1..=2).contains(&components.len()) && components.iter().all(is_sum),
        };
        (friction.constraint as usize) < constraints
            && friction.arms.iter().all(|(arm, along)| self.is_arm(*arm) && along.iter().all(coefficient))
            && friction.unknowns.iter().all(|(unknown, factor)| self.is_unknown(*unknown) && coefficient(factor))
            && is_slope(friction.free)
            && is_slope(friction.share)
            && friction.normal.iter().all(is_normal)
    }

    /// A tree has all arms, once each, of frames that turn by themselves and of lines in the world; and nothing else couples them.
    fn check_links(&self) -> Check {
        if self.links.is_empty() {
            return Ok(());
        }
        let coefficient = |place: &u32| (*place as usize) < self.coefficients.results.len();
        let open = self.rows.is_empty() && self.rods.is_empty() && self.auxiliary.is_empty();
        let has_matching_unknown =
            |(index, frame): (usize, &Frame)| frame.unknown.is_none_or(|unknown| unknown as usize == index);
        let plain = self.products.is_empty() && self.frames.iter().enumerate().all(has_matching_unknown);
        holds(open && plain && self.coupling.is_empty(), "a tree of arms")?;
        let mut found = vec![false; self.frames.len() + self.world.len()];
        for (index, link) in self.links.iter().enumerate() {
            let place = found.get_mut(link.arm as usize).ok_or("the arm of a link")?;
            holds(!std::mem::replace(place, true), "an arm has two links")?;
            holds(link.parent.is_none_or(|parent| (parent as usize) < index), "what a link hangs from")?;
            let masses = link.begin.iter().chain(&link.carried).chain([&link.inertia]);
            holds({ masses }.all(coefficient), "the masses of a link")?;
        }
        holds(found.iter().all(|found| *found), "an arm has no link")
    }

    fn is_arm(&self, arm: u32) -> bool {
        (arm as usize) < self.frames.len() + self.products.len() + self.world.len()
    }

    fn is_unknown(&self, arm: u32) -> bool {
        let (index, frames) = (arm as usize, self.frames.len());
        if let Some(frame) = self.frames.get(index) {
            return frame.unknown == Some(arm);
        }
        let product = self.products.get(index - frames).map(|product| product.factor);
        let world = || self.world.get((index - frames).checked_sub(self.products.len())?).copied();
        product.or_else(world) == Some(Factor::Unknown)
    }

    fn check_unknowns(&self, coordinates: usize) -> Check {
        let arms = self.frames.len() + self.products.len() + self.world.len();
        let unknowns = (0..arms).filter(|&arm| self.is_unknown(arm as u32)).count();
        holds(self.coordinates.len() == coordinates, "the number of coordinates")?;
        holds(unknowns == coordinates + self.auxiliary.len() + self.rods.len(), "the number of unknowns")?;
        for (index, frame) in self.frames.iter().enumerate() {
            let earlier = |unknown: u32| unknown as usize <= index && self.is_unknown(unknown);
            holds(frame.unknown.is_none_or(earlier), "the angle of a frame")?;
        }
        holds(self.products.iter().all(|product| (product.frame as usize) < self.frames.len()), "the frame of an arm")?;
        let mut carried = vec![false; arms];
        let mut carry = |arm: u32| !carried.get_mut(arm as usize).is_none_or(|place| std::mem::replace(place, true));
        for place in &self.coordinates {
            let fits = match *place {
                CoordinatePlace::Angle { arm, parent, .. } => {
                    let angle = |arm: u32| (arm as usize) < self.frames.len() && self.is_unknown(arm);
                    angle(arm) && parent.is_none_or(angle) && carry(arm)
                }
                CoordinatePlace::Displacement { arm } => {
                    arm as usize >= self.frames.len() && self.is_unknown(arm) && carry(arm)
                }
            };
            holds(fits, "the place of a coordinate")?;
        }
        for auxiliary in &self.auxiliary {
            let product = (auxiliary.arm as usize) < self.frames.len() + self.products.len();
            let turning = auxiliary.arm as usize >= self.frames.len() && product && self.is_unknown(auxiliary.arm);
            let rows = (auxiliary.row as usize) + 1 < self.rows.len();
            let direction = auxiliary.direction.iter().all(|place| (*place as usize) < self.coefficients.results.len());
            holds(turning && rows && direction && carry(auxiliary.arm), "a free displacement")?;
        }
        for rod in &self.rods {
            let turning = (rod.frame as usize) < self.frames.len() && self.is_unknown(rod.frame);
            let rows = (rod.row as usize) + 1 < self.rows.len();
            let length = (rod.length as usize) < self.coefficients.results.len();
            holds(turning && rows && length && carry(rod.frame), "a rod")?;
        }
        holds(self.chain().len() == coordinates, "the chain of angles")
    }

    /// Is a series given, or does it follow from what is given?
    fn is_signal(&self, slot: Slot) -> bool {
        let given = self.tape.given.iter().any(|(target, _)| *target == slot);
        given || self.tape.signals.iter().any(|step| step.targets().any(|target| target == slot))
    }

    /// Follows the tape; returns which series are written.
    fn check_tape(&self) -> Result<Vec<bool>, &'static str> {
        let tape = &self.tape;
        let steps = tape.signals.len() + tape.positions.len() + tape.rates.len();
        // The bound keeps a damaged file from asking for all of the memory.
        holds(tape.slots as usize <= tape.given.len() + 2 * steps, "the number of series")?;
        holds(tape.switches.len() <= MAX_SWITCHES, "the number of switches")?;
        let mut written = vec![false; tape.slots as usize];
        for &(slot, _) in &tape.given {
            *written.get_mut(slot as usize).ok_or("a given series")? = true;
        }
        for (level, steps) in [&tape.signals, &tape.positions, &tape.rates].into_iter().enumerate() {
            for step in steps {
                self.check_step(level, step, &written)?;
                for target in step.targets() {
                    let place = written.get_mut(target as usize).ok_or("a series")?;
                    holds(!std::mem::replace(place, true), "a series is written twice")?;
                }
            }
        }
        holds(tape.switches.iter().all(|slot| written.get(*slot as usize) == Some(&true)), "a switch")?;
        Ok(written)
    }

    fn check_step(&self, level: usize, step: &SeriesStep, written: &[bool]) -> Check {
        let known = |slot: Slot| written.get(slot as usize) == Some(&true);
        let coefficient = |place: u32| (place as usize) < self.coefficients.results.len();
        let fits = match step.operation {
            SeriesOperation::Linear { first, count, constant } => {
                let terms = self.tape.terms.get(first as usize..).and_then(|terms| terms.get(..count as usize));
                let term = |source: Source| match source {
                    Source::Slot(slot) => known(slot),
                    Source::X(arm) | Source::Y(arm) => level >= 1 && self.is_arm(arm),
                    Source::Unknown(arm) => level >= 1 && self.is_unknown(arm),
                    Source::UnknownRate(arm) => level >= 2 && self.is_unknown(arm),
                };
                let all = terms.is_some_and(|terms| terms.iter().all(|t| term(t.source) && coefficient(t.factor)));
                all && constant.is_none_or(coefficient)
            }
            SeriesOperation::Multiply(a, b) | SeriesOperation::SquareSum(a, b) | SeriesOperation::Divide(a, b) => {
                known(a) && known(b)
            }
            SeriesOperation::Power(a, exponent) => known(a) && coefficient(exponent),
            SeriesOperation::ArcTangent(y, x, square) => known(y) && known(x) && known(square),
            // A rate reads one order ahead: of what is a series of positions already.
            SeriesOperation::Rate(a) => level == 2 && known(a) && !self.is_rate(a),
            SeriesOperation::Floor { argument, switch, function } => {
                known(argument) && self.tape.switches.get(switch as usize) == Some(&function)
            }
            SeriesOperation::Choose { switch, above, equal, below } => {
                let function = self.tape.switches.get(switch as usize);
                function.is_some_and(|slot| known(*slot)) && [above, equal, below].into_iter().all(known)
            }
            SeriesOperation::SquareRoot(a)
            | SeriesOperation::SineCosine(a, _)
            | SeriesOperation::Exponential(a)
            | SeriesOperation::Logarithm(a)
            | SeriesOperation::HyperbolicTangent(a, _) => known(a),
        };
        holds(fits, "a step of a series")
    }

    fn is_rate(&self, slot: Slot) -> bool {
        self.tape.rates.iter().any(|step| step.targets().any(|target| target == slot))
    }
}
