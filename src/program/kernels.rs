//! Something for each kernel of a program: its expressions, and then its tape.

/// Declares the kernels in the order in which their constants are found.
macro_rules! kernels {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        #[derive(Clone, Debug)]
        pub(super) struct Kernels<T> {
            $($(#[$doc])* pub $name: T,)*
        }

        impl<T: Copy> Kernels<T> {
            pub fn all(&self) -> Vec<T> {
                vec![$(self.$name),*]
            }

            pub fn map<U>(self, mut of: impl FnMut(T) -> U) -> Kernels<U> {
                Kernels { $($name: of(self.$name)),* }
            }
        }
    };
}

kernels! {
    constraint,
    jacobian,
    constraint_rate,
    gamma,
    /// Known and guessed positions, then what they are to be.
    position,
    position_jacobian,
    /// As for positions.
    velocity,
    velocity_jacobian,
    /// Accelerations, rates of states, reactions; then reciprocal pivots.
    acceleration,
    project_position,
    project_velocity,
    indicators,
    laws,
    domains,
    ranges,
    outputs,
    /// What discrete variables begin with, periods and offsets, what is written at instants, sides of comparisons.
    begin,
    clocks,
    written,
    sides,
    /// What is held on one side only.
    gaps,
    gap_rates,
    gap_accelerations,
    restitutions,
    impact,
    pressing,
    locks,
    row_sizes,
    /// Where contacts with profiles are.
    places,
    /// Coefficients of the arm form.
    arms,
    /// Coefficients of the arm form without loads.
    masses,
}
