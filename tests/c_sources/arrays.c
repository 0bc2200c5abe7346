/* Calls the interface of C sources with arrays that are not there, and with more or fewer values than references: errors, and nothing is read or written. */
#include FMI_FILE
#include <stdio.h>

/* A call that must answer so. */
#define EXPECT(answer, call) \
    do { \
        if ((call) != (answer)) { \
            printf("%s\n", #call); \
            return 1; \
        } \
    } while (0)

#if FMI == 2
static void log_nothing(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...)
{
    (void)environment; (void)name; (void)status; (void)category; (void)text;
}

int main(void)
{
    const fmi2CallbackFunctions functions = { log_nothing, NULL, NULL, NULL, NULL };
    const fmi2ValueReference vr[1] = { 0 };
    fmi2Real real[1];
    fmi2Integer integer[1] = { 0 };
    fmi2Component c = fmi2Instantiate("a", fmi2CoSimulation, TOKEN, NULL, &functions, 0, 0);
    EXPECT(1, c != NULL);
    EXPECT(fmi2OK, fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
    EXPECT(fmi2OK, fmi2EnterInitializationMode(c));
    EXPECT(fmi2OK, fmi2ExitInitializationMode(c));
    EXPECT(fmi2OK, fmi2GetReal(c, vr, 1, real));
    EXPECT(fmi2OK, fmi2GetReal(c, NULL, 0, NULL));
    EXPECT(fmi2OK, fmi2SetReal(c, NULL, 0, NULL));
    EXPECT(fmi2Error, fmi2GetReal(c, NULL, 1, real));
    EXPECT(fmi2Error, fmi2GetReal(c, vr, 1, NULL));
    EXPECT(fmi2Error, fmi2GetInteger(c, NULL, 1, integer));
    EXPECT(fmi2Error, fmi2GetInteger(c, vr, 1, NULL));
    EXPECT(fmi2Error, fmi2GetBoolean(c, NULL, 1, integer));
    EXPECT(fmi2Error, fmi2GetBoolean(c, vr, 1, NULL));
    EXPECT(fmi2Error, fmi2SetReal(c, NULL, 1, real));
    EXPECT(fmi2Error, fmi2SetReal(c, vr, 1, NULL));
    EXPECT(fmi2Error, fmi2SetInteger(c, NULL, 1, integer));
    EXPECT(fmi2Error, fmi2SetInteger(c, vr, 1, NULL));
    EXPECT(fmi2Error, fmi2SetBoolean(c, NULL, 1, integer));
    EXPECT(fmi2Error, fmi2SetBoolean(c, vr, 1, NULL));
    EXPECT(fmi2Discard, fmi2GetRealStatus(c, fmi2LastSuccessfulTime, NULL));
    EXPECT(fmi2Discard, fmi2GetBooleanStatus(c, fmi2Terminated, NULL));
    EXPECT(fmi2Error, fmi2GetReal(NULL, vr, 1, real));
    return 0;
}
#else
int main(void)
{
    const fmi3ValueReference vr[2] = { 1, 1 };
    fmi3Float64 real[2] = { 0.0, 7.0 }, last;
    fmi3Int32 integer[1] = { 0 };
    fmi3Boolean truth[1] = { 0 }, events, end, early;
    fmi3Instance c = fmi3InstantiateCoSimulation("a", TOKEN, NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    EXPECT(1, c != NULL);
    EXPECT(fmi3OK, fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0));
    EXPECT(fmi3OK, fmi3ExitInitializationMode(c));
    EXPECT(fmi3OK, fmi3GetFloat64(c, vr, 1, real, 1));
    EXPECT(fmi3OK, fmi3GetFloat64(c, NULL, 0, NULL, 0));
    EXPECT(fmi3OK, fmi3SetFloat64(c, NULL, 0, NULL, 0));
    EXPECT(fmi3Error, fmi3GetFloat64(c, NULL, 1, real, 1));
    EXPECT(fmi3Error, fmi3GetFloat64(c, vr, 1, NULL, 1));
    EXPECT(fmi3Error, fmi3GetFloat64(c, vr, 1, real, 2));
    EXPECT(fmi3Error, fmi3GetFloat64(c, vr, 2, real, 1));
    EXPECT(1, real[1] == 7.0);
    EXPECT(fmi3Error, fmi3GetInt32(c, NULL, 1, integer, 1));
    EXPECT(fmi3Error, fmi3GetInt32(c, vr, 1, NULL, 1));
    EXPECT(fmi3Error, fmi3GetBoolean(c, NULL, 1, truth, 1));
    EXPECT(fmi3Error, fmi3GetBoolean(c, vr, 1, NULL, 1));
    EXPECT(fmi3Error, fmi3SetFloat64(c, NULL, 1, real, 1));
    EXPECT(fmi3Error, fmi3SetFloat64(c, vr, 1, NULL, 1));
    EXPECT(fmi3Error, fmi3SetInt32(c, NULL, 1, integer, 1));
    EXPECT(fmi3Error, fmi3SetInt32(c, vr, 1, NULL, 1));
    EXPECT(fmi3Error, fmi3SetBoolean(c, NULL, 1, truth, 1));
    EXPECT(fmi3Error, fmi3SetBoolean(c, vr, 1, NULL, 1));
    EXPECT(fmi3Error, fmi3DoStep(c, 0.0, 1.0e-3, 1, NULL, &end, &early, &last));
    EXPECT(fmi3Error, fmi3DoStep(c, 0.0, 1.0e-3, 1, &events, &end, &early, NULL));
    EXPECT(fmi3OK, fmi3DoStep(c, 0.0, 1.0e-3, 1, &events, &end, &early, &last));
    EXPECT(fmi3Error, fmi3GetFloat64(NULL, vr, 1, real, 1));
    return 0;
}
#endif
