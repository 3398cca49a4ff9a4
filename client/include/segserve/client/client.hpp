#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/wire/codec_message.hpp"
#include "proto/wire/request_message.hpp"
#include "proto/wire/result_message.hpp"
#include "segserve/client/frame.hpp"
#include "segserve/client/stream.hpp"
#include "segserve/client/stream_options.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/v1/segmentation_service.pb.h"
#include "segserve/v1/server_info.pb.h"

namespace grpc {
class Channel;
class ClientContext;
class Status;
}  // namespace grpc

namespace segserve::client {

class AddressBook;
class Channels;

struct ClientOptions {
  /// Where the servers listen: host:port, or any other name that gRPC resolves; several are separated by
  /// commas ("a:50051,b:50051"). A name that stands for many servers ("dns:///segserve:50051") is used in turn.
  std::string address = "127.0.0.1:50051";
  /// Deadline of a call that does not say its own, all its repetitions included. The server stops computing when
  /// it passes.
  std::chrono::milliseconds timeout = std::chrono::seconds(30);
  /// When no address is in reach: true, a call waits for one until its deadline; false, it fails with UNAVAILABLE.
  bool wait_for_server = false;
  /// Calls that fail with UNAVAILABLE or RESOURCE_EXHAUSTED are repeated, best at another address.
  RetryOptions retry = {};
  /// segment() computes in this process when no address is in reach.
  bool fallback_to_local = false;
};

/// When the planes of a cloud are compressed, without loss, before they are sent.
enum class Compress {
  kWhenTooLarge,  ///< only if the request would exceed the limit of a unary call; if it still does, it is streamed
  kAlways,        ///< pays off on links of 100 Mbit/s and below
  kNever,
};

struct CallOptions {
  std::optional<std::chrono::milliseconds> timeout = std::nullopt;  ///< unset: ClientOptions::timeout
  std::string request_id = {};                                      ///< for the server's logs; at most 256 bytes
  Compress compress = Compress::kWhenTooLarge;
  /// How a cloud is sent; unset: planar, compressed as `compress` says.
  std::optional<wire::CodecOptions> codec = std::nullopt;
  /// Which arrays the answer holds. With supervoxels and tree any cut can be made later without the
  /// server: cut_at_threshold, cut_to_regions, label_points of segserve::core.
  wire::Outputs outputs = {.labels = true, .supervoxels = true, .tree = true};
};

using ServerInfo = v1::GetServerInfoResponse;

/// Connections to one or more servers. Copies share them; any number of threads may use them at the same time.
/// Calls block until they end, at the latest at their deadline.
///
/// Errors have the server's code and a message that names every wrong field or the limit;
/// wire::details_of(status) gives the details to programs. Beyond the server's own errors there are
/// UNAVAILABLE (not reachable) and DEADLINE_EXCEEDED.
class Client {
 public:
  /// INVALID_ARGUMENT for options that make no sense. Does not wait for the server: health() does.
  static absl::StatusOr<Client> connect(ClientOptions options);

  /// Uses a channel that the caller made; `options.address` only serves messages.
  Client(std::shared_ptr<grpc::Channel> channel, const ClientOptions& options);

  /// A stream of frames, which outlives the client. Does not wait for the server. INVALID_ARGUMENT for options that
  /// make no sense.
  absl::StatusOr<Stream> open_stream(StreamOptions options = {}) const;

  /// Segments a cloud in its own view, sent as `call` says; over a stream if it is too large for one message.
  absl::StatusOr<Result> segment(const CloudView& cloud, const Options& options = {},
                                 const CallOptions& call = {}) const;

  /// The same for a cloud that is encoded already; `compress` and `codec` have no meaning here.
  absl::StatusOr<Result> segment_payload(const Payload& payload, const Options& options = {},
                                         const CallOptions& call = {}) const;

  /// The same for a PCD file, sent as it is. Without a view the rule of codec::decode_pcd applies.
  absl::StatusOr<Result> segment_pcd_file(std::string file_bytes, std::optional<View> view = std::nullopt,
                                          const Options& options = {}, const CallOptions& call = {}) const;

  /// What the server can do, and its limits.
  absl::StatusOr<ServerInfo> server_info(std::optional<std::chrono::milliseconds> timeout = std::nullopt) const;

  /// OK if the server says SERVING (grpc.health.v1); UNAVAILABLE if it says otherwise.
  absl::Status health(std::optional<std::chrono::milliseconds> timeout = std::nullopt) const;

 private:
  explicit Client(std::shared_ptr<Channels> channels, ClientOptions options);

  using Attempt = absl::FunctionRef<grpc::Status(const std::shared_ptr<grpc::Channel>&, grpc::ClientContext&)>;
  /// Makes the call at one address after the other until one answers, or another try is in vain.
  absl::Status call(std::optional<std::chrono::milliseconds> timeout, Attempt attempt) const;
  bool is_worth_another(const absl::Status& status, std::uint32_t tries, const AddressBook& book) const;
  bool is_local_turn(const absl::Status& status) const;
  /// Of a call that began at `start`.
  StopToken until_deadline(std::chrono::steady_clock::time_point start, const CallOptions& call) const;

  /// `points` is unset if only the server knows how many there are.
  absl::StatusOr<Result> call_segment(const v1::SegmentRequest& request, const CallOptions& call,
                                      std::optional<std::size_t> points) const;
  absl::StatusOr<Result> stream_one(Payload payload, const Options& options, const CallOptions& call) const;

  std::shared_ptr<Channels> channels_;
  ClientOptions options_;
};

}  // namespace segserve::client
