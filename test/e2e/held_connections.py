# SPDX-License-Identifier: Apache-2.0
"""The connections that an attack holds open, whatever the number of descriptors that a process may have here."""
import collections
import resource


class HeldConnections:
    """Holds the newest connections, and closes the oldest where there would be too many of them."""

    def __init__(self):
        self._most = min(2000, resource.getrlimit(resource.RLIMIT_NOFILE)[0] // 2)
        self._connections = collections.deque()

    def add(self, connection):
        """Takes an object with close(), and returns it."""
        while len(self._connections) >= self._most:
            self._connections.popleft().close()
        self._connections.append(connection)
        return connection

    def close(self):
        while self._connections:
            self._connections.popleft().close()
