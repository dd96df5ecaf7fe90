"""Output error against linear least squares in closed form, on models that are a line of Python."""

import numpy as np
import pytest

from flexmodels.inputs import SimulationError
from pyident.greybox.output_error import output_error
from pyident.greybox.recording import Recording
from pyident.greybox.search import Free

TIME = np.arange(2000) * 0.01
INPUT = np.sin(2 * TIME) + 0.5 * np.sin(9 * TIME)
NOISE = 0.05


def recorded(output: np.ndarray) -> Recording:
    return Recording("a log", TIME, {"u": INPUT}, ("y",), ("rad",), output[:, None])


def noisy(output: np.ndarray) -> Recording:
    return recorded(output + NOISE * np.random.default_rng(3).standard_normal(len(TIME)))


def line(recording, sets, names, progress=None):
    """y = gain u + offset; what `other` is does not matter."""
    u = recording.inputs["u"]
    return np.array([(v.get("gain", 1.0) * u + v.get("offset", 0.0))[:, None] for v in sets])


def test_a_line_and_its_intervals_are_those_of_least_squares():
    log = noisy(2.5 * INPUT - 0.3)
    found = output_error([log], line, [Free("gain", "1", 1.0), Free("offset", "rad", 0.0)])
    X = np.column_stack([INPUT, np.ones(len(TIME))])
    p, *_ = np.linalg.lstsq(X, log.measured[:, 0], rcond=None)
    covariance = NOISE**2 * np.linalg.inv(X.T @ X)
    assert list(found.values.values()) == pytest.approx(p, rel=1e-5)
    assert [e.std for e in found.estimates] == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.25)
    np.testing.assert_allclose(found.residuals[0][:, 0], log.measured[:, 0] - X @ p, atol=1e-5)


def test_what_does_not_act_is_not_told():
    found = output_error([noisy(2.5 * INPUT)], line, [Free("gain", "1", 1.0), Free("other", "1", 1.0)])
    gain, other = found.estimates
    assert gain.determined
    assert not other.determined
    assert np.isnan(other.std)


def test_a_value_at_its_bound_has_no_interval_and_is_said():
    found = output_error([noisy(2.5 * INPUT)], line, [Free("gain", "1", 1.0, 0.0, 2.0)])
    (gain,) = found.estimates
    assert gain.at_bound
    assert gain.value == pytest.approx(2.0, rel=1e-6)
    assert np.isnan(gain.std)
    assert found.notes[-1] == "gain ends at its bound 2"
    assert "starts within the bounds were tried" in found.notes[0]


def test_outputs_that_jump_with_a_parameter_get_no_interval():
    """A stair has no slope: what differences of two widths say of it disagrees."""

    def stair(recording, sets, names, progress=None):
        return np.round(200 * line(recording, sets, names)) / 200

    found = output_error([noisy(2.5 * INPUT)], stair, [Free("gain", "1", 2.4)])
    assert "the outputs jump with the parameters" in found.notes[-1]
    assert np.isnan(found.estimates[0].std)
    assert found.values["gain"] == pytest.approx(2.5, abs=0.2)


def test_an_output_that_the_model_does_not_describe_leaves_no_interval():
    """A model of one unit, a log of another: what is left is larger than the output, and no noise."""

    def turned(recording, sets, names, progress=None):
        return 3 * np.cos(2 * TIME)[None, :, None] + line(recording, sets, names)

    found = output_error([noisy(2.5 * INPUT)], turned, [Free("gain", "1", 1.0)])
    assert found.notes[-1].startswith("a constant would explain more of y than the fitted model does")
    assert np.isnan(found.estimates[0].std)


def test_an_output_of_noise_alone_takes_no_interval_from_the_others():
    both = Recording("a log", TIME, {"u": INPUT}, ("y", "z"), ("rad", "rad"), np.zeros((len(TIME), 2)))
    both.measured[:] = NOISE * np.random.default_rng(4).standard_normal(both.measured.shape)
    both.measured[:, 0] += 2.5 * INPUT

    def silent(recording, sets, names, progress=None):
        y = line(recording, sets, names)
        return np.concatenate([y, 0 * y], axis=2)

    found = output_error([both], silent, [Free("gain", "1", 1.0)])
    assert not found.notes
    assert found.estimates[0].std == pytest.approx(NOISE / np.linalg.norm(INPUT), rel=0.25)


@pytest.mark.parametrize(("start", "told"), [(0.0, False), (2.0, True)])
def test_a_log_that_begins_in_motion_is_told(start, told):
    """A start that the model has not dies out within a tenth of a second."""
    found = output_error([noisy(2.0 * INPUT + start * np.exp(-TIME / 0.1))], line, [Free("gain", "1", 1.0)])
    assert any("name the start values of the model's states" in note for note in found.notes) == told


def test_outputs_that_grow_without_bound_are_refused_in_one_sentence():
    def exploding(recording, sets, names, progress=None):
        return line(recording, sets, names) * np.exp(np.minimum(TIME * 20, 700))[None, :, None]

    with pytest.raises(SimulationError, match="grow without bound at its own start; check that the log's"):
        output_error([noisy(2.5 * INPUT)], exploding, [Free("gain", "1", 1.0)])


def test_two_recordings_count_together():
    found = output_error([noisy(2.5 * INPUT), recorded(2.5 * INPUT)], line, [Free("gain", "1", 1.0)])
    assert found.values["gain"] == pytest.approx(2.5, abs=0.01)
    assert len(found.residuals) == 2


def test_intervals_hold_where_few_samples_tell_a_parameter():
    """The start of a decay is told by its first tenth of a hundred samples; 100 logs, white noise."""
    time = np.arange(100) * 0.03

    def decay(recording, sets, names, progress=None):
        return np.array([(v["start"] * np.exp(-v["rate"] * time))[:, None] for v in sets])

    held = []
    for seed in range(100):
        noise = 0.05 * np.random.default_rng(seed).standard_normal(len(time))
        log = Recording("a log", time, {}, ("y",), ("m",), (2 * np.exp(-1.5 * time) + noise)[:, None])
        rate, start = output_error(
            [log], decay, [Free("rate", "1/s", 1.0), Free("start", "m", 1.0)]
        ).estimates
        held.append((abs(rate.value - 1.5) < 1.96 * rate.std, abs(start.value - 2) < 1.96 * start.std))
    assert (np.mean(held, axis=0) >= 0.89).all()
    assert (np.mean(held, axis=0) <= 0.99).all()
