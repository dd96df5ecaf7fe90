import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from flexmodels.settings.processing import Column
from pyident.logs.log import Log, LogError, read_log, require, write_log


def frame(n=20):
    time = np.arange(n) * 0.004
    return pd.DataFrame({"time": time, "joint1.e": np.sin(time), "joint1.eps[1]": 1e-4 * time})


@pytest.mark.parametrize("ending", [".csv", ".parquet", ".mat"])
def test_a_log_survives_writing_and_reading(ending, tmp_path):
    path = tmp_path / f"log{ending}"
    write_log(Log(frame(), "test"), path)
    pd.testing.assert_frame_equal(read_log(path).frame, frame(), rtol=1e-14)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_foreign_names_and_units_are_mapped(tmp_path):
    time = np.arange(9) * 1e-3
    savemat(tmp_path / "log.mat", {"t": time[:, None], "volt": np.ones((9, 1)), "gain": 3.0})
    log = read_log(tmp_path / "log.mat", {"time": Column("t"), "joint1.tau": Column("volt", 35.0)})
    assert log.frame["joint1.tau"].tolist() == [35.0] * 9
    assert log.period == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f.drop(columns="time"), "column time is missing"),
        (
            lambda f: f.assign(**{"joint1.e": f["joint1.e"].where(f.index != 7)}),
            "column joint1.e is not finite.*row 8",
        ),
        (lambda f: f.drop(index=10), "time goes from 0.036 s to 0.044 s at row 11"),
        (lambda f: f[::-1], "time runs backwards"),
        (lambda f: f.head(1), "1 samples are too few"),
        (lambda f: f.assign(note="text"), "column note holds nothing that is a number"),
        (
            lambda f: f.assign(note=["E-STOP", *range(19)]),
            "column note holds 'E-STOP' in row 1, which is no number",
        ),
        (lambda f: f.head(0), "names of columns, and no rows below them"),
        (lambda f: pd.concat([f, f[["joint1.e"]]], axis=1), "column joint1.e is there twice"),
        (lambda f: f.assign(time=0.0), "time stands still"),
    ],
)
def test_a_wrong_log_is_explained(change, words, tmp_path):
    change(frame()).to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(LogError, match=words) as caught:
        read_log(tmp_path / "log.csv")
    assert "\n" not in str(caught.value)


def test_files_that_are_no_logs_are_explained(tmp_path):
    (tmp_path / "log.parquet").write_text("nonsense")
    with pytest.raises(LogError, match="cannot be read as parquet"):
        read_log(tmp_path / "log.parquet")
    with pytest.raises(LogError, match="must end in"):
        write_log(Log(frame(), ""), tmp_path / "log.xls")
    with pytest.raises(LogError, match="there is no log"):
        read_log(tmp_path / "nothing.csv")
    savemat(tmp_path / "log.mat", {"text": "words"})
    with pytest.raises(LogError, match="holds no numeric vectors"):
        read_log(tmp_path / "log.mat")


def test_what_a_robot_needs_is_required(four_link, identification_log):
    short = Log(identification_log.frame.head(30), "short")
    with pytest.raises(LogError, match="30 samples are too few; robot four_link needs 160"):
        require(short, four_link, 160)
    lacking = Log(identification_log.frame.drop(columns="joint2.eps[3]"), "lacking")
    with pytest.raises(LogError, match=r"column joint2\.eps\[3\] is missing"):
        require(lacking, four_link, 160)
