#!/usr/bin/env python3
"""Simulates render farms: how long a flight takes, what is wasted, how many bytes move, and where it breaks.

    simulate.py [--kind film] [--frames 100000] [--workers 10,100,1000] [--engine hq] [--set NAME=VALUE ...]
    simulate.py --chunks job.json --workers 100       chunks that were cut elsewhere, and what they should take
    simulate.py --validate hedgehop --area AREA.hop --path TRACK     this machine beside its simulation

README.md tells the model; --parameters lists its parameters with units, defaults and where these come from.
"""
import argparse
import dataclasses
import json
import pathlib
import shlex
import sys

import chunks as cutting
import engine as engines
import flight as flights
import parameters
import report
import search
import validate


def changed(text):
    """NAME=VALUE of a parameter."""
    name, _, value = text.partition("=")
    kinds = {field.name: type(field.default) for field in dataclasses.fields(parameters.Farm)}
    if name not in kinds or name == "workers":
        raise argparse.ArgumentTypeError(f"no parameter `{name}`; --parameters lists them")
    try:
        return name, kinds[name](value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"`{value}` is no {kinds[name].__name__} for {name}") from None


def numbers(text):
    """Whole numbers from 1, separated by commas."""
    words = text.split(",")
    if not all(word.isdigit() and int(word) for word in words):
        raise argparse.ArgumentTypeError(f"`{text}` is no list of whole numbers from 1, such as 10,100")
    return [int(word) for word in words]


def arguments(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--kind", choices=sorted(flights.KINDS), default="film", help="measured frames [default: film]")
    add("--frames", metavar="N", type=int, help="[default: 100000, or those of --chunks]")
    add("--workers", metavar="N,...", type=numbers, default=[10, 100, 1000], help="[default: 10,100,1000]")
    add("--engine", choices=sorted(engines.ENGINES), default="hq", help="what hands out tasks [default: hq]")
    add("--plan", metavar="FILE", type=pathlib.Path, help="pages of each frame: `hedgehop plan --json`")
    add("--times", metavar="FILE", type=pathlib.Path, help="seconds of each frame: a manifest.json, `plan --times --json`, `bench --json`, or a JSON list")
    add("--chunks", metavar="FILE", type=pathlib.Path, help='JSON list of {"frames": "1-40", "predicted_s": 12.3}')
    add("--set", metavar="NAME=VALUE", type=changed, action="append", default=[], help="a parameter; may be repeated")
    add("--seeds", metavar="N", type=int, default=5, help="runs of each size; the median counts [default: 5]")
    add("--goal", metavar="SHARE", type=float, default=0.95, help="mends are tried below it [default: 0.95]")
    add("--json", metavar="FILE", help="write the rows as JSON; - is standard output, instead of the table")
    add("--parameters", action="store_true", help="list the parameters")
    add("--validate", metavar="PROGRAM", help="compare with real runs of this program here")
    add("--area", metavar="AREA.hop", type=pathlib.Path, help="database of --validate")
    add("--path", metavar="TRACK", type=pathlib.Path, help="path of --validate")
    add("--render-args", metavar="'FLAG ...'", type=shlex.split, default=[], help="more flags for --validate")
    add("--rounds", metavar="N", type=int, default=3, help="rounds of --validate [default: 3]")
    return parser.parse_args(words)


def flown(options, given):
    """The flight that the options ask for; of chunks alone, their predicted seconds count."""
    kind = flights.KINDS[options.kind]
    count = options.frames or (max(chunk.last for chunk in given) if given else 100000)
    if given and not options.times and not options.plan:
        farm = dataclasses.replace(parameters.Farm(), **dict(options.set))
        return flights.of_chunks(kind, given, farm.prediction_error, farm.error_frames)
    if options.plan or options.times:
        return flights.of_files(kind, count, options.plan, options.times)
    return flights.made_up(kind, count)


def simulated(options):
    """A row for each number of workers."""
    given = cutting.read(options.chunks) if options.chunks else None
    flight = flown(options, given)
    if given and max(chunk.last for chunk in given) != len(flight):
        raise ValueError(f"{options.chunks}: the chunks do not end with frame {len(flight)}")
    task_s, latency_s, array = engines.ENGINES[options.engine]
    rows = []
    for workers in options.workers:
        farm = parameters.Farm(workers=workers, task_s=task_s, latency_s=latency_s)
        farm = dataclasses.replace(farm, **dict(options.set))
        tried = {}
        if given:
            farm = dataclasses.replace(farm, chunk_frames=round(len(flight) / len(given)))
        elif not farm.chunk_frames:
            frames, tried = search.best_length(flight, farm)
            farm = dataclasses.replace(farm, chunk_frames=frames)
        runs = search.several(flight, farm, options.seeds, given)
        steps = [] if given else search.mended(flight, farm, options.goal)
        rows.append(report.row(flight, farm, runs, tried, steps, array))
    return rows


def main(words=None):
    options = arguments(words)
    if options.parameters:
        print(parameters.described(), end="")
        return
    try:
        if options.validate:
            rows = validate.compared(options)
            text = validate.markdown(rows)
        else:
            rows = simulated(options)
            text = report.markdown(rows)
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"error: {error}")
    if options.json:
        written = json.dumps(rows, indent=2) + "\n"
        if options.json != "-":
            pathlib.Path(options.json).write_text(written, encoding="utf-8")
        else:
            sys.stdout.write(written)
            return
    print(text, end="")


if __name__ == "__main__":
    main()
