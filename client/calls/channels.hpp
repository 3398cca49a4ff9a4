#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "grpcpp/channel.h"

namespace segserve::client {

/// One gRPC channel per address; any number of threads. Channels of different objects share no connection.
class Channels {
 public:
  explicit Channels(std::vector<std::string> addresses);
  /// For one address, a channel that the caller made.
  Channels(std::string address, std::shared_ptr<grpc::Channel> channel);

  const std::vector<std::string>& addresses() const { return addresses_; }
  std::shared_ptr<grpc::Channel> get(std::size_t address);
  /// From now on another connection; calls on the old one go on. A channel that the caller made stays.
  void renew(std::size_t address, const std::shared_ptr<grpc::Channel>& cut);
  /// 0, 1, 2, ..: where the next user may begin, so that several spread over the addresses.
  std::size_t next_start();

 private:
  const std::vector<std::string> addresses_;
  const bool own_;
  std::mutex mutex_;
  std::vector<std::shared_ptr<grpc::Channel>> channels_;  // made when used first
  std::size_t starts_ = 0;
};

}  // namespace segserve::client
