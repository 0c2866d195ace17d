#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Paths with blanks, which make splits into words: one sentence before anything starts. Argument: the source folder."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile


def run(folder, *words):
    # As from a shell, also below make itself.
    environment = {key: value for key, value in os.environ.items() if not key.startswith("MAKE") and key != "MFLAGS"}
    return subprocess.run(["make", "-n", "demo", *words], cwd=folder, env=environment, capture_output=True, text=True, check=False)


def check_refused(result, name, value):
    assert result.returncode == 2, result
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1 and f"{name}='{value}'" in lines[0] and "blanks" in lines[0], lines
    assert not result.stdout, result.stdout


def main():
    source = pathlib.Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as scratch:
        for name in ("OUT", "DATA", "CONFIG", "SCAN", "PREFIX"):
            value = f"{scratch}/with blank"
            check_refused(run(source, f"{name}={value}"), name, value)
        checkout = pathlib.Path(scratch) / "my checkout"
        checkout.mkdir()
        shutil.copy(source / "Makefile", checkout)
        check_refused(run(checkout), "CURDIR", str(checkout.resolve()))
        # Without a blank it is taken.
        assert "blanks" not in run(source, f"OUT={scratch}/fine").stderr


if __name__ == "__main__":
    main()
