# SPDX-License-Identifier: Apache-2.0
"""What a server can do."""
from __future__ import annotations

from dataclasses import dataclass

from segserve.options import method_name, numbers_of
from segserve.v1 import block_pb2, segmentation_service_pb2, server_info_pb2


@dataclass(frozen=True)
class OptionInfo:
    """A numeric option of the segmentation."""

    name: str
    unit: str  # empty if the option has none
    description: str
    minimum: float
    maximum: float
    default: float | None  # None: the option is off


@dataclass(frozen=True)
class ServerInfo:
    """What a server can do, and its limits."""

    version: str
    payloads: list[str]  # the kinds that it decodes, such as "planar" and "pcd_file"
    compressions: list[str]  # such as "zstd"
    limits: dict[str, float]  # by the names of segserve.v1.Limits
    default_method: str
    default_options: dict[str, float]  # of a call that sets none
    methods: dict[str, dict[str, float]]  # the options of a call that sets nothing but the method
    options: dict[str, OptionInfo]


def server_info(message: segmentation_service_pb2.GetServerInfoResponse) -> ServerInfo:
    def names(enum: object, numbers: object, prefix: str) -> list[str]:
        known = {number: name[len(prefix):].lower() for name, number in enum.items()}  # type: ignore[attr-defined]
        return [known.get(number, str(number)) for number in numbers]  # type: ignore[attr-defined]

    return ServerInfo(
        version=message.version,
        payloads=names(server_info_pb2.PayloadKind, message.payload_kinds, "PAYLOAD_KIND_"),
        compressions=names(block_pb2.Compression, message.compressions, "COMPRESSION_"),
        limits={entry.name: getattr(message.limits, entry.name) for entry in message.limits.DESCRIPTOR.fields},
        default_method=method_name(message.default_options.method),
        default_options=numbers_of(message.default_options),
        methods={method.name: numbers_of(method.defaults) for method in message.methods},
        options={option.name: OptionInfo(option.name, option.unit, option.description, option.minimum, option.maximum,
                                         option.default_value if option.HasField("default_value") else None)
                 for option in message.options})
