"""The shelf of results: kept by content, whole or not there, bounded."""

import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from surftex.files import shelf

AB, CD = "ab" * 32, "cd" * 32


def key(number):
    return f"{number:064x}"


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.setenv("SURFTEX_CACHE_DIR", str(tmp_path))


def arrays(count=4):
    table = np.zeros(count, [("face", "i4"), ("barycentric", "f8", 3)])
    table["face"] = np.arange(count)
    return {"cell": table, "told": np.frombuffer(b"{}", np.uint8)}


def test_what_is_kept_comes_back():
    assert shelf.kept(AB) is None
    shelf.keep(AB, arrays())
    found = shelf.kept(AB)
    assert found is not None
    for name, array in arrays().items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array)
    assert shelf.held()[0] == 1
    assert shelf.clear() == 1
    assert shelf.kept(AB) is None
    assert not shelf.folder().exists()


DAMAGE = {
    "cut": lambda data: data[:-1],
    "short": lambda data: data[:40],
    "empty": lambda data: b"",
    "changed": lambda data: data[:-9] + bytes([data[-9] ^ 1]) + data[-8:],
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_damaged_results_are_thrown_away(damage):
    shelf.keep(AB, arrays())
    path = shelf.folder() / AB
    path.write_bytes(damage(path.read_bytes()))
    assert shelf.kept(AB) is None
    assert not path.exists()


def test_objects_are_never_unpickled():
    with pytest.raises(ValueError, match="pickle"):
        shelf.keep(AB, {"bad": np.array([{}], object)})
    assert shelf.kept(AB) is None


def test_the_longest_unused_go_when_it_is_full():
    most = 10 * 2000
    for i in range(6):
        shelf.keep(key(i), {"a": np.full(4000, i, np.uint8)}, most_bytes=most)
        os.utime(shelf.folder() / key(i), (i, i)) if (shelf.folder() / key(i)).exists() else None
        if i == 3:
            assert shelf.kept(key(0)) is not None  # used: now it is the newest
    assert shelf.held()[1] <= most
    assert shelf.kept(key(5)) is not None
    assert shelf.kept(key(0)) is not None
    assert shelf.kept(key(1)) is None


def test_files_of_others_are_neither_counted_nor_deleted():
    shelf.folder().mkdir()
    others = [shelf.folder() / name for name in ("thesis.txt", "draft-of-my-thesis", "ab", f"{AB}.txt")]
    for path in others:
        path.write_bytes(b"precious" * 1000)
        os.utime(path, (1, 1))
    shelf.keep(AB, {"a": np.zeros(4000, np.uint8)}, most_bytes=4 * 4000)
    shelf.keep(CD, {"a": np.zeros(4000, np.uint8)}, most_bytes=2 * 4000)
    shelf.keep(CD, {"a": np.zeros(1000, np.uint8)}, most_bytes=4000)
    count, size = shelf.held()
    assert count == 1
    assert size < 4000
    (shelf.folder() / "draft-a1b2c3_4").write_bytes(b"left by a dead process")
    (shelf.folder() / f"{AB}.lock").touch()
    assert shelf.clear() == 3
    assert sorted(shelf.folder().iterdir()) == sorted(others)


def test_a_folder_that_cannot_be_written_keeps_nothing_and_says_nothing(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SURFTEX_CACHE_DIR", str(tmp_path / "file"))
    shelf.keep(AB, arrays())
    assert shelf.kept(AB) is None
    assert shelf.held() == (0, 0)
    assert shelf.clear() == 0
    with shelf.alone(AB):
        pass


CROWD = """
import sys
import numpy as np
from surftex.files import shelf

for turn in range(40):
    number = (7 * turn + int(sys.argv[1])) % 12
    shelf.keep(f"{number:064x}", {"a": np.full(2000, number, np.uint8)}, most_bytes=9000)
    for other in range(12):
        found = shelf.kept(f"{other:064x}")
        assert found is None or (len(found["a"]) == 2000 and (found["a"] == other).all())
    if turn == 20 and sys.argv[1] == "0":
        shelf.clear()
"""


def test_many_processes_share_a_shelf():
    crowd = [
        subprocess.Popen([sys.executable, "-c", CROWD, str(i)], stderr=subprocess.PIPE, text=True)
        for i in range(3)
    ]
    for process in crowd:
        _, said = process.communicate(timeout=120)
        assert process.returncode == 0, said
    shelf.keep(key(0), {"a": np.zeros(2000, np.uint8)}, most_bytes=9000)
    assert 0 < shelf.held()[1] <= 9000
    assert all(len(path.name) == 64 for path in shelf.folder().iterdir())


def test_who_wants_the_same_waits_and_finds_it():
    found = []

    def second():
        with shelf.alone(AB, waits.set):
            found.append(shelf.kept(AB))

    waits = threading.Event()
    other = threading.Thread(target=second)
    with shelf.alone(AB):
        other.start()
        assert waits.wait(30)
        assert not found
        shelf.keep(AB, arrays())
    other.join(30)
    assert found[0] is not None
    assert [path.name for path in shelf.folder().iterdir()] == [AB]
    with shelf.alone(CD), shelf.alone(CD, patience_s=0.0):  # work that hangs elsewhere is not waited for
        pass


def test_who_waits_may_give_up():
    def give_up():
        raise InterruptedError

    with shelf.alone(AB), pytest.raises(InterruptedError), shelf.alone(AB, give_up):
        pytest.fail("both are at it")
