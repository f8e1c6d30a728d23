"""The version of these tools: that of volccd."""

import os
import re

HERE = os.path.dirname(os.path.abspath(__file__))


def version():
    """From the file VERSION beside an installed tool, else from the header of the source tree."""
    for name, pattern in ((os.path.join(HERE, "VERSION"), r"(\S+)"),
                          (os.path.join(os.path.dirname(HERE), "core", "version.hpp"),
                           r"VERSION_STRING \"([\d.]+)\"")):
        try:
            with open(name, encoding="utf-8") as file:
                found = re.search(pattern, file.read())
        except OSError:
            continue
        if found:
            return found.group(1)
    return "of unknown version"
