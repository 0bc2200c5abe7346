/* An input becomes 3 and the first parameter 2: what is set between steps acts from the next step on. Compiled with MODEL_FILE. Prints the rate PRINTED after each of four steps. */
#include <stdio.h>
#include MODEL_FILE

int main(void)
{
    static model m;
    int i;
    model_reset(&m);
    for (i = 0; i < 4; i++) {
        if (i == 1) {
            m.u[0] = 3.0;
        }
        if (i == 2) {
            m.p[0] = 2.0;
            if (model_update(&m) != 0) {
                return 1;
            }
        }
        if (model_step(&m) != 0) {
            return 1;
        }
        printf("%.17g\n", (double)m.x.v[PRINTED]);
    }
    return 0;
}
