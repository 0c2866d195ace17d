#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""kill -9 at random moments of every long stage, on a small dataset made here: a run loses at most what it was on, and what
comes out in the end is what an undisturbed run gives.

    kills.py BUILD [--kills 100] [--seed 1]

Exit code 1 where a killed run ends differently."""
import argparse
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "pipeline"))
from dataset_files import Dataset, differing_dataset, difference, run


def tensors_differ(one, other):
    """Of two models, whatever they say of the time they took."""
    name = differing_dataset(one, other)
    return "" if "seconds" in name else name


class Stage:
    """One resumable command; `--output` names what it makes."""

    def __init__(self, name, command, compare):
        self.name, self.command, self.compare = name, command, compare

    def campaign(self, folder, kills, rng):
        whole, killed = f"{folder}/{self.name}-whole.h5", f"{folder}/{self.name}-killed.h5"
        start = time.time()
        code, text = run(self.command(whole))
        if code != 0:
            return f"an undisturbed run ended with {code}: {text[-300:]}", 0, 0
        duration = time.time() - start
        done = rounds = 0
        while done < kills:
            process = subprocess.Popen(self.command(killed), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            # Longer and longer, so that runs that keep nothing until their end come to one.
            time.sleep(rng.uniform(0.01, duration * (0.2 + 0.01 * done)))
            process.kill()
            done += process.wait() == -9
            if os.path.exists(killed):  # finished: from the start again
                wrong = self.compare(whole, killed)
                if wrong:
                    return f"differs in {wrong} after {done} kills", done, rounds
                os.remove(killed)
                rounds += 1
        code, text = run(self.command(killed))
        if code != 0:
            return f"after {done} kills it ended with {code}: {text[-300:]}", done, rounds
        wrong = self.compare(whole, killed)
        left = [name for name in os.listdir(folder) if name.startswith(f"{self.name}-killed.h5.")]
        return wrong and f"differs in {wrong}" or left and f"leaves {left}" or "", done, rounds + 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = random.Random(options.seed)
    failed = False
    with tempfile.TemporaryDirectory(prefix="ndg-kills-") as folder:
        data = Dataset(options.build, folder)
        files = [part for name in ("template", "bodies", "poses") for part in (f"--{name}", f"{folder}/{name}.h5")]
        samples, space = f"{folder}/samples.h5", f"{folder}/shape-space.h5"
        for command in (data.simulate_command(samples),
                        [f"{data.bin}/fit-shape-space", *files[:4], "--splits", data.splits, "--output", space]):
            code, text = run(command)
            assert code == 0, text
        train = [f"{data.bin}/train-ndg", *files, "--samples", samples, "--shape-space", space, "--widths", "64,64", "--epochs",
                 "200", "--threads", "1", "--checkpoint-seconds", "0.2", "--output"]
        stages = [Stage("simulate-fem", lambda output: data.simulate_command(output, "--threads", "1"), difference),
                  Stage("sample-bodies", lambda output: [f"{data.bin}/sample-bodies", "--template", f"{folder}/procedural.h5", "--source",
                                                         "procedural", "--count", "6", "--threads", "1", "--output", output],
                        differing_dataset),
                  Stage("train-ndg", lambda output: [*train, output], tensors_differ)]
        # Bodies are drawn in a template's tessellation; tubes have no source.
        code, text = run([f"{data.bin}/make-template", "--source", "procedural", "--edge-length", "0.06", "--output", f"{folder}/procedural.h5"])
        if code != 0:
            print("sample-bodies is left out: " + text.strip()[-200:])
            stages.pop(1)
        print("| stage | kills | runs brought to their end | outcome |\n|---|---|---|---|")
        for stage in stages:
            wrong, kills, rounds = stage.campaign(folder, options.kills // len(stages) + 1, rng)
            failed |= bool(wrong)
            print(f"| {stage.name} | {kills} | {rounds} | {wrong or 'the same as undisturbed'} |", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
