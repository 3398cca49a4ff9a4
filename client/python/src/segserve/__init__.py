# SPDX-License-Identifier: Apache-2.0
"""Segments colored 3D point clouds through a segserve server.

    import segserve

    client = segserve.Client("robot-a:50051")
    result = client.segment(xyz, rgb, view="camera")
    print(result.segment_count, result.labels)
    coarser = result.cut(regions=12)

segserve.aio has the same for asyncio, segserve.ros puts labels into messages of ROS.
"""
from segserve import aio, ros
from segserve._stream.address_book import Retry
from segserve._stream.frame import FrameReport, Order, Outcome, OutcomeKind, StreamOptions, WhenBehind
from segserve._version import __version__
from segserve.cameras import Camera, MergedCameras, merge_cameras
from segserve.client import Client
from segserve.cloud import Cloud, as_cloud
from segserve.codecs import CODECS, encode, pcd_file
from segserve.errors import (Aborted, AlreadyExists, Cancelled, DataLoss, DeadlineExceeded, Error, FailedPrecondition,
                             FieldViolation, Internal, InvalidArgument, NotFound, OutageError, OutOfRange,
                             PermissionDenied, ResourceExhausted, TlsError, Unauthenticated, Unavailable, Unimplemented,
                             Unknown)
from segserve.info import OptionInfo, ServerInfo
from segserve.options import METHODS, OUTPUTS, PRESETS
from segserve.payload import Payload
from segserve.result import Placement, Resolution, Result, ResultWarning, SupportPlane
from segserve.rgbd import Intrinsics, encode_rgbd
from segserve.selection import Candidates, PromptedPoint, Prompts, Selection
from segserve.stream import Stream
from segserve.tls import Tls
from segserve.tracking import TrackEvent, Tracking, Tracks
from segserve.tree import MergeTree
from segserve.view import CameraPoints, View

__all__ = [
    "CODECS",
    "METHODS",
    "OUTPUTS",
    "PRESETS",
    "Aborted",
    "AlreadyExists",
    "Camera",
    "CameraPoints",
    "Cancelled",
    "Candidates",
    "Client",
    "Cloud",
    "DataLoss",
    "DeadlineExceeded",
    "Error",
    "FailedPrecondition",
    "FieldViolation",
    "FrameReport",
    "Internal",
    "Intrinsics",
    "InvalidArgument",
    "MergeTree",
    "MergedCameras",
    "NotFound",
    "OptionInfo",
    "Order",
    "OutOfRange",
    "OutageError",
    "Outcome",
    "OutcomeKind",
    "Payload",
    "PermissionDenied",
    "Placement",
    "PromptedPoint",
    "Prompts",
    "ResourceExhausted",
    "Resolution",
    "Result",
    "ResultWarning",
    "Retry",
    "Selection",
    "ServerInfo",
    "Stream",
    "StreamOptions",
    "SupportPlane",
    "Tls",
    "TlsError",
    "TrackEvent",
    "Tracking",
    "Tracks",
    "Unauthenticated",
    "Unavailable",
    "Unimplemented",
    "Unknown",
    "View",
    "WhenBehind",
    "__version__",
    "aio",
    "as_cloud",
    "encode",
    "encode_rgbd",
    "merge_cameras",
    "pcd_file",
    "ros",
]
