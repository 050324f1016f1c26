"""Tests of the comparison that need neither peers nor hedgehop: python3 -m unittest discover tools/against"""
import array
import json
import math
import pathlib
import tempfile
import unittest

import agreement
import convert
import peers
import run
import tables

SCREEN = peers.Screen(20, 10, 60.0)

EMBREE = """\
embree 4.4.0  native 4/8/16: 111  n=64 geom=tri prims=7938 packet=16 coherent=1 threads=1 device=''
fill 0.09 s  build 1.50 s  embree now 412 MB, peak 444 MB  rss now 467 MB, peak 500 MB
pose 0  wall min 30.00 max 31.00 ms  cpu min 20.50 ms  8.77 Mrays/s  hits 53.4%  mean range 1.3  max 4.4
pose 1  wall min 40.00 max 41.00 ms  cpu min 10.25 ms  8.33 Mrays/s  hits 54.3%  mean range 1.2  max 4.5
mean of 2 poses: wall 35.00 ms/frame  cpu 15.38 ms/frame  9.48 Mrays/cpu-s  (tri, 1 threads)
"""
VOXELSPACE = """\
voxelspace  n=64 threads=1  build 0.00 s  peak rss 115 MB
pose 0  wall min 5.00 ms  cpu min 4.00 ms  hits 53.4%
pose 1  wall min 6.00 ms  cpu min 3.00 ms  hits 50.1%
"""
POVRAY = """\
pose 0: parse 1.40 cpu-s  trace wall 3.10 s  cpu 3.05 s
pose 1: parse 1.41 cpu-s  trace wall 3.20 s  cpu 2.95 s
povray n=64 threads=1: mean trace wall 3150 ms/frame, cpu 3000 ms/frame, 0.7 Mrays/cpu-s, peak rss 181 MB
"""
VTK = """\
['OpenGL renderer string:  llvmpipe'] setup + first frame 6.3 s peak rss 2188 MB
pose 0: wall min 1700 ms  cpu min 1650 ms
pose 1: wall min 1600 ms  cpu min 1550 ms
vtk 9.5.0 n=64 LP_NUM_THREADS=1: wall 1650 ms/frame  cpu 1600 ms/frame  peak rss 2188 MB
"""


def peer(name):
    return next(peer for peer in peers.ALL if peer.name == name)


def frame(wall, cpu, march=0.0, shade=0.0):
    return {"frame": 1, "wall_ms": wall, "cpu_ms": cpu, "march_ms": march, "shade_ms": shade, "image_ms": 1.0}


def write_ranges(file, values):
    file.write_bytes(array.array("f", values).tobytes())


class WhatPeersPrint(unittest.TestCase):
    def test_cpu_time_of_each_pose(self):
        for name, text, times in (
            ("embree-triangles", EMBREE, [20.5, 10.25]),
            ("voxelspace", VOXELSPACE, [4.0, 3.0]),
            ("povray", POVRAY, [3050.0, 2950.0]),
            ("vtk", VTK, [1650.0, 1550.0]),
        ):
            self.assertEqual(peer(name).cpu_ms(text), times, name)

    def test_versions(self):
        self.assertEqual(peer("embree-grid").version(EMBREE), "4.4.0")
        self.assertEqual(peer("vtk").version(VTK), "9.5.0")
        self.assertEqual(peer("voxelspace").version(VOXELSPACE), "")

    def test_a_pose_that_is_missing_is_an_error(self):
        for text in ("", "cannot read poses\n", EMBREE.replace("pose 0  ", "post 0  ")):
            with self.assertRaises(peers.PeerError):
                peer("embree-grid").cpu_ms(text)


