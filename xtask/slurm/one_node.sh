#!/bin/sh
# A Slurm of one node, this machine, without systemd: one_node.sh start|restart|stop FOLDER. Needs root;
# installs Debian's munge and slurm-wlm where they are missing.
# Afterwards SLURM_CONF=FOLDER/slurm.conf is what sbatch, squeue and scancel need.
set -eu
action=$1
mkdir -p "$2"
folder=$(cd "$2" && pwd)
conf=$folder/slurm.conf

# Ends the process whose number a file holds, and waits for it.
end() {
    test -s "$1" || return 0
    process=$(cat "$1")
    kill "$process" 2> /dev/null || return 0
    for _ in $(seq 100); do
        kill -0 "$process" 2> /dev/null || return 0
        sleep 0.1
    done
    kill -9 "$process"
}

# What is missing, where that is allowed.
install() {
    if ! apt-get install --yes --no-install-recommends slurm-wlm munge > "$folder/install.log" 2>&1; then
        echo "$program is missing, and apt-get install slurm-wlm munge fails: $(tail -1 "$folder/install.log")" >&2
        exit 1
    fi
}

controller() {
    SLURM_CONF=$conf slurmctld
    for _ in $(seq 100); do
        SLURM_CONF=$conf scontrol ping 2> /dev/null | grep -q ' UP' && return 0
        sleep 0.1
    done
    echo "slurmctld does not answer: $(tail -3 "$folder/slurmctld.log")" >&2
    return 1
}

start() {
    for program in munged slurmctld slurmd; do
        command -v $program > /dev/null || install
    done
    cores=$(nproc)
    memory_mb=$(($(awk '/MemTotal/ {print $2}' /proc/meminfo) / 1024 * 9 / 10))
    mkdir -p "$folder/state" "$folder/spool" "$folder/munge"
    chmod 700 "$folder/munge"
    test -s "$folder/munge/key" || dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 2> /dev/null
    chmod 600 "$folder/munge/key"
    cat > "$conf" << END
ClusterName=one
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=2
MinJobAge=5
KillWait=5
NodeName=$(hostname) NodeAddr=127.0.0.1 CPUs=$cores RealMemory=$memory_mb State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
    munged --force --socket="$folder/munge/socket" --key-file="$folder/munge/key" --pid-file="$folder/munge/pid" \
        --log-file="$folder/munge/log" --seed-file="$folder/munge/seed"
    controller
    SLURM_CONF=$conf slurmd
    for _ in $(seq 100); do
        SLURM_CONF=$conf sinfo --noheader --format=%T 2> /dev/null | grep -q idle && return 0
        sleep 0.1
    done
    echo "the node does not come up: $(tail -3 "$folder/slurmd.log")" >&2
    return 1
}

case $action in
start) start ;;
restart)
    end "$folder/slurmctld.pid"
    controller
    ;;
stop)
    end "$folder/slurmd.pid"
    end "$folder/slurmctld.pid"
    end "$folder/munge/pid"
    ;;
*)
    echo "start, restart or stop, not $action" >&2
    exit 2
    ;;
esac
