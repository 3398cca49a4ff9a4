# SPDX-License-Identifier: Apache-2.0
"""The client for asyncio, with the rules of the one that blocks.

    async with segserve.aio.Client("robot-a:50051") as client:
        result = await client.segment(xyz, rgb, view="camera")
        async with client.stream(view="camera") as stream:
            async for outcome in stream.map(clouds):
                print(outcome.get().labels)
"""
from segserve.aio.client import Client
from segserve.aio.stream import Stream

__all__ = ["Client", "Stream"]
