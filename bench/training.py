#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Training steps of this project against the same network and batch in Python (Debian's python3-torch), in turn.

training.py <folder of bench_training> [--prisms 15000] [--rounds 5] [--steps 3] [--threads 2]

Rows: Python as installed (no setting touched), Python at its best (all threads, OpenBLAS told which kernels fit the
processor, the faster of float32 and bfloat16 autocast), ours in float32 and in bfloat16. Both run LayerNorm, GELU, nine
numbers a prism, the matrix exponential (or none: --parametrisation direct), mean squared error and AdamW. Each round runs
every row once, so that a machine that is shared slows all of them; medians of rounds and of ratios within rounds.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys


def python_steps(arguments):
    import resource
    import time

    import torch

    if arguments.set_threads:
        torch.set_num_threads(arguments.threads)
    torch.manual_seed(1)

    class ToFloat(torch.nn.Module):  # LayerNorm of this version takes no bfloat16 with float32 weights
        def forward(self, values):
            return values.float()

    layers, width = [], 840
    for hidden in (4096, 4096, 600):
        layers += [torch.nn.Linear(width, hidden), ToFloat(), torch.nn.LayerNorm(hidden), torch.nn.GELU()]
        width = hidden
    last = torch.nn.Linear(width, 9 * arguments.prisms)
    torch.nn.init.zeros_(last.weight)
    torch.nn.init.zeros_(last.bias)
    network = torch.nn.Sequential(*layers, last)
    optimizer = torch.optim.AdamW(network.parameters(), lr=1.3e-3, weight_decay=0.01)
    inputs = 0.3 * torch.randn(32, 840)
    identity = torch.eye(3).reshape(1, 1, 9)
    targets = (0.1 * torch.randn(32, arguments.prisms, 9) + identity).reshape(32, -1)

    def step():
        with torch.autocast("cpu", torch.bfloat16, enabled=arguments.autocast):
            outputs = network(inputs)
        outputs = outputs.float().reshape(32, -1, 9)
        if arguments.parametrisation == "exponential":
            residuals = torch.matrix_exp(outputs.reshape(-1, 3, 3))
        else:
            residuals = outputs + identity
        loss = torch.nn.functional.mse_loss(residuals.reshape(32, -1), targets)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        optimizer.step()

    def processor():
        usage = resource.getrusage(resource.RUSAGE_SELF)
        return usage.ru_utime + usage.ru_stime

    step()
    wall, core = time.perf_counter(), processor()
    for _ in range(arguments.steps):
        step()
    wall, core = time.perf_counter() - wall, processor() - core
    print(json.dumps({"seconds": wall / arguments.steps, "core_seconds": core / arguments.steps,
                      "threads": torch.get_num_threads()}))


def openblas_core_type():
    with open("/proc/cpuinfo") as file:
        flags = next((line for line in file if line.startswith("flags")), "").split()
    return "SkylakeX" if {"avx512f", "avx512bw", "avx512dq", "avx512vl"} <= set(flags) else "Haswell"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", nargs="?", default="build/release/bin")
    parser.add_argument("--prisms", type=int, default=15000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=3)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--parametrisation", choices=("exponential", "direct"), default="exponential")
    parser.add_argument("--autocast", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--set-threads", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--in-python", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.in_python:
        return python_steps(arguments)

    common = ["--prisms", str(arguments.prisms), "--steps", str(arguments.steps), "--threads", str(arguments.threads),
              "--parametrisation", arguments.parametrisation]

    def in_python(extra, environment):
        command = [sys.executable, __file__, "--in-python", *common, *extra]
        result = subprocess.run(command, check=True, capture_output=True, text=True,
                                env={**os.environ, **environment}).stdout
        figures = json.loads(result.strip().splitlines()[-1])
        return figures["seconds"], figures["core_seconds"]

    def ours(precision):
        command = [os.path.join(arguments.bin, "bench_training"), "--prism-count", str(arguments.prisms),
                   "--step-count", str(arguments.steps), "--threads", str(arguments.threads), "--precision", precision,
                   "--parametrisation", arguments.parametrisation]
        result = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        figures = json.loads(result.strip().splitlines()[-1])["metrics"]
        return figures["seconds_a_step"], figures["core_seconds_a_step"]

    tuned = {"OPENBLAS_CORETYPE": openblas_core_type(), "OPENBLAS_NUM_THREADS": str(arguments.threads),
             "OMP_NUM_THREADS": str(arguments.threads)}
    rows = {"Python, float32 as installed": lambda: in_python([], {}),
            "Python, float32, tuned": lambda: in_python(["--set-threads"], tuned),
            "Python, bfloat16 autocast, tuned": lambda: in_python(["--set-threads", "--autocast"], tuned),
            "ours, float32": lambda: ours("float32"),
            "ours, bfloat16": lambda: ours("bfloat16")}
    measured = {name: [] for name in rows}
    for _ in range(arguments.rounds):
        for name, run in list(rows.items()):
            try:
                measured[name].append(run())
            except subprocess.CalledProcessError as error:
                print(f"{name}: {error.stderr.strip().splitlines()[-1]}", file=sys.stderr)
                del rows[name], measured[name]

    def median(name, part):
        return statistics.median(figures[part] for figures in measured[name])

    def ratio(numerators, name, part):
        return statistics.median(min(measured[n][i][part] for n in numerators) / measured[name][i][part]
                                 for i in range(arguments.rounds))

    best = [name for name in measured if name.startswith("Python")]
    print(f"{arguments.prisms} prisms, batch 32, 4096-4096-600, {arguments.parametrisation}, {arguments.threads} threads")
    print("| | seconds a step | core-seconds a step | samples a second |\n|---|---|---|---|")
    for name in measured:
        print(f"| {name} | {median(name, 0):.3f} | {median(name, 1):.3f} | {32 / median(name, 0):.0f} |")
    for name in measured:
        if name.startswith("ours"):
            print(f"{name}: {ratio(best[:1], name, 0):.2f} times as fast as Python as installed, "
                  f"{ratio(best, name, 0):.2f} times its best setting (core-seconds: {ratio(best[:1], name, 1):.2f} and "
                  f"{ratio(best, name, 1):.2f})")


if __name__ == "__main__":
    main()
