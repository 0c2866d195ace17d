#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An installation in a folder of its own, a program outside that finds libndg there, and the Debian packages.

install.py SOURCE BUILD
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

source, build = (os.path.abspath(path) for path in sys.argv[1:3])
failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def run(*command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)


def done(*command, **options):
    result = run(*command, **options)
    if result.returncode != 0:
        print(result.stdout[-3000:])
    return result.returncode == 0


def files_below(folder):
    return {os.path.relpath(os.path.join(at, name), folder) for at, _, names in os.walk(folder) for name in names}


def needed(path):
    """Shared libraries that a program or library names, and its own search paths."""
    text = run("readelf", "-d", path).stdout
    return re.findall(r"NEEDED.*\[(.*)\]", text), re.findall(r"R(?:UN)?PATH.*\[(.*)\]", text)


def licences(copyright_text):
    """Licence of each file that the copyright file names; of a file named twice the last one."""
    found = {}
    for paragraph in copyright_text.split("\n\n"):
        if paragraph.startswith("Files:"):
            names = re.match(r"Files:((?:\s+\S+)+?)\nCopyright:", paragraph)[1].split()
            found.update(dict.fromkeys(names, re.search(r"^License: (\S+)", paragraph, re.M)[1]))
    return found


def tools_of_table():
    """What docs/architecture.md says of each tool: links TetGen or CGAL, links CHOLMOD."""
    with open(source + "/docs/architecture.md") as file:
        section = re.search(r"## Executables and licences.*?\n## ", file.read(), re.S)[0]
    table = {}
    for line in re.findall(r"^\| (`.*)\|$", section, re.M):
        cells = [cell.strip() for cell in line.split("|")]
        for tool in re.findall(r"`([a-z-]+)`", cells[0]):
            table[tool] = ("AGPL-3+" if cells[1] in ("yes", "TetGen") else "GPL-3+" if "CGAL" in cells[1] or cells[2] == "yes" else "Apache-2.0")
    return table


