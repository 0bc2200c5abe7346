"""What must happen when the functions are called. A case returns the reason if the model has nothing that it is about."""

import ctypes
import locale
import os
import shutil
import signal
import tempfile
import threading
from ctypes import byref, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

from fmpy import read_model_description
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2EventInfo
from fmpy.validation import validate_model_description

from fmu import DISCARD, ERROR, ME, NAME, OK, WARNING, Fmu, Instance, agree, difference, no_array, status

CASES = {}
UNKNOWN = 1_000_000
NO_EXCHANGE = "it has no Model Exchange"


def case(name):
    def register(check):
        CASES[name] = check
        return check

    return register


@case("D01")
def platform(fmu):
    raw = fmu.instance().raw
    assert (raw.getTypesPlatform(), raw.getVersion()) == ("default", "2.0")


def make(fmu, location, name=b"a", guid=None, kind=1, callbacks="silent"):
    """fmi2Instantiate with these arguments, through fmpy's function of that name."""
    raw = fmu.instance().raw
    functions = {"silent": byref(fmi2CallbackFunctions()), None: no_array(fmi2CallbackFunctions)}[callbacks]
    guid = fmu.description.guid.encode() if guid is None else guid
    return raw.fmi2Instantiate(name, kind, guid or None, location, functions, 0, 0)


def uri(fmu):
    return (fmu.folder / "resources").as_uri().encode()


@case("D02")
def authority(fmu):
    assert uri(fmu).startswith(b"file:///") and make(fmu, uri(fmu))


@case("D03")
def no_authority(fmu):
    assert make(fmu, uri(fmu).replace(b"file://", b"file:", 1))


@case("D04")
def escapes(fmu):
    with tempfile.TemporaryDirectory() as folder:
        other = Path(folder) / "a b é%"
        shutil.copytree(fmu.folder, other)
        fmu.started(folder=other).free()


@case("D05")
def no_location(fmu):
    assert make(fmu, None) is None and make(fmu, b"") is None


def refused(fmu, **more):
    try:
        fmu.instance(**more)
    except Exception as fault:
        assert str(fault) == "Failed to instantiate model", fault
    else:
        raise AssertionError("it was instantiated")


@case("D06")
def wrong_guid(fmu):
    refused(fmu, guid="{1}")


@case("D07")
def missing_strings(fmu):
    refused(fmu, name="")
    assert make(fmu, uri(fmu), name=None) is None and make(fmu, uri(fmu), guid=b"") is None


@case("D08")
def missing_callbacks(fmu):
    assert make(fmu, uri(fmu), callbacks=None) is None
    silent = make(fmu, uri(fmu))
    assert silent and status(fmu.instance().raw.fmi2DoStep, silent, 0.0, 1.0, 1) == ERROR


@case("D09")
def wrong_interface(fmu):
    if fmu.description.modelExchange is None:
        refused(fmu, kind=ME)
    else:
        fmu.instance(ME)
    assert make(fmu, uri(fmu), kind=7) is None


@case("D10")
def transient_arguments(fmu):
    raw = fmu.instance().raw
    texts = [ctypes.create_string_buffer(text) for text in (b"a", fmu.description.guid.encode(), uri(fmu))]
    name, guid, location = (ctypes.cast(text, ctypes.c_char_p) for text in texts)
    instance = fmu.instance()
    functions = fmi2CallbackFunctions.from_buffer_copy(instance.callbacks)
    component = raw.fmi2Instantiate(name, 1, guid, location, byref(functions), 0, 0)
    for text in texts:
        ctypes.memset(text, ord("x"), len(text))
    ctypes.memset(byref(functions), 0, ctypes.sizeof(functions))
    assert status(raw.fmi2Terminate, component) == ERROR
    assert instance.messages[-1][0] == "a"


@case("D11")
def free_anywhere(fmu):
    fmu.instance().raw.fmi2FreeInstance(None)
    fmu.instance().free()
    instance = fmu.instance()
    assert [instance.setup(), instance.enter()] == [OK] * 2
    instance.free()
    fmu.started().free()
    instance = fmu.started()
    instance.run(0, 3)
    assert instance.terminate() == OK
    instance.free()


@case("D12")
def before_initialization(fmu):
    instance = fmu.instance()
    assert [instance.step(0.0, 0.1), instance.exit(), instance.terminate()] == [ERROR] * 3
    assert instance.refuses_get(fmu.outputs[0])


@case("D13")
def no_experiment(fmu):
    assert fmu.instance().enter() == ERROR


