#!/usr/bin/env python3
"""Writes the tables of reference systems in crates/geo/src/registry/ from the EPSG and ESRI registries as PROJ's package has them.

    tools/crs/run.sh tables

Every projected definition is tried in PROJ itself against the system that it stands for; one that does not agree within a
centimetre is written as not served, with the name of its method. Shifts to WGS 84 are those that PROJ would take without
grids, each with its accuracy and its area of use, in the order in which PROJ prefers them.
"""
import math
import random
import re
import sys
import warnings
from pathlib import Path

import numpy
import pyproj
from pyproj import CRS, Transformer
from pyproj.database import get_codes
from pyproj.enums import PJType
from pyproj.transformer import TransformerGroup

from proj import operations, operations_of_text

warnings.simplefilter("ignore")

OUT = Path(__file__).resolve().parents[2] / "crates" / "geo" / "src" / "registry"
AUTHORITIES = ("EPSG", "ESRI")
WGS84 = CRS.from_epsg(4326)
# A definition that agrees within this many metres in PROJ means the system.
SAME = 0.01
# Urban plans of Colombia are taken for transverse Mercator maps at the city's height, and differ by this much at most, metres.
NEARLY_SAME = 0.3
# Offsets of degrees are taken for seven parameters that are as near, metres.
WELL_FITTED = 0.7
ARC_SECOND = math.pi / 180 / 3600
# Nodes of WKT that name a code.
CODES = re.compile(r',\s*(?:AUTHORITY|ID)\["[^"]*",\s*"?[^"\]]*"?(?:,[^\[\]]*)?\]')
# Semi-major axes of what can be the Earth, metres.
EARTH = (6.33e6, 6.42e6)


# Numbers of EPSG's horizontal systems, whatever their kind.
EPSG_CODES = {int(code) for kind in (PJType.GEODETIC_CRS, PJType.PROJECTED_CRS, PJType.COMPOUND_CRS) for code in get_codes("EPSG", kind, True)}


def number(value):
    """A number in as few digits as mean the same to a tenth of a millimetre."""
    text = f"{value:.12g}"
    return "0" if text in ("-0", "0") else text


def every(kind):
    """(authority, code, system) of a kind; EPSG's come first and keep their number where ESRI has it, too."""
    seen = set() if kind == PJType.VERTICAL_CRS else EPSG_CODES
    for authority in AUTHORITIES:
        for code in sorted(map(int, get_codes(authority, kind, True))):
            if authority == "EPSG" or code not in seen:
                yield authority, code, CRS.from_authority(authority, code)


def label(authority, code):
    """A code as it stands in the tables: Esri's end in e."""
    return f"{code}e" if authority == "ESRI" else str(code)


def bare(row):
    return int(row[0].removesuffix("e"))


def one_line(name):
    return re.sub(r"[\t\n;|]", " ", name).strip()


# Shifts ---------------------------------------------------------------------------------------------------------------


def axes(parameters):
    """Semi-axes of the ellipsoid of a step."""
    if "a" in parameters:
        a = float(parameters["a"])
        if "rf" in parameters:
            return a, a * (1 - 1 / float(parameters["rf"]))
        return a, float(parameters.get("b", a))
    if "R" in parameters:
        return float(parameters["R"]), float(parameters["R"])
    named = pyproj.Geod(ellps=parameters["ellps"])
    return named.a, named.b


def identity():
    return [0.0] * 3, [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]


def helmert(step, inverse):
    """T and M of X' = T + M X of a step, which PROJ computes with small angles."""
    value = lambda key: float(step.get(key, 0))
    t = [value("x"), value("y"), value("z")]
    r = [value(key) * ARC_SECOND for key in ("rx", "ry", "rz")]
    if step.get("convention") == "coordinate_frame" or step["proj"] == "molobadekas" and step.get("convention") != "position_vector":
        r = [-angle for angle in r]
    k = 1 + value("s") * 1e-6
    m = [[k, -k * r[2], k * r[1]], [k * r[2], k, -k * r[0]], [-k * r[1], k * r[0], k]]
    if step["proj"] == "molobadekas":
        p = [value("px"), value("py"), value("pz")]
        t = [t[i] + p[i] - sum(m[i][j] * p[j] for j in range(3)) for i in range(3)]
    if inverse:
        m = inverted(m)
        t = [-sum(m[i][j] * t[j] for j in range(3)) for i in range(3)]
    return t, m


