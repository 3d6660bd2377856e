"""What processes started by a run have in common."""

import os
import subprocess
import sys


def apart_from_terminal() -> dict:
    """Return the settings that keep Ctrl-C and a closed terminal from a process: it must live to finish its file.

    It writes UTF-8, which is how its messages are read, whatever the terminal shows.
    """
    settings = {"env": {**os.environ, "PYTHONIOENCODING": "utf-8"}}
    if sys.platform == "win32":
        return {**settings, "creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {**settings, "start_new_session": True}
