#!/bin/sh
# Runs a command with a Slurm cluster of one node, in the directory $1 and for this command only. Needs
# root, and slurmctld, slurmd and munged (Debian: slurm-wlm, munge). Exits with 99 if there is no starting
# it. It keeps to its own directory and ports, and ends what it has started.
set -eu
dir=$1
shift
mkdir -p "$dir/state" "$dir/spool"
dd if=/dev/urandom of="$dir/munge.key" bs=1024 count=1 2>"$dir/dd.log"
chmod 700 "$dir" && chmod 400 "$dir/munge.key"
munged --foreground --force --socket "$dir/munge.socket" --key-file "$dir/munge.key" \
    --pid-file "$dir/munged.pid" --seed-file "$dir/munge.seed" --log-file "$dir/munged.log" 2>"$dir/munged.err" &
munged=$!
# Ports of which others are unlikely to think, different for tests that run at once.
port=$((20000 + $$ % 20000 * 2))
cat >"$dir/slurm.conf" <<END
ClusterName=gmlvm
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
CredType=cred/munge
CryptoType=crypto/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0
ReturnToService=2
MpiDefault=none
NodeName=$(hostname) NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF="$dir/slurm.conf"
slurmctld=; slurmd=
stop() {
    # shellcheck disable=SC2086 # A daemon that was not started has no number.
    kill $slurmd $slurmctld $munged 2>/dev/null || true
    # shellcheck disable=SC2086
    wait $slurmd $slurmctld $munged 2>/dev/null || true
}
trap stop EXIT
trap 'exit 143' TERM INT
slurmctld -D -c -L "$dir/slurmctld.log" 2>"$dir/slurmctld.err" &
slurmctld=$!
slurmd -D -L "$dir/slurmd.log" -N "$(hostname)" 2>"$dir/slurmd.err" &
slurmd=$!
for _ in $(seq 100); do
    case $(sinfo -h -o %T 2>/dev/null) in idle) ready=1; break ;; esac
    sleep 0.2
done
if [ -z "${ready:-}" ]; then
    tail -n 5 "$dir"/*.log "$dir"/*.err >&2
    exit 99
fi
"$@"
