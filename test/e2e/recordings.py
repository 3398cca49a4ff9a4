# SPDX-License-Identifier: Apache-2.0
"""Recordings for tests, written and read by the libraries of Foxglove (clients/recording.js)."""
import base64
import bz2
import json
import os
import pathlib
import shutil
import struct
import subprocess

import node_packages

HERE = pathlib.Path(__file__).resolve().parent
PACKAGES = {"@mcap/core": "2.2.2", "@mcap/support": "1.1.0", "@foxglove/rosmsg": "5.0.5",
            "@foxglove/rosmsg2-serialization": "3.1.0", "@foxglove/wasm-zstd": "1.0.1", "lz4js": "0.2.0", "protobufjs": "7.2.5"}
LINE = "=" * 80 + "\n"
TIME = LINE + "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
HEADER = LINE + "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + TIME
POINT_CLOUD2 = """std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense
""" + LINE + """MSG: sensor_msgs/PointField
uint8 INT8=1
uint8 FLOAT32=7
string name
uint32 offset
uint8 datatype
uint32 count
""" + HEADER
STRING = "string data\n"
IMAGE = """std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
""" + HEADER
COMPRESSED_IMAGE = "std_msgs/Header header\nstring format\nuint8[] data\n" + HEADER
CAMERA_INFO = """std_msgs/Header header
uint32 height
uint32 width
string distortion_model
float64[] d
float64[9] k
float64[9] r
float64[12] p
uint32 binning_x
uint32 binning_y
sensor_msgs/RegionOfInterest roi
""" + LINE + """MSG: sensor_msgs/RegionOfInterest
uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
""" + HEADER
FOXGLOVE = """syntax = "proto3";
package foxglove;
message Timestamp { int64 seconds = 1; int32 nanos = 2; }
message PackedElementField {
  enum NumericType { UNKNOWN = 0; UINT8 = 1; INT8 = 2; UINT16 = 3; INT16 = 4; UINT32 = 5; INT32 = 6; FLOAT32 = 7; FLOAT64 = 8; }
  string name = 1;
  fixed32 offset = 2;
  NumericType type = 3;
}
message PointCloud {
  Timestamp timestamp = 1;
  string frame_id = 2;
  fixed32 point_stride = 4;
  repeated PackedElementField fields = 5;
  bytes data = 6;
}
message CompressedImage { Timestamp timestamp = 1; bytes data = 2; string format = 3; string frame_id = 4; }
message CameraCalibration {
  Timestamp timestamp = 1;
  fixed32 width = 2;
  fixed32 height = 3;
  string distortion_model = 4;
  repeated double D = 5;
  repeated double K = 6;
  repeated double R = 7;
  repeated double P = 8;
  string frame_id = 9;
}
"""
FIRST = 1_700_000_000_000_000_000  # nanoseconds

missing = None if shutil.which("npm") else "there is no npm"


def node(*arguments):
    environment = os.environ | {"NODE_PATH": str(node_packages.installed("mcap-js", PACKAGES))}
    done = subprocess.run(["node", HERE / "clients" / "recording.js", *map(str, arguments)], capture_output=True,
                          timeout=120, env=environment)
    if done.returncode != 0:
        raise AssertionError(f"recording.js {arguments}: {done.stderr.decode()}")
    return done.stdout


def text(data):
    return base64.b64encode(data).decode()


def stamp(nanoseconds):
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def header(nanoseconds, frame_id):
    return {"stamp": stamp(nanoseconds), "frame_id": frame_id}


