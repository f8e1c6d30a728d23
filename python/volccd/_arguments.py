"""What functions of this package say about their arguments."""

from __future__ import annotations

import difflib
import functools
import inspect

from . import _core


def near(name, known):
    """"; did you mean 'separation'?", or "" if no known name is like this one."""
    found = difflib.get_close_matches(name, known, 1)
    return f"; did you mean '{found[0]}'?" if found else ""


def suggesting(function):
    """Lets a TypeError about an unknown argument name the argument that is most like it."""
    parameters = inspect.signature(function).parameters.values()
    names = [p.name for p in parameters if p.kind not in (p.POSITIONAL_ONLY, p.VAR_POSITIONAL, p.VAR_KEYWORD)]

    @functools.wraps(function)
    def wrapper(*args, **kwargs):
        for name in kwargs:
            if name not in names:
                shown = function.__qualname__.replace(".__init__", "")
                known = [one for one in names if one != "self"]
                raise TypeError(f"volccd.{shown}() has no argument '{name}'{near(name, known)}")
        return function(*args, **kwargs)
    return wrapper


def settings_list(settings):
    """Settings as the program has them, "key=value": from one, from a list of them, or from a dict."""
    if isinstance(settings, str):
        return [settings]
    if not hasattr(settings, "items"):
        return list(settings)
    return [f"{key}={_value(key, value)}" for key, value in settings.items()]


def _value(key, value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return ",".join(_value(key, one) for one in value)
    if value is None:
        return "none"
    if isinstance(value, str) or hasattr(value, "__index__") or isinstance(value, float):
        return str(value)
    raise _core.ConfigError(f"settings: {key}: {value!r} is no text, number, bool, None, or list of them")
