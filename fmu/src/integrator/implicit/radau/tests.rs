//! On problems with known solutions.

use super::*;

/// One node after the other.
impl<F: FnMut(f64, &[f64], &mut [f64])> Nodes for F {
    fn evaluate_nodes(&mut self, times: [f64; 3], points: &[Lane], derivatives: &mut [Lane]) {
        for (place, time) in times.into_iter().enumerate() {
            let point: Vec<f64> = points.iter().map(|lane| lane[place]).collect();
            let mut derivative = vec![0.0; point.len()];
            self(time, &point, &mut derivative);
            derivatives.iter_mut().zip(derivative).for_each(|(lane, value)| lane[place] = value);
        }
    }

    /// By differences.
    fn differentiate_nodes(
        &mut self,
        times: [f64; 3],
        points: &[Lane],
        derivatives: &mut [Lane],
        jacobians: &mut [Lane],
    ) {
        let n = points.len() / 2;
        for direction in 0..2 * n {
            let [mut above, mut below] = [points.to_vec(), points.to_vec()];
            let [mut over, mut under] = [vec![ZERO; 2 * n], vec![ZERO; 2 * n]];
            above[direction] = lane::add(points[direction], splat(1e-6));
            below[direction] = lane::add(points[direction], splat(-1e-6));
            self.evaluate_nodes(times, &above, &mut over);
            self.evaluate_nodes(times, &below, &mut under);
            for row in 0..n {
                let slope = lane::subtract(over[n + row], under[n + row]).map(|difference| difference / 2e-6);
                jacobians[direction / n * n * n + row * n + direction % n] = slope;
            }
        }
        self.evaluate_nodes(times, points, derivatives);
    }
}

/// Two coupled oscillators with q = (sin t, cos 2 t), driven so that this is a solution; the Jacobian is exact.
fn problem(time: f64, y: &[f64], derivative: &mut [f64]) {
    let exact = exact(time);
    derivative[0] = y[2];
    derivative[1] = y[3];
    derivative[2] = -exact[0] - 3.0 * (y[0].powi(2) - exact[0].powi(2)) - (y[1] - exact[1]) - 0.5 * (y[2] - exact[2]);
    derivative[3] = -4.0 * exact[1] + (y[0] - exact[0]) - 2.0 * (y[1] * y[3] - exact[1] * exact[3]);
}

fn exact(time: f64) -> [f64; 4] {
    [time.sin(), (2.0 * time).cos(), time.cos(), -2.0 * (2.0 * time).sin()]
}

fn jacobian(radau: &mut Radau, y: &[f64]) {
    let (by_q, by_v) = radau.jacobian_mut();
    by_q.copy_from_slice(&[-6.0 * y[0], -1.0, 1.0, -2.0 * y[3]]);
    by_v.copy_from_slice(&[-0.5, 0.0, 0.0, -2.0 * y[1]]);
}

/// Largest errors at the end of [0, 2] and between the steps, and the last error estimate.
fn run(steps: u32, each: bool) -> [f64; 3] {
    let mut radau = Radau::with(2, each);
    let h = 2.0 / f64::from(steps);
    let (mut y, mut next, mut dense) = (exact(0.0).to_vec(), vec![0.0; 4], vec![0.0; 2 * (DENSE_ORDER + 1)]);
    let worst = |y: &[f64], time: f64| y.iter().zip(exact(time)).fold(0.0, |w: f64, (y, e)| w.max((y - e).abs()));
    let [mut between, mut estimate] = [0.0_f64; 2];
    for step in 0..steps {
        let time = f64::from(step) * h;
        radau.begin(&mut problem, time, &y);
        radau.guess_nothing();
        if each {
            assert!(radau.linearise(&mut problem, (time, &y, h)));
        } else {
            jacobian(&mut radau, &y);
            assert!(radau.factor(h));
        }
        let newton = radau.solve(&mut problem, (time, &y, h), &[1.0; 4], [1e-13, 0.0]);
        assert!(matches!(newton, Newton::Converged { .. }), "{newton:?}");
        estimate = radau.error(&mut problem, (time, &y, h), &[1.0; 4], false);
        radau.end(&y, &mut next);
        radau.dense(&y, h, &mut dense);
        let mut point = [0.0; 4];
        for theta in [0.3, 0.8, 1.0] {
            evaluate(&dense, theta * h, &mut point);
            if theta == 1.0 {
                assert!(point.iter().zip(&next).all(|(a, b)| (a - b).abs() < 1e-12), "{point:?} {next:?}");
            } else {
                between = between.max(worst(&point, time + theta * h));
            }
        }
        std::mem::swap(&mut y, &mut next);
    }
    [worst(&y, 2.0), between, estimate]
}

#[test]
fn converges_with_order_5_its_dense_output_and_its_estimate_with_order_4() {
    for each in [false, true] {
        let (coarse, fine) = (run(40, each), run(80, each));
        let order = |i: usize| (coarse[i] / fine[i]).log2();
        assert!((4.6..5.6).contains(&order(0)), "order {} of {coarse:?}", order(0));
        assert!((3.7..4.7).contains(&order(1)), "dense order {} of {coarse:?}", order(1));
        assert!((3.5..4.5).contains(&order(2)), "estimate {} of {coarse:?}", order(2));
    }
}

/// q'' = -1e6 (q - cos t) - 2e3 (q' + sin t) - cos t: the solution is cos t plus a transient that is gone at once.
#[test]
fn stiff_transients_are_damped_in_a_step_and_slow_motion_is_followed() {
    let mut f = |t: f64, y: &[f64], d: &mut [f64]| {
        d[0] = y[1];
        d[1] = -1e6 * (y[0] - t.cos()) - 2e3 * (y[1] + t.sin()) - t.cos();
    };
    let (mut radau, mut y, mut next) = (Radau::with(1, false), vec![1.0 + 1e-3, 0.0], vec![0.0; 2]);
    let h = 0.1;
    for step in 0..20 {
        let (by_q, by_v) = radau.jacobian_mut();
        (by_q[0], by_v[0]) = (-1e6, -2e3);
        assert!(radau.factor(h));
        let time = f64::from(step) * h;
        radau.begin(&mut f, time, &y);
        radau.guess_nothing();
        // The problem is linear: the second iteration has nothing left to do.
        let newton = radau.solve(&mut f, (time, &y, h), &[1.0; 2], [1e-9, 0.0]);
        assert!(matches!(newton, Newton::Converged { iterations: 1 | 2, .. }), "{newton:?}");
        radau.end(&y, &mut next);
        std::mem::swap(&mut y, &mut next);
    }
    assert!((y[0] - 2.0_f64.cos()).abs() < 1e-7, "{y:?}");
    assert!((y[1] + 2.0_f64.sin()).abs() < 1e-4, "{y:?}");
}

#[test]
fn a_step_that_is_no_number_fails() {
    let mut f = |_: f64, _: &[f64], d: &mut [f64]| d.fill(f64::NAN);
    let mut radau = Radau::with(1, false);
    radau.jacobian_mut();
    assert!(radau.factor(0.1));
    let newton = radau.solve(&mut f, (0.0, &[0.0, 0.0], 0.1), &[1.0; 2], [1e-9, 0.0]);
    assert_eq!(newton, Newton::Failed { shorter: 0.5 });
}
