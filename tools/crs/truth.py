#!/usr/bin/env python3
"""Writes what PROJ says of places in reference systems, for the tests to compare with.

    tools/crs/run.sh truth FILE [POINTS] [--texts]

A line a case, tab-separated:

    code    CODE  x y longitude latitude how    a system by its code; how: exact, or ballpark where PROJ knows no shift
    text    WKT   x y longitude latitude how    a system by its text alone, without any code (with --texts)
    height  CODE or WKT  metres                 a vertical system: metres upward per unit
"""
import math
import sys
import warnings

import pyproj
from pyproj import CRS, Transformer
from pyproj.enums import PJType

from tables import CODES, every, places

warnings.simplefilter("ignore")
WGS84 = CRS.from_epsg(4326)
# Farther than this from the place of its code a text is misread, degrees.
MISREAD = 0.1
DIALECTS = ("WKT1_ESRI", "WKT1_GDAL", "WKT2_2019")


def cases(crs, count, seed):
    """Places of a system: its own coordinates, and longitude and latitude on WGS 84."""
    bounds = crs.area_of_use.bounds if crs.area_of_use else None
    if bounds is None or bounds[0] < -180:
        # PROJ's choice of a shift is by area.
        return
    try:
        back = Transformer.from_crs(WGS84, crs, always_xy=True)
        there = Transformer.from_crs(crs, WGS84, always_xy=True)
    except pyproj.exceptions.ProjError:
        return
    for longitude, latitude in places(bounds, count, seed):
        x, y = back.transform(longitude, latitude)
        if not all(map(math.isfinite, (x, y))):
            continue
        longitude, latitude = there.transform(x, y)
        # Some inverses return places that are none.
        if not all(map(math.isfinite, (longitude, latitude))) or abs(latitude) > 90:
            continue
        try:
            used = there.get_last_used_operation().description
        except pyproj.exceptions.ProjError:
            used = there.description
        yield x, y, longitude, latitude, "ballpark" if "allpark" in used else "exact"


def row(kind, name, case):
    x, y, longitude, latitude, how = case
    return f"{kind}\t{name}\t{x:.4f}\t{y:.4f}\t{longitude:.9f}\t{latitude:.9f}\t{how}" if abs(x) > 1000 or abs(y) > 1000 \
        else f"{kind}\t{name}\t{x:.10f}\t{y:.10f}\t{longitude:.9f}\t{latitude:.9f}\t{how}"


def texts(crs):
    # WKT 2 names a deprecated system as the one that stands in its place.
    for dialect in DIALECTS[:2] if crs.is_deprecated else DIALECTS:
        try:
            yield CODES.sub("", crs.to_wkt(dialect, pretty=False)).replace("\n", " ").replace("\t", " ")
        except pyproj.exceptions.CRSError:
            pass


def main():
    path, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 1
    with_texts = "--texts" in sys.argv
    with open(path, "w") as out:
        print(f"# PROJ {pyproj.proj_version_str}, tools/crs/truth.py", file=out)
        for kind in (PJType.GEOGRAPHIC_2D_CRS, PJType.GEOGRAPHIC_3D_CRS, PJType.PROJECTED_CRS, PJType.COMPOUND_CRS):
            for authority, code, crs in every(kind):
                flat = crs.sub_crs_list[0] if crs.is_compound else crs
                flat = flat.to_2d() if kind == PJType.GEOGRAPHIC_3D_CRS else flat
                for case in cases(flat, count, str(code)):
                    print(row("code", code, case), file=out)
                if not with_texts or kind in (PJType.GEOGRAPHIC_3D_CRS, PJType.COMPOUND_CRS):
                    continue
                for text in texts(crs):
                    # What PROJ makes of the text, not of the code that it came from.
                    for case in cases_of_text(text, flat, count, str(code)):
                        print(row("text", text, case), file=out)
        for authority, code, crs in every(PJType.VERTICAL_CRS):
            axis = crs.axis_info[0]
            metres = axis.unit_conversion_factor * (-1 if axis.direction == "down" else 1)
            print(f"height\t{code}\t{metres:.12g}", file=out)
            if with_texts:
                compound = pyproj.crs.CompoundCRS(name="a place", components=[CRS.from_epsg(32632), crs])
                for text in texts(compound):
                    print(f"height\t{text}\t{metres:.12g}", file=out)


def cases_of_text(text, crs, count, seed):
    """Places by a text, where they are those of the system that it was made from."""
    try:
        read = CRS.from_wkt(text)
        there = Transformer.from_crs(read, WGS84, always_xy=True)
    except pyproj.exceptions.ProjError:
        return
    for x, y, east, north, how in cases(crs, count, seed):
        longitude, latitude = there.transform(x, y)
        if not all(map(math.isfinite, (longitude, latitude))):
            continue
        # PROJ misreads some of its own texts by a prime meridian.
        apart = math.hypot((longitude - east + 180) % 360 - 180, latitude - north)
        if apart > MISREAD:
            print(f"{crs.name}: PROJ places its text {apart:.2f} degrees off: left out", file=sys.stderr)
            continue
        try:
            used = there.get_last_used_operation().description
        except pyproj.exceptions.ProjError:
            used = there.description
        if "allpark" in used and how == "exact":
            # A name that PROJ does not know, though it wrote it: the place is that of the code.
            longitude, latitude = east, north
        yield x, y, longitude, latitude, "ballpark" if "allpark" in used and how != "exact" else "exact"


if __name__ == "__main__":
    main()
