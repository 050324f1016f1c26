"""PROJ's own list of the operations between two systems, which pyproj does not show: grids that are missing left out first."""
import glob
import os
from ctypes import CDLL, POINTER, byref, c_char_p, c_double, c_int, c_void_p
from dataclasses import dataclass

import pyproj

PARTIAL_INTERSECTION = 1
DISCARD_IF_A_GRID_IS_MISSING = 1
CRS_CATEGORY = 3
PROJ_5 = 0


@dataclass(frozen=True)
class Operation:
    name: str
    # Metres, negative where it is not known.
    accuracy: float
    # West, south, east, north in degrees.
    bounds: tuple
    area: str
    # A pipeline; None for one that PROJ cannot compute.
    definition: str
    is_ballpark: bool


def library():
    beside = os.path.join(os.path.dirname(pyproj.__file__), "..", "pyproj.libs", "libproj-*.so*")
    return CDLL(glob.glob(beside)[0])


LIBRARY = library()


def function(name, result, *arguments):
    found = getattr(LIBRARY, name)
    found.restype, found.argtypes = result, arguments
    return found


P = c_void_p
create_context = function("proj_context_create", P)
set_database = function("proj_context_set_database_path", c_int, P, c_char_p, P, P)
set_log_level = function("proj_log_level", c_int, P, c_int)
from_wkt = function("proj_create_from_wkt", P, P, c_char_p, P, P, P)
from_database = function("proj_create_from_database", P, P, c_char_p, c_char_p, c_int, c_int, P)
create_factory = function("proj_create_operation_factory_context", P, P, c_char_p)
set_criterion = function("proj_operation_factory_context_set_spatial_criterion", None, P, P, c_int)
set_availability = function("proj_operation_factory_context_set_grid_availability_use", None, P, P, c_int)
create_operations = function("proj_create_operations", P, P, P, P, P)
list_count = function("proj_list_get_count", c_int, P)
list_get = function("proj_list_get", P, P, P, c_int)
get_accuracy = function("proj_coordoperation_get_accuracy", c_double, P, P)
get_area = function("proj_get_area_of_use", c_int, P, P, *[POINTER(c_double)] * 4, POINTER(c_char_p))
as_proj_string = function("proj_as_proj_string", c_char_p, P, P, c_int, P)
get_name = function("proj_get_name", c_char_p, P)
demote = function("proj_crs_demote_to_2D", P, P, c_char_p, P)
destroy = function("proj_destroy", P, P)
destroy_list = function("proj_list_destroy", None, P)
destroy_factory = function("proj_operation_factory_context_destroy", None, P)

CONTEXT = create_context()
set_database(CONTEXT, os.path.join(pyproj.datadir.get_data_dir(), "proj.db").encode(), None, None)
set_log_level(CONTEXT, 0)


def operations(authority, code):
    """Operations from a system to WGS 84 in PROJ's order, as its transformations between two systems take them."""
    return between(from_database(CONTEXT, authority.encode(), str(code).encode(), CRS_CATEGORY, 0, None))


def operations_of_text(wkt):
    """The same from a system by its text."""
    return between(from_wkt(CONTEXT, wkt.encode(), None, None, None))


def between(stated):
    if not stated:
        return []
    source = demote(CONTEXT, None, stated)
    destroy(stated)
    target = from_database(CONTEXT, b"EPSG", b"4326", CRS_CATEGORY, 0, None)
    factory = create_factory(CONTEXT, None)
    set_criterion(CONTEXT, factory, PARTIAL_INTERSECTION)
    set_availability(CONTEXT, factory, DISCARD_IF_A_GRID_IS_MISSING)
    found = create_operations(CONTEXT, source, target, factory)
    result = [read(list_get(CONTEXT, found, index)) for index in range(list_count(found) if found else 0)]
    if found:
        destroy_list(found)
    destroy_factory(factory)
    destroy(source)
    destroy(target)
    return [operation for operation in result if operation.definition]


def read(operation):
    sides, area = [c_double() for _ in range(4)], c_char_p()
    is_bounded = get_area(CONTEXT, operation, *map(byref, sides), byref(area))
    definition = as_proj_string(CONTEXT, operation, PROJ_5, None)
    result = Operation(
        name=get_name(operation).decode(),
        accuracy=get_accuracy(CONTEXT, operation),
        bounds=tuple(side.value for side in sides) if is_bounded else (-180.0, -90.0, 180.0, 90.0),
        area=(area.value or b"").decode(),
        definition=definition.decode() if definition else None,
        is_ballpark="Ballpark geo" in get_name(operation).decode(),
    )
    destroy(operation)
    return result
