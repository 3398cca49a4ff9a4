# SPDX-License-Identifier: Apache-2.0
"""The connections of a stream."""
from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import NamedTuple

from segserve.errors import Cancelled, Error, Unavailable, is_worth_reconnecting, unavailable_if_cancelled
from segserve._stream.address_book import AddressBook
from segserve._stream.frame import StreamOptions
from segserve._stream.messages import open_message
from segserve._stream.protocol import StreamProtocol


class ActionKind(enum.Enum):
    OPEN = enum.auto()  # connect to `address`
    RENEW = enum.auto()  # use the call's channel for no other call, so that the next one makes a new connection
    PROBE = enum.auto()  # ask the server for a sign of life
    BREAK = enum.auto()  # cancel the call
    BREAK_SILENT = enum.auto()  # cancel the call, and never use its channel again: the network has cut it


class Action(NamedTuple):
    """An order to the transport."""

    kind: ActionKind
    connection: int
    address: int


@dataclass
class Link:
    """A connection to a server, or the attempt to make one."""

    connection: int
    address: int
    protocol: StreamProtocol
    last_sign_of_life: float
    probed_at: float | None = None  # None: there was a sign of life since the last probe
    broken: Error | None = None  # set: given up, and only its end is awaited
    outcome_bytes: int = 0  # of the messages since the last FrameOutcome, that one included
    is_old: bool = False  # shall be replaced, and takes frames until it is

    def takes_frames(self) -> bool:
        """Also true of a connection that is still being made."""
        return self.broken is None and not self.protocol.ending


class End(NamedTuple):
    """How a connection ended."""

    why: Error
    is_fatal: bool = False  # every server would say so again


class Links:
    """Which server to connect to and when, and which connection is dead.

    One connection at a time takes new frames; others may still owe outcomes. Knows neither transport nor clock.
    """

    def __init__(self, options: StreamOptions, addresses: list[str], first_address: int,
                 seed: int | None) -> None:
        self._options = options
        self._addresses = addresses
        self._book = AddressBook(len(addresses), first_address, options.retry, seed)
        self._links: dict[int, Link] = {}
        self._last_connection = 0
        self._actions: list[Action] = []
        self.last_error: Error | None = None  # of a connection

    def find(self, connection: int) -> Link | None:
        """None for unknown connections and those that were given up."""
        link = self._links.get(connection)
        return None if link is None or link.broken is not None else link

    def address_of(self, link: Link) -> str:
        return self._addresses[link.address]

    def out_of_reach(self) -> bool:
        """Whether every address has failed since it was reached last, and no connection takes frames."""
        one_takes_frames = any(link.takes_frames() and link.protocol.opened for link in self._links.values())
        return not one_takes_frames and self._book.nobody_in_reach()

    def open_if_needed(self, now: float) -> float | None:
        """Makes a connection unless there is one that takes frames. Returns when to call again, if it is needed."""
        if any(link.takes_frames() and not link.is_old for link in self._links.values()):
            return None
        choice = self._book.choose(now)
        if choice.not_before > now:
            return choice.not_before
        self._last_connection += 1
        protocol = StreamProtocol(open_message(self._options))
        link = Link(self._last_connection, choice.address, protocol, now)
        self._links[link.connection] = link
        self._request(ActionKind.OPEN, link)
        return now + self._options.progress_timeout / 2

    def check_silence(self, now: float) -> float | None:
        """Probes the connections that owe an answer and are silent, and gives up those whose probe had no answer.

        Returns when to call again, if ever.
        """
        patience = self._options.progress_timeout / 2  # for a sign of life, and then for the answer to a probe
        due: list[float] = []
        for link in self._links.values():
            protocol = link.protocol
            owes_us = not protocol.opened or protocol.in_flight > 0 or protocol.ending
            if link.broken is not None or not owes_us:
                continue
            if link.probed_at is not None and now >= link.probed_at + patience:
                silence = f"{self.address_of(link)} showed no sign of life for {self._options.progress_timeout:g} s"
                self.break_link(link, ActionKind.BREAK_SILENT, Unavailable(silence), now)
                continue
            if link.probed_at is None and now >= link.last_sign_of_life + patience:
                link.probed_at = now
                self._request(ActionKind.PROBE, link)
            due.append((link.last_sign_of_life if link.probed_at is None else link.probed_at) + patience)
        return min(due, default=None)

    def end_all(self) -> None:
        """Half-closes all connections once their uploads are through: no more frames will come."""
        for link in self._links.values():
            link.protocol.end()

    def break_all(self) -> None:
        """Gives up all connections, which is nobody's fault: the stream was closed."""
        for link in self._links.values():
            if link.broken is None:
                link.broken = Cancelled("the stream was closed")
                self._request(ActionKind.BREAK, link)

    def break_link(self, link: Link, kind: ActionKind, why: Error, now: float) -> None:
        """Gives up a connection whose server is at fault."""
        link.broken = self.last_error = why
        self._request(kind, link)
        self._book.failed(link.address, now)

    def on_sign_of_life(self, connection: int, now: float) -> None:
        link = self._links.get(connection)
        if link is not None:
            link.last_sign_of_life, link.probed_at = now, None

    def on_opened(self, link: Link) -> None:
        """The server has granted credit. The connection takes the place of old ones, which finish what they have."""
        self._book.reached(link.address)
        for other in self._links.values():
            if other.is_old:
                other.protocol.end()

    def on_old(self, link: Link) -> None:
        """The server asks for another connection. New frames go to the old one until there is another."""
        if not link.is_old:
            link.is_old = True
            self._book.move_on(link.address)
            self._request(ActionKind.RENEW, link)

    def on_draining(self, link: Link, now: float) -> None:
        """The server takes no more frames."""
        self._book.failed(link.address, now)
        self.last_error = Unavailable(f"{self.address_of(link)} is about to stop")

    def on_closed(self, connection: int, status: Error | None, now: float) -> End | None:
        """The transport says that a connection has ended; None is the status OK. Returns None if it is unknown."""
        link = self._links.pop(connection, None)
        if link is None:
            return None
        if link.broken is not None:
            return End(link.broken)
        if status is None:
            status = Unavailable(f"{self.address_of(link)} closed the stream")
        why = unavailable_if_cancelled(status)
        if link.protocol.ending and link.protocol.in_flight == 0:
            return End(why)
        if not is_worth_reconnecting(why):
            return End(why, is_fatal=True)
        self.last_error = why
        if not link.protocol.ending:
            self._book.failed(link.address, now, why.retry_delay)
        return End(why)

    def take_actions(self) -> list[Action]:
        """The orders to the transport since the last call."""
        actions, self._actions = self._actions, []
        return actions

    def _request(self, kind: ActionKind, link: Link) -> None:
        self._actions.append(Action(kind, link.connection, link.address))
