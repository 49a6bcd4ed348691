#!/bin/sh
# Renders a scene in shards with GNU parallel, on this machine or on several, and joins the parts.
#
#     contrib/render-parallel.sh SCENE PARTS SHARDS [OPTION...]
#
# PARTS is the directory of the part files: started again with the same arguments, what is there is not
# rendered again. Options go to `gmlvm run`, such as --size 1920x1080. Images go to OUT (default: .).
#
# PARALLEL holds options for GNU parallel: PARALLEL='--sshlogin a,b --workdir .' renders on the machines
# a and b, where SCENE and PARTS must be the same files (a shared directory) and gmlvm be installed.
set -eu
scene=$1 parts=$2 shards=$3
shift 3
: "${GMLVM:=gmlvm}" "${OUT:=.}"

# A shard that fails is tried once more: what it had done is kept. One thread for each shard, and as many
# shards at a time as there are processors.
seq "$shards" | parallel --quote --retries 2 --halt soon,fail=1 \
    "$GMLVM" run "$scene" --parts "$parts" --shard "{}/$shards" -j 1 "$@"
"$GMLVM" merge "$parts" -o "$OUT"
