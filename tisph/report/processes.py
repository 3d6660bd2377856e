"""What processes started by a run have in common."""

import subprocess
import sys


def apart_from_terminal() -> dict:
    """Return the settings that keep Ctrl-C and a closed terminal from a process: it must live to finish its file."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {"start_new_session": True}
