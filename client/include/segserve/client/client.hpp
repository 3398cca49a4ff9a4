// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/client/frame.hpp"
#include "segserve/client/payload.hpp"
#include "segserve/client/stream.hpp"
#include "segserve/client/stream_options.hpp"
#include "segserve/client/tls_options.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/prompts.hpp"
#include "segserve/wire/codec.hpp"
#include "segserve/wire/outputs.hpp"
#include "segserve/wire/tracks.hpp"

namespace grpc {
class Channel;
}  // namespace grpc

namespace segserve::v1 {
class GetServerInfoResponse;
}  // namespace segserve::v1

namespace segserve::client {

struct ClientOptions {
  /// Where the servers listen: host:port (without a port: 50051), or any other name that gRPC resolves. Several are
  /// separated by commas ("a:50051,b:50051"). A host's name stands for all of its addresses, and is looked up again
  /// about every ten seconds, or two while servers fail. Streams use all servers at the same time, calls use the least
  /// busy one or else take turns.
  std::string address = "127.0.0.1:50051";
  /// The deadline of a call that sets none of its own, all its repetitions included; above 0. The server stops
  /// computing when it passes.
  std::chrono::milliseconds timeout = std::chrono::seconds(30);
  /// When no address is in reach: true, a call waits for one until its deadline; false, it fails with UNAVAILABLE.
  bool wait_for_server = false;
  /// How calls are repeated that fail with UNAVAILABLE or RESOURCE_EXHAUSTED, at another address if there is one.
  RetryOptions retry = {};
  /// Whether segment() computes in this process when no address is in reach.
  bool fallback_to_local = false;
  /// Whether connections beyond this machine go through the proxy that the environment names (http_proxy, https_proxy,
  /// grpc_proxy, no_proxy), if it names one. Names are left to the proxy then, and stand for one server each.
  bool use_proxy = false;
  /// Unset: the connections are plain text.
  std::optional<TlsOptions> tls = std::nullopt;
  /// The bearer token that the server asks for; empty: none. It goes with every call.
  std::string token = {};
  /// A file that holds the token, and nothing else, instead of `token`. It is read anew for every call and for every
  /// connection of a stream, so that a new token is in use at once.
  std::string token_file = {};
  /// Whether the token may go to other machines as plain text, where whoever listens in can read and use it.
  bool insecure_token = false;
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
  std::string traceparent = {};  ///< W3C's Trace Context, version 00, for the server's logs and traces; may be empty
  Compress compress = Compress::kWhenTooLarge;
  /// How a cloud is sent; unset: planar, compressed as `compress` says.
  std::optional<wire::CodecOptions> codec = std::nullopt;
  /// The arrays of the answer. With supervoxels and tree, any cut can be made later without the server: see
  /// cut_at_threshold, cut_to_regions and label_points of segserve::core.
  wire::Outputs outputs = {.labels = true, .supervoxels = true, .tree = true};
  /// Places on an object, and beside it, that Result::selection tells of. Positions are in the coordinates of the cloud
  /// or payload.
  std::optional<Prompts> prompts = std::nullopt;
  /// Asks for ids that objects keep from cloud to cloud. The caller hands the state on: Result::tracks has the next
  /// one.
  std::optional<wire::TrackRequest> tracking = std::nullopt;
};

/// The answer to GetServerInfo. Include "segserve/v1/segmentation_service.pb.h" to read it.
using ServerInfo = v1::GetServerInfoResponse;

/// Connections to one or more servers. Copies share them, and any number of threads may use them at the same time.
/// Calls block until they end, at the latest at their deadline.
///
///     const auto client = Client::connect({.address = "robot-a:50051"});
///     const auto result = client->segment(cloud, {.threshold = 0.4});
///     if (result.ok()) use(result->segmentation.labels);
///
/// Errors have the server's code and a message that names every wrong field or the limit that was exceeded;
/// wire::details_of(status) gives the details to programs. In addition to the server's own errors there are
/// UNAVAILABLE (no server is in reach), DEADLINE_EXCEEDED, INTERNAL (the answer is broken), and UNAUTHENTICATED (one
/// end does not trust the certificate of the other, or only one of them speaks TLS).
class Client {
 public:
  /// INVALID_ARGUMENT for options that make no sense, for files of TLS that are wrong, and for a token that would go to
  /// another machine as plain text; NOT_FOUND if its file cannot be read. Does not wait for the server: health() does.
  static absl::StatusOr<Client> connect(ClientOptions options);

  /// Uses a channel that the caller made; `options.address` serves messages only. No token is sent but what the channel
  /// sends by itself.
  Client(std::shared_ptr<grpc::Channel> channel, const ClientOptions& options);

  /// Opens a stream of frames, which outlives the client. Does not wait for the server. INVALID_ARGUMENT for options
  /// that make no sense.
  absl::StatusOr<Stream> open_stream(StreamOptions options = {}) const;

  /// Segments a cloud in its own view, sent as `call` says. A cloud that is too large for one message is streamed.
  absl::StatusOr<Result> segment(const CloudView& cloud, const Options& options = {},
                                 const CallOptions& call = {}) const;

  /// Segments a cloud that is encoded already; `compress` and `codec` have no meaning here.
  absl::StatusOr<Result> segment_payload(const Payload& payload, const Options& options = {},
                                         const CallOptions& call = {}) const;

  /// Segments a PCD file, sent as it is. Without a view the rule of codec::decode_pcd applies.
  absl::StatusOr<Result> segment_pcd_file(std::string file_bytes, std::optional<View> view = std::nullopt,
                                          const Options& options = {}, const CallOptions& call = {}) const;

  /// Asks for the version, methods, codecs and limits of the server. `timeout` unset: ClientOptions::timeout.
  absl::StatusOr<ServerInfo> server_info(std::optional<std::chrono::milliseconds> timeout = std::nullopt) const;

  /// OK if the server says SERVING (grpc.health.v1); UNAVAILABLE if it says otherwise. `timeout` unset:
  /// ClientOptions::timeout. `service`: "readiness", which is what "" means, too, or "liveness", which a server that is
  /// about to stop still has. NOT_FOUND for names that the server does not know.
  absl::Status health(std::optional<std::chrono::milliseconds> timeout = std::nullopt,
                      const std::string& service = "") const;

 private:
  class State;
  explicit Client(std::shared_ptr<const State> state);

  absl::StatusOr<Result> stream_one(Payload payload, const Options& options, const CallOptions& call) const;

  std::shared_ptr<const State> state_;
};

}  // namespace segserve::client
