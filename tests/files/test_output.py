"""Output appears whole or not at all, and never at the cost of what was there."""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from surftex.errors import InputError, WorkError
from surftex.files import locks, output, publishing
from surftex.files.output import check_output, check_place, file_hashes, whole_output, write_whole


def contents(folder):
    return {str(p.relative_to(folder)): p.read_text() for p in sorted(folder.rglob("*")) if p.is_file()}


def written(folder, names=("a", "b"), text="new", **options):
    with whole_output(folder, **options) as place:
        for name in names:
            (place / name).write_text(text)


def test_appears_whole_in_a_new_folder(tmp_path):
    written(tmp_path / "deep" / "out")
    assert contents(tmp_path) == {"deep/out/a": "new", "deep/out/b": "new"}
    assert list(tmp_path.iterdir()) == [tmp_path / "deep"]
    expected = hashlib.sha256(b"new").hexdigest()
    assert file_hashes(tmp_path / "deep" / "out") == {"a": expected, "b": expected}


def test_new_files_have_ordinary_rights(tmp_path):
    written(tmp_path / "out")
    (tmp_path / "plain").mkdir()
    (tmp_path / "plain" / "a").write_text("")
    assert (tmp_path / "out").stat().st_mode == (tmp_path / "plain").stat().st_mode
    assert (tmp_path / "out" / "a").stat().st_mode == (tmp_path / "plain" / "a").stat().st_mode


def test_replaces_only_when_told_and_leaves_others(tmp_path):
    (tmp_path / "b").write_text("old")
    (tmp_path / "mine").write_text("keep")
    with pytest.raises(InputError, match=r"holds b already\. Choose another.*--overwrite"):
        written(tmp_path)
    assert contents(tmp_path) == {"b": "old", "mine": "keep"}
    written(tmp_path, overwrite=True)
    assert contents(tmp_path) == {"a": "new", "b": "new", "mine": "keep"}


def interrupted(folder, failure):
    with whole_output(folder, overwrite=True) as place:
        (place / "a").write_text("half")
        raise failure


def on_a_full_disk(folder):
    with whole_output(folder) as place:
        (place / "a").symlink_to("/dev/full")
        (place / "a").write_text("x")


class Stopped(BaseException):
    pass


@pytest.mark.parametrize("failure", [KeyboardInterrupt, Stopped, ValueError])
def test_a_failure_leaves_nothing(tmp_path, failure):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "a").write_text("old")
    for folder in (tmp_path / "out", tmp_path / "new" / "out"):
        with pytest.raises(failure):
            interrupted(folder, failure)
    assert contents(tmp_path) == {"out/a": "old"}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out"]


def without_exchange(monkeypatch):
    def refuse(*folders):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(publishing, "_exchange", refuse)


@pytest.fixture(params=["exchanged", "moved"])
def _by_either_way(request, monkeypatch):
    if request.param == "moved":
        without_exchange(monkeypatch)


@pytest.mark.usefixtures("_by_either_way")
def test_other_files_stay_and_rights_too(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir(mode=0o751)
    (folder / "b").write_text("old")
    (folder / "mine").write_text("keep")
    kept = (folder / "mine").stat().st_ino
    written(folder, overwrite=True)
    assert contents(tmp_path) == {"out/a": "new", "out/b": "new", "out/mine": "keep"}
    assert folder.stat().st_mode & 0o777 == 0o751
    assert (folder / "mine").stat().st_ino == kept
    (folder / "deep").mkdir()
    (folder / "deep" / "own").write_text("keep")
    written(folder, text="newer", overwrite=True)
    assert contents(folder) == {"a": "newer", "b": "newer", "mine": "keep", "deep/own": "keep"}
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.usefixtures("_by_either_way")
def test_files_that_come_at_the_last_moment_stay(tmp_path, monkeypatch):
    """They come between the look at the folder and its exchange."""
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "mine").write_text("keep")
    plain = publishing.shutil.copystat

    def late(*arguments):
        plain(*arguments)
        (folder / "late").write_text("keep")
        (folder / "other").write_text("newer")
        (folder / "other").replace(folder / "mine")

    monkeypatch.setattr(publishing.shutil, "copystat", late)
    written(folder)
    assert contents(folder) == {"a": "new", "b": "new", "mine": "newer", "late": "keep"}
    with pytest.raises(InputError, match=r"holds [ab] and others of the files to write already\."):
        written(folder, text="again")

    def too_late(*arguments):
        plain(*arguments)
        (folder / "c").write_text("theirs")

    monkeypatch.setattr(publishing.shutil, "copystat", too_late)
    with pytest.raises(InputError, match=r"holds c already"):
        written(folder, names="cd")
    assert contents(folder) == {"a": "new", "b": "new", "mine": "newer", "late": "keep", "c": "theirs"}
    assert list(tmp_path.iterdir()) == [folder]


