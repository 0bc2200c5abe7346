/* Loads the shared library of an FMU, runs it and prints every variable at every communication point as the bits of its
 * value, so that the output of two platforms can be compared byte by byte.
 *
 * usage: run LIBRARY RESOURCES_URI GUID VARIABLES STEP COUNT
 */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)(uintptr_t)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *open_library(const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) fprintf(stderr, "%s\n", dlerror());
    return library;
}
static void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

typedef void *Component;
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void print_message(void *environment, const char *name, int status, const char *category, const char *message, ...) {
    va_list arguments;
    (void)environment, (void)category;
    fprintf(stderr, "%s (status %d): ", name, status);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void fail(const char *what) {
    fprintf(stderr, "%s failed\n", what);
    exit(1);
}

static void *function(void *library, const char *name) {
    void *found = find(library, name);
    if (!found) fail(name);
    return found;
}

static void check(int status, const char *call) {
    if (status != 0) fail(call);
}

int main(int count, char **arguments) {
    if (count != 7) fail("usage: run LIBRARY RESOURCES_URI GUID VARIABLES STEP COUNT\nreading the arguments");
    void *library = open_library(arguments[1]);
    if (!library) fail("loading the library");
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) = function(library, "fmi2Instantiate");
    int (*setup)(Component, int, double, double, int, double) = function(library, "fmi2SetupExperiment");
    int (*enter)(Component) = function(library, "fmi2EnterInitializationMode");
    int (*leave)(Component) = function(library, "fmi2ExitInitializationMode");
    int (*get)(Component, const unsigned *, size_t, double *) = function(library, "fmi2GetReal");
    int (*step)(Component, double, double, int) = function(library, "fmi2DoStep");
    int (*terminate)(Component) = function(library, "fmi2Terminate");
    void (*release)(Component) = function(library, "fmi2FreeInstance");

    unsigned variables = (unsigned)strtoul(arguments[4], NULL, 10);
    double h = strtod(arguments[5], NULL);
    unsigned steps = (unsigned)strtoul(arguments[6], NULL, 10);
    unsigned *references = calloc(variables + 1, sizeof *references);
    double *values = calloc(variables + 1, sizeof *values);
    if (!references || !values) fail("allocating");
    for (unsigned i = 0; i < variables; i++) references[i] = i;

    Callbacks callbacks = {print_message, calloc, free, NULL, NULL};
    Component component = instantiate("run", 1, arguments[3], arguments[2], &callbacks, 0, 0);
    if (!component) fail("fmi2Instantiate");
    check(setup(component, 0, 0.0, 0.0, 0, 0.0), "fmi2SetupExperiment");
    check(enter(component), "fmi2EnterInitializationMode");
    check(leave(component), "fmi2ExitInitializationMode");
    for (unsigned k = 0; k <= steps; k++) {
        check(get(component, references, variables, values), "fmi2GetReal");
        for (unsigned i = 0; i < variables; i++) {
            uint64_t bits;
            memcpy(&bits, &values[i], sizeof bits);
            printf("%08lx%08lx ", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xffffffffu));
        }
        putchar('\n');
        if (k < steps) check(step(component, k * h, h, 1), "fmi2DoStep");
    }
    check(terminate(component), "fmi2Terminate");
    release(component);
    return 0;
}
