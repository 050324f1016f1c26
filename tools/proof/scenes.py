"""Scenes with everything on: objects of every shape and model, parts, lights, plumes, weather, sun, stars."""

import places

NAMES = ["day", "rain", "snow", "night", "fog"]

OBJECTS = """
[[object]]
name = "tower"
shape = "box"
size_m = [12, 12, 45]
at = [{x}, {y}, 0]
colour = "#d8c8b0"

[[object]]
name = "ball"
shape = "sphere"
radius_m = 9
at = [{x1}, {y}, 30]
colour = "#b03030"

[[object]]
name = "egg"
shape = "ellipsoid"
radii_m = [4, 9, 6]
at = [{x}, {y1}, 18]
yaw_deg = 30
roll_deg = 20

[[object]]
name = "mast"
shape = "cylinder"
radius_m = 0.4
height_m = 60
at = [{x2}, {y1}, 0]

[[object]]
name = "tent"
shape = "cone"
radius_m = 8
height_m = 7
at = [{x1}, {y1}, 0]
slope = true

[[object]]
name = "pad"
shape = "disc"
radius_m = 12
at = [{x2}, {y}, 0.5]

[[object]]
name = "cable"
shape = "line"
width_m = 0.03
width_px = 0.7
at = [{x}, {y}, 45]
to = [{x2}, {y1}, 60]

[[object]]
name = "buoy"
shape = "point"
radius_m = 0.2
size_px = 1.5
at = [{x1}, {y2}, 3]

[[object]]
name = "barn"
model = "../valley/valley-barn.obj"
length_m = 25
origin = "base"
at = [{x2}, {y2}, 0]
slope = true

[[object]]
name = "chapel"
model = "../valley/valley-chapel.glb"
origin = "base"
at = [{x}, {y2}, 0]

[[object]]
name = "gravel"
model = "../valley/valley-gravel.vox"
scale = 0.5
at = [{x3}, {y}, 0]

[[object]]
name = "plane"
model = "{realdata}/models/airplane/airplane.glb"
length_m = 18
track = "{name}-plane.csv"
bank = true
beyond = "dead-reckoning"

[[object]]
name = "truck"
shape = "box"
size_m = [2.5, 7, 3.2]
track = "{name}-truck.csv"
slope = true

[[object.part]]
name = "turret"
shape = "cylinder"
radius_m = 1.3
height_m = 0.8
offset_m = [0, 0.4, 3.2]
turn_rpm = 6

[[object.part]]
name = "gun"
parent = "turret"
shape = "line"
length_m = 5
width_m = 0.16
offset_m = [0, 1.0, 0.4]
pitch_deg = 8
"""

LIGHTS = """
[[light]]
kind = "runway"
at = [{x}, {y1}, 0.4]
yaw_deg = 4
length_m = 700

[[light]]
kind = "approach"
at = [{x}, {y1}, 0.4]
yaw_deg = 4

[[light]]
kind = "papi"
at = [{x1}, {y1}, 0.6]
yaw_deg = 4

[[light]]
kind = "vasi"
at = [{x2}, {y1}, 0.6]
yaw_deg = 4

[[light]]
kind = "beacon"
at = [{x3}, {y}, 40]

[[light]]
kind = "town"
at = [{x2}, {y2}, 6]
extent_m = [400, 300]
count = 120

[[light]]
kind = "string"
at = [{x}, {y2}, 5]
to = [{x3}, {y2}, 5]
spacing_m = 25
running_s = 2
flash_s = [3, 0.5]

[[light]]
object = "truck"
offset_m = [0, 3.6, 1]
beam_deg = [40, 20]
candela = 20000
"""

PLUMES = """
[[plume]]
kind = "dust"
object = "truck"
offset_m = [0, -3, 0.3]

[[plume]]
kind = "smoke"
at = [{x}, {y}, 45]
wind_mps = [3, 1]

[[plume]]
kind = "steam"
at = [{x1}, {y2}, 5]
"""

WEATHER = {
    "day": """
[sun]
azimuth_deg = 210
elevation_deg = 25
shadows = true
[air]
visibility_m = 12000
[clouds]
base_m = {base}
top_m = {top}
coverage = 0.45
wind_mps = [4, 2]
""",
    "rain": """
[sun]
azimuth_deg = 120
elevation_deg = 35
[precipitation]
kind = "rain"
rate_mm_h = 8
wind_mps = [5, -2]
""",
    "snow": """
[sun]
time = "2026-01-21T11:30:00Z"
shadows = true
[precipitation]
kind = "snow"
rate_mm_h = 2
""",
    "night": """
[sun]
time = "2026-06-21T00:30:00Z"
[night]
light_lx = 0.25
""",
    "fog": """
[sun]
azimuth_deg = 80
elevation_deg = 8
shadows = true
[fog]
top_m = {fog}
visibility_m = 300
[picture]
tone = "filmic"
vignette = 0.2
[hud]
""",
}

# Heights of cloud base and top, of the fog's upper edge and of the aeroplane, metres above the datum.
LAYERS = {"valley": (1300, 1700, 930, 1200), "sba": (300, 700, 25, 150)}


def write(_data, realdata, work):
    folder = work / "scenes"
    folder.mkdir(exist_ok=True)
    for name, (base, top, fog, flown) in LAYERS.items():
        x, y = places.BY_NAME[name].middle()
        near = {f"x{i or ''}": x + 70 * i for i in range(4)} | {f"y{i or ''}": y + 90 * i for i in range(3)}
        values = near | {"base": base, "top": top, "fog": fog, "name": name, "realdata": realdata}
        for scene, weather in WEATHER.items():
            text = weather + OBJECTS + LIGHTS + PLUMES
            (folder / f"{name}-{scene}.toml").write_text(text.format(**values))
        write_track(folder / f"{name}-truck.csv", "alt_agl_m", x, y, 0)
        write_track(folder / f"{name}-plane.csv", "alt_msl_m", x + 40, y + 60, flown)


def write_track(path, altitude, x, y, height):
    """A winding way about a place that lasts as long as the flight."""
    rows = [f"{t},{x + t / 4 - 100},{y + 2 * (t % 100)},{height}" for t in range(0, 801, 20)]
    path.write_text(f"time_s,x_m,y_m,{altitude}\n" + "\n".join(rows) + "\n")
