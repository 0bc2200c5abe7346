
static fmi3Status @_refused(@_instance *c, const char *text)
{
    if (c && c->log) {
        c->log(c->environment, fmi3Error, "logStatusError", text);
    }
    return fmi3Error;
}

static fmi3Status @_failed(@_instance *c)
{
    char text[256];
    @_explain(c, text);
    return @_refused(c, text);
}

/* Time has a value reference of its own, unless the scene has a variable for it. */
static int @_get_reference(@_instance *c, fmi3ValueReference reference, double *value)
{
    if (reference == $TIME_REFERENCE$u) {
        *value = c->initialized ? $TIME$ : c->start;
        return 1;
    }
    return reference > 0 && @_get(c, reference - 1, value);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    (void)instance; (void)on; (void)count; (void)categories;
    return fmi3OK;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    int i;
    (void)name; (void)resources; (void)visible; (void)logging; (void)early; (void)required; (void)count; (void)update;
    if (events || !token || !@_is_text(token, "$TOKEN$")) {
        return NULL;
    }
    for (i = 0; i < COTREE_INSTANCES; i++) {
        if (!@_pool[i].used) {
            @_pool[i].used = 1;
            @_pool[i].environment = environment;
            @_pool[i].log = log;
            @_begin_instance(&@_pool[i]);
            return &@_pool[i];
        }
    }
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    if (instance) {
        ((@_instance *)instance)->used = 0;
    }
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean defined, fmi3Float64 tolerance,
    fmi3Float64 start, fmi3Boolean limited, fmi3Float64 stop)
{
    @_instance *const c = (@_instance *)instance;
    (void)defined; (void)tolerance; (void)limited; (void)stop;
    if (!c) {
        return fmi3Error;
    }
$START_CHECK$    c->start = start;
    c->done = start;
    c->fresh = 0;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    @_instance *const c = (@_instance *)instance;
    if (!c) {
        return fmi3Error;
    }
    if (@_initialize(&c->model, $NARROW$c->start) != @_OK) {
        return @_failed(c);
    }
    c->initialized = 1;
    c->fresh = 0;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) { return instance ? fmi3OK : fmi3Error; }

