"""Makes the files of this folder with GDAL 3.12 (pip install geopandas pyogrio): python3 make.py"""
import os, sqlite3
import geopandas as gpd
from shapely.geometry import LineString, MultiPolygon, Point, Polygon

EAST, NORTH = 612000.0, 5241000.0


def polygon(x, y, w, h, holes=()):
    ring = lambda x, y, w, h: [(EAST + x, NORTH + y), (EAST + x + w, NORTH + y), (EAST + x + w, NORTH + y + h), (EAST + x, NORTH + y + h)]
    return Polygon(ring(x, y, w, h), [ring(*hole) for hole in holes])


buildings = gpd.GeoDataFrame(
    {
        "building": ["house", "church", "yes", "barn"],
        "height": [8.5, 30.0, None, 6.0],
        "levels": ["2", None, "3", None],
        "name": ["Mühle", "St. Anna, " + "long " * 40, None, ""],
    },
    geometry=[
        polygon(10, 10, 12, 9),
        polygon(40, 10, 30, 20, [(50, 15, 10, 10)]),
        MultiPolygon([polygon(100, 0, 10, 10), polygon(120, 0, 10, 10)]),
        None,
    ],
    crs="EPSG:25832",
)
roads = gpd.GeoDataFrame(
    {"highway": ["residential", "track"], "lanes": [2, 1]},
    geometry=[
        LineString([(EAST, NORTH, 600), (EAST + 100, NORTH + 20, 604), (EAST + 200, NORTH, 610)]),
        LineString([(EAST, NORTH + 50, 600), (EAST + 10, NORTH + 90, 601)]),
    ],
    crs="EPSG:25832",
)
trees = gpd.GeoDataFrame(
    {"natural": ["tree"] * 60, "height": [5.0 + i / 4 for i in range(60)]},
    geometry=[Point(EAST + 3 * i, NORTH + 7 * (i % 9)) for i in range(60)],
    crs="EPSG:25832",
)
for name in os.listdir("."):
    if name.split(".")[0] in ("buildings", "roads", "trees", "town"):
        os.remove(name)
for name, layer in (("buildings", buildings), ("roads", roads), ("trees", trees)):
    layer.to_file("town.gpkg", layer=name, driver="GPKG", layer_options={"SPATIAL_INDEX": "NO"})
buildings.to_file("buildings.shp", engine="pyogrio", layer_options={"ENCODING": "UTF-8"})
roads.to_file("roads.shp", engine="pyogrio")
buildings.to_file("buildings.geojson", driver="GeoJSON", engine="pyogrio")
base = sqlite3.connect("town.gpkg")
# Small pages make trees of several levels and long rows that run over.
base.executescript("PRAGMA journal_mode = DELETE; DROP TABLE IF EXISTS gpkg_ogr_contents; PRAGMA page_size = 512; VACUUM;")
base.close()
for name in ("buildings.shx", "roads.shx"):
    os.remove(name)
