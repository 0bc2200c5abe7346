/* Steps a model, and prints the bits of its coordinates and rates: for boards, whose programs have no arguments. Compiled with MODEL_FILE, STEPS and, unless it prints nothing, COORDINATES. */
#include <stdio.h>
#include <string.h>
#include MODEL_FILE

static model m;
/* Read when the program runs, so that a program for another number of steps has the same instructions. */
static volatile const long steps = STEPS;

#ifdef COORDINATES
static void print(double value)
{
    unsigned long long bits;
    memcpy(&bits, &value, sizeof bits);
    printf("%08lx%08lx\n", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xffffffffu));
}
#endif

int main(void)
{
    const long end = steps;
    long i;
    model_reset(&m);
    for (i = 0; i < end; i++) {
        if (model_step(&m) != 0) {
            printf("%s: %s\n", model_place(&m), model_message(&m));
            return 1;
        }
    }
#ifdef COORDINATES
    for (i = 0; i < COORDINATES; i++) {
        print((double)m.x.q[i]);
        print((double)m.x.v[i]);
    }
#endif
    return 0;
}
