# SPDX-License-Identifier: Apache-2.0
"""A TCP proxy on loopback that behaves like a slow, distant and lossy link.

Loss is what TCP makes of it: the bytes behind a lost segment wait until it has been sent again, a round trip later.
"""
import asyncio
import random
import threading

SEGMENT = 1460  # bytes
QUEUED_SECONDS = 0.02  # of sending, for which the proxy reads ahead, as the buffer of a modem does


class _Direction:
    """One direction of the link, which all connections share."""

    def __init__(self, link, seed):
        self._link = link
        self._random = random.Random(seed)
        self._free_at = 0.0  # when the last byte so far has left the sender

    def send(self, size, now):
        """Puts bytes on the link; returns when they have left the sender, and when they arrive."""
        link = self._link
        self._free_at = max(now, self._free_at) + 8 * size / link.bits_per_second
        arrival = self._free_at + link.delay + link.jitter * self._random.random()
        segments = -(-size // SEGMENT)
        if self._random.random() < 1 - (1 - link.loss) ** segments:
            link.lost += 1
            arrival += 2 * link.delay + link.jitter
        return self._free_at, arrival


class ImpairingProxy:
    """Forwards connections to an address. `delay` and `jitter` are seconds one way, `loss` is the share of segments.
    While it is `cut`, nothing arrives at either side, and no connection ends."""

    def __init__(self, target, *, bits_per_second=20e6, delay=0.02, jitter=0.005, loss=0.001, seed=1):
        self.bits_per_second, self.delay, self.jitter, self.loss = bits_per_second, delay, jitter, loss
        self.lost = 0
        self._host, port = target.rsplit(":", 1)
        self._port = int(port)
        self._directions = _Direction(self, seed), _Direction(self, seed + 1)
        self._loop = asyncio.new_event_loop()
        self._started = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        if not self._started.wait(20):
            raise RuntimeError("the proxy did not start")

    def cut(self):
        self._loop.call_soon_threadsafe(self._connected.clear)

    def mend(self):
        self._loop.call_soon_threadsafe(self._connected.set)

    def close(self):
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()

    def _run(self):
        asyncio.set_event_loop(self._loop)
        self._connected = asyncio.Event()
        self._connected.set()
        server = self._loop.run_until_complete(asyncio.start_server(self._forward, "127.0.0.1", 0, limit=SEGMENT))
        self.address = "127.0.0.1:%d" % server.sockets[0].getsockname()[1]
        self._started.set()
        self._loop.run_forever()
        server.close()
        tasks = asyncio.all_tasks(self._loop)
        for task in tasks:
            task.cancel()
        self._loop.run_until_complete(asyncio.gather(*tasks, return_exceptions=True))
        self._loop.close()

    async def _forward(self, reader, writer):
        try:
            far_reader, far_writer = await asyncio.open_connection(self._host, self._port, limit=SEGMENT)
        except OSError:
            writer.close()
            return
        up, down = self._directions
        pumps = [asyncio.ensure_future(self._pump(reader, far_writer, up)),
                 asyncio.ensure_future(self._pump(far_reader, writer, down))]
        try:
            await asyncio.wait(pumps, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for pump in pumps:
                pump.cancel()
            await asyncio.gather(*pumps, return_exceptions=True)
            for each in (writer, far_writer):
                each.close()

    async def _pump(self, reader, writer, direction):
        on_the_way = asyncio.Queue()
        delivery = asyncio.ensure_future(self._deliver(on_the_way, writer))
        try:
            latest = 0.0
            while data := await reader.read(4 * SEGMENT):
                left, arrival = direction.send(len(data), self._loop.time())
                latest = max(latest, arrival)  # bytes arrive in order
                on_the_way.put_nowait((latest, data))
                await asyncio.sleep(max(0.0, left - self._loop.time() - QUEUED_SECONDS))
            on_the_way.put_nowait((latest, b""))
            await delivery
        except ConnectionError:
            pass  # one of the two sides is gone, and the other one will be told
        finally:
            delivery.cancel()

    async def _deliver(self, on_the_way, writer):
        while True:
            arrival, data = await on_the_way.get()
            await asyncio.sleep(max(0.0, arrival - self._loop.time()))
            await self._connected.wait()
            if not data:
                return
            writer.write(data)
            await writer.drain()