@case("D14")
def during_initialization(fmu):
    instance = fmu.instance()
    assert [instance.setup(), instance.enter()] == [OK] * 2
    assert [instance.enter(), instance.setup(), instance.step(0.0, 0.1), instance.terminate()] == [ERROR] * 4
    assert instance.exit() == OK


@case("D15")
def while_stepping(fmu):
    instance = fmu.started()
    assert [instance.enter(), instance.exit(), instance.setup()] == [ERROR] * 3
    instance.run(0, 2)


@case("D16")
def after_termination(fmu):
    instance = fmu.started()
    instance.run(0, 2)
    assert [instance.terminate(), instance.step(0.02, 0.01), instance.terminate()] == [OK, ERROR, ERROR]
    assert all(instance.set(reference, 1.0) == ERROR for reference in fmu.inputs + fmu.tunable)


@case("D17")
def final_values(fmu):
    instance = fmu.started()
    last = instance.run(0, 5)[-1]
    assert instance.terminate() == OK and instance.all() == last


@case("D18")
def reset_is_fresh(fmu):
    fresh = fmu.started().run(0, 30)
    instance = fmu.instance()

    def check():
        assert instance.reset() == OK
        assert instance.start().run(0, 30) == fresh

    check()
    check()
    assert [instance.reset(), instance.setup(), instance.enter()] == [OK] * 3
    check()
    assert instance.terminate() == OK
    check()


@case("D19")
def reset_restores(fmu):
    instance = fmu.instance()
    settable = fmu.inputs + fmu.tunable + fmu.fixed
    assert all(instance.set(reference, fmu.other(reference)) == OK for reference in settable)
    assert [instance.reset(), instance.enter()] == [OK, ERROR]
    instance.start()
    assert all(instance.get(reference) == fmu.default(reference) for reference in settable)


@case("D20")
def reset_after_error(fmu):
    fresh = fmu.started().run(0, 10)
    instance = fmu.started()
    instance.run(0, 3)
    assert [instance.step(77.0, 0.1), instance.reset()] == [ERROR, OK]
    assert instance.start().run(0, 10) == fresh


def other_types(instance, reference):
    """Get and set of every other type are refused."""
    raw = instance.raw
    calls = [
        (raw.getInteger, [reference]),
        (raw.getBoolean, [reference]),
        (raw.getString, [reference]),
        (raw.setInteger, [reference], [0]),
        (raw.setBoolean, [reference], [False]),
        (raw.setString, [reference], ["text"]),
    ]
    assert [status(*call) for call in calls] == [ERROR] * 6


@case("D21")
def unknown_references(fmu):
    instance = fmu.started()
    assert instance.refuses_get(UNKNOWN) and instance.set(UNKNOWN, 1.0) == ERROR
    other_types(instance, UNKNOWN)
    instance.run(0, 2)


@case("D22")
def wrong_type(fmu):
    instance = fmu.started()
    for reference in fmu.references():
        other_types(instance, reference)
    instance.run(0, 2)


@case("D23")
def empty_arrays(fmu):
    raw = fmu.started().raw
    assert [raw.getReal([]), raw.getInteger([]), raw.getBoolean([]), raw.getString([])] == [[]] * 4
    for call in (raw.setReal, raw.setInteger, raw.setBoolean, raw.setString):
        assert status(call, [], []) == OK
    c, references, numbers, orders = raw.component, no_array(c_uint), no_array(c_double), no_array(c_int)
    calls = [
        (raw.fmi2GetReal, c, references, 0, numbers),
        (raw.fmi2SetReal, c, references, 0, numbers),
        (raw.fmi2SetRealInputDerivatives, c, references, 0, orders, numbers),
        (raw.fmi2GetRealOutputDerivatives, c, references, 0, orders, numbers),
        (raw.fmi2GetDirectionalDerivative, c, references, 0, references, 0, numbers, numbers),
    ]
    assert [status(*call) for call in calls] == [OK] * len(calls)


