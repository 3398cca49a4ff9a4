// SPDX-License-Identifier: Apache-2.0
#include "server/health/health_service.hpp"

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/status_macros.hpp"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/final_status.hpp"
#include "server/health/health_message.hpp"
#include "server/health/health_watch.hpp"
#include "server/scheduling/client_address.hpp"

namespace segserve::server {
namespace {

/// A watch that is refused at once.
class RefusedWatch final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  explicit RefusedWatch(const absl::Status& why) { Finish(final_status(why)); }
  void OnDone() override { delete this; }
};

/// Nobody else uses the bytes of a request.
absl::StatusOr<std::string> take_service(const grpc::ByteBuffer* request) {
  return service_of(const_cast<grpc::ByteBuffer&>(*request));
}

}  // namespace

grpc::ServerUnaryReactor* HealthService::Check(grpc::CallbackServerContext* context, const grpc::ByteBuffer* request,
                                               grpc::ByteBuffer* response) {
  const absl::Status status = catch_exceptions("answer a question for health", [&]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::string service, take_service(request));
    const HealthState::Status found = state_.status_of(service);
    if (found == grpc::health::v1::HealthCheckResponse::SERVICE_UNKNOWN) {
      return absl::NotFoundError("this server does not know the health of a service of that name");
    }
    *response = health_response(found);
    return absl::OkStatus();
  });
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  // The API of segmentation has no NOT_FOUND, so that final_status has none, either.
  reactor->Finish(absl::IsNotFound(status) ? grpc::Status(grpc::StatusCode::NOT_FOUND, std::string(status.message()))
                                           : final_status(status));
  return reactor;
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* HealthService::Watch(grpc::CallbackServerContext* context,
                                                                 const grpc::ByteBuffer* request) {
  const auto watch = catch_exceptions("begin to watch health", [&]() -> absl::StatusOr<std::shared_ptr<HealthWatch>> {
    ASSIGN_OR_RETURN(std::string service, take_service(request));
    auto admitted = std::make_shared<HealthWatch>(state_, std::move(service), client_address(context->peer()));
    admitted->start();  // from now on it owns itself
    return admitted;
  });
  if (!watch.ok()) return new RefusedWatch(watch.status());  // deletes itself
  return watch->get();
}

}  // namespace segserve::server
