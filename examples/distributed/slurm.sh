#!/usr/bin/env bash
# The shards of examples/distributed/sweep.py as an array of Slurm jobs, one a shard, without Dask. From the
# root of the repository, or with SWEEP=…/sweep.py, on a disk that all nodes share:
#
#   arguments="scenes/species/young/*.toml --links agp8x,pcie5x16 --shards 8 --out out/young"
#   count=$(python3 examples/distributed/sweep.py $arguments --count)
#   array=$(sbatch --parsable --array=0-$((count - 1)) examples/distributed/slurm.sh $arguments)
#   sbatch --dependency=afterok:"$array" --wrap "python3 examples/distributed/sweep.py $arguments"
#
# The last job finds every shard there and joins them. What a lost node did is done again on another one.
#SBATCH --job-name=spinney
#SBATCH --cpus-per-task=1
#SBATCH --mem=4G
#SBATCH --time=01:00:00
#SBATCH --requeue
set -euo pipefail
cd "${SLURM_SUBMIT_DIR:-.}"
exec python3 "${SWEEP:-examples/distributed/sweep.py}" "$@" \
    --threads "${SLURM_CPUS_PER_TASK:-1}" \
    --only "${SLURM_ARRAY_TASK_ID:?submit this with sbatch --array}"
