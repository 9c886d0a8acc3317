"""Output appears whole or not at all, and never at the cost of what was there."""

import hashlib
import os
import shutil
import signal

import pytest

from surftex.errors import InputError, WorkError
from surftex.files import output
from surftex.files.output import check_output, file_hashes, whole_output


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
    with pytest.raises(InputError, match=r"holds 1 of the files to write; the first is b.*--overwrite"):
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


@pytest.mark.parametrize("which", range(4))
def test_a_failure_while_files_appear_puts_all_back(tmp_path, monkeypatch, which):
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


def test_a_folder_without_leave_to_write_is_told_in_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(WorkError, match="cannot write in") as caught:
        check_output(tmp_path / "a" / "out")
    assert "\n" not in str(caught.value)
    monkeypatch.undo()
    assert check_output(tmp_path / "a" / "out") == tmp_path / "a" / "out"
    assert list(tmp_path.iterdir()) == []


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
