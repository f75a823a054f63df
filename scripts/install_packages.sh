#!/bin/sh
# Installs what mlgimp needs from Debian's packages, if something is missing and this is Debian or Ubuntu.
# A machine that has everything is left alone and the network is not touched.
# usage: scripts/install_packages.sh [PACKAGE ...]        and these packages
set -eu
packages="g++ make pkg-config libpetsc-real-dev petsc-dev libopenmpi-dev openmpi-bin libhdf5-openmpi-dev libmetis-dev
nlohmann-json3-dev python3-numpy python3-h5py python3-matplotlib python3-scipy python3-openpyxl python3-xlrd
python3-pytest python3-pytest-timeout python3-pytest-xdist libgtest-dev $*"

if [ -n "${PETSC_DIR:-}" ]; then exit 0; fi # a PETSc of the user's own

if ! command -v dpkg-query >/dev/null 2>&1; then
  if command -v mpicxx >/dev/null 2>&1 && pkg-config --exists PETSc hdf5-openmpi 2>/dev/null; then exit 0; fi
  echo "mlgimp needs: a C++17 compiler, make, pkg-config, PETSc (real, with headers), Open MPI, parallel HDF5, METIS, nlohmann-json," >&2
  echo "python3 with numpy, h5py, scipy and matplotlib, for workbooks openpyxl and xlrd," >&2
  echo "for tests pytest, pytest-timeout, pytest-xdist and GoogleTest. Install them, or set PETSC_DIR and PETSC_ARCH; see README.md." >&2
  exit 1
fi

missing=""
for package in $packages; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing="$missing $package"
done
if [ -z "$missing" ]; then exit 0; fi

if [ "$(id -u)" -eq 0 ]; then root=""; elif command -v sudo >/dev/null 2>&1; then root=sudo; else
  echo "mlgimp needs these packages; install them as root: apt-get install$missing" >&2
  exit 1
fi
echo "installing:$missing"
$root apt-get update -q
$root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
