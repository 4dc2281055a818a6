"""What is used of dask-jobqueue.

A module of it takes SIGINT over when it is imported, which only a main thread may do, and which would hide how a run is
interrupted here: so it is not heard.
"""

import signal

_listen, signal.signal = signal.signal, lambda number, handler: handler
try:
    from dask_jobqueue.slurm import SLURMCluster, SLURMJob
finally:
    signal.signal = _listen

__all__ = ["SLURMCluster", "SLURMJob"]
