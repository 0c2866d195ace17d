#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Which stages make repeats when a preset changes, and what reaches training on a GPU: make itself with tools that only note
that they were called. make_stages.py SOURCE BUILD"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

failures = []
STUB = """#!/bin/bash
# The options of a stage are the real tool's; its work is left out.
for word in "$@"; do
  case "$word" in --print-config|--list-methods|--help) exec {real}/{name} "$@";; esac
done
while [ $# -gt 0 ]; do
  case "$1" in
    --output|--report|--range-of-motion|--picture|--page|--mesh|--anatomy|--external) mkdir -p "$(dirname "$2")"; echo "$2" > "$2"; shift;;
  esac
  shift
done
"""


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def main():
    source, build = (os.path.abspath(path) for path in sys.argv[1:3])
    environment = {k: v for k, v in os.environ.items() if not k.startswith("MAKE") and k != "MFLAGS"}
    with tempfile.TemporaryDirectory(prefix="ndg-stages-") as folder:
        stubs, out, config = pathlib.Path(folder, "build", "bin"), folder + "/out", folder + "/preset.json"
        stubs.mkdir(parents=True)
        for tool in os.listdir(build + "/bin"):
            stub = stubs / tool
            stub.write_text(STUB.format(real=build + "/bin", name=tool))
            stub.chmod(0o755)
        shutil.copy(source + "/configs/smoke.json", config)
        words = ["make", "-C", source, "PRESET=smoke", f"CONFIG={config}", f"BUILD={folder}/build", f"OUT={out}", "DATA="]
        tables = out + "/report/tables.json"

        def make(*arguments, **more):
            done = subprocess.run([*words, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                  env={**environment, **more}, check=False)
            if done.returncode != 0:
                print(done.stdout[-2000:])
            return done

        def stages():
            return re.findall(r"^== (?:\d+ of \d+, )?([a-z0-9-]+)", make(tables).stdout, re.M)

        def change(section, key, value):
            content = json.loads(pathlib.Path(config).read_text())
            if section:
                content.setdefault(section, {})[key] = value
            else:
                content[key] = value
            pathlib.Path(config).write_text(json.dumps(content))

        first = stages()
        check({"template", "simulate-fem", "train-ndg", "train-vertexnet", "ndg", "evaluate-metrics"} <= set(first) and
              len(first) == len(set(first)), f"all stages run, each once: {' '.join(first)}")
        check(stages() == [], "then there is nothing to do")

        bodies = {"template", "sample-bodies", "build-layers"}
        motions = {"import-motion", "sample-poses"}
        before_training = bodies | motions | {"make-splits", "simulate-fem", "fit-shape-space", "fit-correctives", "lbs",
                                              "gradient-skinning"}
        training = {"train-ndg", "train-vertexnet", "ndg", "vertexnet", "evaluate-metrics"}
        # Section, key, value; what must run; what must not.
        for section, key, value, wanted, spared in (
                ("train-ndg", "epochs", 31, training, before_training),
                ("train-ndg", "learning_rate", 0.0012, training, before_training),
                ("train-ndg", "widths", [64], training, before_training),
                ("simulate-fem", "max_iterations", 121, {"simulate-fem"} | training, bodies | motions | {"make-splits"}),
                ("sample-poses", "count", 41, {"sample-poses", "make-splits", "simulate-fem"} | training, bodies | {"import-motion"}),
                ("sample-bodies", "count", 21, {"sample-bodies", "build-layers", "simulate-fem"} | training, {"template"} | motions),
                ("", "description", "another", set(), set(first)),
                ("train-ndg", "epochs", 31, set(), set(first))):
            change(section, key, value)
            ran = set(stages())
            check(wanted <= ran and not spared & ran,
                  f"{section or 'preset'}.{key} = {value}: {' '.join(sorted(ran)) or 'nothing'}" +
                  (f"; lacks {sorted(wanted - ran)}, repeats {sorted(spared & ran)}" if wanted - ran or spared & ran else ""))
        os.utime(config)
        check(stages() == [], "a config that was only touched repeats nothing")

        # DEVICE reaches every call that has a network.
        dry = make("-n", "-B", "-o", config, tables, "DEVICE=cuda").stdout
        calls = [line for line in dry.replace("\\\n", " ").splitlines() if "pipelines/stage.sh" in line]
        trains = [line for line in calls if "/train-ndg " in line]
        predicts = [line for line in calls if re.search(r"--method (ndg|vertexnet) ", line)]
        check(len(trains) >= 2 and len(predicts) >= 2 and all("--device cuda" in line for line in trains + predicts),
              f"DEVICE=cuda: {len(trains)} trainings and {len(predicts)} predictions by networks are on the GPU")
        check(not any("--device" in line for line in make("-n", "-B", "-o", config, tables).stdout.splitlines()),
              "without it nothing is")

        # The training that Slurm is given, as its job runs it.
        dry = make("-n", "slurm", "DEVICE=cuda", "TRAIN_PARTITION=gpu", "TRAIN_OPTIONS=--gres=gpu:1").stdout
        given = re.search(r"NEXT='([^']*)'", dry.replace("\\\n", " "))
        check(bool(given) and 'NEXT_PARTITION="gpu"' in dry and 'NEXT_OPTIONS="--gres=gpu:1"' in dry,
              "make slurm hands partition and options of the training on")
        if given:
            os.remove(out + "/model.h5")
            job = subprocess.run(["bash", source + "/pipelines/slurm/next.sbatch", given.group(1)], cwd=source, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**environment, "MAKEFLAGS": "n"}, check=False)
            line = next((text for text in job.stdout.replace("\\\n", " ").splitlines() if "/train-ndg " in text and "stage.sh" in text), job.stdout[-500:])
            check(job.returncode == 0 and "--device cuda" in line and "simulate-fem" not in job.stdout,
                  f"the job of the training runs train-ndg --device cuda and simulates nothing{'' if '--device cuda' in line else ': ' + line}")
        memory = lambda preset: re.search(r'NEXT_MEMORY="(\d+)G"', make("-n", "slurm", f"PRESET={preset}").stdout)
        small, paper = memory("smoke"), memory("paper")
        check(bool(small) and bool(paper) and int(small.group(1)) <= 8 < 16 <= int(paper.group(1)),
              "the training of the paper's preset is given the memory that its weights need (docs/performance.md)")

    print(f"{len(failures)} failures" if failures else "all checks hold")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
