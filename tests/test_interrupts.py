"""Ctrl-C at a bad moment: it waits, and is not lost."""

import signal
import threading
from contextlib import suppress
from typing import Any

import pytest

from surftex.interrupts import calm, undisturbed
from surftex.kernels.jit import kernel


def test_an_interrupt_waits_for_the_end_of_the_block():
    done = []

    def work():
        with undisturbed("all is there"):
            signal.raise_signal(signal.SIGINT)
            done.append(True)

    with pytest.raises(KeyboardInterrupt, match="all is there"):
        work()
    assert done
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_blocks_in_blocks_wait_for_the_outermost():
    done = []

    def work():
        with undisturbed():
            with undisturbed():
                signal.raise_signal(signal.SIGINT)
            done.append(True)

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done


def test_other_threads_have_nothing_to_wait_for():
    done = []

    def work():
        with undisturbed():
            done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done


def test_a_thread_that_ends_the_process_waits_for_the_end_of_the_block():
    seen = []

    def end(seconds):
        with calm(seconds) as free:
            seen.append((free, list(done)))

    done = []
    ending, impatient = threading.Thread(target=end, args=(20,)), threading.Thread(target=end, args=(0.01,))
    with undisturbed(), undisturbed():
        ending.start()
        impatient.start()
        impatient.join()
        done.append(True)
    ending.join()
    assert seen == [(False, []), (True, [True])]


def test_a_kernel_is_loaded_or_compiled_to_its_end(monkeypatch):
    compiled: Any = kernel(lambda x: x + 1)

    def interrupted(*_):
        with suppress(KeyboardInterrupt):  # as the compiler does where it calls back to Python
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(compiled._cache, "load_overload", interrupted)
    with pytest.raises(KeyboardInterrupt):
        compiled(1)
    assert compiled(1) == 2
