#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# install-packages.sh [--quiet] [PACKAGE...]: installs the Debian packages this project needs, and those named, as far as
# they are missing. With --quiet: silent when nothing is missing.
set -eu
packages=(
    build-essential cmake ninja-build git
    libeigen3-dev libsuitesparse-dev libopenblas-dev libtet1.5-dev libcgal-dev libhdf5-dev
    libcli11-dev nlohmann-json3-dev libfmt-dev libspdlog-dev libssl-dev zlib1g-dev
    libtorch-dev libdnnl-dev libembree-dev libceres-dev libtinygltf-dev libpng-dev libwebp-dev
    catch2 hdf5-tools python3-h5py python3-numpy python3-torch
)
quiet=
if [ "${1:-}" = "--quiet" ]; then
    quiet=yes
    shift
fi
packages+=("$@")
missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f='${Status}\n' "$package" 2>/dev/null | grep -q '^install ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
    [ -n "$quiet" ] || echo "all packages are installed"
    exit 0
fi
if [ "$(id -u)" = 0 ]; then
    as_root=()
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root=(sudo -n)
else
    echo "missing packages; run:  sudo apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 2
fi
echo "installing: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
