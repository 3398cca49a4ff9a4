#include "segserve/server/service.hpp"

#include <algorithm>

#include "segserve/server/segment_call.hpp"
#include "segserve/server/server_info.hpp"
#include "segserve/wire/status.hpp"
#include "spdlog/spdlog.h"

namespace segserve::server {
namespace {

constexpr std::chrono::milliseconds kRetryElsewhere{500};

std::vector<std::unique_ptr<SegmenterInterface>> make_segmenters(std::size_t count, const SegmenterFactory& make) {
  std::vector<std::unique_ptr<SegmenterInterface>> segmenters(count);
  std::ranges::generate(segmenters, make);
  return segmenters;
}

}  // namespace

SegmentationService::SegmentationService(const ServerOptions& options, const SegmenterFactory& make_segmenter)
    : defaults_(options.defaults),
      max_threads_(options.threads),
      limits_{.max_points = options.max_points, .max_bytes = options.max_decoded_bytes},
      info_(server_info(options, options.workers)),
      segmenters_(make_segmenters(options.workers, make_segmenter)),
      pool_(options.workers,
            {.jobs = options.workers + options.queue, .bytes = options.queue_bytes, .points = options.queue_points}) {}

grpc::ServerUnaryReactor* SegmentationService::Segment(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  if (!gate_.enter()) {
    spdlog::debug("Segment from {}: refused, the server is draining", context->peer());
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    reactor->Finish(wire::to_grpc(
        wire::with_details(absl::UnavailableError("the server is about to stop; try again with another replica"),
                           {.reason = v1alpha1::ERROR_REASON_DRAINING, .retry_delay = kRetryElsewhere})));
    return reactor;
  }
  auto* call = new SegmentCall(*this, *context, *response);  // deletes itself in OnDone
  // Nobody but us uses the request's bytes; parsing frees them, so that they are not in memory twice.
  call->start(const_cast<grpc::ByteBuffer&>(*request));
  return call;
}

grpc::ServerUnaryReactor* SegmentationService::GetServerInfo(grpc::CallbackServerContext* context,
                                                             const v1alpha1::GetServerInfoRequest* /*request*/,
                                                             v1alpha1::GetServerInfoResponse* response) {
  *response = info_;
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace segserve::server
