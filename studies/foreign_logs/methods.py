"""What is asked of a method: the owner's robot file and logs in, names of effects and joints out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from statsmodels.regression.linear_model import OLS
from threadpoolctl import threadpool_limits

from flexmodels.robot import Robot
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import runs_here

from ..rigid_arm.baselines import METHODS, Name, Strengths
from .generator import Made
from .sensors import as_log

_SCREENED = 120  # columns of the LASSO
Method = Callable[[Robot, list[Log], list[Log]], list[Name]]  # robot, logs to fit, logs held out


@dataclass(frozen=True)
class Answer:
    """verdict   `unexplained` says that something is missing which has no name
    ties      of every finding the names that cannot be told apart, the best first
    amounts   of the names of the first finding: the error of the description [m or rad], else None
    strengths  of every finding, falling; none where a method gives names alone
    """

    verdict: str
    ties: list[list[Name]]
    amounts: Sequence[float | None] = ()
    strengths: Sequence[float] = ()


def all_answers(robot: Robot, fit: list[Log], heldout: list[Log]) -> dict[str, Answer]:
    """The diagnosis and, on its whitened columns, simpler methods."""
    search = searched(robot, fit, runs_here)
    answers = {"diagnosis": answer_of(concluded(search, runs_here, heldout))}
    for name, method in (METHODS | {"LASSO": lasso}).items():
        strengths = method(search)
        answers[name] = replace(named(list(strengths)), strengths=tuple(strengths.values()))
    return answers


def answer_of(found: Diagnosis) -> Answer:
    """A diagnosis in a method's terms."""
    ties = [[(n.effect, int(n.joint.removeprefix("joint"))) for n in f.tie] for f in found.findings]
    first = found.findings[0].tie if found.findings else ()
    return Answer(found.verdict, ties, [n.values.get("correction") for n in first])


def said_of(case: Made) -> tuple[Diagnosis | None, Answer, str]:
    """What the diagnosis says of a case's logs; where it fails nothing, a wrong answer, and why."""
    frames = {"the log to fit": case.fit, "the log held out": case.heldout}
    fit, heldout = (as_log(case.robot, frame, name) for name, frame in frames.items())
    with threadpool_limits(1):
        try:
            found = concluded(searched(case.robot, [fit], runs_here), runs_here, [heldout])
        except Exception as error:  # a wrong answer, whatever it is
            return None, Answer("failed", []), f"{type(error).__name__}: {error}"
    return found, answer_of(found), ""


def named(names: list[Name]) -> Answer:
    """The answer of a method that gives names alone."""
    return Answer("missing_effect" if names else "nothing_detectable", [[name] for name in names])


def lasso(search: Search) -> Strengths:
    """L1 regression on all columns, what the model imitates taken out, at the penalty of least BIC.

    Strengths are the squares of the coefficients, of columns of length 1, over the variance of what is left.

    Tibshirani 1996; Zou, Hastie and Tibshirani 2007 for BIC; only the columns that correlate most with the
    residual take part (Fan and Lv 2008), and the whole is reduced to its triangle first.
    """
    X, y, names = _columns(search)
    X = X / np.maximum(np.linalg.norm(X, axis=0), 1e-12)
    kept = np.argsort(-np.abs(X.T @ y))[:_SCREENED]
    names = [names[i] for i in kept]
    R = np.asarray(np.linalg.qr(np.column_stack([X[:, kept], y]), mode="r"))
    triangle, target = R[:, :-1], R[:, -1]
    largest, rows = np.abs(triangle.T @ target).max() / len(R), len(y)
    best, chosen = rows * np.log(float(y @ y)), np.zeros(len(names))
    for penalty in largest * np.geomspace(0.9, 1e-2, 12):
        fit = OLS(target, triangle).fit_regularized(alpha=penalty, L1_wt=1.0, maxiter=30)
        active = np.abs(fit.params) > 1e-9 * max(np.abs(fit.params).max(), 1e-300)
        left = float(np.square(target - triangle @ fit.params).sum())
        score = rows * np.log(max(left, 1e-300)) + active.sum() * np.log(rows)
        if score < best:
            best, chosen = score, active * np.square(fit.params) * rows / max(left, 1e-300)
    found: Strengths = {}
    for i in np.argsort(-chosen):
        if chosen[i]:
            found.setdefault(names[i], float(chosen[i]))
    return found


def _columns(search: Search) -> tuple[np.ndarray, np.ndarray, list[Name]]:
    """(E, K) of every candidate beyond the base, the residual (E,), and the candidates' names."""
    base, blocks, names = search.base, [], []
    for columns, candidate in zip(search.families.columns, search.examination.candidates, strict=True):
        K = next(X.shape[1] for rows in columns for X in rows.values())
        dense = [np.zeros((*r.shape, K)) for r in base.residual]
        for block, rows in zip(dense, columns, strict=True):
            for row, X in rows.items():
                block[row] = X
        along = sum(np.einsum("cer,cek->rk", b, d) for b, d in zip(base.basis, dense, strict=True))
        beyond = [d - b @ along for b, d in zip(base.basis, dense, strict=True)]
        blocks.append(np.vstack([d.reshape(-1, K) for d in beyond]))
        names += [(candidate.effect, candidate.joint)] * K
    return np.hstack(blocks), np.concatenate([r.ravel() for r in base.residual]), names
