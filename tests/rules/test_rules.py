"""Thresholds: each says what it is, and what cannot work together is refused."""

from dataclasses import replace

import pytest

from pyident.rules.bins import BINS
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.greybox import GREYBOX
from pyident.rules.log_checks import LOG_CHECKS
from pyident.rules.replicas import ReplicaRules
from pyident.rules.rule import RulesError, lines
from pyident.rules.rules import RULES, Rules
from pyident.rules.search import SearchRules


def test_every_threshold_says_what_it_is():
    frame = RULES.to_frame()
    assert frame.index.is_unique
    beside = (LOG_CHECKS, CHANNELS, EQUATIONS, GREYBOX, BINS)
    listed = [*lines(RULES), *(line for group in beside for line in lines(group))]
    assert len(listed) > len(frame)
    for line in listed:
        assert line.of, line.name
        assert min(len(line.why), len(line.fixed_on)) > 3, line.name


def test_too_few_replicas_for_the_level_are_refused():
    """The least p-value that B replicas can give is 1/(1 + B)."""
    for count in (5, 18, 19, 20):
        possible = 1 / (1 + count) <= 0.05
        if possible:
            assert Rules(replicas=ReplicaRules(count=count)).replicas.count == count
        else:
            with pytest.raises(RulesError, match="19 replicas or more"):
                Rules(replicas=ReplicaRules(count=count))


@pytest.mark.parametrize(
    "change",
    [{"explained": (0.8, 0.5)}, {"explained": (0.5, 1.2)}, {"part": 0.6}, {"level": 1.5}, {"most": 0}],
)
def test_thresholds_that_contradict_each_other_are_refused(change):
    with pytest.raises(RulesError):
        replace(SearchRules(), **change)


@pytest.mark.parametrize("quantiles", [(0.0, 0.5, 0.4, 1.0), (0.0, 1.5)])
def test_quantiles_are_rising_shares(quantiles):
    with pytest.raises(RulesError, match=r"bins\.quantiles must rise"):
        replace(BINS, quantiles=quantiles)
