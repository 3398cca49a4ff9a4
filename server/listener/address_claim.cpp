// SPDX-License-Identifier: Apache-2.0
#include "server/listener/address_claim.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "server/listener/listener_probe.hpp"

namespace segserve::server {
namespace {

using std::chrono::milliseconds;

absl::Status unavailable(const std::string& path, std::string_view why) {
  return absl::UnavailableError(fmt::format("cannot listen on unix:{}: {}", path, why));
}

std::string folder_of(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  return folder.empty() ? "." : folder.string();
}

/// Returns a descriptor that holds the lock of a folder, or -1 with errno if it is not to be had within a few seconds.
int lock_folder(const std::string& folder) {
  constexpr int kTries = 500;
  constexpr milliseconds kPause{10};
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return -1;
  for (int i = 0; i < kTries; ++i) {
    if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
    std::this_thread::sleep_for(kPause);
  }
  const int error = errno;
  close(descriptor);
  errno = error;
  return -1;
}

/// Makes way if a dead server has left its socket.
absl::Status remove_leftover(const std::string& path) {
  struct stat found {};
  if (lstat(path.c_str(), &found) != 0) return absl::OkStatus();  // whatever else is wrong shows when gRPC binds
  if (!S_ISSOCK(found.st_mode)) return unavailable(path, "there is a file that is no socket");
  switch (ListenerProbe({path, "", true}, 0).look(milliseconds(1000))) {
    case Listener::kAnswers:
    case Listener::kSilent:
      return unavailable(path, "another process serves there");
    case Listener::kNoDescriptors:
    case Listener::kUnknown:
      return unavailable(path, "there is a socket, and whether a process serves on it cannot be found out");
    case Listener::kNone:
      break;
  }
  if (unlink(path.c_str()) == 0) return absl::OkStatus();
  return unavailable(path, fmt::format("the socket of a dead server cannot be removed: {}", std::strerror(errno)));
}

}  // namespace

AddressClaim::AddressClaim(AddressClaim&& other) noexcept
    : bind_address_(std::move(other.bind_address_)),
      path_(std::move(other.path_)),
      bind_path_(std::move(other.bind_path_)),
      lock_(std::exchange(other.lock_, -1)),
      device_(other.device_),
      inode_(other.inode_) {}

AddressClaim::~AddressClaim() {
  if (lock_ >= 0) close(lock_);
}

absl::StatusOr<AddressClaim> AddressClaim::take(const ListenAddress& address) {
  static std::atomic<unsigned> last{0};
  AddressClaim claim;
  if (!address.is_unix) {
    claim.bind_address_ = with_port(address, std::stoi(address.port));
    return claim;
  }
  claim.path_ = address.host;
  const std::string folder = folder_of(claim.path_);
  claim.bind_path_ = fmt::format("{}/.{}.{}", folder, getpid(), ++last);
  claim.bind_address_ = "unix:" + claim.bind_path_;
  if (std::max(claim.path_.size(), claim.bind_path_.size()) >= sizeof(sockaddr_un{}.sun_path)) {
    return unavailable(claim.path_, "the path is too long for a unix socket");
  }
  claim.lock_ = lock_folder(folder);
  if (claim.lock_ < 0) {
    return unavailable(claim.path_, fmt::format("cannot lock the folder {}: {}", folder, std::strerror(errno)));
  }
  RETURN_IF_ERROR(remove_leftover(claim.path_));
  return claim;
}

absl::Status AddressClaim::publish() {
  if (path_.empty()) return absl::OkStatus();
  struct stat bound {};
  if (lstat(bind_path_.c_str(), &bound) != 0 ||
      renameat2(AT_FDCWD, bind_path_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) != 0) {
    return unavailable(path_, std::strerror(errno));
  }
  device_ = bound.st_dev;
  inode_ = bound.st_ino;
  close(std::exchange(lock_, -1));
  return absl::OkStatus();
}

void AddressClaim::release() const {
  if (path_.empty()) return;
  const int lock = lock_folder(folder_of(path_));
  struct stat found {};
  const bool is_ours = lstat(path_.c_str(), &found) == 0 && found.st_dev == device_ && found.st_ino == inode_;
  if (is_ours) unlink(path_.c_str());
  if (lock >= 0) close(lock);
}

}  // namespace segserve::server
