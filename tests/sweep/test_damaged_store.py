"""Whatever lies in the folder of a sweep: its rows are right, or a sentence says which file to remove."""

import json

import numpy as np
import pandas as pd
import pytest

from pyident.sweep.store import ResultsStore, StudyError

DESIGN = pd.DataFrame({"joint1.viscous": np.linspace(1.0, 3.0, 6)})
ROWS = pd.DataFrame({"run": range(6), "tip_error": np.arange(6.0), "seconds": 0.1, "failure": ""})


@pytest.fixture
def folder(tmp_path):
    """Four of six runs finished, in two parts."""
    store = ResultsStore(tmp_path, "mine")
    store.add(ROWS.head(2))
    store.add(ROWS.head(4).tail(2))
    store.close()
    return tmp_path


def gone_on(folder):
    """What the next call does: read what is there, compute the rest, write the table."""
    store = ResultsStore(folder, "mine")
    try:
        left = pd.DataFrame(ROWS[~ROWS["run"].isin(store.rows()["run"])])
        if len(left):
            store.add(left)
        return store.finish(DESIGN)
    finally:
        store.close()


def rewritten(change):
    """A part with its frame changed."""

    def damage(folder):
        file = folder / "parts" / "00000002.parquet"
        change(pd.read_parquet(file)).to_parquet(file, index=False)

    return damage


def bytes_of(name, change):
    def damage(folder):
        file = folder / name
        file.write_bytes(change(file.read_bytes() if file.exists() else b""))

    return damage


def instead(name, content=None):
    """A folder where a file was; or a file of this content, the finished table."""

    def damage(folder):
        file = folder / name
        file.unlink(missing_ok=True)
        if content is None:
            file.mkdir()
        else:
            content.to_parquet(file, index=False)

    return damage


PART, NOTE, TABLE = "parts/00000002.parquet", "study.json", "results.parquet"
REFUSED = {
    "a part of no bytes": bytes_of(PART, lambda b: b""),
    "a part cut in the middle": bytes_of(PART, lambda b: b[: len(b) // 2]),
    "a part without its end": bytes_of(PART, lambda b: b[:-1]),
    "a part that is text": bytes_of(PART, lambda b: b"run\n1\n"),
    "a part of zeros": bytes_of(PART, lambda b: bytes(len(b))),
    "a part with its footer overwritten": bytes_of(PART, lambda b: b[:-40] + b"\xff" * 32 + b[-8:]),
    "a part without runs": rewritten(lambda f: f.drop(columns="run")),
    "runs of words": rewritten(lambda f: f.assign(run=["a", "b"])),
    "runs that are fractions": rewritten(lambda f: f.assign(run=[2.5, 3.5])),
    "runs below zero": rewritten(lambda f: f.assign(run=[-1, 3])),
    "runs that are missing": rewritten(lambda f: f.assign(run=[None, 3])),
    "runs beyond the design": rewritten(lambda f: f.assign(run=[2, 77])),
    "results of words": rewritten(lambda f: f.assign(tip_error=["good", "bad"])),
    "results of lists": rewritten(lambda f: f.assign(tip_error=[[1.0], [2.0]])),
    "results that are times": rewritten(lambda f: f.assign(tip_error=pd.to_datetime(["2026-01-01"] * 2))),
    "a part that is a folder": instead(PART),
    "a note of no bytes": bytes_of(NOTE, lambda b: b""),
    "a note that is no JSON": bytes_of(NOTE, lambda b: b"{"),
    "a note that is a list": bytes_of(NOTE, lambda b: b"[]"),
    "a note without the fingerprint": bytes_of(NOTE, lambda b: b"{}"),
    "a note nested without end": bytes_of(NOTE, lambda b: b"[" * 100_000),
    "a note of another study": bytes_of(NOTE, lambda b: json.dumps({"fingerprint": "yours"}).encode()),
    "a note that is a folder": instead(NOTE),
    "no note": lambda folder: (folder / NOTE).unlink(),
    "a table of another kind": instead(TABLE, pd.DataFrame({"a": [1]})),
    "a table that is text": bytes_of(TABLE, lambda b: b"run,tip_error\n0,1\n"),
    "a table that is a folder": instead(TABLE),
}
MENDED = {
    "no parts": lambda folder: [file.unlink() for file in (folder / "parts").iterdir()],
    "an unfinished part": bytes_of("parts/.00000004.parquet.tmp", lambda b: b"PAR1"),
    "a part twice": rewritten(lambda f: pd.concat([f, f])),
    "a finished table beside its parts": instead(TABLE, ROWS[:3]),
    "columns in another order": rewritten(lambda f: f[f.columns[::-1]]),
}


@pytest.mark.parametrize("damage", REFUSED.values(), ids=REFUSED)
def test_damage_is_named_and_nothing_is_overwritten(damage, folder):
    damage(folder)
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    with pytest.raises((StudyError, OSError)) as refused:
        gone_on(folder)
    assert str(folder) in str(refused.value)
    assert {file: file.read_bytes() for file in before} == before


@pytest.mark.parametrize("damage", MENDED.values(), ids=MENDED)
def test_what_is_only_incomplete_is_completed(damage, folder):
    damage(folder)
    table = gone_on(folder)
    assert table.index.tolist() == list(range(6))
    np.testing.assert_array_equal(table["tip_error"], np.arange(6.0))
    np.testing.assert_array_equal(table["joint1.viscous"], DESIGN["joint1.viscous"])


def test_two_at_once_are_not_mixed(folder):
    store = ResultsStore(folder, "mine")
    with pytest.raises(StudyError, match="another sweep is at work"):
        ResultsStore(folder, "mine")
    store.close()
    assert len(gone_on(folder)) == 6
