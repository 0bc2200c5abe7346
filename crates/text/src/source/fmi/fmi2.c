
static void @_log(@_instance *c, fmi2Status status, const char *text)
{
    if (c->functions.logger) {
        c->functions.logger(c->functions.componentEnvironment, "$ID$", status, "errors", "%s", text);
    }
}

static fmi2Status @_failed(@_instance *c)
{
    char text[256];
    @_explain(c, text);
    @_log(c, fmi2Error, text);
    return fmi2Error;
}

static fmi2Status @_refused(@_instance *c, const char *text)
{
    if (c) {
        @_log(c, fmi2Error, text);
    }
    return fmi2Error;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)component; (void)on; (void)count; (void)categories;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    int i;
    (void)name; (void)resources; (void)visible; (void)logging;
    if (type != fmi2CoSimulation || !guid || !functions || !@_is_text(guid, "$TOKEN$")) {
        return NULL;
    }
    for (i = 0; i < COTREE_INSTANCES; i++) {
        if (!@_pool[i].used) {
            @_pool[i].used = 1;
            @_pool[i].functions = *functions;
            @_begin_instance(&@_pool[i]);
            return &@_pool[i];
        }
    }
    return NULL;
}

void fmi2FreeInstance(fmi2Component component)
{
    if (component) {
        ((@_instance *)component)->used = 0;
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
    fmi2Boolean limited, fmi2Real stop)
{
    @_instance *const c = (@_instance *)component;
    (void)defined; (void)tolerance; (void)limited; (void)stop;
    if (!c) {
        return fmi2Error;
    }
$START_CHECK$    c->start = start;
    c->done = start;
    c->fresh = 0;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component) { return component ? fmi2OK : fmi2Error; }

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    @_instance *const c = (@_instance *)component;
    if (!c) {
        return fmi2Error;
    }
    if (@_initialize(&c->model, $NARROW$c->start) != @_OK) {
        return @_failed(c);
    }
    c->initialized = 1;
    c->fresh = 0;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component) { return component ? fmi2OK : fmi2Error; }

fmi2Status fmi2Reset(fmi2Component component)
{
    if (!component) {
        return fmi2Error;
    }
    @_begin_instance((@_instance *)component);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t count, fmi2Real value[])
{
    size_t i;
    if (!@_are_arrays(vr, count, value, count)) {
        return @_refused((@_instance *)component, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!component || !@_get((@_instance *)component, vr[i], &value[i])) {
            return @_refused((@_instance *)component, "a variable has no value");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t count, fmi2Integer value[])
{
    size_t i;
    double x;
    if (!@_are_arrays(vr, count, value, count)) {
        return @_refused((@_instance *)component, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!component || !@_get((@_instance *)component, vr[i], &x)) {
            return @_refused((@_instance *)component, "a variable has no value");
        }
        value[i] = (fmi2Integer)x;
    }
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t count, fmi2Boolean value[])
{
    size_t i;
    double x;
    if (!@_are_arrays(vr, count, value, count)) {
        return @_refused((@_instance *)component, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!component || !@_get((@_instance *)component, vr[i], &x)) {
            return @_refused((@_instance *)component, "a variable has no value");
        }
        value[i] = x < 0.0 || x > 0.0 ? fmi2True : fmi2False;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t count, const fmi2Real value[])
{
    size_t i;
    if (!@_are_arrays(vr, count, value, count)) {
        return @_refused((@_instance *)component, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!component || !@_set((@_instance *)component, vr[i], value[i])) {
            return @_refused((@_instance *)component, "a variable cannot be set now, or not to this value");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t count, const fmi2Integer value[])
{
    size_t i;
    if (!@_are_arrays(vr, count, value, count)) {
        return @_refused((@_instance *)component, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!component || !@_set((@_instance *)component, vr[i], (double)value[i])) {
            return @_refused((@_instance *)component, "a variable cannot be set now, or not to this value");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t count, const fmi2Boolean value[])
{
    size_t i;
    if (!@_are_arrays(vr, count, value, count)) {
        return @_refused((@_instance *)component, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!component || !@_set((@_instance *)component, vr[i], value[i] ? 1.0 : 0.0)) {
            return @_refused((@_instance *)component, "a variable cannot be set now, or not to this value");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real now, fmi2Real size, fmi2Boolean kept)
{
    @_instance *const c = (@_instance *)component;
    (void)now; (void)kept;
    if (!c || !c->initialized) {
        return fmi2Error;
    }
    switch (@_run(c, size)) {
    case 0:
        return fmi2OK;
    case 1:
        return fmi2Discard;
    case 2:
        return @_failed(c);
    default:
        return @_refused(c, "the communication step must be a multiple of $STEP$ s");
    }
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)component; (void)kind; (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    if (!component || kind != fmi2LastSuccessfulTime || !value) {
        return fmi2Discard;
    }
    *value = ((@_instance *)component)->done;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (!component || kind != fmi2Terminated || !value) {
        return fmi2Discard;
    }
    *value = ((@_instance *)component)->model.ended ? fmi2True : fmi2False;
    return fmi2OK;
}

/* What this model does not offer. */
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    (void)c; (void)vr; (void)nvr; (void)value;
    return fmi2Error;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    (void)c; (void)vr; (void)nvr; (void)value;
    return fmi2Error;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* FMUstate)
{
    (void)c; (void)FMUstate;
    return fmi2Error;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    (void)c; (void)FMUstate;
    return fmi2Error;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* FMUstate)
{
    (void)c; (void)FMUstate;
    return fmi2Error;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t* size)
{
    (void)c; (void)FMUstate; (void)size;
    return fmi2Error;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    (void)c; (void)FMUstate; (void)serializedState; (void)size;
    return fmi2Error;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size, fmi2FMUstate* FMUstate)
{
    (void)c; (void)serializedState; (void)size; (void)FMUstate;
    return fmi2Error;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown, const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    (void)c; (void)vUnknown_ref; (void)nUnknown; (void)vKnown_ref; (void)nKnown; (void)dvKnown; (void)dvUnknown;
    return fmi2Error;
}

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    (void)c;
    return fmi2Error;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* fmi2eventInfo)
{
    (void)c; (void)fmi2eventInfo;
    return fmi2Error;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    (void)c;
    return fmi2Error;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint, fmi2Boolean* enterEventMode, fmi2Boolean* terminateSimulation)
{
    (void)c; (void)noSetFMUStatePriorToCurrentPoint; (void)enterEventMode; (void)terminateSimulation;
    return fmi2Error;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    (void)c; (void)time;
    return fmi2Error;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    (void)c; (void)x; (void)nx;
    return fmi2Error;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    (void)c; (void)derivatives; (void)nx;
    return fmi2Error;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    (void)c; (void)eventIndicators; (void)ni;
    return fmi2Error;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    (void)c; (void)x; (void)nx;
    return fmi2Error;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    (void)c; (void)x_nominal; (void)nx;
    return fmi2Error;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], const fmi2Real value[])
{
    (void)c; (void)vr; (void)nvr; (void)order; (void)value;
    return fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[], fmi2Real value[])
{
    (void)c; (void)vr; (void)nvr; (void)order; (void)value;
    return fmi2Error;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    (void)c;
    return fmi2Error;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer* value)
{
    (void)c; (void)s; (void)value;
    return fmi2Error;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String* value)
{
    (void)c; (void)s; (void)value;
    return fmi2Error;
}
