//! Which loop equations say something new: what decides on them before a program has kernels, from the tapes of its loop equations alone. The runtime has none of it.
//!
//! * `independence`: which loop equations are independent, which repeat others, and which restrict in second order only.
//! * `prescribed`: whether those that are left out hold where drivers lead.
//! * `nearby`: other poses of the motion; `closing`: back onto all loop equations at once.
//! * `matrices`: {Phi} and Phi_q as a vector and a matrix.

mod closing;
pub mod independence;
pub mod matrices;
pub mod nearby;
pub mod prescribed;
