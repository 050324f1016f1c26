"""Databases from every kind of input: rasters of all formats, clouds, features, models, shapes, corridors."""

import shutil

import places
from step import Step

SHAPES = """
[place]
local = true
bbox = [0, 0, 2000, 2000]
spacing_m = 4

[[terrain]]
kind = "plane"
height_m = 100

[[terrain]]
kind = "fractal"
amplitude_m = 60
wavelength_m = 700
seed = 3

[[terrain]]
kind = "dome"
centre = [600, 700]
radius_m = 200
height_m = 80

[[texture]]
kind = "speckle"
colours = ["#a59c8a", "#857c6c", "#c4bdac"]
size_m = 9

[[scatter]]
objects = ["broadleaf", "conifer"]
per_hectare = 5
seed = 2
"""

OUTLINES_RECIPE = """
[place]
spacing_m = 2
[[elevation]]
file = "valley/valley-elevation.tif"
[[features]]
file = "outlines.csv"
crs = "EPSG:32632"
kind = "building"
"""

OUTLINES = """polygon,height_m
"613300 5242100, 613320 5242100, 613320 5242112, 613300 5242112",9
"613340 5242100, 613352 5242100, 613352 5242120, 613340 5242120",12.5
"""


def first(data, realdata, work):
    """Databases that are made from files."""
    (work / "db").mkdir(exist_ok=True)
    (work / "shapes.toml").write_text(SHAPES)
    (work / "outlines.toml").write_text(OUTLINES_RECIPE)
    (work / "outlines.csv").write_text(OUTLINES)
    valley = work / "valley"
    shutil.copytree(data, valley, dirs_exist_ok=True)
    steps = [
        recipe("valley", "valley/valley.toml", "db/valley.without-shadows.hop"),
        recipe("shapes", "shapes.toml"),
        from_rasters("sba", realdata / "sba_airport/sba_elev32_wgs84_512x512.tif", realdata / "sba_airport/sba_rgb_wgs84_512x512.tif"),
        from_rasters("rmnp", realdata / "rmnp/rmnp-dem.tif", realdata / "rmnp/rmnp-rgb.tif", "--nodata-fill", "interp"),
        from_rasters("odm", realdata / "odm_drone_dsm/dsm.tif", realdata / "odm_drone_dsm/odm_ortho_rgb_0p25m.tif", "--spacing", "0.5"),
        from_rasters("little-memory", realdata / "craterlake/craterlake-elev-16bit-30m.tif", None, "--memory", "100M"),
        from_rasters("tiles", realdata / "srtm_tiles/mt_rainier_90m.tif", None),
        build("scan", "--cloud", data / "valley-scan.laz", "--src-vdatum", "egm96"),
        build("map", "--elevation", data / "valley-elevation.tif", "--features", data / "valley-map.geojson"),
        build("vines", "--elevation", data / "valley-elevation.tif", "--features", data / "valley-vineyard.shp"),
        build("airfield", "--elevation", data / "valley-elevation.tif", "--features", data / "valley-airfield.gpkg"),
        recipe("outlines", "outlines.toml"),
        build("cover", "--elevation", data / "valley-elevation.tif", "--land-cover", data / "valley-land-cover.tif", "--land-cover-scheme", "nlcd"),
        build("corridor", "--elevation", data / "valley-elevation.tif", "--imagery", data / "valley-imagery.tif",
              "--corridor", data / "valley-path.csv", "--width", "300", "--spacing", "1.25", "--outside", "20"),
    ]
    return steps + conformance(realdata / "conformance")


def derived(_data, _realdata, work):
    """Databases that are made from databases."""
    damage(work / "db/sba.hop", work / "db/sba-damaged.hop")
    west, south, east, north = places.BY_NAME["sba"].bounds
    half = ",".join(str(edge) for edge in (west, south, (west + east) / 2, north))
    return [
        Step("bake", ["bake", "db/rmnp.hop", "--sun", "250,12", "-o", "db/rmnp-baked.hop", "--overwrite"], ["db/rmnp-baked.hop"]),
        Step("extract", ["extract", "db/sba.hop", "--bbox", half, "-o", "db/sba-west.hop", "--overwrite"], ["db/sba-west.hop"]),
    ]


def merged(_data, _realdata, _work):
    """A database of a part and of the whole around it."""
    return [
        Step("merge", ["merge", "db/sba-west.hop", "db/sba.hop", "--feather", "50", "-o", "db/sba-merged.hop", "--overwrite"], ["db/sba-merged.hop"]),
    ]


def conformance(folder):
    """One database for each raster of the conformance set, or the code with which it is refused."""
    encodings = [path for path in sorted((folder / "encodings").iterdir()) if path.suffix not in (".prj", ".hdr", ".pgw")]
    originals = [path for path in sorted((folder / "originals").glob("*/*")) if path.is_file()]
    steps = []
    for path in encodings + originals:
        name = f"conformance-{path.name.replace('.', '-')}"
        more = ["--elevation-crs", "EPSG:4326"] if path.suffix == ".png" else []
        steps.append(build(name, "--elevation", path, *more, may_refuse=True))
    ground = folder.parent / "sf_srtm1_landsat7/srtm1_sf_485x349_int16.tif"
    for path in encodings:
        if path.name.startswith("c_"):
            name = f"imagery-{path.name.replace('.', '-')}"
            steps.append(build(name, "--elevation", ground, "--imagery", path, may_refuse=True))
    return steps


def damage(sound, damaged):
    """Copies a database with one byte changed, a third of the way through the file: in its finest pages."""
    content = bytearray(sound.read_bytes())
    content[len(content) // 3] ^= 0x55
    damaged.write_bytes(content)


def recipe(name, file, *beside):
    return Step(name, ["build", file, "-o", f"db/{name}.hop", "--overwrite"], [f"db/{name}.hop", *beside])


def from_rasters(name, elevation, imagery, *more):
    return build(name, "--elevation", elevation, *(["--imagery", imagery] if imagery else []), *more)


def build(name, *arguments, may_refuse=False):
    output = f"db/{name}.hop"
    return Step(name, ["build", *arguments, "-o", output, "--jobs", "1", "--overwrite"], [output], may_refuse=may_refuse)
