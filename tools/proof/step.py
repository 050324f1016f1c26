"""One command of the program, and what is hashed of it."""

from dataclasses import dataclass, field


@dataclass
class Step:
    """Runs `hedgehop ARGUMENTS` in the work folder.

    `files` are patterns below that folder whose files are hashed. `hashes_output` adds what the command printed.
    A step that `may_refuse` may end with any exit code, which is hashed then; all others must succeed.
    """

    name: str
    arguments: list
    files: list = field(default_factory=list)
    hashes_output: bool = False
    may_refuse: bool = False
