# SPDX-License-Identifier: Apache-2.0
"""Errors of servers as exceptions."""
import unittest

import grpc

import segserve
from segserve import errors
from segserve.rpc import error_details_pb2, status_pb2


def status(code, message="", *details):
    found = status_pb2.Status(code=code.value[0], message=message)
    for name, detail in details:
        found.details.add(type_url=f"type.googleapis.com/google.rpc.{name}", value=detail.SerializeToString())
    return found


class Errors(unittest.TestCase):
    def test_there_is_a_class_for_each_code(self):
        for code in grpc.StatusCode:
            if code is not grpc.StatusCode.OK:
                self.assertIs(errors.from_rpc(code, "", (), "a:1").code, code)
        self.assertIsInstance(errors.from_status(status_pb2.Status(code=77)), segserve.Unknown)
        self.assertTrue(issubclass(segserve.InvalidArgument, ValueError))

    def test_the_details_are_there_for_programs_and_people(self):
        faults = error_details_pb2.BadRequest()
        faults.field_violations.add(field="options.lambda", description="7 is not in [0, 1]")
        retry = error_details_pb2.RetryInfo()
        retry.retry_delay.FromMilliseconds(1500)
        full = status(grpc.StatusCode.RESOURCE_EXHAUSTED, "full",
                      ("ErrorInfo", error_details_pb2.ErrorInfo(reason="QUEUE_FULL", metadata={"limit": "max_queue"})),
                      ("BadRequest", faults), ("RetryInfo", retry))
        trailers = [("other", "x"), ("grpc-status-details-bin", full.SerializeToString())]
        for error in (errors.from_status(full),
                      errors.from_rpc(grpc.StatusCode.RESOURCE_EXHAUSTED, "full", trailers, "a:1")):
            self.assertIsInstance(error, segserve.ResourceExhausted)
            self.assertEqual((error.reason, error.metadata, error.retry_delay), ("QUEUE_FULL", {
                "limit": "max_queue"
            }, 1.5))
            self.assertEqual(error.field_violations, [("options.lambda", "7 is not in [0, 1]")])
            self.assertEqual(str(error), "full; options.lambda: 7 is not in [0, 1] (try again in 1500 ms)")

    def test_damaged_details_are_skipped(self):
        damaged = status(grpc.StatusCode.INTERNAL, "x")
        damaged.details.add(type_url="type.googleapis.com/google.rpc.ErrorInfo", value=b"\xff\xff\xff")
        retry = error_details_pb2.RetryInfo()
        retry.retry_delay.seconds = -5
        damaged.details.add(type_url="google.rpc.RetryInfo", value=retry.SerializeToString())
        error = errors.from_status(damaged)
        self.assertEqual((error.reason, error.retry_delay), ("", None))
        self.assertEqual(
            errors.from_rpc(grpc.StatusCode.INTERNAL, "x", [("grpc-status-details-bin", b"\xff")], "a").message, "x")

    def test_a_failed_connection_names_the_address_and_the_cause(self):
        message = "failed to connect to all addresses; last error: UNKNOWN: ipv4:127.0.0.1:1: Connection refused"
        error = errors.from_rpc(grpc.StatusCode.UNAVAILABLE, message, (), "127.0.0.1:1")
        self.assertEqual(str(error), "no answer from 127.0.0.1:1: Connection refused; is segserve running there?")

    def test_which_are_tried_again(self):
        for error in (segserve.Unavailable(""), segserve.Aborted(""), segserve.Cancelled(""),
                      segserve.ResourceExhausted(""), segserve.DeadlineExceeded("", reason="UPLOAD_STALLED")):
            self.assertTrue(errors.is_retryable(error), error.code)
        for error in (segserve.InvalidArgument(""), segserve.DeadlineExceeded(""), segserve.Unauthenticated(""),
                      segserve.ResourceExhausted("", reason="LIMIT_EXCEEDED"), segserve.Internal("")):
            self.assertFalse(errors.is_retryable(error), error.code)


if __name__ == "__main__":
    unittest.main()
