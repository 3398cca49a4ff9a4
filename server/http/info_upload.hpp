// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "segserve/v1/segmentation_service.pb.h"
#include "server/http/connect_call.hpp"
#include "server/http/frame_uploads.hpp"
#include "server/http/http_handler.hpp"

namespace segserve::server {

/// The upload of a GetServerInfoRequest of the protocol Connect, which must be one although it has no fields. `info` is
/// the answer, and must outlive the upload.
std::shared_ptr<HttpUpload> info_upload(ConnectCodec codec, const v1::GetServerInfoResponse& info, DressAnswer dress);

}  // namespace segserve::server
