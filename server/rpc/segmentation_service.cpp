// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/segmentation_service.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/byte_run.hpp"
#include "server/access/client_share.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/final_status.hpp"
#include "server/rpc/caller_of.hpp"
#include "server/rpc/segment_call.hpp"
#include "server/rpc/server_info.hpp"
#include "server/scheduling/refusals.hpp"
#include "server/stream/pool_frame_executor.hpp"
#include "server/stream/session_transport.hpp"

namespace segserve::server {
namespace {

constexpr std::uint64_t kDefaultBytesPerStream = std::uint64_t{32} << 20U;
constexpr std::chrono::milliseconds kTick{50};
// Tokens and keys that have changed are in use after two looks.
constexpr std::chrono::milliseconds kLookAtFiles{500};
// A worker without frames for so long gives up its buffers.
constexpr std::chrono::seconds kIdleWorker{10};

std::vector<std::unique_ptr<SegmentationBackend>> make_backends(std::size_t count, const BackendFactory& make) {
  std::vector<std::unique_ptr<SegmentationBackend>> backends(count);
  std::ranges::generate(backends, make);
  return backends;
}

CreditLimits credit_limits(const ServerOptions& options) {
  return {.most_per_stream = {.frames = options.stream_frames, .bytes = options.stream_bytes},
          .default_bytes_per_stream = kDefaultBytesPerStream};
}

StreamSettings stream_settings(const ServerOptions& options, const FrameResolver& resolver, MemoryLedger& ledger,
                               const ServiceObservers& observers, const v1::GetServerInfoResponse& info) {
  StreamSettings settings{.resolver = resolver,
                          .credit = credit_limits(options),
                          .ledger = &ledger,
                          .max_voxels = options.max_voxels,
                          .observers = observers};
  settings.max_age = options.max_stream_age;
  settings.age_grace = options.grace_period;
  v1::StreamOpened& greeting = settings.greeting;
  greeting.set_server_version(info.version());
  *greeting.mutable_limits() = info.limits();
  greeting.set_max_chunk_bytes(wire::kMaxChunkBytes);
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(settings.upload_timeout);
  greeting.mutable_upload_timeout()->set_seconds(seconds.count());
  return settings;
}

/// A stream that is refused at once.
class RefusedStream final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  explicit RefusedStream(const absl::Status& why) { Finish(final_status(why)); }
  void OnDone() override { delete this; }
};

}  // namespace

SegmentationService::SegmentationService(const ServerOptions& options, std::unique_ptr<AccessControl> access,
                                         const BackendFactory& make_backend, ServiceObservers observers)
    : observers_(std::move(observers)),
      access_(std::move(access)),
      ledger_(options.memory),
      memory_return_(ledger_),
      max_voxels_(options.max_voxels),
      resolver_(options),
      info_(server_info(options, options.workers)),
      stream_settings_(stream_settings(options, resolver_, ledger_, observers_, info_)),
      backends_(make_backends(options.workers, make_backend)),
      pool_(options.workers,
            {.jobs = options.workers + options.queue, .bytes = options.queue_bytes, .points = options.queue_points},
            WorkerPool::WhenIdle{kIdleWorker, [this](std::size_t worker) { free_buffers(worker); }}),
      sessions_(kTick,
                [this] {
                  const auto now = std::chrono::steady_clock::now();
                  unary_calls_.on_tick(now);
                  memory_return_.on_tick(now);
                }),
      access_watch_(kLookAtFiles, [this] {
        const absl::Status looked = catch_exceptions("look at the files of tokens and keys", [this] {
          access_->look_for_changes();
          return absl::OkStatus();
        });
        looked.IgnoreError();  // it is in the log
        return true;
      }) {}

void SegmentationService::free_buffers(std::size_t worker) {
  const absl::Status status = catch_exceptions("free the buffers of a worker", [&] {
    backends_[worker]->free_buffers();
    give_back_own_memory();
    return absl::OkStatus();
  });
  status.IgnoreError();  // it is in the log, and the buffers stay
}

