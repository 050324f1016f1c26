"""Tests of the simulation against what can be worked out by hand: python3 -m unittest discover tools/farm"""
import dataclasses
import json
import math
import pathlib
import statistics
import tempfile
import unittest

import chunks as cutting
import farm as farms
import flight as flights
import pagecache
import parameters
import report
import search
import simulate
import validate
from events import Events
from ledger import COLUMNS
from sharing import Sharing
from storage import Storage

#: A farm that wastes nothing.
IDEAL = parameters.Farm(
    workers_per_host=1, cores_per_host=1.0, busy_slowdown=1.0, start_s=0.0, task_s=0.0, latency_s=0.0, slow_hosts=0.0,
    slow_tasks=0.0, failure_s=0.0, prediction_error=0.0, policy="count", manifest_entry_s=0.0, chunk_frames=10,
)


def level(count, seconds=1.0, view=0.0, fresh=0.0, written=0.0, first_s=0.0, check_s=0.0):
    """A flight whose frames are all alike."""
    highs = [view + fresh * i for i in range(count)]
    lows = [high - view for high in highs]
    return flights.Flight([seconds] * count, lows, highs, [written] * count, first_s, check_s)


def ran(flight, seed=0, chunks=None, **changes):
    """A run of the ideal farm with some changes."""
    farm = dataclasses.replace(IDEAL, **changes)
    return farms.Run(flight, chunks or cutting.cut(flight, farm, seed), farm, seed)


