"""Identify robots with flexible joints, and find out what their models lack.

    import pyident as pi
    fit = pi.identify("four_link", pi.read_log("log.parquet"))
    print(fit.summary())

`model` is a Robot, the name of a shipped one or the path of a robot file; `logs` a Log, a DataFrame, the path
of a log, or a list of these. What a function needs is loaded when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flexmodels.compiling.compiler import BuildError as BuildError
    from flexmodels.files.robot_file import load_robot as load_robot
    from flexmodels.files.robot_file import save_robot as save_robot
    from flexmodels.inputs import Experiment as Experiment
    from flexmodels.inputs import SimulationError as SimulationError
    from flexmodels.robot import Robot as Robot
    from flexmodels.robot import RobotError as RobotError
    from pyident.logs.log import Log as Log
    from pyident.logs.log import LogError as LogError
    from pyident.logs.log import write_log as write_log
    from pyident.simulation.references import ExperimentError as ExperimentError
    from pyident.sweep.store import StudyError as StudyError
    from pyident.verbs.excite import check_plan as check_plan
    from pyident.verbs.excite import excite as excite
    from pyident.verbs.excite import export_plan as export_plan
    from pyident.verbs.explain import Explained as Explained
    from pyident.verbs.explain import explain as explain
    from pyident.verbs.fit import identify as identify
    from pyident.verbs.fit import identify_servo as identify_servo
    from pyident.verbs.fit import refine as refine
    from pyident.verbs.fitted import Fit as Fit
    from pyident.verbs.fitted import ServoFit as ServoFit
    from pyident.verbs.fmu.model import compare_fmu as compare_fmu
    from pyident.verbs.fmu.model import diagnose_fmu as diagnose_fmu
    from pyident.verbs.fmu.model import identify_fmu as identify_fmu
    from pyident.verbs.fmu.results import FmuCompared as FmuCompared
    from pyident.verbs.fmu.results import FmuDiagnosed as FmuDiagnosed
    from pyident.verbs.fmu.results import FmuFit as FmuFit
    from pyident.verbs.inputs import check_log as check_log
    from pyident.verbs.inputs import read_log as read_log
    from pyident.verbs.judge import add_effect as add_effect
    from pyident.verbs.judge import compare as compare
    from pyident.verbs.judge import diagnose as diagnose
    from pyident.verbs.judged import Added as Added
    from pyident.verbs.judged import Compared as Compared
    from pyident.verbs.judged import Diagnosed as Diagnosed
    from pyident.verbs.payload import Payload as Payload
    from pyident.verbs.payload import payload as payload
    from pyident.verbs.planned import Checked as Checked
    from pyident.verbs.planned import Planned as Planned
    from pyident.verbs.simulate import export_fmu as export_fmu
    from pyident.verbs.simulate import parameter_study as parameter_study
    from pyident.verbs.simulate import simulate as simulate

_HOME = {
    "Added": "pyident.verbs.judged",
    "BuildError": "flexmodels.compiling.compiler",
    "Checked": "pyident.verbs.planned",
    "Compared": "pyident.verbs.judged",
    "Diagnosed": "pyident.verbs.judged",
    "Experiment": "flexmodels.inputs",
    "ExperimentError": "pyident.simulation.references",
    "Explained": "pyident.verbs.explain",
    "Fit": "pyident.verbs.fitted",
    "FmuCompared": "pyident.verbs.fmu.results",
    "FmuDiagnosed": "pyident.verbs.fmu.results",
    "FmuFit": "pyident.verbs.fmu.results",
    "Log": "pyident.logs.log",
    "LogError": "pyident.logs.log",
    "Robot": "flexmodels.robot",
    "Payload": "pyident.verbs.payload",
    "Planned": "pyident.verbs.planned",
    "RobotError": "flexmodels.robot",
    "SimulationError": "flexmodels.inputs",
    "StudyError": "pyident.sweep.store",
    "add_effect": "pyident.verbs.judge",
    "check_log": "pyident.verbs.inputs",
    "check_plan": "pyident.verbs.excite",
    "compare": "pyident.verbs.judge",
    "compare_fmu": "pyident.verbs.fmu.model",
    "diagnose": "pyident.verbs.judge",
    "diagnose_fmu": "pyident.verbs.fmu.model",
    "excite": "pyident.verbs.excite",
    "explain": "pyident.verbs.explain",
    "export_fmu": "pyident.verbs.simulate",
    "export_plan": "pyident.verbs.excite",
    "identify": "pyident.verbs.fit",
    "ServoFit": "pyident.verbs.fitted",
    "identify_servo": "pyident.verbs.fit",
    "identify_fmu": "pyident.verbs.fmu.model",
    "load_robot": "flexmodels.files.robot_file",
    "parameter_study": "pyident.verbs.simulate",
    "payload": "pyident.verbs.payload",
    "read_log": "pyident.verbs.inputs",
    "refine": "pyident.verbs.fit",
    "save_robot": "flexmodels.files.robot_file",
    "simulate": "pyident.verbs.simulate",
    "write_log": "pyident.logs.log",
}
__all__ = list(_HOME)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    """Load what is asked for. Raises AttributeError for what the package does not offer."""
    if name not in _HOME:
        raise AttributeError(f"pyident has no {name}; it has {', '.join(sorted(_HOME))}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
