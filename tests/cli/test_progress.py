"""What a file sees of long work."""

from pyident.cli.common.progress import SECONDS, lines


def test_a_line_every_ten_seconds_with_what_is_left(capsys):
    now = [0.0]
    progress = lines("search", lambda: now[0])
    for second in range(1, 41):
        now[0] = float(second)
        progress(second / 80)
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 40 / SECONDS
    assert said[-1] == "search: 50 % after 40 s, about 40 s left"
