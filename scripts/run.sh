#!/bin/sh
# Runs the wedge nanoindentation of the paper on the idle cores of this machine and draws its pictures and a page about it in output/.
# usage: scripts/run.sh [PYTHON]
set -eu
python=${1:-python3}
name=wedge_3level

# Cores that have been idle for most of half a second: ranks wait for each other, and one that shares its core with another
# program makes all of them slow.
idle_cores() {
  if [ ! -r /proc/stat ]; then nproc 2>/dev/null || echo 1; return; fi
  { grep '^cpu[0-9]' /proc/stat; sleep 0.5; grep '^cpu[0-9]' /proc/stat; } |
    awk '{ all = 0; for (k = 2; k <= NF; ++k) all += $k
           if ($1 in before) { if ($5 - idle[$1] > 0.7 * (all - before[$1])) ++count } else { before[$1] = all; idle[$1] = $5 } }
         END { print count + 0 }'
}
ranks=$(idle_cores)
cores=$(grep -c '^cpu[0-9]' /proc/stat 2>/dev/null) || cores=$ranks
[ "$ranks" -ge "$cores" ] || echo "other programs keep $((cores - ranks)) of $cores cores busy: this will take longer"
[ "$ranks" -ge 1 ] || ranks=1
[ "$ranks" -le 4 ] || ranks=4
allowed=$(nproc 2>/dev/null) || allowed=$ranks
[ "$ranks" -le "$allowed" ] || ranks=$allowed

start="mpiexec -n $ranks"
[ "$ranks" -gt 1 ] || start=""
# Open MPI, up to version 4 and from 5 on, counts cores as it likes, and not hardware threads.
export OMPI_MCA_rmaps_base_oversubscribe=1 PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
[ "$(id -u)" -ne 0 ] || export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

echo "wedge indentation of aluminium to 450 nm on three levels and $ranks ranks:"
$start bin/mlgimp -options_file options/$name.opts -output_dir output/$name -overwrite -monitor
echo "drawing output/$name/*.png"
$python scripts/plot.py output/$name --window=0,18e-6,22e-6,40.5e-6
$python scripts/report.py output/$name