class ClosedForm(unittest.TestCase):
    def test_one_worker_takes_the_sum(self):
        flight = flights.made_up(flights.KINDS["film"], 300, view_bytes=0.0, fresh_bytes=0.0)
        flight = dataclasses.replace(flight, written=[0.0] * 300)
        run = ran(flight, workers=1)
        self.assertAlmostEqual(run.makespan_s, sum(flight.seconds), places=6)
        self.assertAlmostEqual(run.efficiency, 1.0)

    def test_equal_chunks_on_as_many_workers_take_one_chunk(self):
        run = ran(level(120), workers=12)
        self.assertAlmostEqual(run.makespan_s, 10.0)
        self.assertAlmostEqual(run.efficiency, 1.0)

    def test_one_chunk_more_than_workers_takes_two(self):
        run = ran(level(130), workers=12)
        self.assertAlmostEqual(run.makespan_s, 20.0)
        self.assertAlmostEqual(run.ledger.seconds["tail"], 11 * 10.0)

    def test_start_first_frame_and_hand_out_are_once_a_chunk(self):
        run = ran(level(100, first_s=0.25), workers=1, start_s=0.5, task_s=0.125, latency_s=0.125)
        self.assertAlmostEqual(run.makespan_s, 100.0 + 10 * 1.0)
        self.assertAlmostEqual(run.ledger.seconds["start"], 7.5)
        self.assertAlmostEqual(run.ledger.seconds["engine"], 2.5)

    def test_the_engine_serves_one_worker_after_the_other(self):
        run = ran(level(1000, seconds=0.1), workers=100, task_s=2.0)
        self.assertAlmostEqual(run.makespan_s, 100 * 2.0 + 1.0)
        self.assertGreater(run.ledger.seconds["engine"], 0.4 * run.ledger.total())

    def test_processes_share_cores(self):
        run = ran(level(40), workers=4, workers_per_host=4, cores_per_host=2.0)
        self.assertAlmostEqual(run.makespan_s, 20.0)
        self.assertAlmostEqual(run.ledger.seconds["crowd"], 40.0)

    def test_a_process_may_use_more_than_a_core(self):
        run = ran(level(10), workers=1, cores_per_host=2.0, overlap=1.25)
        self.assertAlmostEqual(run.makespan_s, 8.0)

    def test_busy_cores_are_slower(self):
        run = ran(level(20), workers=2, workers_per_host=2, cores_per_host=2.0, busy_slowdown=1.25)
        self.assertAlmostEqual(run.makespan_s, 12.5)

    def test_threads_of_a_process_share_its_frames(self):
        run = ran(level(80), workers=8, threads=4, workers_per_host=4, cores_per_host=4.0, thread_efficiency=0.8)
        self.assertAlmostEqual(run.makespan_s, 80 / 8 / 0.8)
        self.assertAlmostEqual(run.efficiency, 0.8)

    def test_a_slow_host_is_slow(self):
        run = ran(level(20), workers=2, slow_hosts=0.5, slow_host_factor=3.0)
        self.assertAlmostEqual(run.makespan_s, 30.0)
        self.assertAlmostEqual(run.ledger.seconds["slow"], 20.0)

    def test_saturated_storage_moves_bytes_at_its_bandwidth(self):
        run = ran(level(1000, seconds=1e-6, written=1e6), workers=50, storage_bytes_per_s=1e7, host_bytes_per_s=1e9)
        self.assertAlmostEqual(run.makespan_s, 1e9 / 1e7, places=3)
        self.assertAlmostEqual(run.storage.moved, 1e9, places=0)
        self.assertAlmostEqual(run.storage.busy_s / run.makespan_s, 1.0, places=5)

    def test_a_host_moves_no_more_than_its_network(self):
        run = ran(level(40, seconds=1e-6, written=1e6), workers=4, workers_per_host=2, cores_per_host=2.0,
                  storage_bytes_per_s=1e9, host_bytes_per_s=1e6)
        self.assertAlmostEqual(run.makespan_s, 20.0, places=3)

    def test_a_host_reads_the_database_once_while_it_fits(self):
        flight = level(100, view=8e6, fresh=1e6)
        run = ran(flight, workers=1, block_bytes=1e6, steps=2)
        self.assertAlmostEqual(run.bytes_read, 8e6 + 99 * 1e6)
        small = ran(flight, workers=1, block_bytes=1e6, page_cache_bytes=4e6, steps=2)
        self.assertAlmostEqual(small.bytes_read, 10 * (8e6 + 9 * 1e6))

    def test_frames_lost_are_rendered_again(self):
        """A frame of f seconds at a rate of losses r takes (e^(rf) - 1) (1/r + d) on the mean, with d to come back."""
        frame, mean, back, count = 10.0, 25.0, 7.0, 20000
        flight = level(count, seconds=frame)
        run = ran(flight, workers=1, chunk_frames=1, failure_s=mean, detection_s=0.0, repair_s=back)
        expected = count * (math.exp(frame / mean) - 1.0) * (mean + back)
        self.assertLess(abs(run.makespan_s / expected - 1.0), 0.02)
        self.assertAlmostEqual(run.wasted_frames / (count * (math.exp(frame / mean) - 1.0)), 1.0, delta=0.03)

    def test_whole_frames_of_a_lost_chunk_stay_and_are_checked(self):
        flight = level(200, check_s=0.5)
        run = ran(flight, workers=1, chunk_frames=200, failure_s=70.0, detection_s=0.0, repair_s=0.0)
        self.assertGreater(run.losses, 0)
        self.assertLessEqual(run.wasted_frames, run.losses)
        self.assertGreater(run.checked, 0)
        runs = (ran(flight, seed, workers=1, chunk_frames=200, failure_s=200.0, detection_s=0.0, repair_s=0.0)
                for seed in range(99))
        run = next(run for run in runs if run.losses == 1)
        self.assertGreaterEqual(run.makespan_s, 200.0 + 0.5 * run.checked - 1e-6)
        self.assertLess(run.makespan_s, 201.0 + 0.5 * run.checked)

    def test_a_shared_manifest_is_written_by_one_at_a_time(self):
        run = ran(level(100), workers=10, manifest="shared", manifest_entry_s=0.1, manifest_entry_bytes=0.0)
        self.assertAlmostEqual(run.makespan_s, 10.0 + 0.1 * sum(range(10, 101, 10)))


