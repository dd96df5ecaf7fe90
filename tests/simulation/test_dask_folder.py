"""Where the Dask workers of this machine keep their files: in a folder that goes with this process."""

from contextlib import nullcontext
from pathlib import Path

import pytest

from flexmodels import scratch
from pyident.simulation.processes.dask_cluster import dask_cluster

pytest.importorskip("distributed", reason="Dask is not installed")


def test_the_workers_folder_is_a_scratch_folder_and_is_gone_afterwards():
    with dask_cluster(count=1) as cluster, cluster.holding(nullcontext) as processes:
        place = processes.submit(_folder).result()
        assert place.is_dir()
        assert set(place.parents) & set(scratch._roots.values())  # which a janitor removes after a kill
    assert not place.parents[1].exists()


def _folder(_: None) -> Path:
    from distributed import get_worker

    return Path(get_worker().local_directory)
