"""Benchmark: what sheaths cost a step and a simulation, beside what one could use instead."""

from experiments.benchmarks.benchmark import Benchmark as Benchmark
from experiments.benchmarks.benchmark import run_benchmark as run_benchmark