@case("D24")
def missing_arrays(fmu):
    instance = fmu.started()
    raw = instance.raw
    c, one, value = raw.component, (c_uint * 1)(fmu.outputs[0]), (c_double * 1)()
    references, numbers, orders = no_array(c_uint), no_array(c_double), no_array(c_int)
    calls = [
        (raw.fmi2GetReal, c, references, 1, value),
        (raw.fmi2GetReal, c, one, 1, numbers),
        (raw.fmi2SetReal, c, references, 1, value),
        (raw.fmi2SetReal, c, one, 1, numbers),
        (raw.fmi2GetInteger, c, references, 1, orders),
        (raw.fmi2SetRealInputDerivatives, c, one, 1, orders, numbers),
        (raw.fmi2GetRealOutputDerivatives, c, one, 1, orders, value),
        (raw.fmi2GetDirectionalDerivative, c, one, 1, references, 1, value, value),
        (raw.fmi2GetFMUstate, c, no_array(c_void_p)),
        (raw.fmi2SetFMUstate, c, None),
        (raw.fmi2DeSerializeFMUstate, c, no_array(ctypes.c_char), 10, no_array(c_void_p)),
    ]
    assert [status(*call) for call in calls] == [ERROR] * len(calls)
    instance.run(0, 2)


@case("D25")
def set_calculated(fmu):
    kinds = ("output", "local", "independent", "calculatedParameter")
    calculated = fmu.references(lambda variable: variable.causality in kinds and variable.start is None)
    instance = fmu.instance()

    def check():
        assert all(instance.set(reference, 0.1) == ERROR for reference in calculated)

    check()
    assert [instance.setup(), instance.enter()] == [OK] * 2
    check()
    assert instance.exit() == OK
    check()


@case("D26")
def fixed_late(fmu):
    if not fmu.fixed:
        return "it has no fixed parameter"
    instance = fmu.started()
    for reference in fmu.fixed:
        assert instance.set(reference, fmu.other(reference)) == ERROR
        assert instance.get(reference) == fmu.default(reference)


@case("D27")
def initial_late(fmu):
    instance = fmu.started()
    before = instance.all()
    known = fmu.references(lambda one: one.causality != "input" and one.variability == "continuous")
    assert all(instance.set(reference, 0.1) == ERROR for reference in known)
    assert instance.all() == before


@case("D28")
def tunable(fmu):
    if not fmu.tunable:
        return "it has no tunable parameter"
    instance = fmu.started()
    instance.run(0, 2)
    for reference in fmu.tunable:
        value = fmu.other(reference)
        assert (instance.set(reference, value), instance.get(reference)) == (OK, value)
    instance.run(2, 4)


@case("D29")
def fixed_early(fmu):
    if not fmu.fixed:
        return "it has no fixed parameter"
    instance = fmu.instance()
    assert all(instance.set(reference, fmu.other(reference)) == OK for reference in fmu.fixed)
    instance.start()
    assert all(instance.get(reference) == fmu.other(reference) for reference in fmu.fixed)
    assert instance.outputs() != fmu.started().outputs(), "parameters count"


@case("D30")
def start_values(fmu):
    instance = fmu.started()
    for variable in fmu.variables:
        if variable.start is not None and (variable.initial == "exact" or variable.causality == "input"):
            start, found = float(variable.start), instance.get(variable.valueReference)
            assert abs(found - start) <= 1e-12 * max(abs(start), 1.0), f"{variable.name}: {found}, not {start}"


@case("D31")
def inputs(fmu):
    if not fmu.inputs:
        return "it has no input"
    instance = fmu.instance()

    def check(value):
        assert all((instance.set(one, value), instance.get(one)) == (OK, value) for one in fmu.inputs)

    assert [instance.setup(), instance.enter()] == [OK] * 2
    check(0.25)
    assert instance.exit() == OK
    check(0.5)
    assert instance.step(0.0, 0.01) == OK
    check(-0.5)
    assert instance.step(0.01, 0.01) == OK


@case("D32")
def outputs_early(fmu):
    instance = fmu.instance()
    assert [instance.setup(), instance.enter()] == [OK] * 2
    before = instance.outputs()
    assert instance.exit() == OK and instance.outputs() == before


@case("D33")
def read_all(fmu):
    instance = fmu.started()
    instance.run(0, 3)
    references = fmu.references()
    values = instance.raw.getReal(references)
    assert instance.raw.getReal(references) == values
    assert instance.raw.getReal(references + references) == values + values


@case("D34")
def nan_values(fmu):
    if not fmu.inputs + fmu.tunable:
        return "it has no input and no tunable parameter"
    instance = fmu.started()
    for reference in fmu.inputs + fmu.tunable:
        before = instance.get(reference)
        for value in (float("nan"), float("inf"), float("-inf")):
            assert (instance.set(reference, value), instance.get(reference)) == (ERROR, before)
        instance.set(reference, 1e300)  # a number, but an absurd one: any answer, no hang
    instance.step(0.0, 0.01)
    assert instance.reset() == OK