def inverted(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    rows = [
        [e * i - f * h, c * h - b * i, b * f - c * e],
        [f * g - d * i, a * i - c * g, c * d - a * f],
        [d * h - e * g, b * g - a * h, a * e - b * d],
    ]
    return [[x / det for x in row] for row in rows]


def after(first, second):
    """The second of two affine steps after the first."""
    (t1, m1), (t2, m2) = first, second
    m = [[sum(m2[i][k] * m1[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    t = [t2[i] + sum(m2[i][k] * t1[k] for k in range(3)) for i in range(3)]
    return t, m


def turned(degrees):
    """A turn of longitudes as an affine step."""
    angle = math.radians(degrees)
    return [0.0] * 3, [[1.0, -angle, 0], [angle, 1.0, 0], [0, 0, 1.0]]


def parameters_of(definition, meridian):
    """PROJ's +towgs84 of a pipeline, or None where it is none (an offset of degrees, a grid).

    `meridian`: that of the system, degrees; some operations count from another one.
    """
    total = identity()
    for text in re.split(r"\bstep\b", definition.replace("+", ""))[1:] or [definition.replace("+", "")]:
        words = text.split()
        inverse = "inv" in words
        step = dict(word.split("=", 1) for word in words if "=" in word)
        kind = step.get("proj")
        if kind in ("helmert", "molobadekas"):
            total = after(total, helmert(step, inverse))
        elif kind == "longlat" and inverse and "pm" in step:
            total = after(total, turned(meridian_of(step["pm"]) - meridian))
        elif kind in ("geogoffset", "hgridshift", "xyzgridshift", "gridshift", "deformation", "horner", "defmodel", "tinshift"):
            return None
    t, m = total
    k = (m[0][0] + m[1][1] + m[2][2]) / 3
    rotation = [(m[2][1] - m[1][2]) / 2 / k, (m[0][2] - m[2][0]) / 2 / k, (m[1][0] - m[0][1]) / 2 / k]
    return [*t, *(angle / ARC_SECOND for angle in rotation), (k - 1) * 1e6]


def meridian_of(text):
    """Degrees of a prime meridian by PROJ's name or in degrees."""
    try:
        return float(text)
    except ValueError:
        pm = CRS.from_proj4(f"+proj=longlat +ellps=GRS80 +pm={text} +type=crs").prime_meridian
        return math.degrees(pm.longitude * pm.unit_conversion_factor)


def towgs84(parameters):
    digits = [number(round(value, 5)) for value in parameters[:3]]
    if any(abs(value) > 1e-9 for value in parameters[3:]):
        digits += [number(round(value, 8)) for value in parameters[3:]]
    return ",".join(digits)


def area(bounds):
    west, south, east, north = bounds
    east += 360 if east < west else 0
    return (east - west) * (math.sin(math.radians(north)) - math.sin(math.radians(south)))


def places(bounds, count, seed):
    """Places within an area of use, degrees; none at its rim, where another shift may hold."""
    west, south, east, north = bounds
    east += 360 if east < west else 0
    rng = random.Random(seed)
    for _ in range(count):
        longitude = west + (east - west) * rng.uniform(0.02, 0.98)
        yield (longitude + 180) % 360 - 180, south + (north - south) * rng.uniform(0.02, 0.98)


class Shifts:
    """Shifts of a geographic system to WGS 84 that need no grid: its own in PROJ's order, then those of its maps alone."""

    def __init__(self, authority, code, crs):
        meridian = crs.prime_meridian.longitude * crs.prime_meridian.unit_conversion_factor
        self.meridian = math.degrees(meridian)
        self.parameters = {}
        self.entries = []
        is_other = False
        for operation in operations(authority, code):
            parameters = parameters_of(operation.definition, self.meridian)
            if parameters is None:
                parameters = fitted(crs, operation, self.meridian)
            is_other |= parameters is None
            if parameters is not None:
                self.parameters[operation.name] = parameters
                self.entries.append(entry(operation, parameters))
        # Where PROJ knows no shift, the datum's grid or name decides.
        if all(one.startswith("?") for one in self.entries):
            self.entries = []
        self.own = len(self.entries)
        # A shift that is none of seven parameters.
        self.is_other = is_other and not self.entries

    def of_map(self, authority, code):
        """Indices of the shifts of a map, which PROJ orders by the map's own area; empty for those of the system."""
        return "" if not self.entries else self.order(operations(authority, code), f"{authority}:{code}")

    def of_text(self, crs):
        """Indices of the shifts of the system where a text names it without a code, and so without an area."""
        try:
            text = crs.to_wkt("WKT1_GDAL", pretty=False)
        except pyproj.exceptions.CRSError:
            return ""
        found = operations_of_text(CODES.sub("", text))
        # PROJ does not know every name that it writes.
        return "" if all(one.is_ballpark for one in found) else self.order(found, crs.name)

    def chosen(self, order):
        """The entries of an order."""
        return [self.entries[int(index)] for index in order.split(",")] if order else self.entries[:self.own]

    def order(self, found, name):
        """Indices of operations among the shifts, which get those that are not among them yet."""
        order = []
        for operation in found:
            same = [name for name in self.parameters if f" + {operation.name}".endswith(f" + {name}")]
            parameters = self.parameters[same[0]] if same else parameters_of(operation.definition, self.meridian)
            if parameters is None:
                print(f"{name}: {operation.name} is left out", file=sys.stderr)
                continue
            one = entry(operation, parameters)
            if one not in self.entries:
                self.entries.append(one)
            order.append(self.entries.index(one))
        return "" if order == list(range(self.own)) else ",".join(map(str, order))

    def __str__(self):
        if self.is_other:
            return "!"
        text = ";".join(self.entries[:self.own])
        return text + ("|" + ";".join(self.entries[self.own:]) if len(self.entries) > self.own else "")


def entry(operation, parameters):
    """A shift as it stands in the tables."""
    # A mark for what PROJ takes only where nothing else is at hand.
    mark = "?" if operation.is_ballpark else "~" if "- offshore" in operation.area else ""
    parameters = "0,0,0" if operation.is_ballpark else towgs84(parameters)
    return mark + ",".join([number(operation.accuracy), *map(number, operation.bounds), parameters])


def grids_of(crs):
    """Grids that would place better than the shifts: accuracy, west, south, east, north, names."""
    group = TransformerGroup(crs, WGS84, always_xy=True)
    best = {}
    for operation in group.unavailable_operations:
        if not operation.grids or not operation.area_of_use or operation.accuracy < 0:
            continue
        names = " ".join(grid.short_name for grid in operation.grids)
        if names not in best or operation.accuracy < best[names][0]:
            best[names] = (operation.accuracy, operation.area_of_use.bounds)
    rows = sorted((accuracy, area(bounds), names, bounds) for names, (accuracy, bounds) in best.items())
    return ";".join(",".join([number(a), *map(number, bounds), names]) for a, _, names, bounds in rows[:6])


def fitted(crs, operation, meridian):
    """The seven parameters that are nearest to an offset of degrees over its area; None where they are not near enough."""
    west, south, east, north = operation.bounds
    definition = operation.definition
    step = math.degrees(crs.axis_info[0].unit_conversion_factor)
    geocentric = lambda a, b: Transformer.from_pipeline(
        f"+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +a={a} +b={b}")
    own = geocentric(crs.ellipsoid.semi_major_metre, crs.ellipsoid.semi_minor_metre)
    wgs84 = geocentric(6378137.0, 6356752.314245179)
    pipeline = Transformer.from_pipeline(definition)
    # Pipelines of the registries' own axes begin with latitudes.
    order = -1 if re.match(r"\+?proj=pipeline \+?step \+?proj=axisswap", definition) else 1
    rows, values = [], []
    for i in range(7):
        for j in range(7):
            longitude, latitude = west + (east - west) * i / 6, south + (north - south) * j / 6
            u, v = pipeline.transform(*((longitude - meridian) / step, latitude / step)[::order])[::order]
            x, y, z = own.transform(longitude, latitude, 0)
            shift = [b - a for a, b in zip((x, y, z), wgs84.transform(u, v, 0))]
            rows += [[1, 0, 0, 0, z, -y, x], [0, 1, 0, -z, 0, x, y], [0, 0, 1, y, -x, 0, z]]
            values += shift
    found, *_ = numpy.linalg.lstsq(numpy.array(rows), numpy.array(values), rcond=None)
    left = numpy.array(rows) @ found - numpy.array(values)
    if numpy.abs(left).max() > WELL_FITTED:
        print(f"{crs.name}: {operation.name} is no seven parameters by {numpy.abs(left).max():.1f} m", file=sys.stderr)
        return None
    return [*found[:3], *(found[3:6] / ARC_SECOND), found[6] * 1e6]


# Tables ---------------------------------------------------------------------------------------------------------------

GEODETIC = re.compile(r"\+(proj|datum|ellps|a|b|rf|f|R|pm|no_defs|type|nadgrids|wktext|towgs84)(?=[=\s]|$)(=\S+)?\s*")


def ellipsoid_terms(crs):
    text = crs.to_proj4()
    words = [w for w in text.split() if re.match(r"\+(datum|ellps|a|b|rf|f|R)=", w)]
    words = ["+ellps=clrk66" if w == "+datum=NAD27" else w for w in words]
    return " ".join(words)


def geographic_rows():
    for kind, mark in ((PJType.GEOGRAPHIC_2D_CRS, "2"), (PJType.GEOGRAPHIC_3D_CRS, "3")):
        for authority, code, crs in every(kind):
            pm = crs.prime_meridian
            pm = math.degrees(pm.longitude * pm.unit_conversion_factor)
            unit = math.degrees(crs.axis_info[0].unit_conversion_factor)
            datum = crs.datum.to_json_dict().get("id", {})
            datum = f"{datum.get('code', '')}" if datum.get("authority") in AUTHORITIES else ""
            earth = EARTH[0] < crs.ellipsoid.semi_major_metre < EARTH[1]
            shifts = Shifts(authority, code, crs) if earth else ""
            grids = grids_of(crs if mark == "2" else crs.to_2d()) if earth else ""
            order = shifts.of_text(crs) if earth and mark == "2" else ""
            row = [label(authority, code), mark, one_line(crs.name), datum, ellipsoid_terms(crs), number(pm),
                   "1" if abs(unit - 1) < 1e-9 else number(unit), shifts, grids]
            yield [*row, order] if order else row
    for authority, code, crs in every(PJType.GEOCENTRIC_CRS):
        yield [label(authority, code), "c", one_line(crs.name), "", "", "0", "1", "", ""]


def with_shared(rows):
    """Rows whose shifts and grids are those of a row before name it."""
    seen = {}
    for row in rows:
        value = (str(row[7]), row[8])
        first = seen.setdefault(value, bare(row))
        is_long = len(value[0]) + len(value[1]) > 12
        shared = (f"={first}", "") if is_long and first != bare(row) else value
        yield [*row[:7], *shared, *row[9:]]


def terms_of(crs):
    """PROJ's terms of a projection without its geodetic part, or None where there are none that mean the same."""
    try:
        text = crs.to_proj4()
    except pyproj.exceptions.CRSError:
        return None
    if "+nadgrids=@null" in text and "+proj=merc" in text:
        rest = " ".join(w for w in text.split() if re.match(r"\+(lon_0|x_0|y_0|units|to_meter)=", w))
        return f"webmerc {rest}"
    projection = re.search(r"\+proj=(\S+)", text)
    if projection is None:
        return None
    rest = GEODETIC.sub("", text).strip()
    if projection.group(1) == "col_urban":
        # A plane at a city's height, within decimetres a conformal map of that scale.
        (height,), (latitude,) = re.findall(r"\+h_0=(\S+)", rest), re.findall(r"\+lat_0=(\S+)", rest)
        a, b = crs.ellipsoid.semi_major_metre, crs.ellipsoid.semi_minor_metre
        bulge = 1 - (1 - (b / a) ** 2) * math.sin(math.radians(float(latitude))) ** 2
        return f"tmerc {re.sub(r'[+]h_0=[^ ]+', '', rest)} +k={1 + float(height) * bulge / b:.9f}"
    if projection.group(1) == "omerc" and "+gamma=" not in rest:
        # Goes without saying in PROJ alone.
        rest += re.sub(r".*\+alpha=(\S+).*", r" +gamma=\1", rest) if "+alpha=" in rest else ""
    if "+R_A" in rest:
        # A sphere for the projection alone, which a definition cannot say elsewhere.
        return None
    return f"{projection.group(1)} {rest}"


def own_geographic(crs, known):
    """Code of the geographic system under a projected one."""
    base = crs.geodetic_crs
    identifier = base.to_json_dict().get("id")
    if identifier and identifier["authority"] in AUTHORITIES and int(identifier["code"]) in known:
        return int(identifier["code"])
    # Esri's are built on copies without a code.
    same = [code for code, row in known.items() if row[1] == "2" and row[2] == one_line(base.name)]
    return min(same) if same else None


def about_origin(terms):
    """An area around the origin of a projection whose area of use is not stated."""
    value = lambda key: next((float(found) for found in re.findall(rf"\+{key}=(-?[0-9.]+)", terms)), None)
    longitude = value("lon_0") or value("lonc") or 0
    if value("zone") is not None:
        longitude = 6 * value("zone") - 183
    latitude = value("lat_0") or value("lat_1") or value("lat_ts") or (-20 if "+south" in terms else 20)
    latitude = max(-80, min(80, latitude))
    return (longitude - 1, latitude - 1, longitude + 1, latitude + 1)


ORIENTATIONS = ["", "+axis=wsu", "+axis=neu", "+axis=swu", "+axis=esu", "+axis=wnu", "+axis=nwu", "+axis=seu"]


def agreeing(crs, terms, geodetic, same_within=SAME):
    """The terms with the axes under which they place what the system places; None where they never do."""
    bounds = crs.area_of_use.bounds if crs.area_of_use else None
    # PROJ's mark of an area that is not known.
    bounds = None if bounds and bounds[0] < -180 else bounds
    base = crs.geodetic_crs
    try:
        true = Transformer.from_crs(base, crs, always_xy=True)
    except pyproj.exceptions.ProjError:
        return None
    unit = math.degrees(base.axis_info[0].unit_conversion_factor)
    pm = math.degrees(base.prime_meridian.longitude * base.prime_meridian.unit_conversion_factor)
    if bounds is None:
        bounds = about_origin(terms)
    points = list(places(bounds, 6, str(crs.name)))
    axis = re.search(r"\+axis=\S+", terms)
    without = re.sub(r"\+axis=\S+\s*", "", terms).strip()
    tried = ([axis.group(0)] if axis else []) + ORIENTATIONS
    for orientation in tried:
        try:
            own = pyproj.Proj(f"+proj={without} {orientation} {geodetic}", preserve_units=True)
        except pyproj.exceptions.ProjError:
            return None
        same = 0
        for longitude, latitude in points:
            x, y = true.transform((longitude - pm) / unit, latitude / unit)
            u, v = own(longitude, latitude)
            factor = crs.axis_info[0].unit_conversion_factor
            if not all(map(math.isfinite, (x, y, u, v))):
                continue
            if math.hypot(x - u, y - v) * factor > same_within:
                break
            same += 1
        else:
            if same:
                return f"{without} {orientation}".strip()
    return None


def projected_rows(geographic):
    known = {bare(row): row for row in geographic}
    for authority, code, crs in every(PJType.PROJECTED_CRS):
        method = crs.coordinate_operation.method_name
        base = own_geographic(crs, known)
        name = one_line(crs.name)
        # Only what decides: units' names stay, +units=m is what goes without saying.
        terms = terms_of(crs)
        if base is not None and terms is not None:
            row = known[base]
            meridian = f"+pm={row[5]}" if row[5] != "0" else ""
            same_within = NEARLY_SAME if method == "Colombia Urban" else SAME
            terms = agreeing(crs, terms, f"{row[4]} {meridian}", same_within)
        if terms is None or base is None:
            # What PROJ has no words for, or words that mean another thing.
            yield [label(authority, code), name, str(base or ""), f"!{method}"]
            continue
        scale = re.search(r"\+k(?:_0)?=(\S+)", terms)
        if scale and not 0.5 < float(scale.group(1)) < 2:
            # A unit that the registry mistook.
            yield [label(authority, code), name, str(base), f"!{method} with a scale of {scale.group(1)}"]
            continue
        terms = re.sub(r"\s*\+units=m\b(?!\S)", "", terms)
        terms = re.sub(r"\s*\+(x_0|y_0|lat_0|lon_0|lat_ts)=-?0(?=\s|$)", "", terms)
        terms = re.sub(r"\s*\+(k|k_0)=1(?=\s|$)", "", terms)
        row = [label(authority, code), name, str(base), re.sub(r"\s+", " ", terms).strip()]
        shifts = known[base][7]
        order = shifts.of_map(authority, code) if isinstance(shifts, Shifts) else ""
        yield [*row, order] if order else row


def vertical_rows():
    for authority, code, crs in every(PJType.VERTICAL_CRS):
        axis = crs.axis_info[0]
        yield [label(authority, code), one_line(crs.name), number(axis.unit_conversion_factor), axis.direction[0]]


def compound_rows(horizontal, vertical):
    for authority, code, crs in every(PJType.COMPOUND_CRS):
        parts = [part.to_json_dict().get("id", {}) for part in crs.sub_crs_list]
        codes = [str(part.get("code", "")) for part in parts]
        if codes[0] in horizontal and codes[1] in vertical:
            yield [label(authority, code), one_line(crs.name), *codes]
        else:
            print(f"compound {authority}:{code} left out: {codes}", file=sys.stderr)


def plain(name):
    name = name.removeprefix("D_")
    return "".join(c for c in name if c.isalnum() or c == "+").lower()


def name_rows(geographic):
    """Names of datums and geographic systems, each with the code of a geographic system on that datum."""
    import sqlite3

    database = sqlite3.connect(f"file:{pyproj.datadir.get_data_dir()}/proj.db?mode=ro", uri=True)
    by_datum = {}
    # Greenwich and degrees first, then what is current, then the lower number.
    query = ("select datum_auth_name, datum_code, auth_name, code, deprecated, name from geodetic_crs "
             "where type = 'geographic 2D' and auth_name in ('EPSG', 'ESRI')")
    rows = {bare(row): row for row in geographic if row[1] == "2"}
    names = {}
    order = lambda row, deprecated, code: (row[5] != "0", str(row[7]) in ("", "!"), row[6] != "1", deprecated, code)
    for datum_authority, datum_code, authority, code, deprecated, name in database.execute(query):
        code = int(code)
        if code not in rows:
            continue
        rank = order(rows[code], deprecated, code)
        by_datum[(datum_authority, datum_code)] = min(by_datum.get((datum_authority, datum_code), (rank, code)), (rank, code))
    datums = "select auth_name, code, name, deprecated from geodetic_datum"
    aliases = "select auth_name, code, alt_name, 0 from alias_name where table_name = 'geodetic_datum'"
    for query in (datums, aliases):
        for authority, code, name, deprecated in database.execute(query):
            found = by_datum.get((authority, code))
            if found is not None:
                has_none = str(rows[found[1]][7]) in ("", "!")
                names.setdefault(plain(name), []).append(((has_none, deprecated), found))
    for name in sorted(names):
        choices = sorted(names[name])
        if name:
            yield [name, str(choices[0][1][1])]


def taken(entries, longitude, latitude):
    """The shift that is taken at a place: of those that hold there the first, or a better one behind it."""
    best = None
    for one in entries:
        accuracy, west, south, east, north = (float(word) for word in one.lstrip("~?").split(",")[:5])
        east += 360 if east < west else 0
        if not (south <= latitude <= north and (west <= longitude <= east or west <= longitude + 360 <= east)):
            continue
        here = (accuracy, area((west, south, east, north)))
        if best is None or accuracy >= 0 and not one.startswith("~") and best[0][0] >= 0 and here < best[0]:
            best = (here, one)
    return best[1] if best else entries[0] if entries else "?-1,-180,-90,180,90,0,0,0"


def shifted(one, place):
    """A geocentric place after the +towgs84 of a shift."""
    values = [float(word) for word in one.lstrip("~?").split(",")[5:]] + [0.0] * 4
    step = dict(zip(("x", "y", "z", "rx", "ry", "rz", "s"), values), proj="helmert")
    t, m = helmert(step, False)
    return [t[i] + sum(m[i][j] * place[j] for j in range(3)) for i in range(3)]


# Shifts that place as near to one another mean the same, metres.
NEAR = 0.3


def are_apart(one, other, crs):
    """Whether two lists of shifts place a system's places apart."""
    if one == other:
        return False
    bounds = crs.area_of_use.bounds if crs.area_of_use else None
    if bounds is None or bounds[0] < -180:
        return False
    to_axes = Transformer.from_pipeline(
        f"+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart "
        f"+a={crs.ellipsoid.semi_major_metre} +b={crs.ellipsoid.semi_minor_metre}")
    for longitude, latitude in places(bounds, 20, crs.name):
        place = to_axes.transform(longitude, latitude, 0)
        if math.dist(*(shifted(taken(shifts, longitude, latitude), place) for shifts in (one, other))) > NEAR:
            return True
    return False


def system_name_rows(geographic, projected, datums):
    """Names of systems that PROJ knows, and whose shifts are not those that the name of their datum gives."""
    known = {bare(row): row for row in geographic if isinstance(row[7], Shifts)}
    of_datum = {name: int(code) for name, code in datums}
    # Maps whose shifts are not all those of their geographic system, in its order.
    ordered = {bare(row) for row in projected if len(row) > 4}
    names, seen = {}, set()
    # Names of WKT 2 leave out what others say of systems that are deprecated, and mean those that are not.
    for dialects in (("WKT1_GDAL", "WKT1_ESRI"), ("WKT2_2019",)):
        for kind in (PJType.GEOGRAPHIC_2D_CRS, PJType.PROJECTED_CRS):
            for authority, code, crs in every(kind):
                is_map = kind == PJType.PROJECTED_CRS
                base = own_geographic(crs, known) if is_map else code
                if base not in known or is_map and len(known[base][7].entries) < 2 and code not in ordered:
                    continue
                for dialect in dialects:
                    try:
                        text = CODES.sub("", crs.to_wkt(dialect, pretty=False))
                    except pyproj.exceptions.CRSError:
                        continue
                    words = [re.search(rf'{word}\["([^"]*)"', text) for word in ("^[A-Z]*", "DATUM")]
                    if None in words:
                        continue
                    name, datum = (plain(word.group(1)) for word in words)
                    by_datum = known.get(of_datum.get(datum))
                    # Systems of one name may have two ellipsoids.
                    key = (name, str(bare(by_datum)), number(crs.ellipsoid.inverse_flattening)) if by_datum else None
                    if key is None or key in seen:
                        continue
                    found = operations_of_text(text)
                    # PROJ does not know every name that it writes; where it has no shift for an area, it has none by the code either.
                    is_unknown = all(one.is_ballpark for one in found)
                    if is_unknown and not all(one.is_ballpark for one in operations(authority, code)):
                        continue
                    seen.add(key)
                    is_without_area = not is_map and dialect != "WKT2_2019"
                    usual = by_datum[7].chosen(by_datum[9] if len(by_datum) > 9 and is_without_area else "")
                    order = known[base][7].order(found, name)
                    if are_apart(usual, known[base][7].chosen(order), crs):
                        names[key] = (str(base), order)
    for key, (base, order) in sorted(names.items()):
        yield [*key, base, order]


def unit_rows():
    """Lengths in metres and angles in degrees; rates and notations are neither."""
    # Radians of angles have 15 digits, of which the last one is rounded.
    for category, kind, size, digits in (("linear", "l", 1.0, 15), ("angular", "a", math.degrees(1.0), 13)):
        for unit in pyproj.database.get_units_map(auth_name="EPSG", category=category, allow_deprecated=True).values():
            if unit.conv_factor > 0 and " per " not in unit.name:
                yield [unit.code, kind, one_line(unit.name), f"{unit.conv_factor * size:.{digits}g}"]


def write(name, rows, head):
    rows = list(rows)
    lines = [f"# {line}" for line in head] + ["\t".join(row) for row in rows]
    (OUT / name).write_text("\n".join(lines) + "\n")
    print(f"{name}: {len(rows)} rows, {(OUT / name).stat().st_size} bytes", file=sys.stderr)
    return rows


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    source = f"Made by tools/crs/tables.py from PROJ {pyproj.proj_version_str}; do not edit."
    terms = "Facts of the EPSG Dataset (IOGP, epsg.org/terms-of-use.html) and of Esri's projection engine; see data/README.md."
    geographic = sorted(geographic_rows(), key=bare)
    projected = write("projected.tsv", sorted(projected_rows(geographic), key=bare), [
        source, terms, "code, name, geographic system, projection and its terms (or ! and the method that is not served),",
        "indices of its shifts among those of the geographic system, where they are not that one's own"])
    datums = list(name_rows(geographic))
    systems = list(system_name_rows(geographic, projected, datums))
    geographic = write("geographic.tsv", with_shared(geographic), [
        source, terms,
        "code (e: Esri's), dimensions (c: geocentric), name, datum's code, ellipsoid, prime meridian (degrees), degrees per unit,",
        "shifts (!: one by degrees, ~: offshore, ?: none known; accuracy in metres, west, south, east, north, +towgs84), after | those of maps alone,",
        "=code: as of that one; grids that would be better (accuracy, west, south, east, north, names),",
        "indices of the shifts where a text names the system without a code"])
    write("units.tsv", sorted(unit_rows(), key=bare), [
        source, terms, "code, kind (l: a length in metres, a: an angle in degrees), name, size"])
    vertical = write("vertical.tsv", sorted(vertical_rows(), key=bare), [
        source, terms, "code, name, metres per unit, direction (u: heights, d: depths)"])
    codes = lambda rows: {str(bare(row)) for row in rows}
    write("compound.tsv", compound_rows(codes(geographic) | codes(projected), codes(vertical)), [
        source, terms, "code, name, horizontal system, vertical system"])
    write("datums.tsv", datums, [
        source, terms, "name of a datum (letters and digits, without D_), a geographic system on it"])
    write("systems.tsv", systems, [
        source, terms, "name of a system (letters and digits) whose text places otherwise than the name of its datum says, the system on that datum,",
        "inverse flattening, the geographic system whose shifts it has, their indices where they are not that one's own"])


if __name__ == "__main__":
    main()
