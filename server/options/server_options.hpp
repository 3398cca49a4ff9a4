// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "segserve/options.hpp"

namespace segserve::server {

/// How a server runs. The flags of the program `segserve` have the same names.
struct ServerOptions {
  /// HOST:PORT, [IPv6]:PORT or unix:PATH; port 0 picks a free one.
  std::string listen = "127.0.0.1:50051";
  /// Plain text on an address that other machines can reach is refused unless this is set.
  bool insecure_beyond_loopback = false;

  /// An address as above at which grpc.health.v1 alone is served, always in plain text; empty: none.
  std::string health_listen;

  /// Files in PEM by which the server speaks TLS: its certificate with the chain after it, the private key of that, and
  /// the authorities one of which must have signed the certificate of each client. Without a certificate the server
  /// speaks plain text, and without authorities clients need no certificate.
  std::string tls_cert;
  std::string tls_key;
  std::string tls_client_ca;

  /// A file of bearer tokens, and of the limits of their subjects; empty: no token is asked for.
  std::string tokens;
  /// A JSON Web Key Set whose keys have signed the tokens (JWT) that are accepted, and the `iss` and `aud` of those;
  /// empty: JWT are not accepted.
  std::string jwt_keys;
  std::string jwt_issuer;
  std::string jwt_audience;
  /// Tokens in plain text on an address that other machines can reach are refused unless this is set.
  bool insecure_tokens = false;

  /// HOST:PORT or [IPv6]:PORT, where Prometheus reads metrics in plain text; port 0 picks a free one. Empty: nowhere.
  std::string metrics_listen;

  /// HOST:PORT or [IPv6]:PORT of the web entrance: HTTP/1.1, by TLS if the server speaks TLS; port 0 picks a free one.
  /// Empty: there is none.
  std::string http;
  /// The origin, such as https://app.example, of other sites whose pages may call the web entrance; "*": all of them.
  std::string http_allow_origin;
  /// Names of hosts, separated by commas, that requests to the web entrance may have in their header Host besides
  /// those of this machine. Empty: on loopback there are no others, and elsewhere any will do.
  std::string http_host;

  /// Frames that are computed at the same time; 0: one per CPU.
  std::size_t workers = 0;
  /// Most threads within one frame.
  std::uint32_t threads = 1;
  /// Frames that may wait for a worker.
  std::size_t queue = 64;
  /// Bytes of all requests that wait or are computed, over all clients.
  std::uint64_t queue_bytes = std::uint64_t{512} << 20U;
  /// Points of all clouds that wait or are computed, over all clients.
  std::uint64_t queue_points = 50'000'000;

  /// Credit of one stream: frames, and bytes of payload, that it may have under way. A cloud of more bytes cannot be
  /// sent. A stream gets 32 MiB unless it asks for more.
  std::uint32_t stream_frames = 8;
  std::uint64_t stream_bytes = std::uint64_t{512} << 20U;

  /// Points of one cloud.
  std::uint64_t max_points = 16'000'000;
  /// Bytes of one cloud after decompression.
  std::uint64_t max_decoded_bytes = std::uint64_t{512} << 20U;
  /// Voxels of one cloud.
  std::uint64_t max_voxels = 4'000'000;
  /// Bytes of memory for all frames: payloads, clouds, the workspace of segmentation, and results until they are read.
  /// 0: 75 % of what the cgroup or the machine has.
  std::uint64_t memory = 0;
  /// How long a worker computes one frame at most, whatever its client says.
  std::chrono::milliseconds max_frame_time{60'000};
  /// Accept Draco payloads. Draco's library has known faults with hostile bytes.
  bool enable_draco = false;

  /// Serve gRPC's reflection (v1 and v1alpha), by which tools such as grpcurl learn the interface.
  bool reflection = false;

  /// Calls in flight have this long to finish when the server stops. Then they are cancelled.
  std::chrono::milliseconds grace_period{20'000};

  /// A stream that is so old is asked to move to a new one, which may reach a replica that has less to do; 0: never. It
  /// has `grace_period` for that. Each stream's age differs by up to a tenth, so that they do not all move together.
  std::chrono::milliseconds max_stream_age{1'800'000};

  /// A connection with calls gets a ping of HTTP/2 this often; 0: never. By that a proxy between client and server
  /// hears whether the server is still there, however long a frame takes. A client that resets calls in masses costs
  /// others more where there are pings.
  std::chrono::milliseconds ping_interval{0};

  /// A stopping server answers new calls with UNAVAILABLE (DRAINING) for at least this long, but no longer than the
  /// grace period, before it closes its connections. Calls that are on their way then learn what to do.
  std::chrono::milliseconds drain_delay{200};

  /// How a call is segmented that sets no options.
  Options defaults;
};

/// Every fault of the options at once, by the names of their flags; empty if the options are valid.
std::vector<FieldViolation> violations(const ServerOptions& options);

}  // namespace segserve::server
