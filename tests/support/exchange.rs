//! An importer of Model Exchange that takes Runge-Kutta steps of one length.

use cotree_fmu::instance::{Instance, InstanceError};

/// Classical Runge-Kutta steps up to a time, as an importer takes them.
pub fn integrate(instance: &mut Instance, stop: f64, h: f64) -> Result<(), InstanceError> {
    instance.initialise_exchange()?;
    go_on(instance, stop, h)
}

/// The same where the importer integrates already.
pub fn go_on(instance: &mut Instance, stop: f64, h: f64) -> Result<(), InstanceError> {
    let n = instance.state_count();
    while instance.time() < stop - 0.5 * h {
        let (t, mut start) = (instance.time(), vec![0.0; n]);
        instance.states(&mut start)?;
        let (mut sum, mut slope) = (vec![0.0; n], vec![0.0; n]);
        for (share, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let point: Vec<f64> = start.iter().zip(&slope).map(|(x, k)| x + share * h * k).collect();
            instance.set_time(t + share * h)?;
            instance.set_states(&point)?;
            instance.state_derivatives(&mut slope)?;
            sum.iter_mut().zip(&slope).for_each(|(sum, k)| *sum += weight * k / 6.0);
        }
        let end: Vec<f64> = start.iter().zip(&sum).map(|(x, k)| x + h * k).collect();
        instance.set_states(&end)?;
        if instance.complete_step()? {
            instance.handle_event()?;
        }
    }
    Ok(())
}
