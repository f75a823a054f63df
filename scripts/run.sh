#!/bin/sh
# Runs the wedge nanoindentation of the paper on the cores of this machine and draws its pictures in output/.
# usage: scripts/run.sh [PYTHON]
set -eu
python=${1:-python3}
name=wedge_3level
ranks=$(nproc 2>/dev/null || echo 1)
[ "$ranks" -le 4 ] || ranks=4

start="mpiexec -n $ranks"
[ "$ranks" -gt 1 ] || start=""
[ "$(id -u)" -ne 0 ] || export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

echo "wedge indentation of aluminium to 450 nm on three levels and $ranks ranks:"
$start bin/mlgimp -options_file options/$name.opts -output_dir output/$name -overwrite -monitor
echo "drawing output/$name/*.png"
$python scripts/plot.py output/$name --window=0,18e-6,22e-6,40.5e-6
