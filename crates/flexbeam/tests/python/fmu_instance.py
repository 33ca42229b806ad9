"""One instance of a functional mock-up unit under FMPy, in either version of the interface."""

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

said = []


def log(*arguments):
    said.append(arguments[-1].decode())


def refused(words, call, *arguments):
    """The call fails, and the unit says why."""
    said.clear()
    try:
        call(*arguments)
    except FMICallException:
        assert len(said) == 1 and words in said[0], (words, said)
        return
    raise AssertionError(f"not refused: {words}")


class Instance:
    """Ready for its first step, with these parameters set before the initialization (in version 3: in it)."""

    def __init__(self, description, folder, name, **parameters):
        self.is_3 = description.fmiVersion.startswith("3")
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        self.whole_names = {v.name for v in description.modelVariables if v.type in ("Integer", "Int64", "Enumeration")}
        make = FMU3Slave if self.is_3 else FMU2Slave
        identifier = description.coSimulation.modelIdentifier
        self.fmu = make(guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName=name)
        if self.is_3:
            self.log = fmpy.fmi3.fmi3LogMessageCallback(log)
            self.fmu.instantiate(logMessage=self.log)
        else:
            self.callbacks = fmpy.fmi2.fmi2CallbackFunctions()
            self.callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(log)
            self.fmu.instantiate(callbacks=self.callbacks)
        self.start(**parameters)

    def start(self, **parameters):
        if self.is_3:
            self.fmu.enterInitializationMode(startTime=0.0)
            self.set_named(parameters)
        else:
            self.set_named(parameters)
            self.fmu.setupExperiment(startTime=0.0)
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.time_s = 0.0

    def reset(self, **parameters):
        self.fmu.reset()
        self.start(**parameters)

    def set(self, variables, values):
        (self.fmu.setFloat64 if self.is_3 else self.fmu.setReal)(variables, values)

    def get(self, variables):
        return (self.fmu.getFloat64 if self.is_3 else self.fmu.getReal)(variables)

    def set_whole(self, variable, value):
        (self.fmu.setInt64 if self.is_3 else self.fmu.setInteger)([variable], [value])

    def get_whole(self, variable):
        return (self.fmu.getInt64 if self.is_3 else self.fmu.getInteger)([variable])[0]

    def set_named(self, values):
        for name, value in values.items():
            if name in self.whole_names:
                self.set_whole(self.references[name], int(value))
            else:
                self.set([self.references[name]], [value])

    def do_step(self, step_s):
        self.fmu.doStep(currentCommunicationPoint=self.time_s, communicationStepSize=step_s)
        self.time_s += step_s

    def memory(self):
        return self.fmu.getFMUState() if self.is_3 else self.fmu.getFMUstate()

    def recall(self, memory):
        self.fmu.setFMUState(memory) if self.is_3 else self.fmu.setFMUstate(memory)

    def free(self, memory):
        self.fmu.freeFMUState(memory) if self.is_3 else self.fmu.freeFMUstate(memory)

    def written(self, memory):
        return (self.fmu.serializeFMUState if self.is_3 else self.fmu.serializeFMUstate)(memory)

    def read(self, written):
        return (self.fmu.deserializeFMUState if self.is_3 else self.fmu.deSerializeFMUstate)(written)

    def take_over(self, other):
        """All of another instance of the same unit, by way of bytes."""
        memory = other.memory()
        own = self.read(other.written(memory))
        other.free(memory)
        self.fmu.reset()
        self.recall(own)
        self.free(own)

    def end(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
