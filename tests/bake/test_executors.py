"""Workers of a cluster: whom one talks to, and what is said when they go."""

import socket
import time

import pytest

from surftex.bake.executors import PATIENCE_S, ClusterWorkers, cluster_workers, given_up
from surftex.errors import InputError, WorkError


class Cluster:
    """A client whose scheduler lives, and whose workers come and go."""

    status = "running"

    def __init__(self):
        self.workers = {"tcp://far:1": 1}

    def get_executor(self, pure):
        return self

    def nthreads(self):
        return self.workers


def test_a_cluster_without_workers_is_told_of_and_given_up_after_a_while():
    cluster, lines, now = Cluster(), [], [0.0]
    workers = ClusterWorkers(cluster, "tcp://far:8786", 1, lines.append, lambda: now[0])

    def lost_at(seconds):
        now[0] = seconds
        return workers.lost()

    assert lost_at(10.0) is None
    assert not lines
    cluster.workers = {}
    assert lost_at(20.0) is None
    assert lost_at(30.0) is None
    assert len(lines) == 1
    assert "tcp://far:8786 has no workers any more" in lines[0]
    cluster.workers = {"tcp://far:2": 1}
    assert lost_at(40.0) is None
    assert lines[1:] == ["workers are there again after 20 s"]
    cluster.workers = {}
    assert lost_at(50.0) is None
    assert lost_at(45.0 + PATIENCE_S) is None
    assert lost_at(50.0 + PATIENCE_S) == "the scheduler at tcp://far:8786 has had no workers for 60 s"


@pytest.mark.parametrize(
    "address",
    ["notanaddress:xx", "localhost", "tcp://localhost", "http://localhost:8787", ":8786", "[::1:8786", ""],
)
def test_what_is_no_address_of_a_scheduler_is_refused_at_once(address):
    pytest.importorskip("distributed")
    began = time.monotonic()
    with pytest.raises(InputError, match="no address of a scheduler; it takes one such as"):
        cluster_workers(address).__enter__()
    assert time.monotonic() - began < 5.0


def test_an_address_where_nobody_listens_is_told_at_once():
    pytest.importorskip("distributed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{free.getsockname()[1]}"
        began = time.monotonic()
        with pytest.raises(WorkError, match=f"no scheduler answers at {address}"):
            cluster_workers(address).__enter__()
        assert time.monotonic() - began < 5.0


def test_a_job_that_every_worker_died_of_is_told_apart():
    distributed = pytest.importorskip("distributed")
    assert given_up(distributed.KilledWorker("job", None, 3))
    assert not given_up(OSError("disk"))
