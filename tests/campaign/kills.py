#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""kill -9 at random moments of every long stage, on a small dataset made here: a run loses at most what it was on, and what
comes out in the end is what an undisturbed run gives.

    kills.py BUILD SMOKE [--kills 100] [--seed 1] [--stages NAME...]

SMOKE: a folder with the template.h5 and skins.h5 of a run of make (out/smoke). Exit code 1 where a killed run ends
differently."""
import argparse
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

import h5py  # Debian's python3-h5py

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "pipeline"))
from dataset_files import Dataset, differing_dataset, difference, run


def differing_but_seconds(one, other):
    """Of two models or motions, whatever they say of the time they took."""
    return differing_dataset(one, other, lambda name: "seconds" in name)


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
            try:
                code = process.wait(rng.uniform(0.01, duration * (0.2 + 0.01 * done)))
                if code != 0:
                    return f"ended by itself with {code} after {done} kills", done, rounds
            except subprocess.TimeoutExpired:
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


def subset(source, target, count):
    """The first bodies of a file of skins."""
    with h5py.File(source, "r") as old, h5py.File(target, "w") as new:
        for name, value in old.attrs.items():
            new.attrs[name] = value
        for name in old:
            old.copy(name, new)
        total = len(new["bodies/names"])
        for name, item in list(new["bodies"].items()):
            if isinstance(item, h5py.Dataset) and item.shape and item.shape[0] == total:
                values, attributes = item[:count], dict(item.attrs)
                del new["bodies"][name]
                new["bodies"].create_dataset(name, data=values, dtype=item.dtype).attrs.update(attributes)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("smoke")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--stages", nargs="*", help="only these")
    options = parser.parse_args()
    failed = False
    with tempfile.TemporaryDirectory(prefix="ndg-kills-") as folder:
        data = Dataset(options.build, folder)
        files = [part for name in ("template", "bodies", "poses") for part in (f"--{name}", f"{folder}/{name}.h5")]
        samples, space, scans = f"{folder}/samples.h5", f"{folder}/shape-space.h5", f"{folder}/scans"
        template, skins = f"{options.smoke}/template.h5", f"{folder}/skins.h5"
        subset(f"{options.smoke}/skins.h5", skins, 4)
        for command in (data.simulate_command(samples),
                        [f"{data.bin}/fit-shape-space", *files[:4], "--splits", data.splits, "--output", space],
                        [f"{data.bin}/simulate-scans", "--template", template, "--skins", skins, "--scans", scans, "--people",
                         f"{folder}/people.json", "--output", f"{folder}/truth.h5"]):
            code, text = run(command)
            assert code == 0, text

        def tool(name, *arguments):
            return lambda output: [f"{data.bin}/{name}", *arguments, "--threads", "1", "--output", output]

        stages = [Stage("simulate-fem", tool("simulate-fem", *files, "--splits", data.splits), difference),
                  Stage("simulate-dynamics", tool("simulate-dynamics", "--model", "layered", *files, "--bone-wrap", "lbs",
                                                  "--frames-per-block", "2", "--hold", "0.5"), differing_but_seconds),
                  Stage("sample-bodies", tool("sample-bodies", "--template", template, "--count", "6"), differing_dataset),
                  Stage("build-layers", tool("build-layers", "--template", template, "--skins", skins, "--keep-outside"),
                        differing_dataset),
                  Stage("fit-body", tool("fit-body", "--template", template, "--scan", scans, "--rounds", "1", "--iterations", "2",
                                         "--max-points", "2000", "--keep-failed", "--min-passed", "0"), differing_dataset),
                  Stage("train-ndg", tool("train-ndg", *files, "--samples", samples, "--shape-space", space, "--widths", "64,64",
                                          "--epochs", "200", "--checkpoint-seconds", "0.2"), differing_but_seconds)]
        stages = [stage for stage in stages if not options.stages or stage.name in options.stages]
        print("| stage | kills | runs brought to their end | outcome |\n|---|---|---|---|", flush=True)
        for stage in stages:
            # Of their own, so that a stage alone is killed as among all.
            rng = random.Random(f"{options.seed}/{stage.name}")
            wrong, kills, rounds = stage.campaign(folder, -(-options.kills // len(stages)), rng)
            failed |= bool(wrong)
            print(f"| {stage.name} | {kills} | {rounds} | {wrong or 'the same as undisturbed'} |", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
