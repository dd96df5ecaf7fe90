"""Logs of robots that hide a physical effect, for a blind study: an independent maker of measured data.

    python -m studies.hidden_effect.generator --seed 3 --cases null,stribeck -o folder

writes folder/logs/<id>/train1.parquet, train2.parquet, heldout.parquet and, apart,
folder/sealed/<id>/key.json.
"""

from .cases import LOGS, UNOBSERVABLE, Case
from .laws import LAWS
from .logs_and_key import case_list, cases_of, generate
from .run import NOISELESS, Hidden, Noise, Plan, simulate, standard

__all__ = [
    "LAWS",
    "LOGS",
    "NOISELESS",
    "UNOBSERVABLE",
    "Case",
    "Hidden",
    "Noise",
    "Plan",
    "case_list",
    "cases_of",
    "generate",
    "simulate",
    "standard",
]
