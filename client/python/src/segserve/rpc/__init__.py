# SPDX-License-Identifier: Apache-2.0
"""The messages of google.rpc and grpc.health.v1, generated while the package is built."""
