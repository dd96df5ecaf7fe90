"""FMUs that fail, break the standard or lack something, and what a caller may set: Reference-FMUs, edited."""

import json
import zipfile

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from reference_fmus import reference_fmu

from flexfmu.fmu_file import FmuDescription
from flexfmu.foreign.model import FmuModel
from flexmodels.inputs import SimulationError
from flexmodels.robot import RobotError
from pyident.cli.main import main
from pyident.greybox.search import Free
from pyident.verbs.fmu.model import compare_fmu, diagnose_fmu, identify_fmu

TIME = np.arange(0, 5, 0.1)
DECAY = pd.DataFrame({"time": TIME, "x": (1 - 0.17) ** np.arange(50)})
X_IS_READ = "            values[(*index)++] = M(x);"
both = pytest.mark.parametrize("fmi", [2, 3])


def breaking(what: str) -> list[tuple[str, str, str]]:
    """Edits with which reading x beyond 2.05 s does `what`."""
    return [("model.c", X_IS_READ, f"            if (comp->time > 2.05) {{ {what} }}\n{X_IS_READ}")]


@both
@pytest.mark.parametrize("ask", [compare_fmu, diagnose_fmu, lambda path, log: identify_fmu(path, log, ["k"])])
def test_an_output_that_is_no_number_is_no_small_residual(fmi, ask, tmp_path):
    path = reference_fmu("Dahlquist", fmi, tmp_path, breaking("values[(*index)++] = 0.0 / 0.0; return OK;"))
    with pytest.raises(SimulationError, match=r"output x is no number from 2\.1 s on"):
        ask(path, DECAY)


@both
def test_what_an_fmu_says_of_its_failure_is_told_with_the_time(fmi, tmp_path):
    path = reference_fmu(
        "Dahlquist", fmi, tmp_path, breaking('logError(comp, "The valve is stuck."); return Error;')
    )
    with pytest.raises(SimulationError, match=r"at 2\.1 s: The valve is stuck\."):
        compare_fmu(path, DECAY)


@both
@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
def test_an_input_without_a_column_keeps_the_value_that_is_given(fmi, interface, tmp_path):
    path = reference_fmu("Feedthrough", fmi, tmp_path)
    fed, out = "Float64_continuous_input", "Float64_continuous_output"
    log = pd.DataFrame({"time": TIME, out: np.full(50, 1.5)})
    found = compare_fmu(path, log, values={fed: 1.5}, interface=interface)
    assert found.errors["the data frame"][out]["rmse"] < 1e-12
    assert f"{fed} = 1.5" in found.notes[0]
    with pytest.raises(RobotError, match=f"its column {fed} feeds that input"):
        compare_fmu(path, log.assign(**{fed: 0.0}), values={fed: 1.5}, interface=interface)


def test_the_limits_of_a_declared_type_are_those_of_its_variables(tmp_path):
    rate = '<SimpleType name="Rate"><Real min="0" max="1.5"/></SimpleType>'
    declared = f"  <TypeDefinitions>{rate}</TypeDefinitions>\n"
    edits = [
        ("FMI2.xml", "  <LogCategories>", f"{declared}\n  <LogCategories>"),
        (
            "FMI2.xml",
            '<Real start="1"/>\n    </ScalarVariable>\n  </ModelVariables>',
            '<Real declaredType="Rate" start="1"/>\n    </ScalarVariable>\n  </ModelVariables>',
        ),
    ]
    rate = FmuModel(reference_fmu("Dahlquist", 2, tmp_path, edits)).quantities["k"]
    assert (rate.minimum, rate.maximum) == (0.0, 1.5)


def test_a_description_that_breaks_the_standard_runs_and_is_said_to(tmp_path):
    wrong = [
        (
            "FMI2.xml",
            'causality="parameter" variability="fixed"',
            'causality="parameter" variability="continuous"',
        )
    ]
    path = reference_fmu("Dahlquist", 2, tmp_path, wrong)
    with pytest.raises(SimulationError, match=r'is not an FMU that can be read .*"k"'):
        FmuDescription(path)
    found = compare_fmu(path, DECAY, values={"k": 1.7})
    assert "breaks the standard" in found.notes[0]
    assert '"k"' in found.notes[0]
    assert found.errors["the data frame"]["x"]["rmse"] < 1e-9


def test_an_fmu_of_another_platform_is_refused_by_name(tmp_path):
    path = reference_fmu("Dahlquist", 2, tmp_path)
    other = tmp_path / "windows.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            new.writestr(name.replace("linux64", "win64"), old.read(name))
    with pytest.raises(SimulationError, match="has binaries for win64 only; this machine needs"):
        compare_fmu(other, DECAY)


def test_a_column_that_does_not_move_has_no_share_of_itself(tmp_path):
    path = reference_fmu("Dahlquist", 2, tmp_path)
    still = DECAY.assign(x=1.0)
    assert compare_fmu(path, still).headline().endswith("(rms); the logs' own does not move")
    result = CliRunner().invoke(main, ["compare", str(path), _written(still, tmp_path), "--json", "-"])
    assert "NaN" not in result.output
    fit = identify_fmu(path, still, ["k"])
    assert np.isnan(fit.fit.estimates[0].std)
    assert "0 samples of outputs that move in the logs for 1 parameters: no interval is given" in fit.notes


def _written(frame: pd.DataFrame, folder) -> str:
    file = folder / "log.csv"
    frame.to_csv(file, index=False)
    return str(file)


def test_of_few_samples_there_is_no_interval(tmp_path):
    path = reference_fmu("Dahlquist", 2, tmp_path)
    fit = identify_fmu(path, DECAY.iloc[:4], ["k"])
    assert np.isnan(fit.fit.estimates[0].std)
    assert "4 samples for 1 parameters: no interval is given" in fit.notes


def test_intervals_say_where_what_is_left_is_no_noise(tmp_path):
    path, rng = reference_fmu("Dahlquist", 2, tmp_path), np.random.default_rng(0)
    noisy = DECAY.assign(x=DECAY["x"] + 0.01 * rng.standard_normal(50))
    said = "what is left of x is no white noise"
    assert not any(note.startswith(said) for note in identify_fmu(path, noisy, ["k"]).notes)
    hidden = noisy.assign(x=noisy["x"] + 0.1 * np.sin(TIME))
    assert any(note.startswith(said) for note in identify_fmu(path, hidden, ["k"]).notes)


def test_what_is_named_twice_is_refused(tmp_path):
    path = reference_fmu("Dahlquist", 2, tmp_path)
    with pytest.raises(RobotError, match="k is to be identified and has a value for good"):
        identify_fmu(path, DECAY, ["k"], values={"k": 3.0})
    with pytest.raises(RobotError, match="k is named twice"):
        diagnose_fmu(path, DECAY, ["k", "k"])
    log = _written(DECAY, tmp_path)
    result = CliRunner().invoke(main, ["identify", str(path), log, "--parameters", "k", "k"])
    assert result.exit_code == 2
    assert "k is named twice" in result.output


def test_found_values_are_printed_as_options_of_the_next_command(tmp_path):
    fit = identify_fmu(reference_fmu("Dahlquist", 2, tmp_path), DECAY, {"k": (0.0, 5.0)})
    assert "with them: --set k=1.7" in str(fit.summary())
    assert json.loads(json.dumps(fit.to_dict()))["parameters"]["k"]["value"] == pytest.approx(1.7)


def test_a_start_at_zero_without_bounds_tells_no_size():
    assert Free("k", "1", 0.0).sizeless
    assert not Free("k", "1", 0.0, 0.0, 1e-8).sizeless
    assert not Free("k", "1", 2.0).sizeless