def point_cloud2(nanoseconds, points, frame_id="lidar", width=None):
    """`points`: x, y, z, color and intensity of each. The intensity lies behind a gap, and each row ends in one."""
    width = width or len(points)
    height = len(points) // width if points else 1
    fields = [{"name": name, "offset": offset, "datatype": kind, "count": 1}
              for name, offset, kind in (("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("rgb", 12, 7), ("intensity", 18, 2))]
    rows = [b"".join(struct.pack("<3fI2xB3x", *point) for point in points[row * width:(row + 1) * width]) + b"gap"
            for row in range(height)]
    return {"header": header(nanoseconds, frame_id), "height": height, "width": width if points else 0,
            "fields": fields, "is_bigendian": False, "point_step": 22, "row_step": 22 * (width if points else 0) + 3,
            "data": text(b"".join(rows)), "is_dense": False}


def labels_of(message):
    """The field `label` of a decoded message PointCloud2, and the bytes of the points without it."""
    field = message["fields"][-1]
    assert (field["name"], field["datatype"], field["count"]) == ("label", 6, 1), field
    data = base64.b64decode(message["data"])
    step = message["point_step"]
    points = [data[at:at + step] for at in range(0, len(data), step)]
    return ([struct.unpack_from("<I", point, field["offset"])[0] for point in points],
            [point[:field["offset"]] for point in points])


def channel(topic, kind, schema, messages, encoding="cdr", schema_encoding="ros2msg"):
    """`messages`: a list of (time after the first in ns, message as a dictionary or as bytes)."""
    def entry(after, message):
        key, value = ("data", text(message)) if isinstance(message, bytes) else ("message", message)
        return {"logTime": str(FIRST + after), key: value}
    return {"topic": topic, "type": kind, "encoding": encoding, "schemaEncoding": schema_encoding, "schema": schema,
            "messages": [entry(*message) for message in messages]}


def clouds(topic, messages):
    return channel(topic, "sensor_msgs/msg/PointCloud2", POINT_CLOUD2, messages)


def images(topic, messages):
    return channel(topic, "sensor_msgs/msg/Image", IMAGE, messages)


def image(nanoseconds, width, encoding, data, frame_id="camera_depth_optical_frame"):
    step = width * {"rgb8": 3, "16UC1": 2, "32FC1": 4}[encoding]
    return {"header": header(nanoseconds, frame_id), "height": len(data) // step, "width": width, "encoding": encoding,
            "is_bigendian": 0, "step": step, "data": text(data)}


def compressed_images(topic, messages):
    return channel(topic, "sensor_msgs/msg/CompressedImage", COMPRESSED_IMAGE, messages)


def compressed_image(nanoseconds, form, data):
    return {"header": header(nanoseconds, "camera_depth_optical_frame"), "format": form, "data": text(data)}


def camera_info(nanoseconds, width, height, fx, fy, cx, cy, distortion=()):
    return {"header": header(nanoseconds, "camera_depth_optical_frame"), "height": height, "width": width,
            "distortion_model": "plumb_bob", "d": list(distortion), "k": [fx, 0, cx, 0, fy, cy, 0, 0, 1],
            "r": [1, 0, 0, 0, 1, 0, 0, 0, 1], "p": [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0], "binning_x": 0,
            "binning_y": 0, "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}}


def cameras(topic, messages):
    return channel(topic, "sensor_msgs/msg/CameraInfo", CAMERA_INFO, messages)


def foxglove(topic, kind, messages):
    return channel(topic, f"foxglove.{kind}", FOXGLOVE, messages, "protobuf", "protobuf")


def write(path, channels, compression="zstd", chunks=True, profile="ros2"):
    spec = path.with_suffix(".json")
    spec.write_text(json.dumps({"compression": compression, "chunks": chunks, "profile": profile, "channels": channels,
                                "metadata": {"rosbag2": {"serialized_metadata": "rosbag2_bagfile_information: {}"}}}))
    node("write", spec, path)
    return path


def read(path):
    proto = path.with_suffix(".proto")
    proto.write_text(FOXGLOVE)
    return json.loads(node("read", path, proto))


def _record(fields, data):
    header = b"".join(struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value
                      for name, value in fields.items())
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def ros1_point_cloud2(nanoseconds, points, frame_id):
    """x, y, z of points as ROS 1 writes a PointCloud2."""
    name = frame_id.encode()
    fields = b"".join(struct.pack("<I1sIBI", 1, axis, 4 * i, 7, 1) for i, axis in enumerate((b"x", b"y", b"z")))
    data = b"".join(struct.pack("<3f", *point) for point in points)
    return (struct.pack("<III", 3, nanoseconds // 10**9, nanoseconds % 10**9) + struct.pack("<I", len(name)) + name +
            struct.pack("<III", 1, len(points), 3) + fields + struct.pack("<BIII", 0, 12, 12 * len(points), len(data)) +
            data + b"\1")


def write_bag(path, topic, messages):
    """A ROS 1 bag without an index, as after a crash, with one chunk of bz2. `messages`: (nanoseconds, bytes)."""
    definition = POINT_CLOUD2.replace("std_msgs/Header", "Header")
    connection = b"".join(struct.pack("<I", len(field)) + field for field in
                          (b"type=sensor_msgs/PointCloud2", b"md5sum=1158d486dd51d683ce2f1be655c3c181",
                           b"message_definition=" + definition.encode()))
    number = struct.pack("<I", 0)
    records = _record({"op": b"\7", "conn": number, "topic": topic.encode()}, connection)
    for nanoseconds, message in messages:
        time = struct.pack("<II", nanoseconds // 10**9, nanoseconds % 10**9)
        records += _record({"op": b"\2", "conn": number, "time": time}, message)
    begin = _record({"op": b"\3", "index_pos": bytes(8), "conn_count": bytes(4), "chunk_count": bytes(4)}, b" " * 4000)
    chunk = {"op": b"\5", "compression": b"bz2", "size": struct.pack("<I", len(records))}
    path.write_bytes(b"#ROSBAG V2.0\n" + begin + _record(chunk, bz2.compress(records)))
    return path