folder = tempfile.mkdtemp(prefix="ndg install ")  # with a space, as home folders may have
try:
    prefix = folder + "/prefix"
    check(done("cmake", "--install", build, "--prefix", prefix), "cmake --install ends with exit code 0")
    installed = files_below(prefix)
    binaries = sorted(os.listdir(prefix + "/bin"))
    tools = sorted(name[:-4] for name in os.listdir(source + "/tools") if name.endswith(".cpp"))
    tools = [tool for tool in tools if os.path.exists(f"{build}/bin/{tool}")]
    check(binaries == sorted("ndg-animate" if tool == "animate" else tool for tool in tools), f"{len(tools)} tools are installed")
    libraries = [os.path.join(at, name) for at, _, names in os.walk(prefix) for name in names if name.startswith("libndg.so")]
    library = min(libraries, key=len)

    # Each runs where the build folder is not.
    stray = []
    for path in [*(f"{prefix}/bin/{name}" for name in binaries), library]:
        stray += [path for place in needed(path)[1] if build in place or source in place]
    check(not stray, "nothing looks for libraries in the build folder")
    versions = [run(f"{prefix}/bin/{name}", "--version").stdout for name in binaries]
    check(all(re.match(r"[a-z-]+ \d+\.\d+\.\d+ \(", text) for text in versions), "each says its version")
    for name in ("share/ndg/demo.json", "share/ndg/joint-maps/cmu.json", "share/doc/ndg-tools/docs/install.md"):
        check(name in installed, f"{name} is installed")

    # Its own joint maps are found, there and in the build folder. The motion: two frames of a rig that no map fits.
    with open(folder + "/rig.bvh", "w") as file:
        file.write("HIERARCHY\nROOT Odd\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
                   "MOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0\n0 0 0\n")
    dataset = folder + "/data"
    os.mkdir(dataset)
    done(f"{build}/bin/small-dataset", dataset, "9", "8")
    for place, at in ((f"{prefix}/bin", f"{prefix}/share/ndg"), (f"{build}/bin", f"{build}/share/ndg")):
        result = run(f"{place}/import-motion", "--motion", folder + "/rig.bvh", "--template", dataset + "/template.h5", "--output",
                     folder + "/poses.h5")
        check(result.returncode == 2 and f"{at}/joint-maps/" in result.stdout,
              f"import-motion without --joint-maps takes those in {at}: {result.stdout.strip()}")

    # Completion, as bash loads it.
    scripts = f"{prefix}/share/bash-completion/completions"
    check(sorted(os.listdir(scripts)) == binaries, "every tool has its completion")
    ask = "source \"$1\" && COMP_WORDS=(\"$2\" \"${@:3}\") && COMP_CWORD=$(($# - 2)) && \"$(complete -p \"$2\" | sed 's/.*-F \\([^ ]*\\) .*/\\1/')\"" \
          " && printf '%s ' \"${COMPREPLY[@]}\""

    def completed(tool, *words):
        return run("bash", "-c", ask, "bash", f"{scripts}/{tool}", tool, *words).stdout.split()

    wrong = [tool for tool in binaries if completed(tool, "--print") != ["--print-config"] or completed(tool, "--log-level", "d") != ["debug"]]
    check(not wrong, f"bash completes the flags of every tool{': not of ' + ', '.join(wrong) if wrong else ''}")
    check(completed("make-template", "--source", "p") == ["procedural"], "bash completes the choices of an option")

    # Licences: what programs link, what the copyright file says and what the documentation says.
    with open(prefix + "/share/doc/ndg-tools/copyright") as file:
        stated = licences(file.read())
    table = tools_of_table()
    for tool in tools:
        name = "ndg-animate" if tool == "animate" else tool
        licence = stated.get("usr/bin/" + name, "Apache-2.0")
        check(table.get(tool) == licence, f"{name}: {licence} in the copyright file, {table.get(tool)} by the table in the documentation")
        names = " ".join(needed(f"{prefix}/bin/{name}")[0])
        least = "AGPL-3+" if "libtet" in names else "GPL-3+" if "libgmp" in names or "libcholmod" in names else "Apache-2.0"
        strength = ["Apache-2.0", "GPL-3+", "AGPL-3+"]
        check(strength.index(licence) >= strength.index(least), f"{name} links nothing under stronger terms")
    animation = [library, *(f"{prefix}/bin/{name}" for name in ("ndg-animate", "infer-ndg", "reconstruct") if name in binaries)]
    check(not any(re.search("libtet|libgmp", " ".join(needed(path)[0])) for path in animation),
          "what runs at animation time links neither TetGen nor CGAL")

    # A program outside: built by find_package, run on a network that the installed tools train.
    outside = folder + "/outside"
    shutil.copytree(prefix + "/share/doc/libndg-dev/examples", outside)
    environment = {key: value for key, value in os.environ.items() if not key.startswith("CMAKE")}
    check(done("cmake", "-S", outside, "-B", outside + "/build", f"-DCMAKE_PREFIX_PATH={prefix}", env=environment)
          and done("cmake", "--build", outside + "/build", env=environment), "a program outside is built with find_package(ndg)")
    missing = run(outside + "/build/ndg_example", "none.h5", "none.h5", "none.ndg", "none.obj")
    check(missing.returncode == 1 and "none.h5" in missing.stdout, f"it tells what libndg misses: {missing.stdout.strip()}")
    if "train-ndg" in binaries:
        data = [f"--{name}={dataset}/{name}.h5" for name in ("template", "bodies", "poses")]
        trained = (done(f"{prefix}/bin/fit-shape-space", *data[:2], f"--splits={dataset}/splits.h5", f"--output={dataset}/shape_space.h5")
                   and done(f"{prefix}/bin/simulate-fem", *data, f"--splits={dataset}/splits.h5", "--bone-wrap=lbs", f"--output={dataset}/fem.h5")
                   and done(f"{prefix}/bin/train-ndg", *data, f"--samples={dataset}/fem.h5", f"--shape-space={dataset}/shape_space.h5",
                            "--widths", "16", "--epochs=2", f"--output={dataset}/model.h5")
                   and done(f"{prefix}/bin/export-runtime", f"--model={dataset}/model.h5", f"--output={dataset}/model.ndg"))
        check(trained, "installed tools simulate, train and export")
        names = [f"{dataset}/{name}" for name in ("template.h5", "bodies.h5", "model.ndg", "elbow.obj")]
        check(done(outside + "/build/ndg_example", *names) and os.path.getsize(names[-1]) > 1000, "the program poses a body by libndg")

    # The packages.
    if shutil.which("dpkg-shlibdeps") is None:
        print("skipped: packages need dpkg-dev")
    else:
        check(done("cpack", "--config", build + "/CPackConfig.cmake", "-B", folder + "/packages", cwd=folder), "cpack makes packages")
        packages = {name.split("_")[0]: f"{folder}/packages/{name}" for name in os.listdir(folder + "/packages") if name.endswith(".deb")}
        check(sorted(packages) == ["libndg-dev", "libndg0", "ndg-tools"], f"they are {', '.join(sorted(packages))}")
        contents = {name: run("dpkg-deb", "--contents", path).stdout for name, path in packages.items()}
        depends = {name: run("dpkg-deb", "--field", path, "Depends").stdout for name, path in packages.items()}
        check(all(f"./usr/bin/{name}\n" in contents["ndg-tools"] for name in binaries), "ndg-tools has the tools")
        check("/usr/bin/animate\n" not in contents["ndg-tools"], "no file of it has the name of ImageMagick's animate")
        check("libtet1.5" in depends["ndg-tools"] and "libhdf5" in depends["ndg-tools"], "ndg-tools depends on what its tools link")
        check("libndg.so.0" in contents["libndg0"] and "/bin/" not in contents["libndg0"], "libndg0 has the library alone")
        check("libcholmod" in depends["libndg0"] and not re.search("libtet|libgmp|libtorch", depends["libndg0"]),
              "libndg0 needs neither TetGen nor CGAL nor libtorch")
        check("ndg.h" in contents["libndg-dev"] and "ndgConfig.cmake" in contents["libndg-dev"] and "libndg0" in depends["libndg-dev"],
              "libndg-dev has header and CMake package, and depends on libndg0")
        check(all(f"./usr/share/doc/{name}/copyright\n" in contents[name] for name in packages), "each has its copyright file")
        check(not any(re.search(r" \./(?!usr)[a-z]", text) for text in contents.values()), "nothing lies outside of /usr")
        check(done("dpkg-deb", "--extract", packages["ndg-tools"], folder + "/unpacked"), "ndg-tools is unpacked")
        check(done(folder + "/unpacked/usr/bin/ndg-animate", "--list-methods"), "a program of the package runs")
finally:
    shutil.rmtree(folder)
print(f"{len(failures)} failures")
sys.exit(1 if failures else 0)