fmi3Status fmi3Reset(fmi3Instance instance)
{
    if (!instance) {
        return fmi3Error;
    }
    @_begin_instance((@_instance *)instance);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Float64 value[], size_t values)
{
    size_t i;
    if (!@_are_arrays(vr, count, value, values)) {
        return @_refused((@_instance *)instance, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!instance || !@_get_reference((@_instance *)instance, vr[i], &value[i])) {
            return @_refused((@_instance *)instance, "a variable has no value");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Int32 value[], size_t values)
{
    size_t i;
    double x;
    if (!@_are_arrays(vr, count, value, values)) {
        return @_refused((@_instance *)instance, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!instance || !@_get_reference((@_instance *)instance, vr[i], &x)) {
            return @_refused((@_instance *)instance, "a variable has no value");
        }
        value[i] = (fmi3Int32)x;
    }
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, fmi3Boolean value[], size_t values)
{
    size_t i;
    double x;
    if (!@_are_arrays(vr, count, value, values)) {
        return @_refused((@_instance *)instance, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!instance || !@_get_reference((@_instance *)instance, vr[i], &x)) {
            return @_refused((@_instance *)instance, "a variable has no value");
        }
        value[i] = x < 0.0 || x > 0.0;
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Float64 value[], size_t values)
{
    size_t i;
    if (!@_are_arrays(vr, count, value, values)) {
        return @_refused((@_instance *)instance, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!instance || vr[i] == 0 || !@_set((@_instance *)instance, vr[i] - 1, value[i])) {
            return @_refused((@_instance *)instance, "a variable cannot be set now, or not to this value");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Int32 value[], size_t values)
{
    size_t i;
    if (!@_are_arrays(vr, count, value, values)) {
        return @_refused((@_instance *)instance, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!instance || vr[i] == 0 || !@_set((@_instance *)instance, vr[i] - 1, (double)value[i])) {
            return @_refused((@_instance *)instance, "a variable cannot be set now, or not to this value");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference vr[], size_t count, const fmi3Boolean value[], size_t values)
{
    size_t i;
    if (!@_are_arrays(vr, count, value, values)) {
        return @_refused((@_instance *)instance, "the references and the values must be arrays of the same length");
    }
    for (i = 0; i < count; i++) {
        if (!instance || vr[i] == 0 || !@_set((@_instance *)instance, vr[i] - 1, value[i] ? 1.0 : 0.0)) {
            return @_refused((@_instance *)instance, "a variable cannot be set now, or not to this value");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 now, fmi3Float64 size, fmi3Boolean kept, fmi3Boolean *events,
    fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
{
    @_instance *const c = (@_instance *)instance;
    int result;
    (void)now; (void)kept;
    if (!c || !c->initialized || !events || !terminate || !early || !last) {
        return fmi3Error;
    }
    result = @_run(c, size);
    *events = fmi3False;
    *early = fmi3False;
    *terminate = result == 1;
    *last = c->done;
    return result == 2 ? @_failed(c)
        : result == 3 ? @_refused(c, "the communication step must be a multiple of $STEP$ s")
        : fmi3OK;
}

/* What this model does not offer. */
fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage)
{
    (void)instanceName; (void)instantiationToken; (void)resourcePath; (void)visible; (void)loggingOn; (void)instanceEnvironment; (void)logMessage;
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)instanceName; (void)instantiationToken; (void)resourcePath; (void)visible; (void)loggingOn; (void)instanceEnvironment; (void)logMessage; (void)clockUpdate; (void)lockPreemption; (void)unlockPreemption;
    return NULL;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    (void)instance;
    return fmi3Error;
}

fmi3Status fmi3GetFloat32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Float32 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Int8 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetUInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3UInt8 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Int16 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetUInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3UInt16 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetUInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3UInt32 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Int64 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3UInt64 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3String values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)valueSizes; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Clock values[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values;
    return fmi3Error;
}

fmi3Status fmi3SetFloat32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Float32 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Int8 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetUInt8(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3UInt8 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Int16 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetUInt16(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3UInt16 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetUInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3UInt32 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Int64 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetUInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3UInt64 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3String values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const size_t valueSizes[], const fmi3Binary values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)valueSizes; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Clock values[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)values;
    return fmi3Error;
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference, size_t* nDependencies)
{
    (void)instance; (void)valueReference; (void)nDependencies;
    return fmi3Error;
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t elementIndicesOfDependent[], fmi3ValueReference independents[], size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[], size_t nDependencies)
{
    (void)instance; (void)dependent; (void)elementIndicesOfDependent; (void)independents; (void)elementIndicesOfIndependents; (void)dependencyKinds; (void)nDependencies;
    return fmi3Error;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState* FMUState)
{
    (void)instance; (void)FMUState;
    return fmi3Error;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    (void)instance; (void)FMUState;
    return fmi3Error;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState* FMUState)
{
    (void)instance; (void)FMUState;
    return fmi3Error;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t* size)
{
    (void)instance; (void)FMUState; (void)size;
    return fmi3Error;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    (void)instance; (void)FMUState; (void)serializedState; (void)size;
    return fmi3Error;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size, fmi3FMUState* FMUState)
{
    (void)instance; (void)serializedState; (void)size; (void)FMUState;
    return fmi3Error;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    (void)instance; (void)unknowns; (void)nUnknowns; (void)knowns; (void)nKnowns; (void)seed; (void)nSeed; (void)sensitivity; (void)nSensitivity;
    return fmi3Error;
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    (void)instance; (void)unknowns; (void)nUnknowns; (void)knowns; (void)nKnowns; (void)seed; (void)nSeed; (void)sensitivity; (void)nSensitivity;
    return fmi3Error;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    (void)instance;
    return fmi3Error;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    (void)instance;
    return fmi3Error;
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)intervals; (void)qualifiers;
    return fmi3Error;
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)counters; (void)resolutions; (void)qualifiers;
    return fmi3Error;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3Float64 shifts[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)shifts;
    return fmi3Error;
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)counters; (void)resolutions;
    return fmi3Error;
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Float64 intervals[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)intervals;
    return fmi3Error;
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)counters; (void)resolutions;
    return fmi3Error;
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Float64 shifts[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)shifts;
    return fmi3Error;
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)counters; (void)resolutions;
    return fmi3Error;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    (void)instance;
    return fmi3Error;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* discreteStatesNeedUpdate, fmi3Boolean* terminateSimulation, fmi3Boolean* nominalsOfContinuousStatesChanged, fmi3Boolean* valuesOfContinuousStatesChanged, fmi3Boolean* nextEventTimeDefined, fmi3Float64* nextEventTime)
{
    (void)instance; (void)discreteStatesNeedUpdate; (void)terminateSimulation; (void)nominalsOfContinuousStatesChanged; (void)valuesOfContinuousStatesChanged; (void)nextEventTimeDefined; (void)nextEventTime;
    return fmi3Error;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    (void)instance;
    return fmi3Error;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean* enterEventMode, fmi3Boolean* terminateSimulation)
{
    (void)instance; (void)noSetFMUStatePriorToCurrentPoint; (void)enterEventMode; (void)terminateSimulation;
    return fmi3Error;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    (void)instance; (void)time;
    return fmi3Error;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    (void)instance; (void)continuousStates; (void)nContinuousStates;
    return fmi3Error;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates)
{
    (void)instance; (void)derivatives; (void)nContinuousStates;
    return fmi3Error;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    (void)instance; (void)eventIndicators; (void)nEventIndicators;
    return fmi3Error;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    (void)instance; (void)continuousStates; (void)nContinuousStates;
    return fmi3Error;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    (void)instance; (void)nominals; (void)nContinuousStates;
    return fmi3Error;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t* nEventIndicators)
{
    (void)instance; (void)nEventIndicators;
    return fmi3Error;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t* nContinuousStates)
{
    (void)instance; (void)nContinuousStates;
    return fmi3Error;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    (void)instance;
    return fmi3Error;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
{
    (void)instance; (void)valueReferences; (void)nValueReferences; (void)orders; (void)values; (void)nValues;
    return fmi3Error;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference, fmi3Float64 activationTime)
{
    (void)instance; (void)clockReference; (void)activationTime;
    return fmi3Error;
}
