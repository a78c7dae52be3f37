#!/usr/bin/env python3
"""A Slurm of two nodes on this machine, and the array of docs/SCALE.md on it.

    loopback_slurm.py MEANDER FAULT_PROGRAM [--keep FOLDER]        exit status 77: Slurm is not installed, or not root

It starts munged, slurmctld and two slurmd in a folder of their own, plans a run of 64 models in 8 shards, and
submits the script that `meander plan --emit slurm` prints. While it works a task gets the signal of its time limit,
another is killed (SIGKILL), a second copy of a third is started beside it, and two are taken out of the queue. A
second array then does what `meander status --array` names, and the merged store must have the bytes of one process.

Another array then loses a node: its daemon and the shells of its tasks are killed, while the processes of the tasks live
on where nobody sees them. One goes on with its work; the others hang (SIGSTOP) until second copies on the other node
were refused, and are killed then. The store must be the same again, and what was recorded must not be done twice.
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import scene

TOOLS = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol"]
SHARDS, MODELS, SLOW = 8, 64, 1000  # milliseconds of a model

CONFIGURATION = """
ClusterName=loop
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=10000
ReturnToService=2
SlurmctldPort=16817
SlurmdPort=16818
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmdSpoolDir={folder}/spool-%n
StateSaveLocation={folder}/state
SlurmctldLogFile={folder}/log/slurmctld.log
SlurmdLogFile={folder}/log/slurmd-%n.log
SlurmdParameters=config_overrides
MaxArraySize=1001
JobRequeue=1
SlurmdTimeout=20
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port=16821 CPUs=4
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port=16822 CPUs=4
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class Slurm:
    """The daemons; they end with the scope."""

    def __init__(self, folder):
        self.folder, self.processes, self.nodes = Path(folder), [], []

    def __enter__(self):
        for name in ("state", "log", "spool-n1", "spool-n2"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        configuration = self.folder / "slurm.conf"
        configuration.write_text(CONFIGURATION.format(folder=self.folder, host=os.uname().nodename))
        os.environ["SLURM_CONF"] = str(configuration)
        place = {name: f"--{name}-file={self.folder}/munge.{name}" for name in ("pid", "log", "seed")}
        self.start(["munged", "--foreground", "--force", f"--key-file={key}", f"--socket={self.folder}/munge.socket",
                    place["pid"], place["log"], place["seed"]])
        self.wait(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.start(["slurmctld", "-D", "-c", "-f", configuration])
        for node in ("n1", "n2"):
            self.start(["slurmd", "-D", "-N", node, "-f", configuration])
            self.nodes.append((self.processes[-1], node))
        self.wait(lambda: self.ask(["sinfo", "-h", "-o", "%D %t"]) == "2 idle", "slurmctld and slurmd")
        return self

    def __exit__(self, *_):
        for process in reversed(self.processes):
            process.terminate()
        for process in self.processes:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()

    def start(self, command):
        log = open(self.folder / "log" / (Path(command[0]).name + f"-{len(self.processes)}.out"), "wb")
        self.processes.append(subprocess.Popen([str(word) for word in command], stdout=log, stderr=log))

    def wait(self, done, what, seconds=60):
        end = time.monotonic() + seconds
        while not done():
            if time.monotonic() > end:
                logs = "\n".join(path.read_text(errors="replace")[-1500:] for path in (self.folder / "log").iterdir())
                raise SystemExit(f"loopback_slurm: {what}: not after {seconds} s\n{logs}")
            time.sleep(0.2)

    def ask(self, command):
        return subprocess.run(command, capture_output=True, text=True).stdout.strip()

    def submit(self, script, *options):
        return self.ask(["sbatch", "--parsable", *options, str(script)])

    def tasks(self, job):
        """State by number of the tasks in the queue."""
        lines = self.ask(["squeue", "-h", "-r", "-j", job, "-o", "%K %T"]).splitlines()
        return {int(line.split()[0]): line.split()[1] for line in lines if line.split()[0].isdigit()}


def running():
    """Number, words of the command and variables of every process that can be asked."""
    for folder in Path("/proc").iterdir():
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            variables = (folder / "environ").read_bytes().split(b"\0")
        except OSError:
            continue
        if folder.name.isdigit():
            yield int(folder.name), words, variables


def process_of(task, job):
    """The number of the `meander run` of a task: the process that has its variables."""
    for process, words, variables in running():
        if words[1:2] == [b"run"] and f"SLURM_ARRAY_TASK_ID={task}".encode() in variables \
                and f"SLURM_ARRAY_JOB_ID={job}".encode() in variables:
            return process
    return None


def kill_daemons(slurm, node, jobs):
    """The daemon of a node, what it has started for these jobs, and their shells: the work itself is orphaned."""
    for program, name in slurm.nodes:
        if name == node:
            program.kill()
    for process, words, variables in running():
        daemon = words[0].startswith(b"slurmstepd") and any(f"[{job}.".encode() in words[0] for job in jobs)
        shell = b"bash" in words[0] and any(f"SLURM_JOB_ID={job}".encode() in variables for job in jobs)
        if daemon or shell:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass


def lose_a_node(slurm, folder, expect, findings):
    """The array of d.h5 with a node that dies; returns how many of its tasks were on it."""
    script = expect(["plan", "in", "-o", "d.h5", "-n", "64", "--shards", str(SHARDS), "--emit", "slurm"], 0, "plan")
    (folder / "dead.sh").write_text(script)
    job = slurm.submit("dead.sh", "--cpus-per-task=1", "--output=dead-%a.log")
    slurm.wait(lambda: all(process_of(task, job) for task in range(SHARDS)), "the tasks start on both nodes")
    time.sleep(2.5)
    places = [line.split() for line in slurm.ask(["squeue", "-h", "-r", "-j", job, "-o", "%K %N %A"]).splitlines()]
    lost = {int(task): number for task, node, number in places if node == "n1"}
    orphans = {task: process_of(task, job) for task in lost}
    goes_on = min(lost)
    kill_daemons(slurm, "n1", lost.values())
    # Not before: a stopped process whose parents die is sent SIGHUP.
    for task, process in orphans.items():
        if task != goes_on:
            os.kill(process, signal.SIGSTOP)
    slurm.ask(["scontrol", "update", "nodename=n1", "state=down", "reason=dead"])

    def log(task):
        path = folder / f"dead-{task}.log"
        return path.read_text(errors="replace") if path.exists() else ""
    hung = [task for task in lost if task != goes_on]
    slurm.wait(lambda: all("another process" in log(task) for task in hung), "second copies are refused", 400)
    for task in hung:
        os.kill(orphans[task], signal.SIGKILL)
    slurm.wait(lambda: not slurm.tasks(job), "the tasks of the lost node end on the other one", 600)
    missing = expect(["status", "d.h5.run", "--array"], 75 if shards_missing(folder) else 0, "status").strip()
    if missing:  # a task that was refused three times stays out of the queue
        second = slurm.submit("dead.sh", f"--array={missing}", "--cpus-per-task=1", "--output=dead-%a.log")
        slurm.wait(lambda: not slurm.tasks(second), "the second array ends", 120)
    for task in hung:
        if "continuing" not in log(task):
            findings.add(f"task {task} of the lost node did not go on from its journal: {log(task)}")
    expect(["merge", "d.h5.run"], 0, "merge after a lost node")
    if not (folder / "d.h5").exists() or (folder / "d.h5").read_bytes() != (folder / "whole.h5").read_bytes():
        findings.add("the store of the array with a lost node is not that of one process", folder / "d.h5")
    return len(lost)


def shards_missing(folder):
    shards = folder / "d.h5.run" / "shards" / "000"
    return any(not (shards / f"shard-{shard:06}.h5").exists() for shard in range(SHARDS))


def main():
    parser = scene.arguments(__doc__)
    parser.add_argument("fault_program", help="the program with delays put into it")
    given = parser.parse_args()
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing or os.geteuid() != 0:
        print(f"skipped: {'not installed: ' + ', '.join(missing) if missing else 'only root can start the nodes'}")
        sys.exit(77)
    findings = scene.Findings("loopback_slurm", given.keep)
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as cluster:
        folder = Path(folder)
        scene.write_models(folder / "in", MODELS)
        given.fault_program = os.path.abspath(given.fault_program)
        os.environ["MEANDER_TEST_FAULT"] = f"slow:{SLOW}"
        meander = os.path.abspath(given.meander)

        def expect(command, code, what):
            # A script calls the program that wrote it.
            ended = scene.run([given.fault_program if "--emit" in command else meander] + command, cwd=folder)
            if ended.code != code:
                findings.add(f"{what}: exit code {ended.code}, not {code}: {ended.err} {ended.out}")
            return ended.out

        expect(["run", "in", "-o", "whole.h5", "-n", "64", "--progress", "none"], 0, "one process")
        script = expect(["plan", "in", "-o", "s.h5", "-n", "64", "--shards", str(SHARDS), "--emit", "slurm"], 0, "plan")
        (folder / "job.sh").write_text(script)
        os.chdir(folder)
        with Slurm(cluster) as slurm:
            job = slurm.submit("job.sh", "--cpus-per-task=1", "--output=task-%a.log")
            slurm.wait(lambda: all(process_of(task, job) for task in range(3)), "the first tasks start")
            time.sleep(2.5)  # some of the models of each are done
            # What a limit of time does: the signal that the script asks for, to the shell of the task.
            slurm.ask(["scancel", "--signal=TERM", "--batch", f"{job}_0"])
            os.kill(process_of(1, job), signal.SIGKILL)
            expect(["run", "s.h5.run", "--shard", f"2/{SHARDS}", "--progress", "none"], 75, "a second copy of a task")
            slurm.ask(["scancel", f"{job}_3", f"{job}_4"])
            time.sleep(1)
            slurm.wait(lambda: all(state != "RUNNING" for task, state in slurm.tasks(job).items() if task > 1),
                       "the other tasks end")
            slurm.wait(lambda: not slurm.tasks(job), "the tasks that were put back end", 400)
            logs = {task: (folder / f"task-{task}.log").read_text(errors="replace") for task in range(SHARDS)}
            for task in (0, 1):
                if "continuing" not in logs[task]:
                    findings.add(f"task {task} did not go on from its journal: {logs[task]}")
            again = expect(["status", "s.h5.run", "--array"], 75, "status after the first array").strip()
            if again != "3-4":
                findings.add(f"missing after the first array: {again}, not 3-4")
            expect(["merge", "s.h5.run"], 75, "merge with missing shards")
            second = slurm.submit("job.sh", f"--array={again}", "--cpus-per-task=1", "--output=task-%a.log")
            slurm.wait(lambda: not slurm.tasks(second), "the second array ends", 120)
            expect(["status", "s.h5.run"], 0, "status after the second array")
            lost = lose_a_node(slurm, folder, expect, findings)
        expect(["merge", "s.h5.run"], 0, "merge")
        if not (folder / "s.h5").exists() or (folder / "s.h5").read_bytes() != (folder / "whole.h5").read_bytes():
            findings.add("the merged store is not that of one process", folder / "s.h5", folder / "whole.h5")
        if findings.problems:
            for path in sorted([*folder.glob("task-*.log"), *folder.glob("dead-*.log")]):
                print(f"--- {path.name}\n{path.read_text(errors='replace')}")
        os.chdir("/")
    findings.end(f"{SHARDS} shards on 2 nodes: 1 task ended by the signal of its limit, 1 killed, 1 second copy "
                 f"refused, 2 canceled, 1 second array; a node lost with {lost} tasks, 1 of which went on unseen "
                 "and the others hung; merged stores as of one process")


if __name__ == "__main__":
    main()
