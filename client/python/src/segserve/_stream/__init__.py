# SPDX-License-Identifier: Apache-2.0
"""What a stream decides, without threads, transport or clock. The shells in segserve.stream and segserve.aio bring
those."""
