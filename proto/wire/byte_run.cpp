// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/byte_run.hpp"

#include <algorithm>
#include <utility>

#include "libdeflate.h"

namespace segserve::wire {
namespace {

// Reserving avoids the copies of a string that grows. The system provides reserved memory only when it is written, so a
// sender who promises much and sends little does not use it up.
constexpr std::uint64_t kMaxReservedBytes = std::uint64_t{64} << 20U;

}  // namespace

// libdeflate computes the CRC-32 faster than zlib, which matters for frames of megabytes.
std::uint32_t crc32(std::uint32_t crc_so_far, std::string_view bytes) {
  return libdeflate_crc32(crc_so_far, bytes.data(), bytes.size());
}

std::uint64_t saturating_sum(std::span<const std::uint64_t> sizes) {
  std::uint64_t sum = 0;
  for (const std::uint64_t size : sizes) sum = size > UINT64_MAX - sum ? UINT64_MAX : sum + size;
  return sum;
}

ByteRun::ByteRun(std::vector<std::string_view> blocks, std::shared_ptr<const void> owner)
    : blocks_(std::move(blocks)), owner_(std::move(owner)) {
  for (const std::string_view block : blocks_) {
    size_ += block.size();
    crc32_ = wire::crc32(crc32_, block);
  }
}

ByteRun::ByteRun(std::span<std::string* const> blocks) {
  auto owner = std::make_shared<std::vector<std::string>>();
  for (std::string* block : blocks) owner->push_back(std::exchange(*block, {}));
  *this = ByteRun({owner->begin(), owner->end()}, owner);
}

OutgoingBytes::OutgoingBytes(std::shared_ptr<const ByteRun> run) : run_(std::move(run)) { skip_empty_blocks(); }

std::string_view OutgoingBytes::next(std::size_t max_bytes) {
  if (done()) return {};
  const std::string_view chunk = run_->blocks()[block_].substr(offset_, max_bytes);
  offset_ += chunk.size();
  skip_empty_blocks();
  return chunk;
}

void OutgoingBytes::skip_empty_blocks() {
  while (!done() && offset_ == run_->blocks()[block_].size()) {
    ++block_;
    offset_ = 0;
  }
}

IncomingBytes::IncomingBytes(std::vector<std::uint64_t> sizes)
    : sizes_(std::move(sizes)), blocks_(sizes_.size()), missing_(saturating_sum(sizes_)) {}

bool IncomingBytes::add(std::string_view chunk) {
  if (chunk.size() > missing_) return false;
  missing_ -= chunk.size();
  crc32_ = wire::crc32(crc32_, chunk);
  while (!chunk.empty()) {
    std::string& block = blocks_[block_];
    if (block.empty()) block.reserve(std::min(sizes_[block_], kMaxReservedBytes));
    const std::uint64_t room = sizes_[block_] - block.size();
    const std::string_view part = chunk.substr(0, room);
    block.append(part);
    chunk.remove_prefix(part.size());
    if (block.size() == sizes_[block_]) ++block_;
  }
  return true;
}

void IncomingBytes::move_to(std::span<std::string* const> blocks) {
  for (std::size_t i = 0; i < std::min(blocks.size(), blocks_.size()); ++i) *blocks[i] = std::move(blocks_[i]);
}

}  // namespace segserve::wire
