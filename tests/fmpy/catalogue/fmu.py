"""An unpacked FMU and its instances, as fmpy sees them."""

import ctypes
from ctypes import byref
from pathlib import Path

from fmpy import calloc, free, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Model,
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy

OK, WARNING, DISCARD, ERROR = range(4)
NAME = "it's 100% # mine"
CS, ME = FMU2Slave, FMU2Model


def status(call, *arguments):
    """The status of a call: fmpy raises what is worse than a warning."""
    try:
        result = call(*arguments)
    except FMICallException as fault:
        return fault.status
    return result if isinstance(result, int) else OK


class Fmu:
    """What its description says."""

    def __init__(self, folder):
        self.folder = Path(folder).resolve()
        self.description = read_model_description(self.folder)
        self.variables = self.description.modelVariables
        self.identifier = self.description.coSimulation.modelIdentifier

    def references(self, wanted=lambda variable: True):
        return [variable.valueReference for variable in self.variables if wanted(variable)]

    @property
    def inputs(self):
        return self.references(lambda variable: variable.causality == "input")

    @property
    def outputs(self):
        return self.references(lambda variable: variable.causality == "output")

    @property
    def tunable(self):
        return self.references(lambda variable: variable.variability == "tunable")

    @property
    def fixed(self):
        return self.references(lambda variable: variable.causality == "parameter" and variable.variability == "fixed")

    def variable(self, reference):
        return next(variable for variable in self.variables if variable.valueReference == reference)

    def default(self, reference):
        return float(self.variable(reference).start)

    def other(self, reference):
        """Another permitted value than the default: small, so that loops still close."""
        start = self.default(reference)
        return start * 1.01 if start else 0.5

    def instance(self, kind=CS, **more):
        return Instance(self, kind, **more)

    def started(self, kind=CS, **more):
        return self.instance(kind, **more).start()


class Instance:
    """An instance; `raw` is fmpy's own object, whose functions beginning with fmi2 are those of the C interface."""

    def __init__(self, fmu, kind=CS, name=NAME, guid=None, folder=None, library=None, logging=False):
        self.fmu, self.messages = fmu, []
        self.raw = kind(
            guid=fmu.description.guid if guid is None else guid,
            unzipDirectory=str(folder or fmu.folder),
            modelIdentifier=fmu.identifier,
            instanceName=name,
            libraryPath=library,
        )
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(self.log)
        self.callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        self.callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        addLoggerProxy(byref(self.callbacks))
        self.raw.instantiate(callbacks=self.callbacks, loggingOn=logging)

    def log(self, _, name, status, category, message):
        self.messages.append((name.decode(), status, category.decode(), message.decode()))

    def setup(self, start=0.0, stop=None, tolerance=None):
        return status(self.raw.setupExperiment, tolerance, start, stop)

    def enter(self):
        return status(self.raw.enterInitializationMode)

    def exit(self):
        return status(self.raw.exitInitializationMode)

    def start(self, **experiment):
        assert [self.setup(**experiment), self.enter(), self.exit()] == [OK] * 3, self.messages
        return self

    def step(self, time, step):
        return status(self.raw.doStep, time, step)

    def terminate(self):
        return status(self.raw.terminate)

    def reset(self):
        return status(self.raw.reset)

    def free(self):
        self.raw.freeInstance()

    def get(self, reference):
        return self.raw.getReal([reference])[0]

    def refuses_get(self, reference):
        return status(self.raw.getReal, [reference]) == ERROR

    def set(self, reference, value):
        return status(self.raw.setReal, [reference], [value])

    def all(self):
        return self.raw.getReal(self.fmu.references())

    def outputs(self):
        return self.raw.getReal(self.fmu.outputs)

    def run(self, first, last):
        """Steps of 10 ms, with an input that changes now and then; all variables after each."""
        rows = []
        for step in range(first, last):
            if step % 5 == 0:
                for reference in self.fmu.inputs:
                    assert self.set(reference, 0.1 * (step % 7)) == OK
            assert self.step(step * 0.01, 0.01) == OK, self.messages
            rows.append(self.all())
        return rows

    def last_time(self):
        return self.raw.getRealStatus(2)

    def restore(self, state):
        return status(self.raw.setFMUstate, state)

    def deserialize(self, content):
        try:
            return self.raw.deSerializeFMUstate(content)
        except FMICallException as fault:
            assert fault.status == ERROR
            return None


def difference(values_at, h):
    """Central differences of fourth order."""
    a, b, c, d = (values_at(k * h) for k in (-2, -1, 1, 2))
    return [(8 * (c[i] - b[i]) - (d[i] - a[i])) / (12 * h) for i in range(len(a))]


def agree(fmu, unknowns, exact, found, limit):
    for reference, exact_one, found_one in zip(unknowns, exact, found, strict=True):
        name = fmu.variable(reference).name
        assert abs(exact_one - found_one) <= limit * max(abs(exact_one), 1.0), f"{name}: {exact_one}, not {found_one}"


def no_array(of):
    """A null pointer to such elements."""
    return ctypes.POINTER(of)()
