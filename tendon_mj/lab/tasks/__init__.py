"""Many independent tasks on this machine's cores, on local Dask workers, or on a Dask scheduler."""

from tendon_mj.lab.tasks.parquet_parts import ParquetParts as ParquetParts
from tendon_mj.lab.tasks.workers import Workers as Workers
from tendon_mj.lab.tasks.workers import local_cluster as local_cluster
from tendon_mj.lab.tasks.workers import run_tasks as run_tasks
from tendon_mj.lab.tasks.workers import versions as versions
