"""The table of ratios, for reading and for Markdown."""

#: Below this part of wall time on the CPU, the stages of hedgehop are an estimate.
DISTURBED = 0.9

HEADINGS = (
    "terrain", "path", "peer", "peer ms", "march+shade ms", "frame ms", "ratio march+shade", "ratio frame",
    "median range error", "over 1 %", "hit differs",
)
TEXT_COLUMNS = 3


def cells(row):
    """One line of the table; a * marks the fastest of a family that has several."""
    median = row["range_error_median"]
    ranges = [
        "-" if median is None else f"{median:.1e}",
        f"{100 * row['far_off']:.2f} %",
        f"{100 * row['hit_disagreement']:.3f} %",
    ]
    if not row["ranges_comparable"]:
        ranges = [f"({cell})" for cell in ranges]
    return [
        row["terrain"],
        row["path"],
        row["peer"] + (" *" if row["best_of_family"] and row["peer"] != row["family"] else ""),
        f"{row['peer_ms']:.1f}",
        f"{row['hedgehop_march_shade_ms']:.1f}",
        f"{row['hedgehop_frame_ms']:.1f}",
        f"{row['ratio_march_shade']:.2f}",
        f"{row['ratio_frame']:.2f}",
        *ranges,
    ]


def markdown(lines):
    """Rows of a Markdown table, numbers to the right."""
    rule = ["---" if column < TEXT_COLUMNS else "---:" for column in range(len(HEADINGS))]
    return "".join("| " + " | ".join(line) + " |\n" for line in [HEADINGS, rule, *lines])


def aligned(lines):
    """Columns as wide as their widest cell, numbers to the right."""
    lines = [HEADINGS, *lines]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEADINGS))]
    pad = lambda column, cell: (str.ljust if column < TEXT_COLUMNS else str.rjust)(cell, widths[column])
    return "".join("  ".join(pad(*pair) for pair in enumerate(line)).rstrip() + "\n" for line in lines)


def marcher(row):
    """Engine and vector instructions of hedgehop."""
    return row["hedgehop_engine"] + (f" on {row['hedgehop_simd']}" if row["hedgehop_simd"] else "")


def by_reference(row):
    """Whether scan planes were asked for and left poses to the reference engine."""
    return row["hedgehop_engine"] == "planes" and row["hedgehop_frames_by_reference"] > 0


def notes(rows, skipped, screen):
    """What belongs under the table."""
    lines = []
    if rows:
        versions = sorted({f"{row['family']} {row['peer_version']}" for row in rows if row["peer_version"]})
        lines.append(
            f"{screen.width}x{screen.height}, {screen.hfov:g} degrees, one worker; milliseconds of CPU time per frame, "
            f"mean over the poses; hedgehop {rows[0]['hedgehop_version']}, {marcher(rows[0])}"
            + "".join(f", {version}" for version in versions)
            + f"; {rows[0]['processor']}"
        )
    remarks = {row["peer"]: row["remark"] for row in rows if row["remark"]}
    lines += [f"{peer}: {remark}" for peer, remark in remarks.items()]
    disturbed = min((row["hedgehop_cpu_share"] for row in rows), default=1.0)
    if disturbed < DISTURBED:
        lines.append(
            f"the machine was busy: hedgehop had the CPU for {100 * disturbed:.0f} % of its frames' time at the worst, "
            "so that march+shade is an estimate"
        )
    scenes = sorted({f"{row['path']} {row['terrain']}" for row in rows if by_reference(row)})
    if scenes:
        lines.append(f"poses that scan planes do not serve were rendered by the reference engine: {', '.join(scenes)}")
    scenes = {}
    for peer, scene, reason in skipped:
        scenes.setdefault((peer, reason), []).append(f"{scene.path} {scene.size}")
    lines += [f"skipped: {peer} ({', '.join(where)}): {reason}" for (peer, reason), where in scenes.items()]
    return lines


def render(rows, skipped, screen, as_markdown):
    """The table and its notes."""
    lines = [cells(row) for row in rows]
    table = (markdown if as_markdown else aligned)(lines) if lines else "nothing was measured\n"
    bullet = "- " if as_markdown else ""
    return table + "\n" + "".join(f"{bullet}{line}\n" for line in notes(rows, skipped, screen))
