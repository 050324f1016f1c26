"""The places that are flown over, and forty poses at each: ordinary ones, and those that find mistakes."""

import math
from dataclasses import dataclass


@dataclass
class Place:
    """A database, the box in which eyes stand (metres of its reference system), and the size of its voxels."""

    name: str
    bounds: tuple
    voxel: float

    def middle(self):
        west, south, east, north = self.bounds
        return ((west + east) / 2, (south + north) / 2)


ALL = [
    Place("valley", (612000.0, 5241000.0, 614560.0, 5243560.0), 1.25),
    Place("sba", (239598.0, 3813359.76, 241072.92, 3815119.26), 3.06),
    Place("rmnp", (426000.0, 4450000.0, 455000.0, 4485000.0), 230.0),
]
ENDLESS = Place("shapes", (-3000.0, -3000.0, 5000.0, 5000.0), 4.0)
FPS = "1/20"
BY_NAME = {place.name: place for place in ALL}

# Pitch, roll, voxels above the ground, and horizontal field of view of the poses that no chance would find.
EXTREMES = [
    (-90, 0, 300, 60),
    (-90, 45, 80, 90),
    (90, 0, 40, 60),
    (0, 90, 30, 60),
    (0, 180, 30, 60),
    (-45, -90, 100, 100),
    (0, 0, 1, 60),
    (-3, 0, 2, 30),
    (-10, 5, 1500, 2),
    (-30, 10, 200, 170),
]


def write_flights(work):
    """Writes two paths for each place, whose frame N shows pose N at `FPS` frames a second."""
    for place in [*ALL, ENDLESS]:
        write_flight(work / f"{place.name}.csv", poses(place))
        write_flight(work / f"{place.name}-near.csv", near(place))


def write_flight(path, poses_of_it):
    """The eye rests at each pose for most of the time, so that hills on the way to the next one do not raise it."""
    rows = ["t,x_m,y_m,alt_agl_m,yaw_deg,pitch_deg,roll_deg,hfov_deg"]
    for index, pose in enumerate(poses_of_it):
        for second in (20 * index - 9, 20 * index + 9):
            rows.append(",".join(f"{value:.6f}" for value in (max(second, 0), *pose)))
    path.write_text("\n".join(rows) + "\n")


def poses(place):
    """Forty of x, y, height above ground, yaw, pitch, roll and field of view; the same on every machine."""
    chance = Chance(sum(map(ord, place.name)))
    west, south, east, north = place.bounds
    for index in range(40):
        x = west + (east - west) * chance.between(0.08, 0.92)
        y = south + (north - south) * chance.between(0.08, 0.92)
        yaw = 45.0 * (index % 8) if index % 3 == 0 else chance.between(0, 360)
        if index % 4 == 3:
            pitch, roll, height, hfov = EXTREMES[index // 4]
        else:
            pitch, roll = chance.between(-35, 12), chance.between(-40, 40) if index % 2 else 0.0
            height, hfov = 3 * 60 ** chance.between(0, 1), 60.0
        yield x, y, height * place.voxel, yaw, pitch, roll, hfov


def near(place):
    """Forty poses about the objects of scenes, north-east of a place's middle, most of which look at them."""
    chance = Chance(7 + sum(map(ord, place.name)))
    x, y = (edge + 90 for edge in place.middle())
    for _ in range(40):
        bearing, distance = chance.between(0, 360), 30 * 20 ** chance.between(0, 1)
        east, north = math.sin(math.radians(bearing)), math.cos(math.radians(bearing))
        height = 2 * 80 ** chance.between(0, 1)
        pitch = -math.degrees(math.atan2(height - 15, distance)) + chance.between(-15, 15)
        yaw = bearing + 180 + chance.between(-30, 30)
        yield x + distance * east, y + distance * north, height, yaw, pitch, chance.between(-25, 25), 60.0


class Chance:
    """Numbers that look like chance: the 64-bit generator of Knuth (MMIX, 1999)."""

    def __init__(self, seed):
        self.state = seed

    def between(self, low, high):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return low + (high - low) * (self.state >> 11) / 2**53
