"""Benchmark: what sheaths cost a step and a simulation, beside what one could use instead."""

from tendon_mj.verification.benchmark.benchmark import Benchmark as Benchmark
from tendon_mj.verification.benchmark.benchmark import run_benchmark as run_benchmark
