"""Run a command inside a throw-away Slurm cluster on this host, and wait for what it submits.

    python3 slurm_cluster.py [--max-array N] [--restart] -- hedgehop farm submit --engine slurm ...

It needs neither munge nor systemd nor root: a controller and three node daemons
run in the foreground in a temporary folder, on free ports, with their own
configuration, which commands find by SLURM_CONF. It prints each task with its
end as JSON, and ends with 77 and a line on standard error where Slurm is missing.
"""

import argparse
import getpass
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile

import processes

NODES = ["n1", "n2", "n3"]
# Waiting tasks start about once a second; the usual pace is once in half a minute.
CONFIG = """\
ClusterName=hedgehop
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
StateSaveLocation={folder}/state
SlurmctldPidFile={folder}/slurmctld.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdSpoolDir={folder}/spool-%n
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SlurmdParameters=config_overrides
SchedulerType=sched/backfill
SchedulerParameters=sched_min_interval=1000000,sched_interval=1,bf_interval=1,batch_sched_delay=0
MaxArraySize={max_array}
KillWait=2
ReturnToService=2
"""
NODE = "NodeName={} NodeHostname={} NodeAddr=127.0.0.1 Port={} CPUs=1 RealMemory=2000\n"
PARTITION = "PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
ENDS = {"COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL"}


class SlurmCluster:
    """One controller and three nodes; a context manager."""

    def __init__(self, max_array):
        self.folder = tempfile.mkdtemp(prefix="slurm-")
        self.daemons = {}
        ports = free_ports(len(NODES) + 1)
        host = socket.gethostname().split(".")[0]
        text = CONFIG.format(host=host, port=ports[0], folder=self.folder,
                             user=getpass.getuser(), max_array=max_array)
        for name, port in zip(NODES, ports[1:]):
            text += NODE.format(name, host, port)
        os.mkdir(os.path.join(self.folder, "state"))
        self._write("slurm.conf", text + PARTITION)
        self._write("cgroup.conf", "CgroupPlugin=%s\n" % cgroup_plugin())
        self.env = dict(os.environ, SLURM_CONF=os.path.join(self.folder, "slurm.conf"))

    def __enter__(self):
        processes.adopt_orphans()
        try:
            self.start_controller()
            for name in NODES:
                self._start(name, "slurmd", "-D", "-N", name)
            processes.wait_until(self._is_ready, 30, "idle nodes")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        processes.end_descendants()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _write(self, name, text):
        with open(os.path.join(self.folder, name), "w") as f:
            f.write(text)

    def _start(self, key, program, *arguments):
        with open(os.path.join(self.folder, key + ".out"), "ab") as log:
            self.daemons[key] = subprocess.Popen(
                [program_path(program)] + list(arguments), env=self.env,
                stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)

    def _is_ready(self):
        lines = self.run("sinfo", "-hN", "-o", "%N %T", check=False).splitlines()
        return len(lines) == len(NODES) and all(line.split()[1] == "idle" for line in lines)

    def start_controller(self):
        """Start the controller; it reads back the state of an earlier one."""
        self._start("controller", "slurmctld", "-D", "-i")

    def restart_controller(self):
        """Stop the controller and start it anew."""
        process = self.daemons.pop("controller")
        process.terminate()
        process.wait()
        self.start_controller()

    def run(self, *command, check=True):
        """Run a command against this cluster and return its output."""
        done = subprocess.run(command, env=self.env, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True)
        if check and done.returncode:
            raise RuntimeError("%s: %d: %s" % (command[0], done.returncode, done.stderr.strip()))
        return done.stdout.strip()

    def tasks(self):
        """Return the state and exit code of all tasks, by the number Slurm gives them."""
        tasks = {}
        for line in self.run("scontrol", "-o", "show", "job", check=False).splitlines():
            fields = dict(f.split("=", 1) for f in line.split() if "=" in f)
            if "JobState" in fields:
                name = fields["JobId"] + ":" + fields.get("ArrayTaskId", "")
                tasks[name] = {"state": fields["JobState"], "exit": fields["ExitCode"]}
        return tasks

    def states(self):
        """Return the states in which tasks are."""
        return {task["state"] for task in self.tasks().values()}

    def wait_running(self):
        """Wait until a task runs."""
        processes.wait_until(lambda: "RUNNING" in self.states(), 30, "running task")

    def wait(self):
        """Wait until all tasks have ended; a controller that is away tells of none."""
        def over():
            states = self.states()
            return states and states <= ENDS
        processes.wait_until(over, 90, "end of all tasks")


def program_path(name):
    """Return the path of a program, None where it is missing; daemons are not on every PATH."""
    return shutil.which(name) or shutil.which(name, path="/usr/sbin:/usr/bin:/sbin")


def free_ports(count):
    """Return as many distinct free TCP ports of the loopback interface."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for s in sockets:
            s.bind(("127.0.0.1", 0))
        return [s.getsockname()[1] for s in sockets]
    finally:
        for s in sockets:
            s.close()


def cgroup_plugin():
    """Name a plugin that needs no systemd; older versions cannot switch it off."""
    version = subprocess.check_output([program_path("slurmd"), "-V"], universal_newlines=True)
    major, minor = re.match(r"\D*(\d+)\.(\d+)", version).groups()
    return "disabled" if (int(major), int(minor)) >= (23, 11) else "cgroup/v1"


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--max-array", type=int, default=1001, help="MaxArraySize (default 1001)")
    p.add_argument("--restart", action="store_true",
                   help="restart the controller once a task runs")
    p.add_argument("command", nargs="+", help="what submits the tasks")
    args = p.parse_args()
    for program in ("slurmctld", "slurmd", "sbatch"):
        if program_path(program) is None:
            print("skipped: no program %s of Slurm" % program, file=sys.stderr)
            return 77
    with SlurmCluster(args.max_array) as cluster:
        said = cluster.run(*args.command)
        if args.restart:
            cluster.wait_running()
            cluster.restart_controller()
        cluster.wait()
        print(json.dumps({"said": said, "tasks": cluster.tasks()}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
