// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "server/observe/frame_record.hpp"

namespace segserve::server {

/// Learns of every frame and every stream once, when it is over, and of refused questions. All functions are called on
/// gRPC's threads, on workers and with locks held: they must be quick, must not wait for anything, and must not call
/// the service.
class ServiceObserver {
 public:
  virtual ~ServiceObserver() = default;

  /// A frame is over. Its client has not seen the outcome yet.
  virtual void on_frame(const FrameRecord& frame) = 0;
  /// A call of SegmentStream is over, or was refused. Records of its frames came before.
  virtual void on_stream(const StreamRecord& stream) = 0;
  /// A question about the server was refused.
  virtual void on_refused_question(const RefusedQuestion& question) = 0;
};

/// The observers of a service, in the order in which they learn of things. What one throws, for example for lack of
/// memory, goes to the log and changes nothing else.
class ServiceObservers {
 public:
  ServiceObservers() = default;
  explicit ServiceObservers(std::vector<std::shared_ptr<ServiceObserver>> observers)
      : observers_(std::move(observers)) {}

  /// Must not be called once a service has the observers.
  void add(std::shared_ptr<ServiceObserver> observer) { observers_.push_back(std::move(observer)); }

  void on_frame(const FrameRecord& frame) const noexcept;
  void on_stream(const StreamRecord& stream) const noexcept;
  void on_refused_question(const RefusedQuestion& question) const noexcept;

 private:
  std::vector<std::shared_ptr<ServiceObserver>> observers_;
};

}  // namespace segserve::server