KILLED = """
import os, signal, sys
from pathlib import Path
from surftex.files import output, publishing, workplace

way, calls = sys.argv[1], []

def watched(plain, moment):
    def call(*arguments, **more):
        if len(calls) == moment:
            os.kill(os.getpid(), signal.SIGKILL)
        calls.append(plain)
        return plain(*arguments, **more)
    return call

def refuse(*folders):
    raise OSError(38, "Function not implemented")

def write(moment):
    for owner, name in (
        (Path, "mkdir"), (Path, "rmdir"), (Path, "rename"), (Path, "touch"), (output, "_sync"), (workplace, "locked"),
        (publishing.shutil, "rmtree"),
    ):
        setattr(owner, name, watched(getattr(owner, name), moment))
    publishing._exchange = watched(publishing._exchange, moment) if way == "exchanged" else refuse
    with output.whole_output(f"{moment}/out", overwrite=True) as place:
        for name in "abc":
            (place / name).write_text("new")

for moment in range(99):
    folder = Path(f"{moment}/out")
    folder.mkdir(parents=True)
    for name in "abc":
        (folder / name).write_text("old")
    (folder / "mine").write_text("keep")
    child = os.fork()
    if child == 0:
        write(moment)
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    assert status in (0, signal.SIGKILL)
    if status == 0:
        break
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs an exchange in one step")
@pytest.mark.parametrize("way", ["exchanged", "moved"])
def test_who_is_killed_at_any_moment_leaves_one_output_or_the_other(tmp_path, way):
    """In one step never a mixture; moved one by one none that the next look at the folder does not mend."""
    done = subprocess.run([sys.executable, "-c", KILLED, way], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    old, new = ({**dict.fromkeys("abc", word), "mine": "keep"} for word in ("old", "new"))
    seen = []
    for place in sorted(tmp_path.iterdir(), key=lambda path: int(path.name)):
        if way == "exchanged":
            assert contents(place / "out") in (old, new)
        for probe in place.rglob(".surftex-*"):
            os.utime(probe, (0, 0))  # a young one may be a living process's
        check_output(place / "out")
        assert contents(place / "out") in (old, new)
        assert sorted(path.name for path in place.rglob("*")) == ["a", "b", "c", "mine", "out"]
        seen.append(contents(place / "out") == new)
    assert seen == sorted(seen)
    assert len(seen) == (20 if way == "exchanged" else 27)
    assert seen[-1]


def test_remains_of_the_living_and_folders_of_others_are_left_alone(tmp_path):
    for name in (".out-abcdefgh", ".out-short", ".out-x-abcdefgh", ".surftex-young___/out"):
        (tmp_path / name / "new").mkdir(parents=True)
    (tmp_path / ".surftex-notmine_").mkdir()
    (tmp_path / ".surftex-notmine_" / "letters").write_text("")
    os.utime(tmp_path / ".surftex-notmine_", (0, 0))
    (tmp_path / ".out-notmine_").mkdir()
    (tmp_path / ".out-notmine_" / "lock").write_text("")
    (tmp_path / ".out-notmine_" / "letters").write_text("")
    before = sorted(tmp_path.iterdir())
    with whole_output(tmp_path / "out") as place:
        check_output(tmp_path / "out")
        assert place.is_dir()
        assert len(list(tmp_path.iterdir())) == len(before) + 1
    assert sorted(tmp_path.iterdir()) == sorted([*before, tmp_path / "out"])


@pytest.mark.parametrize("inside", [False, True])
def test_a_folder_that_cannot_be_renamed_holds_its_workplace(tmp_path, monkeypatch, inside):
    folder = tmp_path / "out"
    folder.mkdir()
    monkeypatch.setattr(type(folder), "is_mount", lambda self: inside)
    with whole_output(folder) as place:
        assert place.parent.parent == (folder if inside else tmp_path)
        (place / "a").write_text("new")
    assert contents(tmp_path) == {"out/a": "new"}
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "a"]


def test_one_file_is_written_whole_and_drafts_of_the_dead_go(tmp_path):
    dead, young = tmp_path / ".m.json.0000.surftex-draft", tmp_path / ".m.json.1111.surftex-draft"
    for path in (dead, young):
        path.write_text("half")
    os.utime(dead, (0, 0))
    write_whole(tmp_path / "m.json", b"whole")
    assert contents(tmp_path) == {"m.json": "whole", young.name: "half"}
    os.utime(young, (0, 0))
    with locks.locked_where_possible(young):
        os.utime(young, (0, 0))
        write_whole(tmp_path / "m.json", b"again")
    assert contents(tmp_path) == {"m.json": "again", young.name: "half"}
    with pytest.raises(WorkError, match="cannot write"):
        write_whole(tmp_path / "none" / "m.json", b"")


@pytest.mark.parametrize("which", range(4))
def test_a_failure_while_files_appear_puts_all_back(tmp_path, monkeypatch, which):
    without_exchange(monkeypatch)
    folder = tmp_path / "out"
    folder.mkdir()
    for name in "ac":
        (folder / name).write_text("old")
    plain, calls = type(folder).rename, []

    def rename(self, target):
        calls.append(self)
        if len(calls) == which + 1:
            raise OSError(28, "No space left on device")
        return plain(self, target)

    monkeypatch.setattr(type(folder), "rename", rename)
    with pytest.raises(
        WorkError, match=r"out: cannot write: No space left on device; nothing was left there"
    ):
        written(folder, names="abc", overwrite=True)
    assert contents(tmp_path) == {"out/a": "old", "out/c": "old"}


def test_a_full_disk_is_told_in_a_line(tmp_path):
    with pytest.raises(WorkError, match="No space left on device") as caught:
        on_a_full_disk(tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_refuses_links_files_and_folders_in_the_way(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    (tmp_path / "file").write_text("keep")
    with pytest.raises(InputError, match="symbolic link"):
        written(tmp_path / "link")
    with pytest.raises(InputError, match="is a file"):
        written(tmp_path / "file")
    (tmp_path / "real" / "a").symlink_to(tmp_path / "file")
    with pytest.raises(InputError, match="link or a folder"):
        written(tmp_path / "real", overwrite=True)
    assert (tmp_path / "file").read_text() == "keep"


def test_a_folder_without_leave_to_write_is_told_in_a_line_and_before_any_work(tmp_path, monkeypatch):
    def refused(*what, **how):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "mkdir", refused)
    with pytest.raises(InputError, match=r"cannot write in .*: Permission denied; choose another") as caught:
        check_output(tmp_path / "a" / "out")
    assert "\n" not in str(caught.value)
    monkeypatch.undo()
    assert check_output(tmp_path / "a" / "out") == tmp_path / "a" / "out"
    assert list(tmp_path.iterdir()) == []


def test_folders_that_no_disk_can_make_are_refused_before_any_work(tmp_path):
    """Whether root may, a mode does not say: the disk is asked."""
    (tmp_path / "file").write_text("keep")
    (tmp_path / "gone").symlink_to(tmp_path / "nowhere")
    wrong = [
        tmp_path / "file" / "out",
        tmp_path / "gone" / "out",
        tmp_path / ("a" * 250),
        tmp_path / ("a" * 300),
    ]
    for folder in wrong + [Path("/proc/x/y")] * sys.platform.startswith("linux"):
        with pytest.raises(InputError, match=r"cannot write in .*; choose another folder"):
            check_output(folder)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "gone"]


def test_a_full_disk_is_no_fault_of_the_folder(tmp_path, monkeypatch):
    def full(*what, **how):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "mkdir", full)
    with pytest.raises(WorkError, match="No space left on device"):
        check_output(tmp_path / "out")


def test_folders_made_for_one_file_go_again_where_it_cannot_be_written(tmp_path, monkeypatch):
    write_whole(tmp_path / "a" / "b" / "one", b"1", parents=True)
    assert contents(tmp_path / "a" / "b") == {"one": "1"}

    def failing(path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(output, "_sync", failing)
    with pytest.raises(WorkError, match="No space left"):
        write_whole(tmp_path / "a" / "c" / "d" / "two", b"2", parents=True)
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["b"]


@pytest.fixture(params=[signal.SIGINT, signal.SIGTERM], ids=lambda each: each.name)
def request_to_end(request):
    """A signal, and what sends it to this process, where it is heard as in the command."""

    def listening(*told):
        raise KeyboardInterrupt

    usual = {each: signal.signal(each, listening) for each in (signal.SIGINT, signal.SIGTERM)}
    yield lambda: os.kill(os.getpid(), request.param)
    assert signal.getsignal(request.param) is listening
    for each, handler in usual.items():
        signal.signal(each, handler)


def test_a_request_to_end_waits_while_files_appear_and_is_obeyed_then(tmp_path, monkeypatch, request_to_end):
    publish = output._publish

    def disturbed(*arguments):
        request_to_end()
        publish(*arguments)
        request_to_end()

    monkeypatch.setattr(output, "_publish", disturbed)
    with pytest.raises(KeyboardInterrupt, match="out is written, and whole"):
        written(tmp_path / "out")
    assert contents(tmp_path) == {"out/a": "new", "out/b": "new"}
    assert list(tmp_path.iterdir()) == [tmp_path / "out"]


def test_a_request_to_end_while_the_workplace_goes_away_leaves_nothing(tmp_path, monkeypatch, request_to_end):
    remove = shutil.rmtree

    def disturbed(*arguments, **more):
        request_to_end()
        remove(*arguments, **more)

    def failing(*arguments):
        raise ValueError("the work fails")

    monkeypatch.setattr(shutil, "rmtree", disturbed)
    monkeypatch.setattr(output, "_publish", failing)
    with pytest.raises(KeyboardInterrupt):
        written(tmp_path / "deep" / "out")
    assert not list(tmp_path.iterdir())


def test_a_place_where_nothing_can_be_written_is_told_before_any_work(tmp_path):
    with pytest.raises(
        InputError, match=r"a.npz: cannot write in .*none \(No such file or directory\); choose another"
    ):
        check_place(tmp_path / "none" / "a.npz")
    (tmp_path / "b").write_text("keep")
    check_place(tmp_path / "b")
    check_place(tmp_path / "c")
    assert contents(tmp_path) == {"b": "keep"}


@pytest.mark.skipif(os.name != "posix", reason="modes are of POSIX")
@pytest.mark.parametrize("others", [0, 200])
def test_what_is_replaced_keeps_its_mode(tmp_path, others):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "a").write_text("old")
    for i in range(others):
        (folder / f"other{i}").touch()
    (folder / "a").chmod(0o600)
    folder.chmod(0o750)
    with whole_output(folder, overwrite=True) as workplace:
        (workplace / "a").write_text("new")
        (workplace / "b").write_text("new")
    write_whole(folder / "b", b"newer")
    (folder / "b").chmod(0o640)
    write_whole(folder / "b", b"newest")
    assert (folder / "a").read_text() == "new"
    modes = [path.stat().st_mode & 0o777 for path in (folder, folder / "a", folder / "b")]
    assert modes == [0o750, 0o600, 0o640]
