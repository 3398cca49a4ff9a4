#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud/cloud.hpp"
#include "segserve/options/options.hpp"
#include "segserve/v1alpha1/segmentation_service.pb.h"
#include "segserve/v1alpha1/server_info.pb.h"
#include "segserve/wire/request.hpp"
#include "segserve/wire/result.hpp"

namespace grpc {
class Channel;
}

namespace segserve::client {

struct ClientOptions {
  /// Where the server listens: host:port, or any other name that gRPC resolves.
  std::string address = "127.0.0.1:50051";
  /// Deadline of a call that does not say its own. The server stops computing when it passes.
  std::chrono::milliseconds timeout = std::chrono::seconds(30);
  /// true: a call waits, until its deadline, for a server that is not reachable yet; false: it
  /// fails at once with UNAVAILABLE.
  bool wait_for_server = false;
};

/// When the planes of a cloud are compressed, without loss, before they are sent.
enum class Compress {
  kWhenTooLarge,  ///< only if the request would exceed the limit of a unary call
  kAlways,        ///< pays off on links of 100 Mbit/s and below
  kNever,
};

struct CallOptions {
  std::optional<std::chrono::milliseconds> timeout = std::nullopt;  ///< unset: ClientOptions::timeout
  std::string request_id = {};                                      ///< for the server's logs; at most 256 bytes
  Compress compress = Compress::kWhenTooLarge;
  /// Which arrays the answer holds. With supervoxels and tree any cut can be made later without the
  /// server: cut_at_threshold, cut_to_regions, label_points of segserve::core.
  wire::Outputs outputs = {.labels = true, .supervoxels = true, .tree = true};
};

using Result = wire::Result;
using ServerInfo = v1alpha1::GetServerInfoResponse;

/// A connection to a server. Copies share it; any number of threads may use it at the same time.
/// Calls block until they end, at the latest at their deadline.
///
/// Errors have the server's code and a message that names every wrong field or the limit;
/// wire::details_of(status) gives the details to programs. Beyond the server's own errors there are
/// UNAVAILABLE (not reachable), DEADLINE_EXCEEDED, and INVALID_ARGUMENT for a request above
/// wire::kMaxRequestBytes, which is refused here without being sent.
class Client {
 public:
  /// INVALID_ARGUMENT for options that make no sense. Does not wait for the server: health() does.
  static absl::StatusOr<Client> connect(ClientOptions options);

  /// Uses a channel that the caller made; `options.address` only serves messages.
  Client(std::shared_ptr<grpc::Channel> channel, ClientOptions options);

  /// Segments a cloud, sent as planar raw in its own view.
  absl::StatusOr<Result> segment(const CloudView& cloud, const Options& options = {},
                                 const CallOptions& call = {}) const;

  /// Segments a PCD file, sent as it is. Without a view the rule of codec::decode_pcd applies;
  /// `compress` has no meaning here.
  absl::StatusOr<Result> segment_pcd_file(std::string file_bytes, std::optional<View> view = std::nullopt,
                                          const Options& options = {}, const CallOptions& call = {}) const;

  /// What the server can do, and its limits.
  absl::StatusOr<ServerInfo> server_info(std::optional<std::chrono::milliseconds> timeout = std::nullopt) const;

  /// OK if the server says SERVING (grpc.health.v1); UNAVAILABLE if it says otherwise.
  absl::Status health(std::optional<std::chrono::milliseconds> timeout = std::nullopt) const;

 private:
  /// `points` is unset if only the server knows how many there are.
  absl::StatusOr<Result> call_segment(const v1alpha1::SegmentRequest& request, const CallOptions& call,
                                      std::optional<std::size_t> points) const;

  std::shared_ptr<grpc::Channel> channel_;
  ClientOptions options_;
};

}  // namespace segserve::client
