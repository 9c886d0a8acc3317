"""Kernels compiled before they are called: the list holds, a second process helps and goes, files are not mistaken."""

import subprocess
import sys
from contextlib import contextmanager

import pytest

from surftex.cli.watch import COMPILING, ColdWatch
from surftex.kernels import ahead
from surftex.kernels.jit import _Files


@pytest.mark.slow
def test_the_list_is_what_bakes_call():
    from docs.make_signatures import made

    assert made() == ahead.LIST.read_text("utf-8"), "run python -m docs.make_signatures"


def test_the_list_tells_kinds_apart():
    leather, cells = ahead.listed(["leather"]), ahead.listed(["cells"])
    assert set(leather) & set(cells)
    assert set(leather) - set(cells)
    assert set(ahead.listed(["leather", "cells"])) == set(leather) | set(cells)


HELPED = """
import os, sys, time
from pathlib import Path
from surftex.kernels import ahead
folder, (name, signature) = Path(os.environ["NUMBA_CACHE_DIR"]), ahead.listed(["skin"])[-1]
module, function = name.split(".")
with ahead.second_process(["skin"]):
    until = time.monotonic() + 100
    while not list(folder.rglob(f"{module}.{function}-*.nbi")) and time.monotonic() < until:
        time.sleep(0.05)
    assert list(folder.rglob(f"{module}.{function}-*.nbc")), "nothing was compiled beside this process"
ahead.compile_one(name, signature)
from importlib import import_module
print(getattr(import_module(f"surftex.kernels.{module}"), function).stats.cache_hits)
try:
    os.waitpid(-1, os.WNOHANG)
except ChildProcessError:
    print("alone")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="waits for children as POSIX does")
def test_a_second_process_compiles_the_end_of_the_list_and_is_ended(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    done = subprocess.run(
        [sys.executable, "-c", HELPED], capture_output=True, text=True, timeout=200, check=False
    )
    assert done.returncode == 0, done.stderr
    hits, alone = done.stdout.splitlines()
    assert ": 1}" in hits
    assert alone == "alone"


def test_no_second_process_where_none_can_be_started(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with ahead.second_process(["leather"]):
        pass


@pytest.mark.parametrize("threads", [1, 2])
def test_a_cold_bake_is_told_and_helped_from_the_end_of_loading_to_its_own(threads, monkeypatch, capsys):
    events = []

    @contextmanager
    def helped(kinds):
        events.append(kinds)
        yield
        events.append("ended")

    monkeypatch.setattr(ahead, "second_process", helped)
    with ColdWatch(cold=("leather",), threads=threads) as watch:
        watch("load", 0.5)
        assert not events
        assert not capsys.readouterr().err
        watch("place", 0.0)
        watch("place", 1.0)
        assert events == [("leather",)] * (threads - 1)
        assert capsys.readouterr().err == f"surftex: {COMPILING}\n"
    assert events == [("leather",), "ended"] * (threads - 1)


def test_two_that_keep_compiled_code_at_once_do_not_take_it_for_each_other_s(tmp_path, monkeypatch):
    one, two = (_Files(str(tmp_path), "kernel", "stamp") for _ in range(2))
    usual = one._save_data
    monkeypatch.setattr(two, "_load_index", dict)  # has looked before the first began

    def meanwhile(name, data):
        two.save("integers", "code for integers")
        usual(name, data)

    monkeypatch.setattr(one, "_save_data", meanwhile)
    one.save("numbers", "code for numbers")
    read = _Files(str(tmp_path), "kernel", "stamp")
    assert read.load("integers") == "code for integers"
    assert read.load("numbers") == "code for numbers"
    assert _Files(str(tmp_path), "kernel", "newer").load("numbers") is None
