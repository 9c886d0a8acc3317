"""Progress in a log: a line a stage where the work is long, none where it is not."""

import sys

import pytest

from surftex.cli import watch
from surftex.cli.watch import PATIENCE_S, ColdWatch, Watch


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass when told."""
    now = [100.0]
    monkeypatch.setattr(watch.time, "perf_counter", lambda: now[0])

    def wait(seconds):
        now[0] += seconds

    return wait


def stage(told, clock, name, seconds, ticks=4):
    told(name, 0.0)
    for tick in range(ticks):
        clock(seconds / ticks)
        told(name, (tick + 1) / ticks)


def test_long_work_in_a_log_has_a_line_for_each_stage(clock, capsys):
    with Watch() as told:
        stage(told, clock, "load", 1.5)
        assert capsys.readouterr().err == ""
        told("unwrap", 0.0)
        stage(told, clock, "place", 40.0)
        told.detail("unwrap", "2 of 3")
        told("unwrap", 1.0)
        stage(told, clock, "save", 0.25)
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines() == [
        "surftex: reading the mesh: 1.50 s",
        "surftex: placing features ...",
        "surftex: placing features: 40.00 s",
        "surftex: unwrapping: 40.00 s (2 of 3)",
        "surftex: writing files: 0.25 s",
    ]


def test_short_work_in_a_log_has_none_and_quiet_never(clock, capsys):
    for quiet, seconds in ((False, PATIENCE_S / 4), (True, 100.0)):
        with ColdWatch(cold=(), threads=1, quiet=quiet) as told:
            for name in ("load", "place", "bake"):
                stage(told, clock, name, seconds)
    assert capsys.readouterr().err == ""


def test_every_stage_has_its_line_when_asked_and_one_before_where_it_is_long(clock, capsys):
    with Watch(verbose=True) as told:
        stage(told, clock, "load", 1.0)
        stage(told, clock, "place", 40.0)
    assert capsys.readouterr().err.splitlines() == [
        "surftex: reading the mesh: 1.00 s",
        "surftex: placing features ...",
        "surftex: placing features: 40.00 s",
    ]


def test_a_terminal_has_its_bar_and_no_lines(clock, capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    told = Watch()
    assert told.bar is not None
    assert not told.lines
