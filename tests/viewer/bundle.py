#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""viewer/dist/viewer.js is what viewer/src gives, and brings the licence of three.js; GLB files pass the Khronos validator:
bundle.py VIEWER [GLB]... Both exit 77 (skipped) where npm's modules are not installed."""
import os
import shutil
import subprocess
import sys

viewer = sys.argv[1]
with open(f"{viewer}/dist/viewer.js") as file:
    bundle = file.read()
for text in ("The MIT License", "three.js authors", "Apache-2.0", "THE SOFTWARE IS PROVIDED"):
    if text not in bundle:
        sys.exit(f"FAIL  dist/viewer.js lacks '{text}'")
if "</script" in bundle:
    sys.exit("FAIL  dist/viewer.js would end the script element it stands in")
with open(f"{viewer}/package-lock.json") as file:
    if "://" in file.read():
        sys.exit("FAIL  package-lock.json names addresses")
if not shutil.which("node") or not os.path.isdir(f"{viewer}/node_modules"):
    print("skipped: viewer/node_modules is not there (make viewer installs it)")
    sys.exit(77)
files = [os.path.abspath(path) for path in sys.argv[2:] if os.path.exists(path)]
code = subprocess.run(["node", "build.mjs", "--check"], cwd=viewer).returncode
if files:
    code = subprocess.run(["node", "validate-glb.mjs", *files], cwd=viewer).returncode or code
else:
    print("skipped: there is no GLB to validate (pipeline_smoke writes one)")
sys.exit(code)
