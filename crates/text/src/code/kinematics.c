
/* Solves A x = b by elimination with row exchanges; A (by rows) is overwritten and b becomes x. Not finite if A is singular. */
static void solve(int n, double *A, double *b)
{
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(A[i * n + k]) > fabs(A[pivot * n + k]))
                pivot = i;
        for (int j = 0; j < n; j++) {
            const double held = A[k * n + j];
            A[k * n + j] = A[pivot * n + j];
            A[pivot * n + j] = held;
        }
        const double held = b[k];
        b[k] = b[pivot];
        b[pivot] = held;
        for (int i = k + 1; i < n; i++) {
            const double factor = A[i * n + k] / A[k * n + k];
            for (int j = k; j < n; j++)
                A[i * n + j] -= factor * A[k * n + j];
            b[i] -= factor * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            b[i] -= A[i * n + j] * b[j];
        b[i] /= A[i * n + i];
    }
}

/* The loop equations that determine the motion, in this order. */
static const int @NAME@_rows[@N@] = {@ROWS@};

/* The rates v that the drivers prescribe: Phi_q v = -Phi_t.
   Sizes: v @N@. */
void @NAME@_velocities(double t, const double *p, const double *u, const double *f, const double *q, double *v)
{
    double M[@N@ * @N@], Q[@N@], Phi[@M@], Phi_q[@M@ * @N@], Phi_t[@M@], gamma[@M@], A[@N@ * @N@];
    const double rest[@N@] = {0};
    @NAME@_equations(t, p, u, f, q, rest, M, Q, Phi, Phi_q, Phi_t, gamma);
    for (int i = 0; i < @N@; i++) {
        const int row = @NAME@_rows[i];
        for (int j = 0; j < @N@; j++)
            A[i * @N@ + j] = Phi_q[row * @N@ + j];
        v[i] = -Phi_t[row];
    }
    solve(@N@, A, v);
}

/* The accelerations a that the drivers prescribe: Phi_q a = gamma; with masses also the reactions: Phi_q^T lambda = Q - M a.
   Sizes: a @N@, lambda @M@. Without masses, lambda is zero. */
void @NAME@_accelerations(double t, const double *p, const double *u, const double *f, const double *q, const double *v,
    double *a, double *lambda)
{
    double M[@N@ * @N@], Q[@N@], Phi[@M@], Phi_q[@M@ * @N@], Phi_t[@M@], gamma[@M@], A[@N@ * @N@];
    @NAME@_equations(t, p, u, f, q, v, M, Q, Phi, Phi_q, Phi_t, gamma);
    for (int i = 0; i < @N@; i++) {
        const int row = @NAME@_rows[i];
        for (int j = 0; j < @N@; j++)
            A[i * @N@ + j] = Phi_q[row * @N@ + j];
        a[i] = gamma[row];
    }
    solve(@N@, A, a);
    for (int i = 0; i < @M@; i++)
        lambda[i] = 0.0;
@MASSES@
    double b[@N@];
    for (int i = 0; i < @N@; i++) {
        b[i] = Q[i];
        for (int j = 0; j < @N@; j++) {
            b[i] -= M[i * @N@ + j] * a[j];
            A[i * @N@ + j] = Phi_q[@NAME@_rows[j] * @N@ + i];
        }
    }
    solve(@N@, A, b);
    for (int i = 0; i < @N@; i++)
        lambda[@NAME@_rows[i]] = b[i];
@END@
}
