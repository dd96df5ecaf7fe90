"""FMILibrary, by its C interface: the bare calls of FMI 2 and 3; the loop is that of `stepping`."""

import ctypes as c
import tempfile

from request import Description, Request, describe, read, write
from stepping import BareFmu, run

WARNING = 3  # the library's log level: warnings and what is worse, to the standard error


class Callbacks(c.Structure):
    _fields_ = [*((name, c.c_void_p) for name in ("malloc", "calloc", "realloc", "free", "logger"))]
    _fields_ += [("level", c.c_int), ("context", c.c_void_p), ("message", c.c_char * 2000)]


class EventInfo2(c.Structure):
    _fields_ = [*((f"flag{i}", c.c_int) for i in range(5)), ("next", c.c_double)]


class Fmu(BareFmu):
    def __init__(self, request: Request, description: Description, folder: str):
        self.library = c.CDLL(request.tool)
        self.request, self.description = request, description
        self.old = description.version == "2.0"
        self.prefix = "fmi2_import_" if self.old else "fmi3_import_"
        exchange = request.interface == "ModelExchange"
        pointer = self.library.jm_get_default_callbacks
        pointer.restype = c.POINTER(Callbacks)
        callbacks = pointer()
        callbacks.contents.level = WARNING
        context = self._made("fmi_import_allocate_context", callbacks)
        path = request.fmu.encode()
        self.library.fmi_import_get_fmi_version(context, path, folder.encode())
        self.fmu = self._made(self.prefix + "parse_xml", context, folder.encode(), None)
        kinds = (1, 2) if self.old else (2, 4)
        kind = kinds[0 if exchange else 1]
        if self.old:
            self._call("create_dllfmu", c.c_int(kind), None)
            self._call("instantiate", b"plant", c.c_int(0 if exchange else 1), None, c.c_int(0))
            self._call("setup_experiment", 0, c.c_double(0), c.c_double(0), 0, c.c_double(0))
            self._call("enter_initialization_mode")
        else:
            no = c.c_bool(False)
            self._call("create_dllfmu", c.c_int(kind), None, None)
            if exchange:
                self._call("instantiate_model_exchange", b"plant", None, no, no)
            else:
                more = (no, no, None, c.c_size_t(0), None)
                self._call("instantiate_co_simulation", b"plant", None, no, no, *more)
            start = (no, c.c_double(0), c.c_double(0), no, c.c_double(0))
            self._call("enter_initialization_mode", *start)
        self.apply(0)
        self._call("exit_initialization_mode")

    def _made(self, name: str, *arguments) -> c.c_void_p:
        function = getattr(self.library, name)
        function.restype = c.c_void_p
        made = function(*arguments)
        if not made:
            raise RuntimeError(f"{name} made nothing")
        return c.c_void_p(made)

    def _call(self, name: str, *arguments) -> None:
        status = getattr(self.library, self.prefix + name)(self.fmu, *arguments)
        if status:
            raise RuntimeError(f"{name} returned {status}")

    def apply(self, i):
        inputs = self.request.inputs
        references = self._references(inputs)
        n, values = len(inputs), _doubles([values[i] for values in inputs.values()])
        sizes = (references, c.c_size_t(n), values)
        if self.old:
            self._call("set_real", *sizes)
        else:
            self._call("set_float64", *sizes, c.c_size_t(n))

    def outputs(self):
        names = self.request.outputs
        n, values = len(names), _doubles([0.0] * len(names))
        sizes = (self._references(names), c.c_size_t(n), values)
        if self.old:
            self._call("get_real", *sizes)
        else:
            self._call("get_float64", *sizes, c.c_size_t(n))
        return list(values)

    def _references(self, names):
        return (c.c_uint * len(names))(*self.description.of(names))

    def do_step(self, time, step):
        if self.old:
            self._call("do_step", c.c_double(time), c.c_double(step), c.c_int(1))
            return
        event, terminate, early, last = c.c_bool(), c.c_bool(), c.c_bool(), c.c_double()
        told = (c.byref(event), c.byref(terminate), c.byref(early), c.byref(last))
        self._call("do_step", c.c_double(time), c.c_double(step), c.c_bool(True), *told)

    def close(self):
        self._call("terminate")
        getattr(self.library, self.prefix + "free_instance")(self.fmu)

    def update_discrete_states(self):
        if self.old:
            info = EventInfo2()
            self._call("new_discrete_states", c.byref(info))
            return bool(info.flag0), info.next
        flags, instant = [c.c_bool() for _ in range(5)], c.c_double()
        self._call("update_discrete_states", *map(c.byref, flags), c.byref(instant))
        return flags[0].value, instant.value

    def enter_continuous_time_mode(self):
        self._call("enter_continuous_time_mode")

    def enter_event_mode(self):
        self._call("enter_event_mode")

    def at(self, time, x):
        self._call("set_time", c.c_double(time))
        self._call("set_continuous_states", _doubles(x), c.c_size_t(len(x)))

    def _vector(self, name, n):
        values = _doubles([0.0] * n)
        self._call(name, values, c.c_size_t(n))
        return list(values)

    def states(self):
        return self._vector("get_continuous_states", self.description.states)

    def rates(self):
        return self._vector("get_derivatives", self.description.states)

    def indicators(self):
        return self._vector("get_event_indicators", self.description.indicators)


def _doubles(values):
    return (c.c_double * len(values))(*values)


def main() -> None:
    request = read()
    with tempfile.TemporaryDirectory() as folder:
        rows = run(Fmu(request, describe(request), folder), request)
    write(dict(zip(request.outputs, map(list, zip(*rows, strict=True)), strict=True)))


main()
