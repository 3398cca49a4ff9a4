# SPDX-License-Identifier: Apache-2.0
"""The messages of the API segserve.v1, generated from proto/segserve/v1 while the package is built."""
