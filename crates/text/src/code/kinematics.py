

# The loop equations that determine the motion, in this order.
ROWS = [@ROWS@]


def @NAME@_velocities(t, p, u, f, q):
    """The rates v that the drivers prescribe: Phi_q v = -Phi_t.

    Returns v.
    """
    M, Q, Phi, Phi_q, Phi_t, gamma = @NAME@_equations(t, p, u, f, q, np.zeros(@N@))
    return np.linalg.solve(Phi_q[ROWS], -Phi_t[ROWS])


def @NAME@_accelerations(t, p, u, f, q, v):
    """The accelerations a that the drivers prescribe: Phi_q a = gamma; with masses also the reactions: Phi_q^T lambda = Q - M a.

    Returns a, lambda_; without masses, lambda_ is zero.
    """
    M, Q, Phi, Phi_q, Phi_t, gamma = @NAME@_equations(t, p, u, f, q, v)
    a = np.linalg.solve(Phi_q[ROWS], gamma[ROWS])
    lambda_ = np.zeros(@M@)
@MASSES@
    lambda_[ROWS] = np.linalg.solve(Phi_q[ROWS].T, Q - M @ a)
@END@
    return a, lambda_
