#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Damaged files for every reader: each must be refused in one line or read, within two gigabytes, and not be silent
for long: looking through a damaged HDF5 file is told after ten seconds and ended after a minute.

    damaged_inputs.py BIN CORPUS [--count 10000] [--seed 1] [--jobs 2] [--silent 30] [--timeout 120] [--megabytes 2048] [--keep FOLDER]

BIN: folder of the tools. CORPUS: files or folders with sound files of the kinds that ndg-info knows; small ones are damaged
more usefully. Texts and meshes of foreign formats are made here. File, kind of damage and place depend on the seed and the
number of the trial alone. Prints one line for every trial that went wrong, then a table; exit code 1 if there was any."""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import random
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time

MOST_BYTES = 30_000_000
EXTREMES = ["-1", "0", "4294967295", "9223372036854775808", "1e308", "-1e308", "1e-320", "nan", "inf", "", "x", "0.5.5"]

BVH = """HIERARCHY
ROOT Hips
{
OFFSET 0 90 0
CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT Spine
{
OFFSET 0 10 0
CHANNELS 3 Zrotation Xrotation Yrotation
End Site
{
OFFSET 0 40 0
}
}
}
MOTION
Frames: 3
Frame Time: 0.0333333
0 90 0 0 0 0 0 0 0
0 91 0 1 2 3 4 5 6
0 92 0 2 4 6 8 10 12
"""
ASF = """:version 1.10
:name x
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name spine
     direction 0 1 0
     length 2
     axis 0 0 0 XYZ
     dof rx ry rz
     limits (-20.0 45.0)
            (-30.0 30.0)
            (-30.0 30.0)
  end
:hierarchy
  begin
    root spine
  end
