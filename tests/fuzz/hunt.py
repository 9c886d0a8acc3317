"""Damage to every reader, in processes of their own: ``python -m tests.fuzz [--runs 100000] [--only mesh,picture]``.

A find is an exception that is no refusal, a dead process, one number that takes more than 5 s of processor time, or
more than 1 GB of memory over what the libraries take. Each is named by target and number, and happens again with
``--only TARGET --first NUMBER --runs 1``.
"""

import argparse
import json
import multiprocessing
import resource
import signal
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

from surftex.errors import InputError
from tests.fuzz.targets import TARGETS

SLOW_S, ROOM_MB = 5, 1000


def trial(name: str, folder: Path, number: int) -> str:
    """Run one number; ``taken``, ``refused``, or what went wrong."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            TARGETS[name](folder, number)
    except InputError as problem:
        return "refused" if str(problem) else "a refusal without a word"
    except BaseException as problem:  # noqa: BLE001  (a find)
        place = traceback.extract_tb(problem.__traceback__)[-1]
        return f"{type(problem).__name__} in {Path(place.filename).name}:{place.lineno}: {str(problem)[:120]}"
    return "taken"


def work(name: str, first: int, last: int, pipe: Any) -> None:
    """Run numbers in a child; the pipe hears each number before and each fate after."""
    signal.signal(signal.SIGALRM, _late)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        trial(name, folder, 10**9)  # imports and kernels
        for number in range(first, last):
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            pipe.send((number, None))
            signal.alarm(12 * SLOW_S)
            began = time.process_time()
            fate = trial(name, folder, number)
            signal.alarm(0)
            grown_mb = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / 1e6
            if time.process_time() - began > SLOW_S:
                fate = f"slow: {time.process_time() - began:.1f} CPU-s ({fate})"
            elif grown_mb > ROOM_MB:
                fate = f"large: {grown_mb:.0f} MB ({fate})"
            pipe.send((number, fate))
    pipe.send((last, "end"))


def _late(number: int, frame: Any) -> None:
    raise TimeoutError(f"more than {12 * SLOW_S} s")


def hunt(name: str, first: int, runs: int) -> tuple[Counter, list[str]]:
    """Feed one target; a child that dies is replaced, and goes on behind the number that killed it."""
    context = multiprocessing.get_context("spawn")
    counts: Counter = Counter()
    finds: list[str] = []
    at, last = first, first + runs
    deaths = 0
    while at < last and deaths < 20:
        here, there = context.Pipe(duplex=False)
        child = context.Process(target=work, args=(name, at, last, there))
        child.start()
        there.close()
        try:
            while True:
                at, fate = here.recv()
                if fate == "end":
                    break
                if fate in ("taken", "refused"):
                    counts[fate] += 1
                elif fate is not None:
                    counts["find"] += 1
                    finds.append(f"{name} {at}: {fate}")
        except EOFError:
            child.join()
            finds.append(f"{name} {at}: the process died ({child.exitcode})")
            counts["find"] += 1
            at, deaths = at + 1, deaths + 1
        child.join()
    return counts, finds


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=100_000, help="over all targets")
    parser.add_argument("--only", help="targets, with commas between")
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    names = options.only.split(",") if options.only else list(TARGETS)
    total, found = 0, []
    for name in names:
        began = time.perf_counter()
        runs = max(1, options.runs // len(names))
        counts, finds = hunt(name, options.first, runs)
        total += runs
        found += finds
        print(
            f"{name:12} {runs:7} runs {time.perf_counter() - began:6.0f} s {json.dumps(counts)}", flush=True
        )
        kinds: dict[str, list[str]] = {}
        for find in finds:
            kinds.setdefault(find.partition(": ")[2][:60], []).append(find)
        for same in kinds.values():
            print(f"    {len(same)} x {same[0]}", flush=True)
    print(f"{total} runs, {len(found)} finds")
    return 1 if found else 0
