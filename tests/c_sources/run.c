/* Steps a model, and prints its coordinates and rates: run.c STEPS, compiled with MODEL_FILE. */
#include <stdio.h>
#include <stdlib.h>
#include MODEL_FILE

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
    }
    if (m.status != 0) {
        printf("%s: %s\n", model_place(&m), model_message(&m));
        return 1;
    }
    for (i = 0; i < COORDINATES; i++) {
        printf("%.17g %.17g\n", m.x.q[i], m.x.v[i]);
    }
    return 0;
}
