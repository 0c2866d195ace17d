# SPDX-License-Identifier: Apache-2.0
"""A Slurm of one node in a temporary folder: munged, slurmctld and slurmd of our own, stopped at the end."""
import glob
import os
import shutil
import signal
import socket
import subprocess
import time

DAEMONS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")


def why_not():
    """'' where a cluster can be started here, otherwise the reason."""
    if os.geteuid() != 0:
        return "Slurm's daemons need root"
    path = os.environ["PATH"] + ":/usr/sbin:/sbin"
    missing = [name for name in DAEMONS if shutil.which(name, path=path) is None]
    return f"{', '.join(missing)} not installed (Debian packages slurm-wlm and munge)" if missing else ""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def shards_of(tool, output):
    """Process number of each shard of `output` that `tool` is at."""
    found = {}
    for path in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            with open(path, "rb") as file:
                words = file.read().decode(errors="replace").split("\0")
        except OSError:
            continue
        if words[0].endswith("/" + tool) and output in words and "--shard" in words:
            found[int(words[words.index("--shard") + 1].split("/")[0])] = int(path.split("/")[2])
    return found


class Cluster:
    """Processes end with the `with` block; nothing outside `folder` is written."""

    def __init__(self, folder, cpus):
        self.folder = folder
        self.daemons = []
        os.makedirs(folder + "/state")
        os.makedirs(folder + "/spool")
        host = socket.gethostname().split(".")[0]
        controller, node = free_ports(2)
        self.write("munge.key", os.urandom(1024))
        # No cgroups, no accounting: what a container without systemd can do.
        self.write("slurm.conf", f"""ClusterName=ndgtest
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=5,batch_sched_delay=0,requeue_delay=1
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory=8000 State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP
""".encode())
        self.environment = {**os.environ, "SLURM_CONF": folder + "/slurm.conf",
                            "PATH": os.environ["PATH"] + ":/usr/sbin:/sbin"}

    def write(self, name, content):
        with open(f"{self.folder}/{name}", "wb", opener=lambda p, f: os.open(p, f, 0o600)) as file:
            file.write(content)

    def start(self, *command):
        log = open(f"{self.folder}/{command[0]}.out", "wb")
        self.daemons.append(subprocess.Popen(command, env=self.environment, stdout=log, stderr=subprocess.STDOUT,
                                             cwd=self.folder))

    def run(self, *command, check=True):
        done = subprocess.run(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if check and done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}: {done.stdout}")
        return done.stdout

    def wait_for(self, condition, what, seconds=60, poll=0.1):
        end = time.time() + seconds
        while time.time() < end:
            found = condition()
            if found:
                return found
            time.sleep(poll)
        raise RuntimeError(f"waited {seconds} s in vain for {what}")

    def jobs(self):
        """(id, name, state) of all jobs that are queued or running."""
        lines = self.run("squeue", "--noheader", "--array", "--format", "%i|%j|%T", check=False).split("\n")
        return [tuple(line.split("|")) for line in lines if line.count("|") == 2]

    def __enter__(self):
        try:
            self.start("munged", "--foreground", "--force", f"--socket={self.folder}/munge.socket",
                       f"--key-file={self.folder}/munge.key", f"--pid-file={self.folder}/munged.pid",
                       f"--seed-file={self.folder}/munged.seed", f"--log-file={self.folder}/munged.log")
            self.wait_for(lambda: os.path.exists(self.folder + "/munge.socket"), "munged")
            self.start("slurmctld", "-D")
            self.start("slurmd", "-D")
            self.wait_for(lambda: "idle" in self.run("sinfo", "--noheader", "--format", "%t", check=False),
                          "an idle node")
        except Exception:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if len(self.daemons) > 1:
            self.run("scancel", "--user", "root", check=False)
            end = time.time() + 15
            while self.jobs() and time.time() < end:
                time.sleep(0.2)
        for daemon in reversed(self.daemons):
            daemon.send_signal(signal.SIGTERM)
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()

    def logs(self):
        text = ""
        for name in sorted(os.listdir(self.folder)):
            if name.endswith((".log", ".out")):
                with open(f"{self.folder}/{name}", errors="replace") as file:
                    text += f"--- {name}\n" + file.read()[-3000:]
        return text
