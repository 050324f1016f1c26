"""How well two sets of range images agree."""
import array
import math
import sys

#: Of all pixels one in so many is compared: enough for a median, and quick without libraries. It shares no
#: factor with usual widths, so that all columns are met.
STEP = 7

#: Relative difference above which a range counts as far off.
FAR_OFF = 0.01


class RangeError(Exception):
    """A range image that is missing or of another size."""


def read(file, pixels):
    """Every STEP-th range of a raw float32 image of `pixels` pixels."""
    try:
        data = file.read_bytes()
    except OSError as error:
        raise RangeError(f"{file}: {error.strerror}") from error
    if len(data) != 4 * pixels:
        raise RangeError(f"{file}: {len(data)} bytes, where {pixels} float32 take {4 * pixels}")
    values = array.array("f")
    values.frombytes(data)
    if sys.byteorder == "big":
        values.byteswap()
    return values[::STEP]


def quantile(ordered, part):
    """The value below which `part` of the rising list `ordered` lies; None of nothing."""
    return ordered[min(int(part * len(ordered)), len(ordered) - 1)] if ordered else None


def agreement(pairs):
    """Of pairs (theirs, ours) of equally long ranges, infinity for the sky:

    - range_error_median, range_error_p99: |ours - theirs| / theirs where both see ground, pooled over all pairs
    - far_off: the part of these above FAR_OFF
    - hit_disagreement: the part of all pixels where one sees ground and the other sky
    """
    errors, pixels, differ = array.array("d"), 0, 0
    for theirs, ours in pairs:
        pixels += len(theirs)
        for a, b in zip(theirs, ours, strict=True):
            if (a < math.inf) != (b < math.inf):
                differ += 1
            elif a < math.inf:
                errors.append(abs(b - a) / a)
    ordered = sorted(errors)
    return {
        "range_error_median": quantile(ordered, 0.5),
        "range_error_p99": quantile(ordered, 0.99),
        "far_off": sum(error > FAR_OFF for error in ordered) / max(len(ordered), 1),
        "hit_disagreement": differ / max(pixels, 1),
    }
