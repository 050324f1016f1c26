"""Answers of the commands that ask a database: maps, lines, tables, plots."""

import places
from step import Step


def all(data, _realdata, _work):
    steps = []
    for place in places.ALL:
        steps += about(place)
    buildings = data / "valley-map.geojson"
    return steps + [
        made("heights-of-shadows", ["shadow-heights", buildings, "--sun", "231,28.5", "--imagery", data / "valley-imagery.tif",
                                    "--elevation", data / "valley-elevation.tif", "--all", "--overwrite"], "shadow-heights.csv"),
        Step("corridor/info", ["info", "--json", "--classes", "db/corridor.hop"], hashes_output=True),
        Step("damaged/verify", ["verify", "--json", "db/sba-damaged.hop"], hashes_output=True, may_refuse=True),
        made("frames/sheet", ["contact-sheet", "frames/sba/planes"], "sheet.png"),
        made("frames/compare", ["compare", "frames/sba/planes/0001.png", "frames/sba/planes/0002.png"], "compare.png"),
    ]


def about(place):
    name, (x, y) = place.name, place.middle()
    area, flight = f"db/{name}.hop", ["--path", f"{name}.csv"]
    here, there = f"{x},{y}", f"{x + 300},{y - 200}"
    return [
        made(f"{name}/contours", ["contours", area], f"{name}.geojson"),
        made(f"{name}/contour-map", ["contours", area], f"{name}-contours.tif"),
        made(f"{name}/hillshade", ["hillshade", area], f"{name}-shade.tif"),
        made(f"{name}/hillshade-colour", ["hillshade", area, "--colour", "--level", "4"], f"{name}-shade.png"),
        made(f"{name}/overview", ["overview", area, *flight], f"{name}-overview.png"),
        made(f"{name}/profile", ["profile", area, "--xy", "--from", here, "--to", there], f"{name}-profile.csv"),
        made(f"{name}/profile-plot", ["profile", area, *flight], f"{name}-profile.svg"),
        made(f"{name}/continuity", ["continuity", area, "--fail-on", "cracks", "--picture", f"answers/{name}-faults.png"], f"{name}-faults.csv"),
        Step(f"{name}/info", ["info", "--json", "--classes", area], hashes_output=True),
        Step(f"{name}/verify", ["verify", "--json", area], hashes_output=True),
        Step(f"{name}/height", ["height", area, "--xy", "--json", here, there], hashes_output=True),
        Step(f"{name}/sight", ["sight", area, "--xy", "--json", "--from", f"{here},2", "--to", f"{there},30"], hashes_output=True),
        Step(f"{name}/plan", ["plan", area, *flight, "--fps", places.FPS, "--size", "320x180", "--no-timing",
                              "--traffic", f"answers/{name}-traffic.svg"], [f"answers/{name}-traffic.svg"]),
    ]


def made(name, arguments, output):
    return Step(name, [*arguments, "-o", f"answers/{output}"], [f"answers/{output}"])
