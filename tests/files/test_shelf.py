"""The shelf of results: kept by content, whole or not there, bounded."""

import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from surftex.files import shelf


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.setenv("SURFTEX_CACHE_DIR", str(tmp_path))


def arrays(count=4):
    table = np.zeros(count, [("face", "i4"), ("barycentric", "f8", 3)])
    table["face"] = np.arange(count)
    return {"cell": table, "told": np.frombuffer(b"{}", np.uint8)}


def test_what_is_kept_comes_back():
    assert shelf.kept("ab") is None
    shelf.keep("ab", arrays())
    found = shelf.kept("ab")
    assert found is not None
    for name, array in arrays().items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array)
    assert shelf.held()[0] == 1
    assert shelf.clear() == 1
    assert shelf.kept("ab") is None
    assert not shelf.folder().exists()


DAMAGE = {
    "cut": lambda data: data[:-1],
    "short": lambda data: data[:40],
    "empty": lambda data: b"",
    "changed": lambda data: data[:-9] + bytes([data[-9] ^ 1]) + data[-8:],
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_damaged_results_are_thrown_away(damage):
    shelf.keep("ab", arrays())
    path = shelf.folder() / "ab"
    path.write_bytes(damage(path.read_bytes()))
    assert shelf.kept("ab") is None
    assert not path.exists()


def test_objects_are_never_unpickled():
    with pytest.raises(ValueError, match="pickle"):
        shelf.keep("ab", {"bad": np.array([{}], object)})
    assert shelf.kept("ab") is None


def test_the_longest_unused_go_when_it_is_full():
    most = 10 * 2000
    for i in range(6):
        shelf.keep(f"{i}", {"a": np.full(4000, i, np.uint8)}, most_bytes=most)
        os.utime(shelf.folder() / f"{i}", (i, i)) if (shelf.folder() / f"{i}").exists() else None
        if i == 3:
            assert shelf.kept("0") is not None  # used: now it is the newest
    assert shelf.held()[1] <= most
    assert shelf.kept("5") is not None
    assert shelf.kept("0") is not None
    assert shelf.kept("1") is None


def test_a_folder_that_cannot_be_written_keeps_nothing_and_says_nothing(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SURFTEX_CACHE_DIR", str(tmp_path / "file"))
    shelf.keep("ab", arrays())
    assert shelf.kept("ab") is None
    assert shelf.held() == (0, 0)
    assert shelf.clear() == 0
    with shelf.alone("ab"):
        pass


CROWD = """
import sys
import numpy as np
from surftex.files import shelf

for turn in range(40):
    number = (7 * turn + int(sys.argv[1])) % 12
    shelf.keep(f"{number:x}", {"a": np.full(2000, number, np.uint8)}, most_bytes=9000)
    for other in range(12):
        found = shelf.kept(f"{other:x}")
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
    shelf.keep("0", {"a": np.zeros(2000, np.uint8)}, most_bytes=9000)
    assert 0 < shelf.held()[1] <= 9000
    assert all(len(path.name) == 1 for path in shelf.folder().iterdir())


def test_who_wants_the_same_waits_and_finds_it():
    found = []

    def second():
        with shelf.alone("ab", waits.set):
            found.append(shelf.kept("ab"))

    waits = threading.Event()
    other = threading.Thread(target=second)
    with shelf.alone("ab"):
        other.start()
        assert waits.wait(30)
        assert not found
        shelf.keep("ab", arrays())
    other.join(30)
    assert found[0] is not None
    assert [path.name for path in shelf.folder().iterdir()] == ["ab"]
    with shelf.alone("cd"), shelf.alone("cd", patience_s=0.0):  # work that hangs elsewhere is not waited for
        pass


def test_who_waits_may_give_up():
    def give_up():
        raise InterruptedError

    with shelf.alone("ab"), pytest.raises(InterruptedError), shelf.alone("ab", give_up):
        pytest.fail("both are at it")
