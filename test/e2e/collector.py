# SPDX-License-Identifier: Apache-2.0
"""A small collector of OpenTelemetry's traces, by OTLP over HTTP as JSON."""
import http.server
import json
import ssl
import threading
import time


class Collector:
    """Listens on a free loopback port. `answers` are the answers of the next requests: a status, or a tuple of status,
    headers and body; after the last, it is 200. With `certificate` and `key` it speaks TLS."""

    def __init__(self, answers=(), certificate=None, key=None):
        self.answers = list(answers)
        self.requests = []  # (time, path, headers, status)
        self.spans = []  # of requests that were answered with 200
        self.resources = []
        self.lock = threading.Lock()
        collector = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                status, headers, answer = collector.take(self.path, dict(self.headers), body)
                try:
                    self.send_response(status)
                    for name, value in headers.items():
                        self.send_header(name, value)
                    self.send_header("Content-Length", str(len(answer)))
                    self.end_headers()
                    self.wfile.write(answer)
                except OSError:
                    pass  # the client did not wait

            def log_message(self, *_):
                pass

        class Server(http.server.ThreadingHTTPServer):
            daemon_threads = True
            block_on_close = False

            def handle_error(self, *_):
                pass  # the client broke the connection off

        self.server = Server(("127.0.0.1", 0), Handler)
        if certificate:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(certificate, key)
            self.server.socket = context.wrap_socket(self.server.socket, server_side=True, do_handshake_on_connect=False)
        scheme = "https" if certificate else "http"
        self.endpoint = f"{scheme}://127.0.0.1:{self.server.server_address[1]}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def take(self, path, headers, body):
        with self.lock:
            answer = self.answers.pop(0) if self.answers else 200
            status, more, text = answer if isinstance(answer, tuple) else (answer, {}, b"{}")
            self.requests.append((time.monotonic(), path, headers, status))
            if status == 200:
                for resource_spans in json.loads(body)["resourceSpans"]:
                    self.resources.append(attributes(resource_spans["resource"]))
                    for scope_spans in resource_spans["scopeSpans"]:
                        self.spans.extend(scope_spans["spans"])
            return status, more, text

    def roots(self):
        with self.lock:
            return [span for span in self.spans if span["name"] == "segserve.segment"]

    def children(self, parent):
        with self.lock:
            return [span for span in self.spans if span.get("parentSpanId") == parent["spanId"]]

    def close(self):
        self.server.shutdown()
        self.server.server_close()


def attributes(thing):
    """name -> text or number"""
    found = {}
    for attribute in thing.get("attributes", ()):
        value = attribute["value"]
        found[attribute["key"]] = int(value["intValue"]) if "intValue" in value else value["stringValue"]
    return found


def times(span):
    """Begin and end, seconds since 1970."""
    return int(span["startTimeUnixNano"]) / 1e9, int(span["endTimeUnixNano"]) / 1e9
