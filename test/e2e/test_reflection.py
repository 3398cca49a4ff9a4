# SPDX-License-Identifier: Apache-2.0
"""A client that knows nothing of segserve learns its interface by reflection and calls it, as grpcurl does."""
import importlib
import pathlib
import subprocess
import sys
import unittest

import grpc
from google.protobuf import descriptor_pb2, descriptor_pool, json_format, message_factory

from harness import EndToEnd

PROTOS = pathlib.Path("/usr/share/grpc-proto")


class Reflection(EndToEnd):
    server_flags = ("--reflection",)

    def learn(self, version, symbol):
        """The descriptors of a symbol, by this version of reflection."""
        generated = self.folder / version
        generated.mkdir()
        proto = f"grpc/reflection/{version}/reflection.proto"
        # The package would hide Python's own grpc.
        text = (PROTOS / proto).read_text()
        (generated / f"reflection_{version}.proto").write_text(text)
        subprocess.run(["protoc", f"--proto_path={generated}", f"--python_out={generated}", f"reflection_{version}.proto"],
                       check=True, timeout=60)
        sys.path.insert(0, str(generated))
        self.addCleanup(sys.path.remove, str(generated))
        messages = importlib.import_module(f"reflection_{version}_pb2")
        with grpc.insecure_channel(self.server.address, options=[("grpc.enable_http_proxy", 0)]) as channel:
            ask = channel.stream_stream(f"/grpc.reflection.{version}.ServerReflection/ServerReflectionInfo",
                                        request_serializer=messages.ServerReflectionRequest.SerializeToString,
                                        response_deserializer=messages.ServerReflectionResponse.FromString)
            request = messages.ServerReflectionRequest(file_containing_symbol=symbol)
            response, = ask(iter([request]), timeout=20)
        pool = descriptor_pool.DescriptorPool()
        for data in response.file_descriptor_response.file_descriptor_proto:
            pool.Add(descriptor_pb2.FileDescriptorProto.FromString(data))
        return pool

    def check(self, version):
        pool = self.learn(version, "segserve.v1.SegmentationService")
        method = pool.FindServiceByName("segserve.v1.SegmentationService").FindMethodByName("GetServerInfo")
        factory = message_factory.MessageFactory(pool)
        request, response = (factory.GetPrototype(each) for each in (method.input_type, method.output_type))
        with grpc.insecure_channel(self.server.address, options=[("grpc.enable_http_proxy", 0)]) as channel:
            call = channel.unary_unary("/segserve.v1.SegmentationService/GetServerInfo",
                                       request_serializer=request.SerializeToString,
                                       response_deserializer=response.FromString)
            told = json_format.MessageToDict(call(request(), timeout=20))
        self.assertGreater(int(told["limits"]["maxPoints"]), 0)

    def test_v1(self):
        self.check("v1")

    def test_v1alpha(self):
        self.check("v1alpha")


if __name__ == "__main__":
    unittest.main()
