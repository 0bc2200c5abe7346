/* Steps a model, and prints its coordinates and rates: run.c STEPS, compiled with MODEL_FILE. With CONSTRAINT, its loop equations must hold to RESIDUAL after every step. */
#include <stdio.h>
#include <stdlib.h>
#include MODEL_FILE

#ifdef CONSTRAINT
static int is_open(const model *m)
{
    REAL r[ROWS];
    int i;
    CONSTRAINT(m, &m->x, r);
    for (i = 0; i < ROWS; i++) {
        if (!(fabs((double)r[i]) <= RESIDUAL)) {
            printf("loop equation %d: %g at %g s\n", i, (double)r[i], (double)m->x.t);
            return 1;
        }
    }
    return 0;
}
#endif

int main(int count, char **arguments)
{
    static model m;
    const long steps = count > 1 ? atol(arguments[1]) : 0;
    long i;
    model_reset(&m);
    for (i = 0; i < steps; i++) {
        if (model_step(&m) != 0) {
            break;
        }
#ifdef CONSTRAINT
        if (is_open(&m)) {
            return 1;
        }
#endif
    }
    if (m.status != 0) {
        printf("%s: %s\n", model_place(&m), model_message(&m));
        return 1;
    }
    for (i = 0; i < COORDINATES; i++) {
        printf("%.17g %.17g\n", (double)m.x.q[i], (double)m.x.v[i]);
    }
    return 0;
}
