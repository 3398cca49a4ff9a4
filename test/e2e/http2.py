# SPDX-License-Identifier: Apache-2.0
"""A client of HTTP/2 (RFC 9113) without manners: it sends what it is told to, and reads only when asked."""
import socket
import struct

DATA, HEADERS, RST_STREAM, SETTINGS, PING, GOAWAY, WINDOW_UPDATE, CONTINUATION = 0, 1, 3, 4, 6, 7, 8, 9
END_STREAM, ACK, END_HEADERS = 1, 1, 4
INITIAL_WINDOW_SIZE = 4  # a setting


def literal(name, value):
    """A header field without indexing and without Huffman code (RFC 7541, section 6.2.2)."""
    return b"\0" + bytes([len(name)]) + name + bytes([len(value)]) + value


def headers_of_call(method):
    return b"".join(literal(name, value) for name, value in (
        (b":method", b"POST"), (b":scheme", b"http"), (b":path", method.encode()), (b":authority", b"x"),
        (b"te", b"trailers"), (b"content-type", b"application/grpc")))


def message(content):
    """A message of gRPC: no compression, length, content."""
    return b"\0" + struct.pack(">I", len(content)) + content


class Connection:
    def __init__(self, address, window=None):
        """`window`: bytes that the server may send on a stream before it is allowed more."""
        host, port = address.split(":")
        self.socket = socket.create_connection((host, int(port)), timeout=10)
        self.next_stream = 1
        settings = b"" if window is None else struct.pack(">HI", INITIAL_WINDOW_SIZE, window)
        self.socket.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + self.frame(SETTINGS, 0, 0, settings))

    @staticmethod
    def frame(kind, flags, stream, payload=b""):
        return struct.pack(">I", len(payload))[1:] + bytes([kind, flags]) + struct.pack(">I", stream) + payload

    def send(self, kind, flags, stream, payload=b""):
        self.socket.sendall(self.frame(kind, flags, stream, payload))

    def call(self, method):
        """Begins a call; returns its stream."""
        stream, self.next_stream = self.next_stream, self.next_stream + 2
        self.send(HEADERS, END_HEADERS, stream, headers_of_call(method))
        return stream

    def send_data(self, stream, content, flags=0):
        """In frames of the least size that every server takes. The windows must have room for it."""
        for begin in range(0, max(len(content), 1), 16384):
            part = content[begin:begin + 16384]
            self.send(DATA, flags if begin + 16384 >= len(content) else 0, stream, part)

    def receive(self):
        """The next frame: kind, flags, stream, payload. None if the server has closed the connection."""
        head = self.read(9)
        if head is None:
            return None
        payload = self.read(int.from_bytes(head[:3], "big"))
        return None if payload is None else (head[3], head[4], int.from_bytes(head[5:], "big"), payload)

    def read(self, count):
        content = b""
        while len(content) < count:
            try:
                part = self.socket.recv(count - len(content))
            except OSError:
                return None
            if not part:
                return None
            content += part
        return content

    def close(self):
        self.socket.close()
