#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Rules a compiler does not check: layers of the includes, file lengths, licence lines. house_rules.py SOURCE"""
import os
import re
import sys

source = sys.argv[1]
layers = ["core", "io", "solver", "geometry", "body", "bones", "dataset", "body_source", "placement", "measures", "scan", "registration", "procedural", "makehuman", "anatomical", "people",
          "wraps", "template_build", "layers", "motion", "retarget", "deform", "avatar", "protrusion", "elastic", "simulation", "dynamics", "capture", "estimation", "runtime", "info", "release", "neural", "evaluate", "scene", "export", "page", "display"]
# Headers that only sources of their own module include.
internal = {"lib/ndg/io/h5_handles.h", "lib/ndg/geometry/cgal_mesh.h"} | {f"lib/ndg/neural/{n}.h" for n in (
    "adamw", "checkpoint", "coefficients", "matrix_product", "model_state", "network", "objective", "output_basis", "parametrisation",
    "target_loader", "tensor_exponential", "torch_network", "training_pass", "weight_average")}
soft_limit, hard_limit = 400, 800
failures = []

with open(os.path.join(source, "docs/architecture.md")) as file:
    architecture = file.read()
files = []
for top in ("lib", "tools", "tests", "bench"):
    for folder, _, names in os.walk(os.path.join(source, top)):
        files += [os.path.relpath(os.path.join(folder, n), source) for n in names if n.endswith((".h", ".cpp"))]
for path in sorted(files):
    with open(os.path.join(source, path)) as file:
        lines = file.read().split("\n")
    if not lines[0].startswith("// SPDX-License-Identifier: Apache-2.0"):
        failures.append(f"{path}: no SPDX line")
    if len(lines) > hard_limit or (len(lines) > soft_limit and path not in architecture):
        failures.append(f"{path}: {len(lines)} lines, and docs/architecture.md does not say why")
    module = re.match(r"lib/ndg/(\w+)/", path)
    for line in lines:
        include = re.match(r'#include "ndg/(\w+)/', line)
        if module and include and layers.index(include[1]) > layers.index(module[1]):
            failures.append(f"{path}: includes a higher module: {line}")
        if path.startswith("lib/ndg/") and not path.startswith("lib/ndg/neural/") and "<torch/" in line:
            failures.append(f"{path}: sees libtorch")
        if path.endswith(".h") and re.match(r"#include <(hdf5|CGAL/|tetgen|cholmod|torch/|embree)", line) and path not in internal:
            failures.append(f"{path}: a header leaks a third party: {line}")

print("\n".join(failures) if failures else f"{len(files)} files keep the rules")
sys.exit(1 if failures else 0)
