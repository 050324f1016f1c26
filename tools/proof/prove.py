#!/usr/bin/env python3
"""Renders and hashes a fixed set, to show that a change of the code changes no byte of what the program makes.

    tools/proof/prove.py target/release/hedgehop -o before.txt
    ... change the code, build ...
    tools/proof/prove.py target/release/hedgehop -o after.txt --against before.txt

A line of the list is a SHA-256 and the name of what was hashed. Hashes hold for one machine's vector instructions
(`--simd` asks for others where it matters) and one version of the program; lists of two machines may differ.
The exit code is 0 if nothing differs, 1 if something does, 2 if a command failed that should not have.

Needs Python 3.9 and nothing else. Real places are taken from HEDGEHOP_REALDATA, by default `../shared/realdata`.
"""

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import databases
import pictures
import questions
from step import Step

ROOT = Path(__file__).resolve().parents[2]


def main():
    arguments = parse_arguments()
    if not arguments.realdata.is_dir():
        sys.exit(f"{arguments.realdata}: no such folder; HEDGEHOP_REALDATA says where the real places are")
    with tempfile.TemporaryDirectory(prefix="proof-") as own:
        work = (arguments.work or Path(own)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        lines, failures = run_all(arguments, work)
    text = "".join(f"{digest}  {name}\n" for name, digest in sorted(lines.items()))
    arguments.output.write_text(text)
    print(f"{len(lines)} hashes in {arguments.output}, together {hashlib.sha256(text.encode()).hexdigest()[:16]}")
    for failure in failures:
        print(f"failed: {failure}", file=sys.stderr)
    differing = compare(arguments.against, lines, arguments.only) if arguments.against else 0
    sys.exit(2 if failures else 1 if differing else 0)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda text: Path(text).resolve(), help="the hedgehop to prove")
    parser.add_argument("-o", "--output", type=Path, required=True, help="list of hashes to write")
    parser.add_argument("--against", type=Path, help="list of hashes of before, to compare with")
    parser.add_argument("--only", default="", help="names to run: those that hold this text")
    parser.add_argument("--work", type=Path, help="folder that keeps what is made; by default it is removed")
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count(), help="commands at once")
    default = os.environ.get("HEDGEHOP_REALDATA", ROOT / "../shared/realdata")
    parser.add_argument("--realdata", type=lambda text: Path(text).resolve(), default=Path(default).resolve())
    return parser.parse_args()


def run_all(arguments, work):
    """Runs stage after stage; the steps of one stage run side by side."""
    lines, failures = {}, []
    for stage in (databases.first, databases.derived, databases.merged, pictures.all, questions.all):
        if failures and stage.__module__ == databases.__name__:
            break
        steps = stage(ROOT / "data", arguments.realdata, work)
        if stage.__module__ != databases.__name__:
            steps = [step for step in steps if arguments.only in step.name]
        with ThreadPoolExecutor(arguments.jobs) as pool:
            results = pool.map(lambda step: run(arguments.program, step, work), steps)
            for step, (hashes, failure) in zip(steps, results):
                lines.update(hashes)
                failures.extend([failure] if failure else [])
        print(f"{stage.__module__}.{stage.__name__}: {len(steps)} commands, {len(lines)} hashes so far", flush=True)
    return lines, failures


def run(program, step: Step, work):
    """Runs a step, and hashes what it made."""
    command = [program, *step.arguments]
    done = subprocess.run(command, cwd=work, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    if done.returncode != 0 and not step.may_refuse:
        said = done.stderr.decode(errors="replace").strip()
        words = " ".join(str(word) for word in step.arguments)
        return {}, f"{step.name}: code {done.returncode}: {words}\n    {said}"
    hashes = {}
    if step.hashes_output:
        hashes[f"{step.name}/stdout"] = hashlib.sha256(done.stdout).hexdigest()
    if done.returncode != 0:
        return hashes | {f"{step.name}/refused": hashlib.sha256(str(done.returncode).encode()).hexdigest()}, None
    for pattern in step.files:
        made = sorted(work.glob(pattern))
        if not made:
            return hashes, f"{step.name}: nothing made that is named {pattern}"
        for path in made:
            hashes[str(path.relative_to(work))] = hashlib.sha256(path.read_bytes()).hexdigest()
    return hashes, None


def compare(before, lines, only):
    """Prints what differs from a list of before, and returns how much does."""
    old = {name: digest for digest, name in (line.split("  ", 1) for line in before.read_text().splitlines())}
    gone = [name for name in old if name not in lines and not only]
    differing = [name for name in lines if name in old and old[name] != lines[name]]
    new = [name for name in lines if name not in old]
    for kind, names in (("differs", differing), ("is missing", gone), ("is new", new)):
        for name in sorted(names):
            print(f"{kind}: {name}")
    print(f"{len(lines) - len(differing) - len(new)} of {len(old)} are as before, {len(differing)} differ, {len(gone)} are missing")
    return len(differing) + len(gone)


if __name__ == "__main__":
    main()