@case("D35")
def out_of_range(fmu):
    instance = fmu.instance()
    beyond = [(one, float(one.min) - 1.0) for one in fmu.variables if one.min is not None]
    beyond += [(one, float(one.max) + 1.0) for one in fmu.variables if one.max is not None]
    if not beyond:
        return "it has no limit of a variable"
    assert all(instance.set(one.valueReference, value) == DISCARD for one, value in beyond)
    instance.start()


@case("D36")
def no_steps(fmu):
    instance = fmu.started()
    assert [instance.step(0.0, 0.0), instance.step(0.0, -0.01)] == [ERROR] * 2
    instance.run(0, 1)


@case("D37")
def nan_steps(fmu):
    instance = fmu.started()
    for odd in (float("nan"), float("inf"), float("-inf")):
        assert [instance.step(odd, 0.01), instance.step(0.0, odd)] == [ERROR] * 2
    instance.run(0, 1)


@case("D38")
def far_steps(fmu):
    instance = fmu.started()
    instance.run(0, 2)
    assert [instance.step(36_000.0, 0.01), instance.step(-36_000.0, 0.01)] == [ERROR] * 2


@case("D39")
def stop_time(fmu):
    instance = fmu.instance().start(stop=1.0)
    time = 0.0
    for _ in range(10):
        assert instance.step(time, 0.1) == OK
        time += 0.1
    assert instance.step(time, 0.1) == ERROR
    free = fmu.started()
    assert [free.step(0.0, 0.5), free.step(0.5, 5.0)] == [OK] * 2, "no stop time, no limit"


@case("D40")
def start_time(fmu):
    instance = fmu.instance().start(start=2.5)
    assert [instance.step(2.5, 0.25), instance.step(2.75, 0.25)] == [OK] * 2
    assert instance.last_time() == 3.0


@case("D41")
def wrong_first_step(fmu):
    assert fmu.started().step(18_000.0, 0.01) == ERROR


@case("D42")
def variable_steps(fmu):
    instance, time = fmu.started(), 0.0
    for step in (0.04, 0.02, 0.01, 0.08, 1e-6, 0.3):
        assert instance.step(time, step) == OK
        time += step
    other = fmu.started()
    assert other.step(0.0, time) == OK
    agree(fmu, fmu.outputs, instance.outputs(), other.outputs(), 1e-4)


@case("D43")
def determinism(fmu):
    def run(fixed):
        instance = fmu.started()
        for step in range(50):
            instance.raw.doStep(step * 0.01, 0.01, fixed)
        return instance.all()

    assert run(0) == run(0) == run(1)


@case("D44")
def accumulated(fmu):
    instance, time = fmu.started(), 0.0
    for _ in range(1000):
        assert instance.step(time, 0.0007) == OK, instance.messages
        time += 0.0007
    assert abs(instance.last_time() - time) < 1e-12


@case("D45")
def two_instances(fmu):
    expected = fmu.started().run(0, 20)
    both = [fmu.started(), fmu.started()]
    for step in range(20):
        assert [one.run(step, step + 1) for one in both] == [[expected[step]]] * 2


@case("D46")
def threads(fmu):
    expected = fmu.started().run(0, 200)
    found = []
    instances = [fmu.started() for _ in range(8)]
    all_threads = [threading.Thread(target=lambda one=one: found.append(one.run(0, 200))) for one in instances]
    for thread in all_threads:
        thread.start()
    for thread in all_threads:
        thread.join()
    assert found == [expected] * 8


@case("D47")
def another_thread(fmu):
    expected = fmu.started().run(0, 5)
    instance, found = fmu.instance(), []

    def work():
        found.append(instance.start().run(0, 5))
        instance.free()

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [expected]


def resident():
    """Resident memory in bytes."""
    return 4096 * int(Path("/proc/self/statm").read_text().split()[1])


@case("D48")
def memory(fmu):
    def once():
        instance = fmu.started()
        instance.run(0, 3)
        instance.free()

    for _ in range(30):
        once()
    before = resident()
    for _ in range(300):
        once()
    assert resident() - before < 3 << 20, resident() - before


@case("D49")
def reload(fmu):
    def once():
        instance = Fmu(fmu.folder).started()
        rows = instance.run(0, 3)
        instance.free()  # unloads the library, too
        return rows

    assert all(once() == rows for rows in [once()] for _ in range(5))


