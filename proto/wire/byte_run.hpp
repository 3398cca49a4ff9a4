// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// In a stream the bytes of a message's blocks travel apart from the message: they are concatenated to one run, which is
// cut into chunks.
namespace segserve::wire {

/// The largest size of a chunk, bytes. Larger chunks would delay a cancel behind them, and smaller ones would need more
/// calls.
inline constexpr std::size_t kMaxChunkBytes = std::size_t{256} << 10U;

/// The CRC-32 (the one of zlib, PNG and RFC 1952) of a sequence of bytes and the `bytes` that follow it, where
/// `crc_so_far` is the CRC-32 of the sequence. The CRC-32 of no bytes is 0.
std::uint32_t crc32(std::uint32_t crc_so_far, std::string_view bytes);

/// The sum of the sizes, or UINT64_MAX if it overflows.
std::uint64_t saturating_sum(std::span<const std::uint64_t> sizes);

/// The bytes of a message's blocks, with their checksum.
class ByteRun {
 public:
  ByteRun() = default;
  /// Moves the strings that `blocks` point to into the run, and leaves them empty.
  explicit ByteRun(std::span<std::string* const> blocks);
  /// Refers to bytes that stay where they are. `owner` keeps them alive and unchanged.
  ByteRun(std::vector<std::string_view> blocks, std::shared_ptr<const void> owner);

  std::span<const std::string_view> blocks() const { return blocks_; }
  /// Bytes of all blocks together.
  std::uint64_t size() const { return size_; }
  /// CRC-32 of all blocks, one after the other.
  std::uint32_t crc32() const { return crc32_; }

 private:
  std::vector<std::string_view> blocks_;
  std::shared_ptr<const void> owner_;
  std::uint64_t size_ = 0;
  std::uint32_t crc32_ = 0;
};

/// Cuts a run into chunks to send. The run is shared, so that it can be sent more than once.
class OutgoingBytes {
 public:
  OutgoingBytes() : OutgoingBytes(std::make_shared<const ByteRun>()) {}
  explicit OutgoingBytes(std::shared_ptr<const ByteRun> run);

  const ByteRun& run() const { return *run_; }
  const std::shared_ptr<const ByteRun>& shared_run() const { return run_; }
  /// Whether `next` has returned all bytes.
  bool done() const { return block_ == run_->blocks().size(); }
  /// The next bytes: at most `max_bytes`, which must be above 0, and all of one block. They are valid as long as the
  /// run. Empty if done.
  std::string_view next(std::size_t max_bytes = kMaxChunkBytes);

 private:
  void skip_empty_blocks();

  std::shared_ptr<const ByteRun> run_;
  std::size_t block_ = 0;   // The index of the block that holds the next byte.
  std::size_t offset_ = 0;  // The position of the next byte in that block.
};

/// Puts blocks together from the chunks that arrive. The memory in use grows with the bytes that have come, not with
/// those that were promised.
class IncomingBytes {
 public:
  IncomingBytes() = default;
  /// `sizes` are the bytes of each block, as the sender promised them.
  explicit IncomingBytes(std::vector<std::uint64_t> sizes);

  /// Bytes that have not come yet. It begins at UINT64_MAX if the sum of the promised sizes overflows.
  std::uint64_t missing() const { return missing_; }
  /// CRC-32 of the bytes that have come.
  std::uint32_t crc32() const { return crc32_; }
  /// Appends a chunk. Returns false, and takes nothing, if the chunk is longer than what is missing.
  [[nodiscard]] bool add(std::string_view chunk);
  /// Moves the blocks, complete or not, to the strings that `blocks` point to. There must be a string for each promised
  /// size.
  void move_to(std::span<std::string* const> blocks);

 private:
  std::vector<std::uint64_t> sizes_;
  std::vector<std::string> blocks_;
  std::uint64_t missing_ = 0;
  std::uint32_t crc32_ = 0;
  std::size_t block_ = 0;  // The index of the block that the next byte belongs to.
};

}  // namespace segserve::wire
