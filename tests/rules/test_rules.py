"""Thresholds: each says what it is, and what cannot work together is refused."""

import re
from dataclasses import replace
from pkgutil import iter_modules

import pytest

import pyident.rules
from pyident.rules.bins import BINS
from pyident.rules.replicas import ReplicaRules
from pyident.rules.rule import RulesError
from pyident.rules.rules import RULES, Rules, every_threshold
from pyident.rules.search import SearchRules


def test_every_threshold_says_what_it_is():
    assert RULES.to_frame().index.is_unique
    listed = list(every_threshold())
    assert len({line.name for line in listed}) == len(listed) > len(RULES.to_frame())
    groups = {line.name.split(".")[0] for line in listed}
    modules = {module.name for module in iter_modules(pyident.rules.__path__)}
    assert modules - groups == {"rule", "rules", "confidence"}  # no group is forgotten
    assert groups - modules == {"extension", "change_checks"}  # beside the unexplained, and the log checks
    for line in listed:
        assert line.of, line.name
        assert min(len(line.why), len(line.fixed_on)) > 3, line.name
        assert not re.search("not (yet )?(measured|run|scored)|not recorded", line.fixed_on), line.name


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