@case("D50")
def silent(fmu):
    def surroundings():
        handlers = [signal.getsignal(one) for one in (signal.SIGSEGV, signal.SIGFPE)]
        tiny = 2.0**-55
        return os.getcwd(), locale.setlocale(locale.LC_ALL), [1.0 + tiny == 1.0, 1.0 - tiny == 1.0], handlers

    before = surroundings()
    with tempfile.TemporaryFile() as file:
        kept = [(number, os.dup(number)) for number in (1, 2)]
        for number, _ in kept:
            os.dup2(file.fileno(), number)
        instance = fmu.started()
        instance.run(0, 5)
        instance.set(UNKNOWN, 1.0)
        instance.terminate()
        instance.free()
        for number, copy in kept:
            os.dup2(copy, number)
        assert os.fstat(file.fileno()).st_size == 0, "something was printed"
    assert surroundings() == before


@case("D51")
def saved_state(fmu):
    instance = fmu.started()
    instance.run(0, 13)
    state = instance.raw.getFMUstate()
    expected = instance.run(13, 40)
    for _ in range(2):
        assert instance.restore(state) == OK
        assert instance.run(13, 40) == expected
    assert fmu.started().run(0, 40)[13:] == expected, "saving changes nothing"
    instance.raw.freeFMUstate(state)
    assert state.value is None


@case("D52")
def reused_state(fmu):
    instance = fmu.started()
    first, second = instance.raw.getFMUstate(), instance.raw.getFMUstate()
    place = first.value
    instance.run(0, 3)
    assert status(instance.raw.fmi2GetFMUstate, instance.raw.component, byref(first)) == OK and first.value == place
    instance.raw.freeFMUstate(second)
    expected = instance.run(3, 6)
    assert instance.restore(first) == OK and instance.run(3, 6) == expected
    instance.raw.freeFMUstate(first)
    assert status(instance.raw.fmi2FreeFMUstate, instance.raw.component, byref(c_void_p())) == OK


@case("D53")
def whole_state(fmu):
    instance = fmu.instance()
    assert [instance.setup(), instance.enter()] == [OK] * 2
    early = instance.raw.getFMUstate()
    assert instance.exit() == OK
    instance.run(0, 3)
    late = instance.raw.getFMUstate()
    before = instance.all(), instance.last_time()
    assert all(instance.set(one, fmu.other(one)) == OK for one in fmu.inputs + fmu.tunable)
    assert [instance.step(0.03, 0.01), instance.terminate(), instance.restore(late)] == [OK] * 3
    assert (instance.all(), instance.last_time()) == before
    assert [instance.restore(early), instance.step(0.0, 0.01), instance.exit()] == [OK, ERROR, OK]


@case("D54")
def serialised(fmu):
    instance = fmu.started()
    instance.run(0, 13)
    content = instance.raw.serializeFMUstate(instance.raw.getFMUstate())
    expected = instance.run(13, 40)
    other = fmu.instance()
    copy = other.raw.deSerializeFMUstate(content)
    assert other.raw.serializeFMUstate(copy) == content
    assert other.restore(copy) == OK and other.run(13, 40) == expected


@case("D55")
def damaged(fmu):
    instance = fmu.started()
    state = instance.raw.getFMUstate()
    content = instance.raw.serializeFMUstate(state)
    small = ctypes.create_string_buffer(len(content) - 1)
    raw = instance.raw
    assert status(raw.fmi2SerializeFMUstate, raw.component, state, small, c_size_t(len(small))) == ERROR
    for place in range(len(content)):
        changed = bytearray(content)
        changed[place] ^= 0x11
        assert instance.deserialize(content[:place]) is None and instance.deserialize(bytes(changed)) is None
    instance.run(0, 2)


@case("D56")
def capabilities(fmu):
    for interface in (fmu.description.coSimulation, fmu.description.modelExchange):
        if interface is not None:
            assert interface.canGetAndSetFMUstate and interface.canSerializeFMUstate
            assert interface.providesDirectionalDerivative
    slave = fmu.description.coSimulation
    assert slave.canInterpolateInputs and not slave.canRunAsynchronuously
    assert status(fmu.started().raw.cancelStep) == ERROR


