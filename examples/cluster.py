"""
A plane on a dask cluster
=========================

*My plane is large, and I have a cluster whose workers come and go. What do I write?*
"""

# %%
# Any dask cluster will do: here one of processes of this machine, which stands in for ``SLURMCluster`` or
# ``KubeCluster``. It has no worker until there is work, then up to two, each with one thread.

from dask.distributed import SubprocessCluster

cluster = SubprocessCluster(n_workers=0, worker_kwargs={"nthreads": 1}, scheduler_kwargs={"dashboard": False})
scaling = cluster.adapt(minimum=0, maximum=2)
print(len(cluster.workers), "workers")

# %%
# A run needs the address alone. It waits for the first worker; workers write what they computed into the store
# themselves, so the store must have the same path everywhere. What a lost worker had under way, another does again.

import pipeline

sizes = ["plane.sweep.num=160", "plane.parameter.num=40"]
where = ["cluster=scheduler", f"cluster.address={cluster.scheduler_address}", "store.name=by_workers"]
by_workers = pipeline.compute("omega_fe", [*sizes, *where])
print([step["status"] for _, step in scaling.log][:1], "when the work came")

# %%
# Do results depend on who computed them? No: a worker whose program or arithmetic would make another digit is not used,
# and the run says so. The same plane, computed here alone, is the same to the last bit:

import xarray as xr

alone = pipeline.compute("omega_fe", [*sizes, "cluster=none", "store.name=alone"])
stores = [xr.open_zarr(plane.path).load() for plane in (by_workers, alone)]
print("equal:", stores[0].equals(stores[1]))

# %%
# Close the cluster when nothing more is to be computed. Before it is one that others can reach, read
# :doc:`/how-to/cluster`: whoever reaches a scheduler runs code there.

cluster.close()