grpc::ServerUnaryReactor* SegmentationService::refuse_call(grpc::CallbackServerContext& context,
                                                           const absl::Status& why) noexcept {
  const absl::Status told = catch_exceptions("tell of a refused call", [&] {
    const auto now = std::chrono::steady_clock::now();
    FrameRecord record = arriving_call(caller_of(context), now);
    end_call(record, why, now);
    observers_.on_frame(record);
    return absl::OkStatus();
  });
  told.IgnoreError();  // it is in the log
  grpc::ServerUnaryReactor* reactor = context.DefaultReactor();
  reactor->Finish(final_status(why));
  return reactor;
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* SegmentationService::refuse_stream(
    grpc::CallbackServerContext& context, const absl::Status& why) noexcept {
  const absl::Status told = catch_exceptions("tell of a refused stream", [&] {
    const auto now = std::chrono::steady_clock::now();
    const auto caller = std::make_shared<const Caller>(caller_of(context));
    observers_.on_stream({.caller = caller, .began = now, .ended = now, .status = facts_of(why)});
    return absl::OkStatus();
  });
  told.IgnoreError();             // it is in the log
  return new RefusedStream(why);  // deletes itself
}

absl::Status SegmentationService::admit_question(const grpc::CallbackServerContext& context, std::string_view rpc) {
  absl::Status admitted = access_->admit(proofs_of(context)).status();
  if (!admitted.ok()) {
    observers_.on_refused_question(
        {.rpc = rpc, .caller = std::make_shared<const Caller>(caller_of(context)), .status = facts_of(admitted)});
  }
  return admitted;
}

ServiceState SegmentationService::state() const {
  return {.pool = pool_.state(),
          .memory = ledger_.use(),
          .unary_calls = unary_calls_.count(),
          .streams = sessions_.count(),
          .is_draining = calls_.is_closed(),
          .access_reloads = access_->reloads().done,
          .failed_access_reloads = access_->reloads().failed};
}

void SegmentationService::start_draining() {
  calls_.close();
  sessions_.start_draining();
}

void SegmentationService::abort_calls() {
  unary_calls_.abort_all();
  sessions_.abort_all();
}

grpc::ServerUnaryReactor* SegmentationService::Segment(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  if (!calls_.admit()) return refuse_call(*context, draining());
  const auto call = catch_exceptions("begin a call", [&]() -> absl::StatusOr<std::shared_ptr<SegmentCall>> {
    ASSIGN_OR_RETURN(AccessGrant grant, access_->admit(proofs_of(*context)));
    auto admitted = std::make_shared<SegmentCall>(*this, std::move(grant), *context, *response);
    unary_calls_.add(admitted);
    return admitted;
  });
  if (!call.ok()) {
    calls_.release();
    return refuse_call(*context, call.status());
  }
  // Nobody else uses the request's bytes. Parsing frees them, so that they are not in memory twice.
  (*call)->start(const_cast<grpc::ByteBuffer&>(*request));  // from now on it owns itself
  return call->get();
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* SegmentationService::SegmentStream(
    grpc::CallbackServerContext* context) {
  if (!calls_.admit()) return refuse_stream(*context, draining());
  const auto transport = catch_exceptions("begin a stream", [&]() -> absl::StatusOr<std::shared_ptr<SessionTransport>> {
    ASSIGN_OR_RETURN(AccessGrant grant, access_->admit(proofs_of(*context)));
    // Each stream counts as one, whether or not streams share a connection.
    const std::string stream = fmt::format("{} stream {}", context->peer(), ++streams_so_far_);
    const ClientShare share = share_of(grant.subject(), context->peer(), stream);
    auto executor = std::make_unique<PoolFrameExecutor>(pool_, backends_, share.client, share.flow);
    auto admitted = std::make_shared<SessionTransport>(*context, calls_, sessions_, std::move(executor));
    Caller caller = caller_of(*context, grant.subject());  // before the grant is moved away
    admitted->prepare(stream_settings_, share.owner, std::move(caller), std::move(grant));
    return admitted;
  });
  if (!transport.ok()) {
    calls_.release();
    return refuse_stream(*context, transport.status());
  }
  (*transport)->start();  // from now on it owns itself
  return transport->get();
}

grpc::ServerUnaryReactor* SegmentationService::GetServerInfo(grpc::CallbackServerContext* context,
                                                             const grpc::ByteBuffer* request,
                                                             grpc::ByteBuffer* response) {
  // The request has no fields, so that it is not looked at. Nobody else uses its bytes.
  const_cast<grpc::ByteBuffer*>(request)->Clear();
  const absl::Status status = catch_exceptions("answer GetServerInfo", [&]() -> absl::Status {
    RETURN_IF_ERROR(admit_question(*context, "GetServerInfo"));
    bool owns_buffer = false;
    const grpc::Status written =
        grpc::SerializationTraits<v1::GetServerInfoResponse>::Serialize(info_, response, &owns_buffer);
    return written.ok() ? absl::OkStatus() : absl::InternalError("the answer cannot be serialized");
  });
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(final_status(status));
  return reactor;
}

}  // namespace segserve::server