@case("D57")
def directional(fmu):
    if not fmu.inputs + fmu.tunable:
        return "it has no input and no tunable parameter"
    unknowns = fmu.references(lambda variable: variable.causality in ("output", "local"))
    instance = fmu.started()
    # An input that a driver follows has rested here: what is set then has no rate.
    instance.run(0, 9)
    raw = instance.raw
    for known in fmu.inputs + fmu.tunable:
        exact, before = raw.getDirectionalDerivative(unknowns, [known], [1.0]), instance.get(known)

        def at(change):
            assert instance.set(known, before + change) == OK
            return raw.getReal(unknowns)

        found = difference(at, 1e-2)
        assert instance.set(known, before) == OK
        agree(fmu, unknowns, exact, found, 1e-7)
    for pair in ([unknowns[0]], [UNKNOWN]), ([UNKNOWN], [unknowns[0]]):
        assert status(raw.getDirectionalDerivative, *pair, [1.0]) == ERROR


@case("D58")
def input_derivatives(fmu):
    if not fmu.inputs:
        return "it has no input"
    instance = fmu.started()

    def set_rate(reference, order):
        return status(instance.raw.setRealInputDerivatives, [reference], [order], [1.0])

    assert [set_rate(UNKNOWN, 1), set_rate(fmu.outputs[0], 1)] == [ERROR] * 2
    for number, reference in enumerate(fmu.inputs):
        assert [set_rate(reference, order) for order in (1, 0, 3)] == [OK, ERROR, ERROR]
        before = instance.get(reference)
        assert instance.step(0.5 * number, 0.5) == OK
        assert instance.get(reference) == before + 0.5, "the derivative acts"


@case("D59")
def output_derivatives(fmu):
    H = 1e-3

    def at(run, time, order):
        instance, state = run
        assert [instance.restore(state), instance.step(0.0, time)] == [OK] * 2
        if order == 0:
            return instance.outputs()
        return instance.raw.getRealOutputDerivatives(fmu.outputs, [order] * len(fmu.outputs))

    runs = [fmu.instance().start(tolerance=tolerance) for tolerance in (1e-12, 1e-11, 1e-10)]
    runs = [(instance, instance.raw.getFMUstate()) for instance in runs]
    highest = fmu.description.coSimulation.maxOutputDerivativeOrder
    for order in range(1, highest + 1):
        exact, *others = (at(run, 0.1, order) for run in runs)
        lower, *lower_others = (at(run, 0.1, order - 1) for run in runs)
        found = difference(lambda change: at(runs[0], 0.1 + change, order - 1), H)
        for i in range(len(exact)):
            # What another tolerance changes is not known any better: stiff motion multiplies every error of the state.
            unknown = max(abs(exact[i] - again[i]) for again in others)
            unknown += max(abs(lower[i] - again[i]) for again in lower_others) / H
            limit = 1e-5 * max(abs(exact[i]), abs(lower[i]), 1.0) + 10 * unknown
            assert abs(exact[i] - found[i]) <= limit, f"output {i}, order {order}: {exact[i]}, not {found[i]}"
    for order in (-1, 0, highest + 1):
        assert status(runs[0][0].raw.getRealOutputDerivatives, fmu.outputs[:1], [order]) == ERROR


@case("D60")
def statuses(fmu):
    instance = fmu.started()
    instance.run(0, 4)
    assert abs(instance.last_time() - 0.04) < 1e-12
    raw = instance.raw
    calls = [
        (raw.getStatus, 0),
        (raw.getRealStatus, 1),
        (raw.getIntegerStatus, 0),
        (raw.getBooleanStatus, 0),
        (raw.getStringStatus, 1),
    ]
    assert [status(*call) for call in calls] == [DISCARD] * 5
    assert status(raw.cancelStep) == ERROR


@case("D61")
def terminated_status(fmu):
    instance = fmu.started()
    instance.run(0, 1)
    assert instance.raw.getBooleanStatus(3) is False


@case("D62")
def log_categories(fmu):
    raw = fmu.instance().raw
    lists = [[]] + [[category.name] for category in fmu.description.logCategories]
    assert len(lists) > 1
    assert all(status(raw.setDebugLogging, on, names) == OK for names in lists for on in (True, False))
    assert status(raw.setDebugLogging, True, ["no such category"]) in (WARNING, ERROR)


@case("D63")
def log_messages(fmu):
    instance = fmu.started(logging=True)
    instance.run(0, 3)
    instance.set(UNKNOWN, 1.0)
    instance.step(9.0, 1.0)
    instance.terminate()
    categories = [category.name for category in fmu.description.logCategories]
    assert len(instance.messages) >= 5, instance.messages
    for name, level, category, message in instance.messages:
        assert name == NAME and category in categories and message and not message.endswith("\n")
        assert (level == ERROR) == (category == "errors")


