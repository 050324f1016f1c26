"""The other renderers: how each is called, what it prints, and what it lacks here.

They are programs of their own (docs/peers.md says what they are given and print). Every one renders all poses of
a file, each several times, and prints for each pose the least CPU time of a frame over its runs:

    embree_bench, ref_bench   pose 3  wall min 1.23 max 1.50 ms  cpu min 1.20 ms  ...
    povray_bench.py           pose 3: parse 1.4 cpu-s  trace wall 3.10 s  cpu 3.05 s
    vtk_bench.py              pose 3: wall min 1700 ms  cpu min 1650 ms

and leaves the range image of pose K as OUT/range_K.f32: float32, rows from the top, metres along the ray.
"""
import dataclasses
import os
import pathlib
import re
import shutil
import subprocess

MIB = 1 << 20


class PeerError(Exception):
    """A peer that is there did not do its work."""


@dataclasses.dataclass(frozen=True)
class Scene:
    """A terrain of size x size samples in `data` and one of its paths."""

    data: pathlib.Path
    size: int
    path: str

    @property
    def heights(self):
        return self.data / f"height_{self.size}.f32"

    @property
    def colours(self):
        return self.data / f"rgb_{self.size}.raw"

    @property
    def poses(self):
        return self.data / f"{self.path}_{self.size}.txt"


@dataclasses.dataclass(frozen=True)
class Screen:
    """Pixels and horizontal field of view in degrees."""

    width: int
    height: int
    hfov: float


@dataclasses.dataclass(frozen=True)
class Found:
    """Where peers are looked for."""

    folders: tuple
    python: str

    def file(self, name):
        """The first folder's `name`, or None."""
        return next((folder / name for folder in self.folders if (folder / name).is_file()), None)

    def imports(self, *modules):
        """Whether the interpreter of the Python peers has `modules`."""
        command = [self.python, "-c", "import " + ", ".join(modules)]
        try:
            return subprocess.run(command, capture_output=True, check=False).returncode == 0
        except OSError:
            return False


class Peer:
    """One renderer with its settings."""

    name = family = program = remedy = ""
    #: Resident bytes per terrain sample while it builds, with what the process needs besides.
    bytes_per_sample, bytes_besides = 0, 200 * MIB
    #: What to bear in mind when its figures are read.
    remark = ""
    #: Whether its pixels see the same directions as hedgehop's.
    ranges_comparable = True
    cpu_time = re.compile(r"^pose +(\d+)\b.*\bcpu min +([\d.]+) ms", re.MULTILINE)
    cpu_unit_ms = 1.0
    version_line = re.compile(r"^(\S+)", re.MULTILINE)

    def missing(self, found, scene, memory=None):
        """Why it cannot run here and what helps, or None. `memory`: bytes that are free."""
        if found.file(self.program) is None:
            return f"no {self.program} in --peers; {self.remedy}"
        lacking = [file.name for file in (scene.heights, scene.colours, scene.poses) if not file.is_file()]
        if lacking:
            return f"no {', '.join(lacking)} in {scene.data}"
        needed = self.bytes_per_sample * scene.size**2 + self.bytes_besides
        if memory is not None and needed > memory:
            return f"needs about {needed / 1024**3:.1f} GiB of memory, {memory / 1024**3:.1f} GiB are free"
        return None

    def command(self, found, scene, screen, runs, out):
        """The command line; `out` is a folder for range images, or None where they are optional."""
        words = [found.file(self.program), *self.settings()]
        words += ["--heights", scene.heights, "--n", scene.size, "--rgb", scene.colours, "--poses", scene.poses]
        words += ["--width", screen.width, "--height", screen.height, "--hfov", screen.hfov]
        words += ["--threads", 1, "--runs", runs]
        if out is not None:
            words += ["--out", out]
        return [str(word) for word in words]

    def settings(self):
        """Flags that make it this peer."""
        return []

    def environment(self):
        """Variables that it needs."""
        return {}

    def cpu_ms(self, text):
        """CPU milliseconds of a frame for each pose, in their order, from what it printed."""
        found = {int(pose): float(time) * self.cpu_unit_ms for pose, time in self.cpu_time.findall(text)}
        if not found or sorted(found) != list(range(len(found))):
            raise PeerError(f"{self.name} printed no line `pose K ... cpu ...` for every pose")
        return [found[pose] for pose in sorted(found)]

    def version(self, text):
        """What it says of its version; empty where it has none."""
        match = self.version_line.search(text)
        return match[1] if match else ""


