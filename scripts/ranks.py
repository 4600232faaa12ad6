"""The processes that mpirun starts."""

import os
import pathlib


def ranks_of(pid):
    """The processes of weft that this mpirun has started, itself (Open MPI) or by a process in between (MPICH)."""
    try:
        children = [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []
    return [rank for child in children for rank in ([child] if is_weft(child) else ranks_of(child))]


def is_weft(pid):
    """False too for a process that has ended."""
    try:
        return os.path.basename(pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")[0]).startswith(b"weft")
    except OSError:
        return False
