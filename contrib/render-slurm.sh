#!/bin/sh
# Renders a scene in shards as a Slurm job array, and joins the parts when all are done.
#
#     contrib/render-slurm.sh SCENE PARTS SHARDS [OPTION...]
#
# PARTS is the directory of the part files, which all nodes see. Options go to `gmlvm run`. Images go to
# OUT (default: .). If tasks fail or are killed, start it again with the same arguments: what is there
# is not rendered again. SBATCH_... variables hold options for sbatch, such as SBATCH_PARTITION.
#
# Prints the numbers of the two jobs: of the array, and of the one that joins.
set -eu
scene=$1 parts=$2 shards=$3
shift 3
: "${GMLVM:=gmlvm}" "${OUT:=.}"
mkdir -p "$parts"

# sbatch runs the script that it is given; its arguments follow.
render='#!/bin/sh
exec "$@" -j "${SLURM_CPUS_PER_TASK:-1}"'
array=$(printf '%s\n' "$render" | sbatch --parsable --job-name gmlvm --requeue \
    --array "1-$shards" --output "$parts/%A_%a.log" /dev/stdin \
    "$GMLVM" run "$scene" --parts "$parts" --shard auto "$@")
join=$(printf '#!/bin/sh\nexec "$@"\n' | sbatch --parsable --job-name gmlvm-merge \
    --dependency "afterok:$array" --kill-on-invalid-dep yes --output "$parts/%j.log" /dev/stdin \
    "$GMLVM" merge "$parts" -o "$OUT")
echo "$array $join"
