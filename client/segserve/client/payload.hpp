#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud/cloud.hpp"
#include "segserve/codec/labelled_cloud.hpp"
#include "segserve/codec/rgbd_encode.hpp"
#include "segserve/v1alpha1/cloud.pb.h"
#include "segserve/wire/codec.hpp"

namespace segserve::client {

/// A cloud as it goes over the wire: encoded once, sent any number of times. Copies share the bytes.
class Payload {
 public:
  Payload() = default;
  /// Takes the bytes out of the message. `points` and `decoded_bytes` as in v1alpha1.FrameHeader; 0: not known.
  explicit Payload(v1alpha1::Cloud message, std::uint64_t points = 0, std::uint64_t decoded_bytes = 0);

  /// The message without the bytes of its blocks.
  const v1alpha1::Cloud& header() const { return data_->header; }
  std::span<const std::string> blocks() const { return data_->blocks; }
  std::uint64_t bytes() const { return data_->bytes; }
  std::uint32_t crc32() const { return data_->crc32; }
  std::uint64_t points() const { return data_->points; }
  std::uint64_t decoded_bytes() const { return data_->decoded_bytes; }

  /// The message with its bytes.
  v1alpha1::Cloud message() const;

 private:
  struct Data {
    v1alpha1::Cloud header;
    std::vector<std::string> blocks;
    std::uint64_t bytes = 0;
    std::uint32_t crc32 = 0;
    std::uint64_t points = 0;
    std::uint64_t decoded_bytes = 0;
  };
  std::shared_ptr<const Data> data_ = std::make_shared<const Data>();
};

/// The cloud in its own view; by default as planar raw. INVALID_ARGUMENT if its planes do not fit each other, or the
/// codec cannot encode it.
absl::StatusOr<Payload> cloud_payload(const CloudView& cloud, const wire::CodecOptions& codec = {});

/// A PCD file as it is. The view, if given, overrides the file's.
Payload pcd_payload(std::string file_bytes, std::optional<View> view = std::nullopt);

/// The images of an RGB-D camera as they are.
Payload rgbd_payload(codec::RgbdFiles images);

/// The cloud that a server makes of the payload, and by which rule it chose the view.
absl::StatusOr<codec::LabelledCloud> decode(const Payload& payload);

/// The next bytes of a payload, chunk by chunk.
class PayloadReader {
 public:
  PayloadReader() = default;
  explicit PayloadReader(Payload payload);

  bool done() const { return block_ == payload_.blocks().size(); }
  /// At most `max_bytes` (above 0) bytes, not beyond the end of a block; empty if done.
  std::string_view next(std::size_t max_bytes);

 private:
  void skip_empty_blocks();

  Payload payload_;
  std::size_t block_ = 0, offset_ = 0;  // of the next byte
};

}  // namespace segserve::client
