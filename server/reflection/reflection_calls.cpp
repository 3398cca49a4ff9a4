// SPDX-License-Identifier: Apache-2.0
#include "server/reflection/reflection_calls.hpp"

#include <cstddef>
#include <utility>

#include "absl/status/statusor.h"
#include "server/frames/catch_exceptions.hpp"
#include "server/frames/final_status.hpp"
#include "server/reflection/reflection_answer.hpp"

namespace segserve::server {
namespace {

constexpr std::size_t kMostCalls = 16;

}  // namespace

void ReflectionCall::start() {
  self_ = shared_from_this();
  read();
}

void ReflectionCall::read() {
  const MutexLock lock(mutex_);
  if (!finished_) StartRead(&request_);
}

void ReflectionCall::OnReadDone(bool ok) {
  if (!ok) return finish(grpc::Status::OK);  // the client asks for no more
  absl::StatusOr<grpc::ByteBuffer> answer =
      catch_exceptions("answer a question of reflection", [this] { return answer_reflection(request_); });
  if (!answer.ok()) return finish(final_status(answer.status()));
  const MutexLock lock(mutex_);
  if (finished_) return;
  response_ = *std::move(answer);
  StartWrite(&response_);
}

void ReflectionCall::OnWriteDone(bool ok) {
  if (!ok) return finish({grpc::StatusCode::CANCELLED, "the connection broke"});
  response_.Clear();
  read();
}

void ReflectionCall::OnCancel() { finish({grpc::StatusCode::CANCELLED, "the client gave up"}); }

void ReflectionCall::finish(const grpc::Status& status) {
  const MutexLock lock(mutex_);
  if (std::exchange(finished_, true)) return;
  Finish(status);
}

void ReflectionCall::OnDone() {
  calls_.remove(self_);
  self_.reset();  // `this` may be gone now
}

ReflectionCall* ReflectionCalls::begin(const grpc::CallbackServerContext& context) {
  const absl::Status permitted = catch_exceptions("look at a caller", [&] { return permit_(context); });
  auto call = std::make_shared<ReflectionCall>(*this);
  std::shared_ptr<ReflectionCall> oldest;
  bool is_closed = false;
  {
    const MutexLock lock(mutex_);
    is_closed = closed_;
    calls_.push_back(call);
    if (calls_.size() > kMostCalls) {
      oldest = calls_.front();
      calls_.pop_front();
    }
  }
  if (oldest) oldest->finish({grpc::StatusCode::RESOURCE_EXHAUSTED, "there are too many calls of reflection"});
  call->start();  // from now on it owns itself
  if (!permitted.ok()) call->finish(final_status(permitted));
  if (is_closed) call->finish({grpc::StatusCode::UNAVAILABLE, "the server stops"});
  return call.get();
}

void ReflectionCalls::close() {
  std::list<std::shared_ptr<ReflectionCall>> calls;
  {
    const MutexLock lock(mutex_);
    closed_ = true;
    calls = calls_;
  }
  for (const auto& call : calls) call->finish({grpc::StatusCode::UNAVAILABLE, "the server stops"});
}

void ReflectionCalls::remove(const std::shared_ptr<ReflectionCall>& call) {
  const MutexLock lock(mutex_);
  std::erase(calls_, call);
}

}  // namespace segserve::server