class Conservation(unittest.TestCase):
    def setUp(self):
        self.flight = flights.made_up(flights.KINDS["film"], 3000)
        self.farm = parameters.Farm(workers=60, chunk_frames=13, failure_s=500.0, slow_tasks=0.1, slow_hosts=0.3,
                                    storage_bytes_per_s=3e8)

    def test_every_frame_is_done_once_and_every_second_booked(self):
        for policy in ("count", "cost", "longest", "shrinking"):
            for affinity in (0, 1):
                for manifest in ("parts", "shared"):
                    farm = dataclasses.replace(self.farm, policy=policy, affinity=affinity, manifest=manifest)
                    run = search.one(self.flight, farm, 3)
                    self.assertEqual(set(run.times_done), {1}, policy)
                    self.assertEqual(run.left, 0)
                    self.assertGreater(run.losses, 0)
                    booked = run.ledger.total() / (60 * run.makespan_s)
                    self.assertAlmostEqual(booked, 1.0, places=9)
                    self.assertAlmostEqual(run.ledger.seconds["useful"], sum(self.flight.seconds), places=4)
                    self.assertTrue(all(run.ledger.seconds[name] > -1e-6 for name in COLUMNS), run.ledger.seconds)
                    self.assertAlmostEqual(run.bytes_written, sum(self.flight.written), delta=1.0)

    def test_losses_while_pages_are_read_keep_no_frames(self):
        flight = level(200, view=8e6, fresh=0.0, check_s=0.1, first_s=0.5)
        run = ran(flight, workers=4, failure_s=40.0, detection_s=1.0, repair_s=1.0, start_s=1.0, block_bytes=1e6,
                  page_cache_bytes=2e6, storage_bytes_per_s=4e6, host_bytes_per_s=4e6)
        self.assertGreater(run.losses, 5)
        self.assertEqual(set(run.times_done), {1})
        self.assertAlmostEqual(run.ledger.seconds["useful"], 200.0)
        self.assertAlmostEqual(run.ledger.total(), 4 * run.makespan_s)

    def test_a_seed_is_one_run_and_another_seed_another(self):
        runs = [search.one(self.flight, self.farm, seed) for seed in (1, 1, 2)]
        self.assertEqual(runs[0].makespan_s, runs[1].makespan_s)
        self.assertEqual(runs[0].ledger.seconds, runs[1].ledger.seconds)
        self.assertNotEqual(runs[0].makespan_s, runs[2].makespan_s)

    def test_a_table_and_json_come_of_it(self):
        runs = search.several(self.flight, self.farm, 3)
        self.assertLessEqual(runs[0].makespan_s, runs[2].makespan_s)
        row = report.row(self.flight, self.farm, runs, {}, [])
        self.assertAlmostEqual(row["efficiency"] + sum(row["lost"].values()), 1.0, places=6)
        self.assertEqual(json.loads(json.dumps(row))["workers"], 60)
        self.assertIn("| 60 |", report.markdown([row]))


