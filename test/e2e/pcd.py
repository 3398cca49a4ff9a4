# SPDX-License-Identifier: Apache-2.0
"""Writes and reads the PCD files that the tests need."""
import struct


def header(points, fields="x y z", size="4 4 4", kind="F F F", count="1 1 1", width=None, height=1, data="ascii"):
    return (f"VERSION 0.7\nFIELDS {fields}\nSIZE {size}\nTYPE {kind}\nCOUNT {count}\n"
            f"WIDTH {points if width is None else width}\nHEIGHT {height}\n"
            f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n").encode()


def ascii_file(points, colors=None):
    """Points (x, y, z), with packed colors as unsigned integers if given."""
    if colors is None:
        return header(len(points)) + "".join(f"{x} {y} {z}\n" for x, y, z in points).encode()
    rows = "".join(f"{x} {y} {z} {color}\n" for (x, y, z), color in zip(points, colors))
    return header(len(points), "x y z rgb", "4 4 4 4", "F F F U", "1 1 1 1") + rows.encode()


def binary_file(points):
    return header(len(points), data="binary") + b"".join(struct.pack("<3f", *point) for point in points)


def equal_points(count):
    """A compressed file of so many points at (0, 0, 1): twelve bytes a point in an eighty-eighth of that."""
    columns = lzf_of_repeated(bytes(4), 2 * count) + lzf_of_repeated(struct.pack("<f", 1), count)
    return (header(count, data="binary_compressed") + struct.pack("<II", len(columns), 12 * count) + columns)


def lzf_of_repeated(word, count):
    """LZF: the word as it is, then runs of up to 264 bytes that repeat the last four."""
    out = bytes([len(word) - 1]) + word
    left = len(word) * (count - 1)
    while left > 0:
        run = min(left, 264)
        length = [7 << 5, run - 9] if run >= 9 else [run - 2 << 5]
        out += bytes([*length, len(word) - 1])
        left -= run
    return out


def read_binary(path):
    """The names of the fields, and the bytes of the points, of a binary PCD file. Fields that do not have 4 bytes are left out."""
    content = path.read_bytes()
    start = content.index(b"DATA binary\n")
    lines = dict(line.split(" ", 1) for line in content[:start].decode().splitlines() if " " in line)
    fields = lines["FIELDS"].split()
    sizes = [int(size) for size in lines["SIZE"].split()]
    body = content[start + len(b"DATA binary\n"):]
    assert len(body) == sum(sizes) * int(lines["POINTS"])
    begins = [sum(sizes[:i]) for i in range(len(sizes))]
    kept = [i for i, size in enumerate(sizes) if size == 4]
    if len(kept) == len(sizes):
        return fields, body
    rows = (body[row:row + sum(sizes)] for row in range(0, len(body), sum(sizes)))
    return [fields[i] for i in kept], b"".join(row[begins[i]:begins[i] + 4] for row in rows for i in kept)


def read_labels(path):
    """The field `label`, the last one."""
    fields, body = read_binary(path)
    assert fields[-1] == "label", fields
    return [row[-1] for row in struct.iter_unpack(f"<{len(fields)}I", body)]


def read_points(path):
    """The columns x, y, z and the packed colors."""
    fields, body = read_binary(path)
    assert fields[:4] == ["x", "y", "z", "rgb"], fields
    rows = list(struct.iter_unpack("<3fI" + "I" * (len(fields) - 4), body))
    return [[row[i] for row in rows] for i in range(4)]
