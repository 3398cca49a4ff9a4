# SPDX-License-Identifier: Apache-2.0
"""Recordings for tests, written and read by the libraries of Foxglove (clients/recording.js)."""
import base64
import json
import os
import pathlib
import shutil
import struct
import subprocess

import node_packages

HERE = pathlib.Path(__file__).resolve().parent
PACKAGES = {"@mcap/core": "2.2.2", "@mcap/support": "1.1.0", "@foxglove/rosmsg": "5.0.5",
            "@foxglove/rosmsg2-serialization": "3.1.0", "@foxglove/wasm-zstd": "1.0.1", "lz4js": "0.2.0"}
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


def write(path, channels, compression="zstd", chunks=True, profile="ros2"):
    spec = path.with_suffix(".json")
    spec.write_text(json.dumps({"compression": compression, "chunks": chunks, "profile": profile, "channels": channels,
                                "metadata": {"rosbag2": {"serialized_metadata": "rosbag2_bagfile_information: {}"}}}))
    node("write", spec, path)
    return path


def read(path):
    return json.loads(node("read", path))