"""
AMC = ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\nspine 1 2 3\n2\nroot 0 1 0 0 0 0\nspine 2 3 4\n"


def tetrahedron():
    return [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def glb():
    vertices, triangles = tetrahedron()
    binary = b"".join(struct.pack("<3f", *v) for v in vertices) + b"".join(struct.pack("<3H", *t) for t in triangles)
    text = json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "children": [1], "scale": [2, 2, 2]}, {"mesh": 0, "translation": [3, 0, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "buffers": [{"byteLength": 72}]}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def foreign_files(folder):
    """Files of formats that others write."""
    vertices, triangles = tetrahedron()
    ply_head = ("ply\nformat {}\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                "element face 4\nproperty list uchar int vertex_indices\nend_header\n")
    points = "".join("%g %g %g\n" % v for v in vertices)
    faces = "".join("3 %d %d %d\n" % t for t in triangles)
    stl = b"\0" * 80 + struct.pack("<I", 4) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *vertices[t[0]], *vertices[t[1]], *vertices[t[2]], 0) for t in triangles)
    solid = "solid s\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % vertices[k] for k in t) + "endloop\nendfacet\n"
        for t in triangles) + "endsolid s\n"
    files = {
        "x.obj": "".join("v %g %g %g\n" % v for v in vertices) + "".join("f %d/1 %d//2 %d\n" % tuple(k + 1 for k in t) for t in triangles),
        "x.off": "OFF\n4 4 0\n" + points + faces, "ascii.ply": ply_head.format("ascii 1.0") + points + faces, "ascii.stl": solid,
        "x.bvh": BVH, "x.asf": ASF, "x.amc": AMC,
        "binary.ply": ply_head.format("binary_little_endian 1.0").encode() + b"".join(struct.pack("<3f", *v) for v in vertices) +
                      b"".join(struct.pack("<B3i", 3, *t) for t in triangles),
        "binary.stl": stl, "x.glb": glb()}
    for name, content in files.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return [folder / name for name in files]


def is_text(content):
    return b"\0" not in content[:4096] and content[:3] != b"PK\x03"


def damage(content, rng):
    """One kind of damage, and its name."""
    size = len(content)
    kinds = ["bits", "bytes", "cut", "hole", "insert", "repeat", "swap", "ones"]
    kind = rng.choice(kinds + ["number"] * 6 if is_text(content) else kinds)
    data = bytearray(content)
    at = rng.randrange(size)
    length = min(rng.choice([1, 4, 8, 64, 512, 4096]), size - at)
    if kind == "bits":
        for _ in range(rng.choice([1, 3, 20])):
            # Headers promise most: half of the places lie in the first kilobytes.
            place = rng.randrange(size if rng.random() < 0.5 else min(size, 4096))
            data[place] ^= 1 << rng.randrange(8)
    elif kind == "bytes":
        data[at:at + length] = bytes(rng.randrange(256) for _ in range(length))
    elif kind == "ones":
        data[at:at + length] = b"\xff" * length
    elif kind == "cut":
        del data[at:]
    elif kind == "hole":
        del data[at:at + length]
    elif kind == "insert":
        data[at:at] = bytes(rng.randrange(256) for _ in range(length))
    elif kind == "repeat":
        data[at:at] = data[at:at + length]
    elif kind == "swap":
        other = rng.randrange(size - length + 1)
        data[at:at + length], data[other:other + length] = data[other:other + length], data[at:at + length]
    else:
        words = content.split(b" ")
        places = [i for i, word in enumerate(words) if word.strip(b"-,]}\n\r\t[{:").replace(b".", b"").isdigit()]
        if not places:
            return damage(content[:-1] or b"x", rng)
        words[rng.choice(places)] = rng.choice(EXTREMES).encode()
        data = bytearray(b" ".join(words))
    return bytes(data), kind


class Campaign:
    def __init__(self, options, files):
        self.options = options
        kinds = {path.suffix: [p for p in files if p.suffix == path.suffix] for path in files}
        # Our own format has the most readers.
        self.kinds = [files for suffix, files in sorted(kinds.items()) for _ in range(4 if suffix == ".h5" else 1)]

    def limit(self):
        size = self.options.megabytes << 20
        if size:
            resource.setrlimit(resource.RLIMIT_AS, (size, size))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    def trial(self, number):
        rng = random.Random(f"{self.options.seed}/{number}")
        source = rng.choice(rng.choice(self.kinds))
        content, kind = damage(source.read_bytes(), rng)
        with tempfile.TemporaryDirectory(prefix="damaged_") as folder:
            path = pathlib.Path(folder) / source.name
            path.write_bytes(content)
            for one, other in ((".amc", ".asf"), (".asf", ".amc")):  # read together
                if path.suffix == one:
                    shutil.copy(source.with_suffix(other), folder)
            environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MALLOC_ARENA_MAX="1")
            start = time.monotonic()
            try:
                result = subprocess.run([str(self.options.bin / "ndg-info"), str(path)], capture_output=True, check=False,
                                        timeout=self.options.timeout, preexec_fn=self.limit, env=environment)
            except subprocess.TimeoutExpired:
                return self.report(number, source, kind, content, "hang", "")
            text = result.stderr.decode("utf-8", "replace")
            outcome = {0: "read", 2: "refused", 3: "outside its ranges"}.get(result.returncode, "crash")
            if time.monotonic() - start > self.options.silent and "still looking through it" not in text:
                return self.report(number, source, kind, content, "hang", text)
            errors = [line for line in text.splitlines() if "error:" in line or "Sanitizer" in line or "terminate" in line]
            if outcome == "crash" and result.returncode == 1 and len(errors) == 1 and "memory" in errors[0]:
                outcome = "out of memory"  # said in one line
            elif outcome == "refused" and (len(errors) != 1 or source.stem not in text):
                outcome = "unclear"
            elif outcome == "refused" and any(ord(c) < 32 and c != "\n" for c in text):
                outcome = "unclear"
            return self.report(number, source, kind, content, outcome, text.strip()[-300:])

    def report(self, number, source, kind, content, outcome, text):
        wrong = outcome in ("hang", "crash", "unclear")
        if wrong:
            print(f"trial {number}: {source.name}, {kind}: {outcome}: {text}", flush=True)
            if self.options.keep:
                self.options.keep.mkdir(parents=True, exist_ok=True)
                (self.options.keep / f"{number}-{source.name}").write_bytes(content)
        return source.suffix, outcome


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("corpus", type=pathlib.Path, nargs="*")
    parser.add_argument("--count", type=int, default=10000)
    parser.add_argument("--first", type=int, default=0, help="number of the first trial")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--silent", type=float, default=30, help="seconds after which a run must have said what it does")
    parser.add_argument("--timeout", type=float, default=120)
    parser.add_argument("--megabytes", type=int, default=2048, help="0: no limit, as address sanitizers need")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for what went wrong")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="campaign_") as folder:
        files = foreign_files(pathlib.Path(folder))
        known = {".h5", ".json", ".ndg", ".npz", ".pt", ".glb", ".html", ".obj", ".ply", ".safetensors", ".onnx"}
        for given in options.corpus:
            found = sorted(p for p in given.rglob("*") if p.is_file()) if given.is_dir() else [given]
            files += [p for p in found if p.suffix in known and 0 < p.stat().st_size <= MOST_BYTES]
        sound = [p for p in files if subprocess.run([str(options.bin / "ndg-info"), str(p)], capture_output=True, check=False).returncode in (0, 3)]
        print(f"{len(sound)} sound files of {len(files)}: {', '.join(sorted({p.suffix for p in sound}))}", flush=True)
        campaign = Campaign(options, sound)
        counts = collections.Counter()
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            for number, outcome in enumerate(pool.map(campaign.trial, range(options.first, options.first + options.count))):
                counts[outcome] += 1
                if (number + 1) % 1000 == 0:
                    print(f"{number + 1} of {options.count}", flush=True)
    outcomes = ["read", "refused", "outside its ranges", "out of memory", "unclear", "hang", "crash"]
    suffixes = sorted({suffix for suffix, _ in counts})
    print("| kind | tried | " + " | ".join(outcomes) + " |\n|" + "---|" * (len(outcomes) + 2))
    for suffix in suffixes + ["all"]:
        row = [sum(n for (s, o), n in counts.items() if o == outcome and suffix in (s, "all")) for outcome in outcomes]
        print(f"| {suffix} | {sum(row)} | " + " | ".join(map(str, row)) + " |")
    wrong = sum(n for (_, o), n in counts.items() if o in ("hang", "crash", "unclear"))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
