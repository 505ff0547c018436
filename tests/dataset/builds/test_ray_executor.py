"""A Ray cluster of two nodes on this machine, one of which is killed on the way: the same bytes."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from glassware.dataset.commands.build_dataset import main

#: A cluster of two nodes: prints its address, kills the second node at the first line of its input, ends at the next.
CLUSTER = """
import sys
from ray.cluster_utils import Cluster
cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
second = cluster.add_node(num_cpus=1)
cluster.wait_for_nodes()
print(cluster.address, flush=True)
sys.stdin.readline()
cluster.remove_node(second, allow_graceful=False)
print("killed", flush=True)
sys.stdin.readline()
cluster.shutdown()
"""


@pytest.fixture
def cluster():
    """A running cluster of two nodes of one core each."""
    pytest.importorskip("ray", reason="the extra ray is not installed")
    child = subprocess.Popen(
        [sys.executable, "-P", "-c", CLUSTER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "RAY_USAGE_STATS_ENABLED": "0"},
        text=True,
    )
    yield child
    child.communicate("\n\n", timeout=60)


@pytest.mark.slow
def test_a_cluster_that_loses_a_node_makes_the_same_bytes(
    builds, undisturbed, content, hidden, tmp_path, cluster, cleared
):
    address = cluster.stdout.readline().strip()
    child = builds.started(tmp_path / "data", "--executor", "ray", "--address", address, "--threads", 1)
    cleared(child)
    while not (line := child.stdout.readline()).startswith("scene "):
        assert line, child.stderr.read()
    cluster.stdin.write("\n")
    cluster.stdin.flush()
    assert cluster.stdout.readline() == "killed\n"
    told, errors = child.communicate(timeout=300)
    assert child.returncode == 0, told + errors
    assert content(tmp_path / "data") == content(undisturbed)
    assert hidden(tmp_path / "data") == []


@pytest.mark.slow
def test_a_cluster_that_is_not_there_is_one_line(builds, tmp_path):
    pytest.importorskip("ray", reason="the extra ray is not installed")
    ended = builds.run(tmp_path / "data", "--executor", "ray", "--address", "127.0.0.1:1")
    assert ended.returncode == 2, ended.stderr
    assert "--address: expected a running Ray cluster" in ended.stderr


def test_without_ray_the_command_says_what_to_install(builds, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    assert main(builds.arguments(tmp_path / "data", "--executor", "ray")) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--executor ray: expected the extra ray installed" in line