@case("D64")
def log_silence(fmu):
    instance = fmu.started()
    # Before the input jumps: of one that a driver follows that is a warning.
    instance.run(0, 5)
    instance.terminate()
    assert instance.messages == []


@case("D65")
def log_printf(fmu):
    instance = fmu.started(name="%s%n%d #r1#")
    instance.set(UNKNOWN, 1.0)
    instance.step(float("nan"), 1.0)
    assert len(instance.messages) == 2 and all(message[0] == "%s%n%d #r1#" for message in instance.messages)
    with tempfile.TemporaryDirectory() as folder:
        # The location is part of the message; fmpy's proxy formats it as C does.
        other = Path(folder) / "100%s %n"
        shutil.copytree(fmu.folder, other)
        (other / "resources/program.bin").unlink()
        messages = []
        try:
            Instance.log = lambda self, _, name, level, category, message: messages.append(message.decode())
            fmu.instance(folder=other)
        except Exception as fault:
            assert str(fault) == "Failed to instantiate model"
        assert len(messages) == 1 and "100%s %n" in messages[0], messages


@case("D66")
def strings(fmu):
    assert all(variable.type == "Real" for variable in fmu.variables)
    assert fmu.started().raw.getString([]) == []


@case("D67")
def tolerances(fmu):
    for tolerance in (1e-3, 1e-10, 1e-16, 10.0):
        fmu.instance().start(tolerance=tolerance).run(0, 10)
    for tolerance in (0.0, -1.0, float("nan"), float("inf")):
        assert fmu.instance().setup(tolerance=tolerance) == ERROR


@case("D68")
def stop_before_start(fmu):
    instance = fmu.instance()
    assert [instance.setup(start=1.0, stop=0.5), instance.setup(start=float("nan"))] == [ERROR] * 2
    instance.start()


def event(instance):
    """The status of fmi2NewDiscreteStates."""
    info = fmi2EventInfo()
    found = status(instance.raw.fmi2NewDiscreteStates, instance.raw.component, byref(info))
    assert found != OK or (info.newDiscreteStatesNeeded, info.terminateSimulation) == (0, 0)
    return found


@case("M01")
def exchange_order(fmu):
    if fmu.description.modelExchange is None:
        return NO_EXCHANGE
    instance = fmu.started(ME)
    raw = instance.raw

    def completed():
        return OK if status(raw.completedIntegratorStep) == OK else ERROR

    def continuous():
        return status(raw.enterContinuousTimeMode)

    assert completed() == ERROR
    assert [event(instance), continuous(), continuous(), event(instance)] == [OK, OK, ERROR, ERROR]
    assert [completed(), status(raw.setTime, 0.01), status(raw.setTime, float("nan"))] == [OK, OK, ERROR]
    instance.all()
    assert all(instance.set(one, fmu.other(one)) == ERROR for one in fmu.tunable), "in event mode only"
    assert status(raw.enterEventMode) == OK
    assert all(instance.set(one, fmu.other(one)) == OK for one in fmu.tunable)
    assert [event(instance), continuous(), instance.terminate(), continuous()] == [OK, OK, OK, ERROR]
    instance.all()
    assert instance.reset() == OK
    instance.start()


@case("M02")
def exchange_sizes(fmu):
    if fmu.description.modelExchange is None:
        return NO_EXCHANGE
    instance = fmu.started(ME)
    raw, count = instance.raw, len(fmu.description.derivatives)
    indicators = int(fmu.description.numberOfEventIndicators)
    assert [event(instance), status(raw.enterContinuousTimeMode)] == [OK] * 2
    values = (c_double * (count + indicators + 1))()
    calls = [raw.getContinuousStates, raw.setContinuousStates, raw.getDerivatives, raw.getNominalsOfContinuousStates]
    assert [status(call, values, count) for call in calls] == [OK] * 4
    assert [status(call, values, count + 1) for call in calls] == [ERROR] * 4
    assert status(raw.getEventIndicators, values, indicators) == OK
    assert status(raw.getEventIndicators, values, indicators + 1) == ERROR
    if count:
        assert status(raw.setContinuousStates, (c_double * count)(*[float("nan")] * count), count) == DISCARD
        assert status(raw.getDerivatives, no_array(c_double), count) == ERROR