class Embree(Peer):
    """Intel Embree: packets of 16 rays (8 x 2 pixels), coherent; the fastest of the settings that it has."""

    family, program = "embree", "embree_bench"
    remedy = "it needs Embree 4 or 3 (apt-get install libembree-dev, or its releases)"
    version_line = re.compile(r"^embree (\S+)", re.MULTILINE)

    def __init__(self, geometry, name, bytes_per_sample):
        self.geometry, self.name, self.bytes_per_sample = geometry, name, bytes_per_sample

    def settings(self):
        return ["--geom", self.geometry, "--packet", "16", "--pw", "8", "--coherent", "1"]


class Reference(Peer):
    """Plain heightfield renderers without an external library."""

    program, remedy = "ref_bench", "any C++17 compiler builds it"

    def __init__(self, algorithm, bytes_per_sample):
        self.name = self.family = self.algorithm = algorithm
        self.bytes_per_sample = bytes_per_sample
        if algorithm == "voxelspace":
            self.ranges_comparable = False
            self.remark = "shears the picture instead of pitching: its ranges (in parentheses) are of other directions"

    def settings(self):
        return ["--algo", self.algorithm]

    def version(self, text):
        return ""


class Script(Peer):
    """A peer that is driven by a Python script with positional arguments and always leaves its ranges."""

    modules = ()

    def missing(self, found, scene, memory=None):
        reason = super().missing(found, scene, memory)
        if reason is None and not found.imports(*self.modules):
            reason = f"{found.python} lacks {' or '.join(self.modules)}; {self.remedy}, or name another --python"
        return reason

    def words(self, found, scene, out):
        """What all scripts take first."""
        return [found.python, found.file(self.program), scene.data, scene.size, scene.poses, out]


class PovRay(Script):
    """POV-Ray's height_field."""

    name = family = "povray"
    program, remedy = "povray_bench.py", "apt-get install povray; pip install numpy pillow"
    modules, bytes_per_sample = ("numpy", "PIL"), 9
    remark = "heights of 16 bits, ranges in steps of 1/8; one run of each pose"
    cpu_time = re.compile(r"^pose +(\d+):.*\bcpu +([\d.]+) s", re.MULTILINE)
    cpu_unit_ms = 1000.0

    def missing(self, found, scene, memory=None):
        reason = super().missing(found, scene, memory)
        image = scene.data / f"height_{scene.size}.png"
        if reason is None and shutil.which("povray") is None:
            reason = f"no povray on the PATH; {self.remedy}"
        if reason is None and not image.is_file():
            reason = f"no {image.name} (16-bit grey, 65535 = 600 units) in {scene.data}"
        return reason

    def command(self, found, scene, screen, runs, out):
        words = [*self.words(found, scene, out), 1, screen.width, screen.height, screen.hfov]
        return [str(word) for word in words]

    def version(self, text):
        said = subprocess.run(["povray", "--version"], capture_output=True, text=True, check=False)
        match = re.search(r"POV-Ray (\d[\d.]*\d)", said.stdout + said.stderr)
        return match[1] if match else ""


class Vtk(Script):
    """VTK on Mesa's software rasteriser."""

    name = family = "vtk"
    program, remedy = "vtk_bench.py", "apt-get install libosmesa6; pip install numpy vtk"
    modules, bytes_per_sample = ("numpy", "vtk"), 135
    version_line = re.compile(r"^vtk (\S+) n=", re.MULTILINE)

    def command(self, found, scene, screen, runs, out):
        words = [*self.words(found, scene, out), screen.width, screen.height, screen.hfov, runs]
        return [str(word) for word in words]

    def environment(self):
        return {"LP_NUM_THREADS": "1"}


#: Memory: from resident sets that were measured at 2048 to 16384 samples.
ALL = (
    Embree("tri", "embree-triangles", 230),
    Embree("grid", "embree-grid", 31),
    Reference("voxelspace", 8),
    Reference("maxmip", 9),
    PovRay(),
    Vtk(),
)


def free_memory():
    """Bytes that a program can take without swapping, or None where the system does not tell."""
    try:
        text = pathlib.Path("/proc/meminfo").read_text(encoding="ascii")
    except OSError:
        return None
    match = re.search(r"^MemAvailable: +(\d+) kB", text, re.MULTILINE)
    return int(match[1]) * 1024 if match else None


def output(command, environment=None):
    """What `command` prints on standard output; PeerError with its last words if it fails."""
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env={**os.environ, **(environment or {})}, check=False
        )
    except OSError as error:
        raise PeerError(f"cannot run {command[0]}: {error.strerror}") from error
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip() or "nothing").splitlines()[-1]
        raise PeerError(f"{command[0]} ended with {done.returncode}, saying: {said}")
    return done.stdout
