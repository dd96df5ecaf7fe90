"""Outcomes of compare, diagnose and add, written by hand."""

from typing import Any, cast

import numpy as np
from one_joint import one_joint

from pyident.comparison.compare import Comparison
from pyident.comparison.errors import Error, LogErrors
from pyident.diagnosis.result import Diagnosis, Finding, Limit, Named, Row
from pyident.extension.add_effect import Extended
from pyident.extension.waterfall import Step
from pyident.verbs.judged import Compared

inf = float("inf")
STRIBECK = Named(
    "stribeck",
    "joint1",
    {"level": 8.1234, "velocity": 0.0517, "share": 0.5},
    {"level": 0.25, "velocity": inf, "share": inf},
    {"level": "N.m", "velocity": "rad/s", "share": "1"},
    91.5,
    nonlinear=("velocity",),
)
DIAGNOSIS = Diagnosis(
    robot="arm",
    logs=("a.csv",),
    heldout=(),
    verdict="missing_effect",
    sentence="stribeck at joint1 is missing.",
    findings=(Finding((STRIBECK,), 1 / 21, 88.8, 97.25, None, "slow reversals"),),
    localised=("joint1", "motor"),
    limits=tuple(Limit(f"law{i}", "joint1", {}, {}, 1.0, "no such motion") for i in range(6)),
    rows=(Row("joint1.e", "joint1", "motor", ((0.0, 0.5), (0.5, 25.0)), (1.25, 0.06), (12.5, 1.25)),),
    excess=7.25,
    remaining=1.17,
    ranking=(STRIBECK,),
    notes=(),
    noise={},
    depends_on=("It repeats with time at 7.5 Hz.",),
    stages=(),
)


ADDED = Extended(
    one_joint(),
    one_joint().with_effect(1, "stribeck"),
    (),
    (),
    (Step("torque of joint 1", "N.m", 2.0, 1.0, 0.5),),
    (0.75, 0.5),
    "",
    cast(Any, type("Gate", (), {"json": lambda self: {}})()),
)


def compared(rmse: float) -> Compared:
    error = Error(rmse=rmse, signal=10.0, floor=0.5, unit="N.m")
    log = LogErrors("a.csv", {"joint1.e": error}, {}, np.zeros(1), {})
    return Compared(Comparison("arm", f"it misses by {rmse:g}", None, False, (log,), (), (), True), ())
