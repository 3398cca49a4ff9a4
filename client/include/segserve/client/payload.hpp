#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "proto/wire/byte_run.hpp"
#include "proto/wire/cloud_message.hpp"
#include "proto/wire/codec_message.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/labelled_cloud.hpp"
#include "segserve/codec/rgbd_encode.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/v1/cloud.pb.h"

namespace segserve::client {

/// A cloud as it goes over the wire: encoded once, sent any number of times. Copies share the bytes.
class Payload {
 public:
  Payload() = default;
  /// Takes the bytes out of the message. `points` and `decoded_bytes` as in v1.FrameHeader; 0: not known.
  explicit Payload(v1::Cloud message, std::uint64_t points = 0, std::uint64_t decoded_bytes = 0);
  explicit Payload(wire::OutgoingCloud cloud, std::uint64_t points, std::uint64_t decoded_bytes);

  /// The message without the bytes of its blocks.
  const v1::Cloud& header() const { return data_->header; }
  /// The bytes. Never null.
  const std::shared_ptr<const wire::ByteRun>& run() const { return data_->run; }
  std::uint64_t bytes() const { return run()->size(); }
  std::uint64_t points() const { return data_->points; }
  std::uint64_t decoded_bytes() const { return data_->decoded_bytes; }

  /// The message with its bytes.
  v1::Cloud message() const;

 private:
  struct Data {
    v1::Cloud header;
    std::shared_ptr<const wire::ByteRun> run = std::make_shared<const wire::ByteRun>();
    std::uint64_t points = 0;
    std::uint64_t decoded_bytes = 0;
  };
  std::shared_ptr<const Data> data_ = std::make_shared<const Data>();
};

/// The cloud in its own view; by default as planar raw. INVALID_ARGUMENT if its planes do not fit each other, or the
/// codec cannot encode it.
absl::StatusOr<Payload> cloud_payload(const CloudView& cloud, const wire::CodecOptions& codec = {});

/// The same; by the codec `planar` without a copy: the coordinates are sent from where they are, and must not change as
/// long as the payload is in use.
absl::StatusOr<Payload> cloud_payload(std::shared_ptr<const Cloud> cloud, const wire::CodecOptions& codec = {});

/// A PCD file as it is. The view, if given, overrides the file's.
Payload pcd_payload(std::string file_bytes, std::optional<View> view = std::nullopt);

/// The images of an RGB-D camera as they are.
Payload rgbd_payload(codec::RgbdFiles images);

/// The cloud that a server makes of the payload, and by which rule it chose the view.
absl::StatusOr<codec::LabelledCloud> decode(const Payload& payload, const StopToken& stop = {});

}  // namespace segserve::client