class Parts(unittest.TestCase):
    def test_jobs_that_come_and_go_share_a_core(self):
        events, ends = Events(), []
        cores = Sharing(events, lambda jobs: 1.0 / jobs)
        cores.add(2.0, lambda: ends.append(("a", events.now)))
        second = cores.add(9.0, lambda: ends.append(("b", events.now)))
        removed = []
        events.at(6.0, lambda: removed.append(cores.remove(second)))
        events.at(7.0, lambda: cores.add(1.0, lambda: ends.append(("c", events.now))))
        events.run(lambda: False)
        self.assertEqual(ends, [("a", 4.0), ("c", 8.0)])
        self.assertEqual(removed, [4.0])

    def test_two_hosts_share_the_storage_and_one_has_its_network(self):
        events, ends = Events(), {}
        storage = Storage(events, 10.0, 8.0)
        for host, name, size in ((1, "a", 10.0), (1, "b", 10.0), (2, "c", 10.0)):
            storage.add(host, size, lambda name=name: ends.setdefault(name, events.now))
        events.run(lambda: False)
        self.assertEqual({name: round(end, 9) for name, end in ends.items()}, {"c": 2.0, "a": 3.25, "b": 3.25})

    def test_a_page_cache_forgets_what_was_not_used_longest(self):
        cache = pagecache.PageCache(2.0, 1.0)
        self.assertEqual([cache.take(i, i + 1) for i in (0, 1, 0, 2, 0, 1)], [1, 1, 0, 1, 0, 1])

    def test_chunks_by_cost_are_alike_and_cover_all(self):
        flight = flights.made_up(flights.KINDS["film"], 5000)
        for policy in ("count", "cost", "longest", "shrinking"):
            farm = dataclasses.replace(IDEAL, policy=policy, chunk_frames=50, workers=10)
            chunks = cutting.cut(flight, farm, 0)
            covered = sorted((chunk.first, chunk.last) for chunk in chunks)
            self.assertEqual([first for first, _ in covered], [0] + [last for _, last in covered[:-1]])
            self.assertEqual(covered[-1][1], 5000)
            costs = [chunk.predicted_s for chunk in chunks]
            if policy == "cost":
                self.assertLess(max(costs) / statistics.mean(costs), 1.05)
            if policy == "count":
                self.assertGreater(max(costs) / statistics.mean(costs), 1.5)
            if policy == "longest":
                self.assertEqual(costs, sorted(costs, reverse=True))

    def test_predictions_err_as_much_as_asked(self):
        flight, farm = level(20000), dataclasses.replace(IDEAL, prediction_error=0.2, error_frames=20)
        logs = [math.log(cost) for cost in cutting.predicted(flight, farm, 0)]
        self.assertAlmostEqual(statistics.pstdev(logs), 0.2, delta=0.02)
        self.assertAlmostEqual(logs[100], logs[101], delta=0.1)

    def test_chunks_are_read_and_gaps_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "job.json"
            parts = {"41-50": 2.5, "1-40": 12.3, "51": 1}
            good = [{"frames": frames, "predicted_s": seconds} for frames, seconds in parts.items()]
            file.write_text(json.dumps({"chunks": good}), encoding="utf-8")
            chunks = cutting.read(file)
            self.assertEqual([(c.first, c.last) for c in chunks], [(40, 50), (0, 40), (50, 51)])
            run = ran(level(51), chunks=chunks, workers=2)
            self.assertAlmostEqual(run.makespan_s, 40.0)
            flight = flights.of_chunks(flights.KINDS["film"], chunks, 0.0, 10)
            self.assertAlmostEqual(sum(flight.seconds[:40]), 12.3)
            self.assertAlmostEqual(sum(flight.seconds), 15.8)
            file.write_text(json.dumps(good[:1] + good[2:]), encoding="utf-8")
            self.assertRaises(ValueError, cutting.read, file)

    def test_a_flight_of_files_is_extended(self):
        with tempfile.TemporaryDirectory() as folder:
            plan, times = pathlib.Path(folder) / "plan.json", pathlib.Path(folder) / "times.json"
            bytes_of_frames = ((100, 100), (100, 10), (80, 0))
            needs = [{"bytes": whole, "first_bytes": first} for whole, first in bytes_of_frames]
            plan.write_text(json.dumps({"by_frame": needs}), encoding="utf-8")
            times.write_text("[1, 2, 3]", encoding="utf-8")
            flight = flights.of_files(flights.KINDS["film"], 8, plan, times)
        self.assertEqual(flight.seconds, [1, 2, 3, 3, 2, 1, 1, 2])
        self.assertEqual(flight.high[:3], [100, 110, 110])
        self.assertEqual(flight.low[:3], [0, 10, 30])

    def test_times_come_from_manifests_and_plans(self):
        manifest = {"settings_digest": "x", "frames": [
            {"cost": {"wall_s": 3.0, "cpu_s": 2.0}}, {"cost": {"wall_s": 4.0}}]}
        planned = {"by_frame": [{"predicted_s": 0.5}, {"predicted_s": 0.25}]}
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "times.json"
            for value, seconds in ((manifest, [2.0, 4.0]), (planned, [0.5, 0.25]), ([1, 2], [1.0, 2.0])):
                file.write_text(json.dumps(value), encoding="utf-8")
                self.assertEqual(flights.read_times(file), seconds)

    def test_parameters_are_checked_and_listed(self):
        self.assertEqual(simulate.changed("slow_tasks=0.5"), ("slow_tasks", 0.5))
        self.assertEqual(simulate.changed("policy=cost"), ("policy", "cost"))
        for field in dataclasses.fields(parameters.Farm):
            self.assertIn(f"| {field.name} |", parameters.described())

    def test_a_calibration_predicts_equal_chunks(self):
        single = validate.Measured(24.0, 24.0, 0.0)
        calibration = validate.Calibration([0.1] * 240, 0.5, 1.0, 1.0, single, single)
        self.assertAlmostEqual(validate.predict(calibration, 2, 2.0, 0.0), 12.0 + 6 * 0.5)
        self.assertAlmostEqual(validate.predict(calibration, 4, 2.0, 0.0), 12.0 + 6 * 0.5)


if __name__ == "__main__":
    unittest.main()
