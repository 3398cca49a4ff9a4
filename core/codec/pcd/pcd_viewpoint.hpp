// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::codec {

/// Whether the content has the VIEWPOINT of a file, and its view does not have the sensor at another place, as one that
/// was given does.
bool keeps_viewpoint(const FileContent& content);

}  // namespace segserve::codec
