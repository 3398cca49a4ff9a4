# SPDX-License-Identifier: Apache-2.0
"""The segmentation in this process, without any server, by the same core: labels and results are those of a server, bit
for bit.

    from segserve import local

    result = local.segment(xyz, rgb, view="camera")

It needs the module segserve._local, which is compiled: README.md of client/python says how. Threads run at the same
time, because the lock of the interpreter is released.
"""
from __future__ import annotations

import datetime
import math
import os
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from segserve import result_message
from segserve.cameras import Camera, merge_cameras
from segserve.codecs import DEFAULT_ERROR_BOUND
from segserve.encoding import Encoding, file_payload, rgbd_payload
from segserve.errors import from_status
from segserve.options import DEFAULT_OUTPUTS, options_message, outputs_message
from segserve.result import Result
from segserve.rpc import status_pb2
from segserve.selection import Prompts
from segserve.v1 import result_pb2
from segserve.view import ViewLike

try:
    from segserve._local import segment_payload as _segment_payload
except ImportError as _error:
    raise ImportError(
        "segserve.local needs the compiled module segserve._local; README.md of client/python says how to build it"
    ) from _error

_FOREVER = 86400.0 * 365


def segment(points: Any,
            rgb: Any = None,
            *,
            view: ViewLike = None,
            method: str | None = None,
            threshold: float | None = None,
            regions: int | None = None,
            options: Mapping[str, float | str] | None = None,
            codec: str | None = None,
            error_bound: float = DEFAULT_ERROR_BOUND,
            unit: str = "m",
            outputs: Collection[str] = DEFAULT_OUTPUTS,
            prompts: Prompts | None = None,
            timeout: float | None = None,
            request_id: str = "",
            frame_id: str = "",
            stamp: datetime.datetime | None = None) -> Result:
    """Segments a cloud; arguments, results and errors are those of Client.segment().

    With the codec "planar", which is the usual one if the view is given, the planes of the coordinates and the labels
    are not copied between Python and the core. timeout: seconds; None: as long as it takes.
    """
    payload = Encoding(view, codec, error_bound, unit).payload(points, rgb)
    wanted = outputs_message(outputs, False)
    chosen = options_message(method, threshold, regions, options)
    status, content, labels, supervoxels = _segment_payload(
        payload.header.SerializeToString(), list(payload.blocks), chosen.SerializeToString(),
        wanted.SerializeToString(), None if prompts is None else prompts.message().SerializeToString(),
        _FOREVER if timeout is None or math.isinf(timeout) else timeout)
    if status:
        raise from_status(status_pb2.Status.FromString(status))
    message = result_pb2.SegmentationResult.FromString(content)
    shape = (message.summary.points,) if payload.shape is None else payload.shape
    rest = [name for name in ((outputs,) if isinstance(outputs, str) else outputs) if name in ("tree", "segments")]
    return result_message.decode(message, shape, rest, request_id, frame_id, stamp,
                          labels=labels.reshape(shape) if wanted.labels else None,
                          supervoxels=supervoxels.reshape(shape) if wanted.supervoxels else None)


def segment_rgbd(depth: Any,
                 color: Any,
                 intrinsics: Any,
                 *,
                 depth_scale: float | None = None,
                 color_intrinsics: Any = None,
                 images: str = "raw",
                 **call: Any) -> Result:
    """Segments the images of an RGB-D camera; see Client.segment_rgbd."""
    return segment(
        rgbd_payload(depth,
                     color,
                     intrinsics,
                     depth_scale=depth_scale,
                     color_intrinsics=color_intrinsics,
                     images=images), **call)


def segment_cameras(cameras: Sequence[Camera], **call: Any) -> Result:
    """Segments what several cameras see as one cloud; see Client.segment_cameras."""
    merged = merge_cameras(cameras)
    return merged.restore(segment(merged.cloud, view=merged.view, **call))


def segment_file(path: str | os.PathLike[str], *, view: ViewLike = None, unit: str = "m", **call: Any) -> Result:
    """Segments a PCD file; see Client.segment_file."""
    return segment(file_payload(path, view, unit), **call)
