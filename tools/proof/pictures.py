"""Frames of every kind: engines, screens, instruction sets, options of the picture, scenes with everything on."""

import places
import rays
import scenes
from step import Step

# Databases whose colours hold no shadows, so that scenes may throw their own.
UNSHADED = {"valley": "valley.without-shadows", "sba": "sba"}
EVERY_FIFTH = "1-40:5"
AOV = ["--aov", "cryptomatte,motion,position,material"]

# Screens with their flags, and the size of PNG frames of them.
SCREENS = {
    "distorted": (["--distortion=-0.2,0.05"], "160x90"),
    "cylindrical": (["--screen", "cylindrical", "--hfov", "270"], "240x90"),
    "equirectangular": (["--screen", "equirectangular"], "240x120"),
    "fisheye": (["--screen", "fisheye", "--hfov", "220"], "120x120"),
    "table": (["--screen", "table:rays.exr", "--channel", "20,30,5"], None),
    "orthographic": (["--screen", "orthographic", "--ground-width", "900"], "120x120"),
    "channel": (["--channel=-60,10,3"], "160x90"),
}

# What flags of the picture and the engine do, one by one.
OPTIONS = {
    "blocks": ["--surface", "blocks"],
    "flat": ["--curvature", "off"],
    "curved": ["--curvature", "0.13"],
    "low-sun": ["--sun", "250,6", "--shadows", "on"],
    "dusk": ["--sun", "280,-4"],
    "haze": ["--visibility", "3000"],
    "coarse": ["--detail", "0.3"],
    "fine": ["--detail", "4"],
    "antialias": ["--antialias", "2"],
    "shutter": ["--shutter", "180"],
    "instruments": ["--hud"],
    "film": ["--tone", "filmic", "--exposure", "0.7", "--dither", "ordered", "--vignette", "0.3"],
    "gamma": ["--gamma", "1.8"],
    "preload": ["--preload", "--late", "coarser"],
    "workers": ["--jobs", "2", "--in-flight", "3"],
    "unverified": ["--verify", "never"],
    "little-memory": ["--memory", "256M"],
    "raised": ["--clearance", "60"],
}


def all(data, realdata, work):
    places.write_flights(work)
    scenes.write(data, realdata, work)
    rays.write_table(work / "rays.exr", 96, 72)
    steps = []
    for place in places.ALL:
        steps += engines(place.name)
    for name in ("valley", "sba"):
        steps += screens(name) + scenes_over(name)
    return steps + instruction_sets() + options() + others()


def engines(name):
    """All forty poses by both engines, in 8 bits and with all channels."""
    return [
        render(f"{name}/planes", name, "png", "480x270"),
        render(f"{name}/planes-exr", name, "exr", "320x180", *AOV),
        render(f"{name}/reference", name, "png", "96x54", "--engine", "reference"),
        render(f"{name}/reference-exr", name, "exr", "80x45", "--engine", "reference", *AOV),
    ]


def screens(name):
    steps = []
    for screen, (flags, size) in SCREENS.items():
        channels = ["--aov", "cryptomatte,position,material"] if screen == "table" else AOV
        few = ["--frames", EVERY_FIFTH]
        steps.append(render(f"{name}/{screen}", name, "png", size, *flags, *few))
        steps.append(render(f"{name}/{screen}-exr", name, "exr", size, *flags, *few, *channels))
        if screen != "orthographic":
            rare = ["--frames", "1-40:13", "--engine", "reference"]
            steps.append(render(f"{name}/{screen}-reference", name, "png", size, *flags, *rare))
    return steps


def scenes_over(name):
    steps, database = [], UNSHADED[name]
    for scene in scenes.NAMES:
        flags = ["--scene", f"scenes/{name}-{scene}.toml", "--frames", "1-40:2"]
        steps.append(render(f"{name}/{scene}", database, "png", "240x135", *flags, flight=f"{name}-near"))
        steps.append(render(f"{name}/{scene}-exr", database, "exr", "120x68", *flags, *AOV, flight=f"{name}-near"))
        steps.append(render(f"{name}/{scene}-fisheye", database, "png", "100x100", *flags, "--screen", "fisheye", flight=f"{name}-near"))
        rare = [*flags[:2], "--frames", "1-40:9", "--engine", "reference"]
        steps.append(render(f"{name}/{scene}-reference", database, "png", "96x54", *rare, flight=f"{name}-near"))
        steps.append(render(f"{name}/{scene}-reference-exr", database, "exr", "80x45", *rare, *AOV, flight=f"{name}-near"))
    return steps


def instruction_sets():
    name, steps = "valley", []
    for simd in ("avx2", "portable"):
        flags = ["--simd", simd, "--frames", "1-40:3"]
        steps.append(render(f"{name}/{simd}", name, "png", "160x90", *flags))
        steps.append(render(f"{name}/{simd}-exr", name, "exr", "160x90", *flags))
        scene = ["--scene", f"scenes/{name}-day.toml"]
        steps.append(render(f"{name}/{simd}-day", UNSHADED[name], "png", "160x90", *flags, *scene, flight=f"{name}-near"))
    return steps


def options():
    """Each option alone, on a few frames."""
    few, database = ["--frames", "1-40:6"], UNSHADED["valley"]
    return [
        render(f"valley/{option}", database, "png", "160x90", *few, *flags, flight="valley")
        for option, flags in OPTIONS.items()
    ]


def others():
    """Databases that are flown for one reason each, and films."""
    few = ["--frames", "1-40:6"]
    return [
        render("shapes/endless", "shapes", "png", "160x90", *few, "--tile-world"),
        *(render(f"valley/{name}", name, "png", "160x90", *few, flight="valley") for name in ("map", "vines", "airfield", "cover", "corridor")),
        render("corridor/exr", "corridor", "exr", "160x90", *few, flight="valley"),
        render("sba/damaged", "sba-damaged", "png", "160x90", *few, "--damaged", "coarser", flight="sba"),
        render("sba/merged", "sba-merged", "png", "160x90", *few, flight="sba"),
        render("rmnp/baked", "rmnp-baked", "png", "160x90", *few, flight="rmnp"),
        Step("scan", ["render", "db/scan.hop", "--eye", "613700,5242280,20", "--alt-mode", "agl", "--ypr", "40,-20,0", "--size", "160x90",
                      "-o", "frames/scan.png", "--overwrite"], ["frames/scan.png"]),
        Step("film", ["render", "db/sba.hop", "--path", "sba.csv", "--fps", places.FPS, "--size", "160x90", "-o", "film.y4m"], ["film.y4m"]),
    ]


def render(folder, database, extension, size, *flags, flight=None):
    arguments = ["render", f"db/{database}.hop", "--path", f"{flight or database}.csv", "--fps", places.FPS]
    arguments += ["--size", size] if size else []
    arguments += ["--allow-below-ground", "--overwrite"]
    arguments += [] if "--jobs" in flags else ["--jobs", "1"]
    arguments += [*flags, "-o", f"frames/{folder}/####.{extension}"]
    return Step(folder, arguments, [f"frames/{folder}/*.{extension}", f"frames/{folder}/poses.csv"])
