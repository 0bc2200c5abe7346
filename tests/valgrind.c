/* Instances that live a short life: values, steps, a saved state; the library is unloaded and loaded again. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *Component;
typedef struct {
    void *logger;
    void *allocate_memory;
    void *free_memory;
    void *step_finished;
    void *environment;
} Callbacks;

/* ISO C has no conversion from an object pointer to a function pointer, but a union does it. */
#define FUNCTION(type, name, arguments)                                        \
    union {                                                                    \
        void *object;                                                          \
        type(*call) arguments;                                                 \
    } name;                                                                    \
    name.object = dlsym(library, "fmi2" #name);                                \
    if (!name.object) return fail(#name)

static int fail(const char *what) {
    fprintf(stderr, "failed: %s\n", what);
    return EXIT_FAILURE;
}

static int run(void *library, const char *resources, const char *guid) {
    FUNCTION(Component, Instantiate, (const char *, int, const char *, const char *, const Callbacks *, int, int));
    FUNCTION(int, SetupExperiment, (Component, int, double, double, int, double));
    FUNCTION(int, EnterInitializationMode, (Component));
    FUNCTION(int, ExitInitializationMode, (Component));
    FUNCTION(int, DoStep, (Component, double, double, int));
    FUNCTION(int, GetReal, (Component, const unsigned *, size_t, double *));
    FUNCTION(int, GetFMUstate, (Component, void **));
    FUNCTION(int, SetFMUstate, (Component, void *));
    FUNCTION(int, FreeFMUstate, (Component, void **));
    FUNCTION(int, SerializedFMUstateSize, (Component, void *, size_t *));
    FUNCTION(int, SerializeFMUstate, (Component, void *, char *, size_t));
    FUNCTION(int, DeSerializeFMUstate, (Component, const char *, size_t, void **));
    FUNCTION(void, FreeInstance, (Component));

    const Callbacks callbacks = {0};
    Component c = Instantiate.call("one", 1, guid, resources, &callbacks, 0, 0);
    if (!c) return fail("Instantiate");
    if (SetupExperiment.call(c, 0, 0.0, 0.0, 0, 0.0) || EnterInitializationMode.call(c) || ExitInitializationMode.call(c))
        return fail("initialization");
    const unsigned references[] = {0, 1, 2};
    double values[3];
    for (int step = 0; step < 3; step++)
        if (DoStep.call(c, step * 0.01, 0.01, 1) || GetReal.call(c, references, 3, values)) return fail("DoStep");
    void *state = NULL, *copy = NULL;
    size_t size = 0;
    if (GetFMUstate.call(c, &state) || SerializedFMUstateSize.call(c, state, &size)) return fail("GetFMUstate");
    char *bytes = malloc(size);
    if (!bytes || SerializeFMUstate.call(c, state, bytes, size) || DeSerializeFMUstate.call(c, bytes, size, &copy))
        return fail("SerializeFMUstate");
    bytes[size / 2] ^= 1;
    void *damaged = NULL;
    if (DeSerializeFMUstate.call(c, bytes, size, &damaged) != 3) return fail("a damaged state is refused");
    free(bytes);
    if (SetFMUstate.call(c, copy) || FreeFMUstate.call(c, &state) || FreeFMUstate.call(c, &copy))
        return fail("SetFMUstate");
    FreeInstance.call(c);
    return EXIT_SUCCESS;
}

int main(int count, char **arguments) {
    if (count != 6) return fail("usage: instances LIBRARY RESOURCES GUID LOADS INSTANCES");
    for (int loads = atoi(arguments[4]); loads > 0; loads--) {
        void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
        if (!library) return fail(dlerror());
        for (int left = atoi(arguments[5]); left > 0; left--)
            if (run(library, arguments[2], arguments[3])) return EXIT_FAILURE;
        if (dlclose(library)) return fail(dlerror());
        if (dlopen(arguments[1], RTLD_NOW | RTLD_NOLOAD)) return fail("the library stays loaded");
    }
    return EXIT_SUCCESS;
}
