"""What is used of dask-jobqueue, a module of which takes SIGINT over when it is imported."""

from pipeline.run.processes import signals_left_alone

with signals_left_alone():
    from dask_jobqueue.slurm import SLURMCluster, SLURMJob

__all__ = ["SLURMCluster", "SLURMJob"]