@case("M03")
def exchange_derivatives(fmu):
    if fmu.description.modelExchange is None:
        return NO_EXCHANGE
    instance = fmu.started(ME)
    raw = instance.raw
    derivatives = [unknown.variable for unknown in fmu.description.derivatives]
    states = [derivative.derivative for derivative in derivatives]
    count = len(states)
    values, rates = (c_double * count)(), (c_double * count)()
    raw.getContinuousStates(values, count)
    raw.getDerivatives(rates, count)
    unknowns = [variable.valueReference for variable in derivatives]
    assert raw.getReal([variable.valueReference for variable in states]) == list(values)
    assert raw.getReal(unknowns) == list(rates)
    assert [event(instance), status(raw.enterContinuousTimeMode)] == [OK] * 2
    for place, state in enumerate(states):
        exact = raw.getDirectionalDerivative(unknowns, [state.valueReference], [1.0])

        def at(change):
            moved = list(values)
            moved[place] += change
            raw.setContinuousStates((c_double * count)(*moved), count)
            return raw.getReal(unknowns)

        found = difference(at, 1e-3)
        at(0.0)
        agree(fmu, unknowns, exact, found, 1e-7)


@case("M04")
def exchange_state(fmu):
    if fmu.description.modelExchange is None:
        return NO_EXCHANGE
    instance = fmu.started(ME)
    raw = instance.raw
    saved, before = raw.getFMUstate(), instance.all()
    assert [event(instance), status(raw.enterContinuousTimeMode), status(raw.setTime, 0.02)] == [OK] * 3
    moved, later = raw.getFMUstate(), instance.all()
    assert instance.restore(saved) == OK and instance.all() == before
    other = fmu.instance(ME)
    copy = other.raw.deSerializeFMUstate(raw.serializeFMUstate(moved))
    assert other.restore(copy) == OK and other.all() == later
    assert fmu.instance().restore(copy) == ERROR, "not in Co-Simulation"


@case("X01")
def second_library(fmu):
    expected = fmu.started().run(0, 20)
    with tempfile.TemporaryDirectory() as folder:
        copy = shutil.copy(next((fmu.folder / "binaries").glob("linux64/*.so")), Path(folder) / "another.so")
        both = [fmu.started(), fmu.started(library=str(copy))]
        for step in range(20):
            assert [one.run(step, step + 1) for one in both] == [[expected[step]]] * 2


@case("X02")
def state_from_file(fmu):
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "state.bin"
        child = os.fork()
        if child == 0:
            instance = fmu.started()
            instance.run(0, 13)
            file.write_bytes(instance.raw.serializeFMUstate(instance.raw.getFMUstate()))
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        instance = fmu.instance()
        assert instance.restore(instance.raw.deSerializeFMUstate(file.read_bytes())) == OK
    assert instance.run(13, 40) == fmu.started().run(0, 40)[13:]


@case("X03")
def impossible_initial(fmu):
    instance = fmu.instance()
    exact = [one for one in fmu.variables if one.initial == "exact" and one.causality != "parameter"]
    for variable in exact:
        reference = variable.valueReference
        value = fmu.other(reference)
        assert instance.set(reference, value) == OK
        instance.start()
        assert abs(instance.get(reference) - value) < 1e-9, variable.name
        assert [instance.set(reference, float("nan")), instance.reset()] == [ERROR, OK]
    instance.start().run(0, 2)


@case("X04")
def damaged_resources(fmu):
    with tempfile.TemporaryDirectory() as folder:
        other = Path(folder) / "copy"
        shutil.copytree(fmu.folder, other)
        file = other / "resources/program.bin"
        whole = file.read_bytes()
        for place in range(0, len(whole), len(whole) // 60 + 1):
            changed = bytearray(whole)
            changed[place] ^= 0x24
            for content in (bytes(changed), whole[:place], whole + b"more"):
                file.write_bytes(content)
                refused(fmu, folder=other)
        file.unlink()
        refused(fmu, folder=other)
    fmu.started()


@case("X05")
def another_model(fmu):
    folders = sorted(file.parent for file in fmu.folder.parent.glob("*/modelDescription.xml"))
    strangers = [Fmu(folder).started() for folder in folders if folder != fmu.folder]
    assert strangers
    expected = fmu.started().run(0, 20)
    instance = fmu.started()
    for step in range(20):
        for stranger in strangers:
            stranger.run(step, step + 1)
        assert instance.run(step, step + 1) == [expected[step]]
    content = strangers[0].raw.serializeFMUstate(strangers[0].raw.getFMUstate())
    assert instance.deserialize(content) is None


@case("X07")
def description(fmu):
    problems = validate_model_description(
        read_model_description(fmu.folder), validate_variable_names=True, validate_model_structure=True
    )
    assert not problems, problems