class WhatPeersNeed(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.scene = peers.Scene(self.folder, 64, "open")
        self.found = peers.Found((self.folder,), "python3")

    def fill(self):
        for file in ("embree_bench", "height_64.f32", "rgb_64.raw", "open_64.txt"):
            (self.folder / file).touch()

    def test_a_missing_program_names_the_remedy(self):
        self.assertIn("libembree", peer("embree-grid").missing(self.found, self.scene))

    def test_missing_data_are_named(self):
        self.fill()
        self.scene.colours.unlink()
        self.assertIn("rgb_64.raw", peer("embree-grid").missing(self.found, self.scene))

    def test_memory_decides(self):
        self.fill()
        self.assertIsNone(peer("embree-triangles").missing(self.found, self.scene, 1 << 30))
        self.assertIn("GiB", peer("embree-triangles").missing(self.found, self.scene, 1 << 20))

    def test_one_thread_and_the_size_are_asked_for(self):
        self.fill()
        words = peer("embree-triangles").command(self.found, self.scene, SCREEN, 4, self.folder)
        flags = dict(zip(words[1::2], words[2::2]))
        self.assertEqual(flags["--geom"], "tri")
        self.assertEqual((flags["--threads"], flags["--runs"]), ("1", "4"))
        self.assertEqual((flags["--width"], flags["--height"], flags["--hfov"]), ("20", "10", "60.0"))
        self.assertEqual(flags["--out"], str(self.folder))
        self.assertNotIn("--out", peer("maxmip").command(self.found, self.scene, SCREEN, 4, None))

    def test_a_program_that_fails_is_quoted(self):
        with self.assertRaisesRegex(peers.PeerError, "ended with 3, saying: no device"):
            peers.output(["sh", "-c", "echo no device >&2; exit 3"])


class WhatHedgehopSays(unittest.TestCase):
    def test_stages_are_scaled_by_the_share_of_the_cpu(self):
        figures = run.hedgehop_frame(frame(20.0, 10.0, march=8.0, shade=4.0))
        self.assertEqual((figures["frame_ms"], figures["march_shade_ms"], figures["cpu_share"]), (10.0, 6.0, 0.5))

    def test_without_cpu_time_wall_time_counts(self):
        figures = run.hedgehop_frame(frame(20.0, None, march=8.0))
        self.assertEqual((figures["frame_ms"], figures["march_shade_ms"]), (20.0, 8.0))

    def test_json_of_another_shape_is_an_error(self):
        good = {"hedgehop": "1.2.3", "engine": "planes", "simd": "avx2", "frames_by_reference": 0}
        good["results"] = [{"fastest_passes": [frame(2.0, 1.0)]}]
        found = {"hedgehop_version": "1.2.3", "hedgehop_engine": "planes", "hedgehop_simd": "avx2"}
        self.assertEqual(run.bench_figures(json.dumps(good), 1)[0], {**found, "hedgehop_frames_by_reference": 0})
        for text in ("", "{}", "[]", '{"results": []}', json.dumps(good).replace("march", "stride")):
            with self.assertRaises(run.BenchError):
                run.bench_figures(text, 1)
        with self.assertRaises(run.BenchError):
            run.bench_figures(json.dumps(good), 2)


class WhatIsAsked(unittest.TestCase):
    def test_scan_planes_are_measured_unless_another_engine_is_named(self):
        asked = lambda *words: run.arguments(["--data", ".", "--terrain", "64=a.hop", *words]).engine
        self.assertEqual(asked(), "planes")
        self.assertEqual(asked("--engine", "reference"), "reference")

    def test_the_engine_is_passed_to_bench(self):
        # A program that says what it was called with instead of figures.
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "hedgehop"
            program.write_text('#!/bin/sh\necho "$@" >&2\nexit 1\n')
            program.chmod(0o755)
            options = run.arguments(["--data", ".", "--terrain", "64=a.hop", "--engine", "reference"])
            with self.assertRaisesRegex(peers.PeerError, "--engine reference"):
                run.bench(program, "a.hop", "poses.csv", SCREEN, options, 1)


class Ratios(unittest.TestCase):
    def duel(self, name, rounds):
        duel = run.Duel(peer(name), peers.Scene(pathlib.Path("."), 64, "open"))
        for theirs, ours in rounds:
            duel.add(theirs, [run.hedgehop_frame(one) for one in ours])
        duel.agreement = {"range_error_median": 1e-5, "range_error_p99": 1e-3, "far_off": 0.0, "hit_disagreement": 0.0}
        return duel

    def test_a_ratio_is_of_the_best_round_of_each_pose(self):
        rounds = [
            ([100.0, 300.0], [frame(10.0, 10.0, 5.0), frame(40.0, 20.0, 20.0)]),
            ([120.0, 200.0], [frame(12.0, 9.0, 5.0), frame(20.0, 20.0, 10.0)]),
        ]
        row = self.duel("embree-grid", rounds).row(SCREEN, {"hedgehop_version": "1"})
        self.assertEqual(row["peer_ms"], 150.0)
        self.assertEqual(row["hedgehop_frame_ms"], 15.0)
        self.assertAlmostEqual(row["ratio_frame"], 10.0)
        self.assertAlmostEqual(row["ratio_march_shade"], 20.0)
        self.assertEqual(row["ratio_frame_of_poses"], [10.0, 10.0])
        self.assertAlmostEqual(row["peer_pixels_per_cpu_s"], 200 / 0.15)

    def test_other_numbers_of_poses_are_an_error(self):
        with self.assertRaises(peers.PeerError):
            self.duel("embree-grid", [([1.0], [frame(1.0, 1.0)] * 2)])

    def test_the_faster_embree_is_marked_and_both_tables_show_all(self):
        versions = {"hedgehop_version": "1", "hedgehop_engine": "planes", "hedgehop_simd": "avx2", "processor": "P"}
        versions["hedgehop_frames_by_reference"] = 1
        rows = [
            self.duel(name, [([time], [frame(2.0, 2.0, 1.0)])]).row(SCREEN, versions)
            for name, time in (("embree-triangles", 40.0), ("embree-grid", 50.0), ("voxelspace", 9.0))
        ]
        run.mark_best(rows)
        self.assertEqual([row["best_of_family"] for row in rows], [True, False, True])
        scenes = [peers.Scene(pathlib.Path("."), 64, path) for path in ("open", "climb")]
        skipped = [("vtk", scene, "no vtk_bench.py") for scene in scenes]
        for as_markdown in (False, True):
            text = tables.render(rows, skipped, SCREEN, as_markdown)
            for part in ("hedgehop 1, planes on avx2", "reference engine: open 64", "embree-triangles *", "voxelspace", "(1.0e-05)", "20.00", "skipped: vtk (open 64, climb 64)"):
                self.assertIn(part, text)
        self.assertEqual(tables.render(rows, [], SCREEN, True).splitlines()[1].count("---:"), len(tables.HEADINGS) - 3)


class Ranges(unittest.TestCase):
    def test_agreement_of_two_images(self):
        sky = math.inf
        with tempfile.TemporaryDirectory() as folder:
            theirs, ours = pathlib.Path(folder) / "a", pathlib.Path(folder) / "b"
            # Only every STEP-th pixel is looked at: four of these.
            spread = lambda values: [v for value in values for v in [value] + [7.0] * (agreement.STEP - 1)]
            write_ranges(theirs, spread([100.0, 200.0, sky, 50.0]))
            write_ranges(ours, spread([101.0, 200.0, sky, sky]))
            pixels = 4 * agreement.STEP
            found = agreement.agreement([(agreement.read(theirs, pixels), agreement.read(ours, pixels))])
            self.assertAlmostEqual(found["range_error_median"], 0.01)
            self.assertEqual(found["hit_disagreement"], 0.25)
            with self.assertRaisesRegex(agreement.RangeError, "bytes"):
                agreement.read(theirs, pixels + 1)
            with self.assertRaises(agreement.RangeError):
                agreement.read(pathlib.Path(folder) / "c", pixels)

    def test_nothing_in_common_has_no_median(self):
        found = agreement.agreement([([math.inf], [3.0])])
        self.assertIsNone(found["range_error_median"])
        self.assertEqual(found["hit_disagreement"], 1.0)


class Poses(unittest.TestCase):
    def test_yaw_turns_from_east_to_north_and_samples_are_centres(self):
        lines = convert.path_csv("# x y z roll pitch yaw\n1 2 3 0 -10 0\n\n4 5 6 7 8 90\n").splitlines()
        self.assertEqual(lines[1:], ["0,1.5,2.5,3.0,90.0,-10.0,0.0", "1,4.5,5.5,6.0,0.0,8.0,7.0"])


if __name__ == "__main__":
    unittest.main()
