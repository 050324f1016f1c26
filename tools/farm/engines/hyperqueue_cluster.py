"""Run the chunks of a prepared job on a HyperQueue server and workers of this process.

    python3 hyperqueue_cluster.py FRAMES.job CHUNKS

The Python package brings server and workers without the program `hq`. Its
tasks count from 0 and chunks from 1, so each task gets its chunk as argument.
It prints the exit code of each chunk as JSON, and ends with 77 and a line on
standard error where the package is missing.
"""

import json
import os
import re
import shutil
import sys
import tempfile

import processes

WORKERS = 2


def run(cluster, hyperqueue, job, chunks):
    """Run one task per chunk, wait for all, and return their exit codes by chunk."""
    from hyperqueue.ffi.protocol import ResourceRequest

    # By default a job ends at its first failure.
    tasks = hyperqueue.Job(max_fails=None, default_workdir="/")
    for chunk in chunks:
        tasks.program(["sh", os.path.join(job, "chunk.sh"), str(chunk)], stdout=None, stderr=None,
                      resources=ResourceRequest(cpus=1))
    client = cluster.client()
    submitted = client.submit(tasks)
    codes = dict.fromkeys(chunks, 0)
    if not client.wait_for_jobs([submitted], raise_on_error=False):
        for number, why in client.get_failed_tasks(submitted).items():
            code = re.search(r"exit code (-?\d+)", why.error)
            codes[chunks[number]] = int(code.group(1)) if code else why.error
    return codes


def main():
    os.environ.setdefault("TQDM_DISABLE", "1")
    try:
        import hyperqueue
        from hyperqueue.cluster import LocalCluster, WorkerConfig
    except ImportError:
        print("skipped: no Python package hyperqueue", file=sys.stderr)
        return 77
    job, count = os.path.abspath(sys.argv[1]), int(sys.argv[2])
    processes.adopt_orphans()
    folder = tempfile.mkdtemp(prefix="hyperqueue-")
    # The server prints a table; standard output is for the result.
    result = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    try:
        cluster = LocalCluster(folder)
        for _ in range(WORKERS):
            cluster.start_worker(WorkerConfig(cores=1))
        codes = run(cluster, hyperqueue, job, list(range(1, count + 1)))
        cluster.stop()
    finally:
        processes.end_descendants()
        shutil.rmtree(folder, ignore_errors=True)
    print(json.dumps(codes), file=result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
