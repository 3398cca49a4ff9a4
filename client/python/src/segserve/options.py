# SPDX-License-Identifier: Apache-2.0
"""How a cloud is segmented, and what the answer shall hold."""
from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Mapping
from typing import Any

from segserve.v1 import block_pb2, options_pb2

_PREFIX = "METHOD_"
#: The names of the methods, as on the command line.
METHODS = tuple(
    name[len(_PREFIX):].lower().replace("_", "-") for name, number in options_pb2.Method.items() if number != 0)
_PRESET_PREFIX = "PRESET_"
#: The names of the presets: what kind of cloud it is.
PRESETS = tuple(name[len(_PRESET_PREFIX):].lower() for name, number in options_pb2.Preset.items() if number != 0)
OUTPUTS = ("labels", "supervoxels", "tree", "segments")
#: The arrays that a result holds unless the caller says otherwise. With supervoxels and tree, any cut can be made
#: later.
DEFAULT_OUTPUTS = ("labels", "supervoxels", "tree")


def _did_you_mean(name: str, known: Collection[str]) -> str:
    close = difflib.get_close_matches(name, known, 1)
    return f"; did you mean '{close[0]}'?" if close else f"; there are {', '.join(sorted(known))}"


def method_number(name: str) -> int:
    """ValueError if there is no method of this name."""
    if name not in METHODS:
        raise ValueError(f"method: there is no '{name}'{_did_you_mean(name, METHODS)}")
    return int(options_pb2.Method.Value(_PREFIX + name.upper().replace("-", "_")))


def method_name(number: int) -> str:
    """The name of a method, as the server counts it; "" if this version does not know it."""
    if number == 0 or number not in options_pb2.Method.values():
        return ""
    return str(options_pb2.Method.Name(number))[len(_PREFIX):].lower().replace("_", "-")


def preset_number(name: Any) -> int:
    """ValueError if there is no preset of this name."""
    if name not in PRESETS:
        raise ValueError(f"preset: there is no '{name}'{_did_you_mean(str(name), PRESETS)}")
    return int(options_pb2.Preset.Value(_PRESET_PREFIX + name.upper()))


def options_message(method: str | None, threshold: float | None, regions: int | None,
                    options: Mapping[str, float | str] | None) -> options_pb2.SegmentOptions:
    """The options of a request. What is None has the server's default. The server checks ranges.

    options: numbers by name, and a name of PRESETS as "preset".
    ValueError: an unknown method, preset or option, two ways to cut, or a value that the field cannot hold. TypeError: no
    number.
    """
    message = options_pb2.SegmentOptions()
    if method is not None:
        setattr(message, "method", method_number(method))  # the stub knows numbers by name only
    if threshold is not None and regions is not None:
        raise ValueError("threshold, regions: the tree can be cut in one of the two ways only")
    fields = message.DESCRIPTOR.fields_by_name
    given: dict[str, Any] = dict(options or {})
    for name, value in (("threshold", threshold), ("regions", regions)):
        if value is None:
            continue
        if given.keys() & {"threshold", "regions"}:
            raise ValueError(f"options: the cut is given twice, as {name}=, too")
        given[name] = value
    if {"threshold", "regions"} <= given.keys():
        raise ValueError("options: the tree can be cut at a threshold or a number of regions, not both")
    if "preset" in given:
        setattr(message, "preset", preset_number(given.pop("preset")))
    for name, value in given.items():
        if name == "method" or name not in fields:
            raise ValueError(f"options: there is no '{name}'{_did_you_mean(name, set(fields) - {'method'})}")
        _set_number(message, name, value)
    return message


def _set_number(message: options_pb2.SegmentOptions, name: str, value: Any) -> None:
    is_whole = message.DESCRIPTOR.fields_by_name[name].cpp_type == message.DESCRIPTOR.fields_by_name[
        name].CPPTYPE_UINT32
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: {value!r} is not a number") from None
    if not is_whole:
        setattr(message, name, number)
        return
    if not math.isfinite(number) or number != int(number) or not 0 <= number < 2**32:
        raise ValueError(f"{name}: {value} is not a whole number from 0 to {2**32 - 1}")
    setattr(message, name, int(number))


def outputs_message(outputs: Collection[str], compressed: bool) -> options_pb2.Outputs:
    """Which arrays the answer shall hold. `compressed`: the server may compress them by Zstandard."""
    if isinstance(outputs, str):
        outputs = (outputs,)
    message = options_pb2.Outputs()
    for name in outputs:
        if name not in OUTPUTS:
            raise ValueError(f"outputs: there is no '{name}'{_did_you_mean(name, OUTPUTS)}")
        setattr(message, name, True)
    if compressed:
        message.accepted_compressions.append(block_pb2.COMPRESSION_ZSTD)
    return message


def numbers_of(message: options_pb2.SegmentOptions) -> dict[str, float]:
    """The options that are set, by name, without method and preset."""
    return {field.name: value for field, value in message.ListFields() if field.name not in ("method", "preset")}
