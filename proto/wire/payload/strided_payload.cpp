// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "proto/wire/block_message.hpp"
#include "proto/wire/payload/payload_codecs.hpp"
#include "proto/wire/payload/payload_support.hpp"
#include "segserve/codec/strided.hpp"

namespace segserve::wire {
namespace {

codec::StridedLayout read_layout(const v1::Cloud& message) {
  const v1::StridedCloud& strided = message.strided();
  codec::StridedLayout layout;
  layout.width = message.width();
  layout.height = message.height();
  for (const v1::PointField& field : strided.fields()) {
    // A message may hold any number. 0 is no type, so that check_layout refuses it.
    const int type = field.datatype();
    const auto datatype = static_cast<codec::PointDatatype>(type > 0 && type < 256 ? type : 0);
    layout.fields.push_back({field.name(), field.offset(), datatype, field.count()});
  }
  layout.point_step = strided.point_step();
  layout.row_step = strided.row_step();
  layout.is_bigendian = strided.is_bigendian();
  return layout;
}

}  // namespace

absl::StatusOr<DecodedCloud> decode_strided(const v1::Cloud& message, const codec::ReadOptions& options,
                                            const codec::DecodeLimits& limits, const StopToken& stop) {
  const codec::StridedLayout layout = read_layout(message);
  if (const absl::Status status = codec::check_layout(layout, limits); !status.ok()) return decode_error(status);
  std::string buffer;
  ASSIGN_OR_RETURN(const std::string_view data,
                   block_bytes(message.strided().data(), layout.bytes(), "cloud.strided.data", buffer));
  ASSIGN_OR_RETURN(auto decoded, with_decode_reason(codec::decode_strided(layout, data, options, limits, stop)));
  decoded.view_rule = requested_view_rule(*options.view);
  return decoded_cloud(std::move(decoded));
}

absl::StatusOr<v1::Cloud> to_strided_message(const CloudView& cloud, v1::Compression compression) {
  codec::StridedCloud encoded = codec::encode_strided(cloud);
  v1::Cloud message = message_without_payload(cloud);
  v1::StridedCloud& strided = *message.mutable_strided();
  for (const codec::PointField& field : encoded.layout.fields) {
    v1::PointField& entry = *strided.add_fields();
    entry.set_name(field.name);
    entry.set_offset(field.offset);
    entry.set_datatype(static_cast<v1::PointDatatype>(field.datatype));
    entry.set_count(field.count);
  }
  strided.set_point_step(encoded.layout.point_step);
  strided.set_row_step(encoded.layout.row_step);
  ASSIGN_OR_RETURN(*strided.mutable_data(), to_block(std::move(encoded.data), compression));
  return message;
}

}  // namespace segserve::wire
