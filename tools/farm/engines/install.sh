#!/bin/sh
# Installs what the tests of farm engines need, as far as that can be had: sh install.sh VENV
# It never fails: tests say which engines they skip.
venv=$1
export DEBIAN_FRONTEND=noninteractive

has_programs() {
    for program in slurmctld slurmd sbatch parallel; do
        command -v "$program" >/dev/null || return 1
    done
}

debian_packages() {
    [ "$(id -u)" = 0 ] && timeout 120 apt-get update &&
        timeout 300 apt-get install --yes --no-install-recommends slurmctld slurmd slurm-client parallel
}

python_packages() {
    python3 -m venv "$venv" && timeout 300 "$venv/bin/pip" install hyperqueue openjd-cli
}

has_programs || debian_packages >/dev/null 2>&1 || echo "Slurm or GNU parallel cannot be installed here" >&2
"$venv/bin/python" -c 'import hyperqueue, openjd.cli' 2>/dev/null || python_packages >/dev/null 2>&1 ||
    echo "hyperqueue and openjd-cli cannot be installed here" >&2
exit 0
