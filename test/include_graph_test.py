# SPDX-License-Identifier: Apache-2.0
"""Every rule of include_graph.py fails on an example that breaks it, and accepts one that does not."""

import unittest

import include_graph


class IncludeGraphTest(unittest.TestCase):
    def check(self, sources, *expected):
        found = list(include_graph.faults(sources))
        self.assertEqual(len(found), len(expected), found)
        for line, words in zip(found, expected):
            self.assertIn(words, line)

    def test_arrows_along_the_flow_are_fine(self):
        self.check({"core/voxels/grid.hpp": '#include "core/base/stop.hpp"\n#include "segserve/cloud.hpp"\n#include <vector>',
                    "core/base/stop.hpp": "", "core/include/segserve/cloud.hpp": "#include <Eigen/Core>",
                    "server/a.cpp": '#include "server/b.hpp"\n#include "server/version.hpp"', "server/b.hpp": ""})

    def test_a_step_must_not_include_a_later_one(self):
        self.check({"core/voxels/a.cpp": '#include "core/merging/merger.hpp"', "core/merging/merger.hpp": ""},
                   "core/voxels must not know core/merging")

    def test_the_core_must_not_include_the_laboratory(self):
        self.check({"core/pipeline/a.cpp": '#include "core/lab/scene.hpp"', "core/lab/scene.hpp": ""}, "must not know core/lab")

    def test_the_server_must_not_include_the_client(self):
        self.check({"server/a.cpp": '#include "segserve/client/client.hpp"', "client/include/segserve/client/client.hpp": ""},
                   "server must not know client/include")

    def test_a_public_header_must_not_include_a_private_one(self):
        self.check({"core/include/segserve/cloud.hpp": '#include "core/base/stop.hpp"', "core/base/stop.hpp": ""},
                   "is public and includes core/base/stop.hpp")

    def test_the_core_must_not_include_messages(self):
        self.check({"core/codec/a.cpp": '#include "segserve/v1/cloud.pb.h"'}, "neither gRPC nor protobuf")

    def test_pcl_stays_in_its_adapter(self):
        self.check({"core/voxels/a.cpp": '#include "pcl/point_types.h"'}, "core/pcl_adapter alone")
        self.check({"core/pcl_adapter/a.cpp": '#include "pcl/point_types.h"'})

    def test_kernels_must_not_include_eigen(self):
        self.check({"core/normals/simd/a.hpp": "#include <Eigen/Core>"}, "must not share Eigen's inline functions")

    def test_names_are_unique(self):
        self.check({"server/frame.hpp": "", "client/stream/frame.hpp": ""}, "have the same name")

    def test_headers_that_are_not_there_are_found(self):
        self.check({"core/voxels/a.cpp": '#include "core/voxels/gone.hpp"'}, "which is no header of ours")


if __name__ == "__main__":
    unittest.main()
