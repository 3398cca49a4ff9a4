# SPDX-License-Identifier: Apache-2.0
"""Addresses of servers: how they are written, and which to try next."""
from __future__ import annotations

import random
import re
from dataclasses import dataclass, field
from typing import NamedTuple

DEFAULT_PORT = 50051
_RESOLVERS = ("dns:", "unix:", "unix-abstract:", "ipv4:", "ipv6:", "passthrough:", "xds:")
_MOST_DOUBLINGS = 20


@dataclass(frozen=True)
class Retry:
    """How frames and calls are repeated, which is always safe: results are pure functions of the bytes that are sent.

    The time before an address is tried again doubles from the first to the largest, and is shortened at random by up to
    a half. It is never less than the server asked for.
    """

    max_attempts: int = 5
    first_backoff: float = 0.05  # seconds
    max_backoff: float = 5.0  # seconds

    def __post_init__(self) -> None:
        if not 1 <= self.max_attempts <= 1_000_000:
            raise ValueError(f"retry.max_attempts: {self.max_attempts} is not in [1, 1000000]")
        if not 0.001 <= self.first_backoff <= self.max_backoff <= 86400:
            raise ValueError(
                f"retry: the backoffs {self.first_backoff} and {self.max_backoff} s are not 0.001 <= first <= max "
                "<= 86400")

    def backoff(self, attempt: int, asked_for: float | None, rng: random.Random) -> float:
        """The seconds to wait before the `attempt`-th repetition, counted from 1."""
        doublings = min(max(attempt, 1) - 1, _MOST_DOUBLINGS)
        wait = min(self.first_backoff * 2**doublings, self.max_backoff) * rng.uniform(0.5, 1.0)
        return max(wait, asked_for or 0.0)


def parse_addresses(text: str) -> list[str]:
    """Splits a list at its commas, and gives hosts without a port the default one.

    A name that gRPC resolves ("dns:///name:50051", "unix:/path") is one address even if it stands for many servers.
    ValueError if there is no address, or one of them is empty, a URL, or has no number as its port.
    """
    if not text.strip():
        raise ValueError("address: it is empty")
    return [_with_port(address.strip(), text) for address in text.split(",")]


def _with_port(address: str, text: str) -> str:
    if not address:
        raise ValueError(f"address: there is an empty one in '{text}'")
    if address.startswith(_RESOLVERS):
        return address
    if "/" in address:
        raise ValueError(
            f"address: '{address}' is a URL; a server's address is HOST:PORT, such as 127.0.0.1:{DEFAULT_PORT}")
    if not address.startswith("[") and address.count(":") > 1:
        return f"[{address}]:{DEFAULT_PORT}"
    host, colon, port = address.rpartition(":")
    if not colon or address.endswith("]"):
        return f"{address}:{DEFAULT_PORT}"
    if not host or not re.fullmatch(r"\d{1,5}", port) or not 0 < int(port) < 65536:
        raise ValueError(f"address: the port of '{address}' is no number from 1 to 65535")
    return address


def is_loopback(address: str) -> bool:
    return address.startswith(("127.", "localhost:", "[::1]", "unix:", "unix-abstract:"))


class Choice(NamedTuple):
    address: int
    not_before: float


@dataclass
class _Entry:
    failures: int = 0  # since it was reached last
    not_before: float = field(default=float("-inf"))


class AddressBook:
    """Chooses which of several addresses to try next, and when."""

    def __init__(self, count: int, first: int, retry: Retry, seed: int | None) -> None:
        """Begins with the address `first` modulo `count`."""
        self._entries = [_Entry() for _ in range(count)]
        self._turn = first % count
        self._retry = retry
        self._rng = random.Random(seed)

    def choose(self, now: float) -> Choice:
        """The address that may be tried soonest. If several may be tried at that time, the next in turn."""
        count = len(self._entries)
        in_turn = [(self._turn + i) % count for i in range(count)]
        best = min(in_turn, key=lambda address: max(now, self._entries[address].not_before))
        return Choice(best, max(now, self._entries[best].not_before))

    def failed(self, address: int, now: float, asked_for: float | None = None) -> None:
        """The server could not be reached, broke the connection or refuses us, and may have asked to wait."""
        entry = self._entries[address]
        entry.failures += 1
        entry.not_before = now + self._retry.backoff(entry.failures, asked_for, self._rng)
        self._turn = (address + 1) % len(self._entries)

    def reached(self, address: int) -> None:
        """The server answered."""
        self._entries[address] = _Entry()
        self._turn = address

    def move_on(self, address: int) -> None:
        """The server asks for another connection, best to another address: the turn goes on."""
        self._turn = (address + 1) % len(self._entries)

    def nobody_in_reach(self) -> bool:
        """Whether every address has failed since it was reached last."""
        return all(entry.failures > 0 for entry in self._entries)
