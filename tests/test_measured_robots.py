"""The studies of measured robots meet the published figures."""

import pytest

from flexmodels.robot_file import load_robot
from pyident.studies import find_study


@pytest.mark.parametrize(("name", "goals"), [("tx40", 3), ("kuka_kr300", 2)])
def test_published_figures(name, goals, data, tmp_path):
    run = find_study(name)
    assert run is not None
    result = run(tmp_path, lambda _: None)
    judged = [r for r in result.rows if r["met"] != "-"]
    assert (len(judged), {r["met"] for r in judged}) == (goals, {"yes"})
    assert (tmp_path / "index.html").is_file()
    if name == "kuka_kr300":
        stiffness = [r["value"] for r in result.rows if r["what"].endswith("stiffness")]
        assert stiffness[0].startswith("not identifiable")
        assert all("MN m/rad" in text for text in stiffness[1:])


def test_shipped_robots_hold_their_transmissions():
    assert load_robot("tx40").transmission.ratio[5][4] == 32.0  # pyright: ignore[reportOptionalMemberAccess]
    assert load_robot("kuka_kr300").coordinates[6:] == tuple(f"joint{k}.eps[1]" for k in (1, 2, 3))
