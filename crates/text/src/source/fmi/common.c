/* The Functional Mock-up Interface of $ID$. Instances are taken from a pool: nothing is allocated. */
#define COTREE_NO_SHORT_NAMES
#include "$ID$.c"
#include "fmi$VERSION$Functions.h"

#ifndef COTREE_INSTANCES
#define COTREE_INSTANCES 1
#endif

typedef struct {
    @_model model;
    int used, initialized, initial, fresh;
    double start, done;
$CALLBACKS$
} @_instance;

static @_instance @_pool[COTREE_INSTANCES];

enum { @_OF_TIME, @_OF_P, @_OF_D, @_OF_U, @_OF_Y, @_OF_Q, @_OF_V, @_OF_A };

/* Where the value of each variable is, the parameter that sets its value at the start or -1, and whether it may be set during the simulation. */
static const int @_variables[][4] = {
$VARIABLES$
};

/* The smallest and the largest permitted value of each variable. */
static const double @_bounds[][2] = {
$BOUNDS$
};

enum { @_VARIABLES = $COUNT$ };

static void @_begin_instance(@_instance *c)
{
    c->initialized = 0;
    c->initial = 0;
    c->fresh = 0;
    c->start = $START$;
    c->done = c->start;
    @_reset(&c->model);
}

static int @_is_text(const char *a, const char *b)
{
    int i;
    for (i = 0; i < 256 && a[i] != 0 && a[i] == b[i]; i++) {
    }
    return a[i] == b[i];
}

/* Appends to a text of at most 255 characters. */
static void @_append(char *text, const char *more)
{
    int end = 0, i;
    while (end < 255 && text[end] != 0) {
        end++;
    }
    for (i = 0; end < 255 && more[i] != 0; i++) {
        text[end++] = more[i];
    }
    text[end] = 0;
}

/* What went wrong, and where. */
static void @_explain(const @_instance *c, char *text)
{
    text[0] = 0;
    @_append(text, @_place(&c->model));
    @_append(text, ": ");
    @_append(text, @_message(&c->model));
}

/* True for arrays of references and values that are there, as many of both. */
static int @_are_arrays(const void *references, unsigned long count, const void *values, unsigned long given)
{
    return given == count && (count == 0 || (references && values));
}

/* Before the end of the initialization the state follows the parameters and inputs. */
static int @_settle(@_instance *c)
{
    if (!c->initialized && !c->fresh) {
        (void)@_initialize(&c->model, $NARROW$c->start);
    }
    if (!c->fresh && c->model.status == @_OK) {
        (void)@_outputs(&c->model);
        c->fresh = 1;
    }
    return c->model.status == @_OK;
}

static int @_get(@_instance *c, unsigned long place, double *value)
{
    const int *of;
    if (place >= (unsigned long)@_VARIABLES) {
        return 0;
    }
    of = @_variables[place];
    if (of[0] != @_OF_P && of[0] != @_OF_U && !@_settle(c)) {
        return 0;
    }
    *value = of[0] == @_OF_P ? $WIDE$c->model.p[of[1]]
        : of[0] == @_OF_D ? $WIDE$c->model.d[of[1]]
        : of[0] == @_OF_U ? $WIDE$c->model.u[of[1]]
        : of[0] == @_OF_Y ? $WIDE$c->model.y[of[1]]
        : of[0] == @_OF_Q ? $WIDE$c->model.x.q[of[1]]
        : of[0] == @_OF_V ? $WIDE$c->model.x.v[of[1]]
        : of[0] == @_OF_A ? $WIDE$c->model.x.a[of[1]]
        : $TIME$;
    return 1;
}

static int @_set(@_instance *c, unsigned long place, double value)
{
    const int *of;
    if (place >= (unsigned long)@_VARIABLES || !@_is_finite($NARROW$value)) {
        return 0;
    }
    of = @_variables[place];
    if (!(value >= @_bounds[place][0] && value <= @_bounds[place][1])) {
        return 0;
    }
    if (!c->initialized && of[2] >= 0) {
        c->model.p[of[2]] = $NARROW$value;
    } else if (of[0] == @_OF_U && of[3]) {
        c->model.u[of[1]] = $NARROW$value;
    } else if (of[0] == @_OF_P && of[3]) {
        c->model.p[of[1]] = $NARROW$value;
        if (c->initialized) {
            const int status = @_update(&c->model);
            if (status != @_OK) {
                return 0;
            }
        }
    } else {
        return 0;
    }
    c->fresh = 0;
    return 1;
}

/* As many steps as the communication step has. The state before it stays if one of them fails. 0: done, 1: ended by an event, 2: failed, 3: no multiple of the step. */
static int @_run(@_instance *c, double size)
{
    const double count = floor(size / $STEP$ + 0.5);
    const @_model before = c->model;
    double k;
    if (!(count >= 1.0 && count < 1.0e9 && fabs(size - count * $STEP$) <= 1.0e-6 * $STEP$)) {
        return 3;
    }
    c->fresh = 0;
    for (k = 0.0; k < count && !c->model.ended; k += 1.0) {
        if (@_step(&c->model) != @_OK) {
            const int status = c->model.status, place = c->model.place;
            c->model = before;
            c->model.status = status;
            c->model.place = place;
            return 2;
        }
        c->done = $TIME$;
    }
    return c->model.ended ? 1 : 0;
}
