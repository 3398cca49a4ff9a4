// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/prompts.hpp"
#include "segserve/wire/outputs.hpp"
#include "segserve/wire/result.hpp"
#include "server/http/http_message.hpp"

// The answers to POST /v1/segment.
namespace segserve::server {

/// The form of an answer.
enum class AnswerForm : std::uint8_t {
  kJson,    ///< application/json: what `segctl segment --json` writes, with the arrays that were asked for
  kLabels,  ///< application/octet-stream: the labels of all points, 32-bit integers, little endian
  kView,    ///< application/vnd.segserve.view+json: what the page needs to draw the cloud
};

/// The type of content of a form, as it stands in Accept and Content-Type.
std::string_view content_type(AnswerForm form);

/// The form that a header Accept asks for; nullopt if it asks for none of them. Without the header it is JSON.
std::optional<AnswerForm> accepted_form(std::string_view accept);

/// The bytes of memory that making an answer takes for each point of the cloud, besides those of the result.
std::uint64_t bytes_per_point(AnswerForm form);

/// The parts of an answer besides the result.
struct AnswerContent {
  wire::Outputs outputs = {};                     ///< labels, supervoxels, tree and segments in JSON
  std::optional<Prompts> prompts = std::nullopt;  ///< of the request
  std::string name = {};                          ///< of the scene
};

/// The answer of a result. With prompts, kLabels has 1 for each point that is selected and 0 for the others. May take
/// parts of the result. INVALID_ARGUMENT if there are too many points to draw.
absl::StatusOr<HttpAnswer> answer_of(AnswerForm form, const AnswerContent& content, wire::Result& result,
                                     const CloudView& cloud);

}  // namespace segserve::server
