// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// In a stream the bytes of a message's blocks travel apart from it, as one run cut into chunks.
namespace segserve::wire {

/// Most bytes of one chunk. Larger ones would hold up cancels, smaller ones cost calls.
inline constexpr std::size_t kMaxChunkBytes = std::size_t{256} << 10U;

/// The CRC-32 of zlib, PNG and RFC 1952, over the bytes so far followed by `bytes`; that of no bytes is 0.
std::uint32_t crc32(std::uint32_t crc_so_far, std::string_view bytes);

/// The bytes of a message's blocks.
class ByteRun {
 public:
  ByteRun() = default;
  /// Takes the strings that `blocks` point to, and leaves them empty.
  explicit ByteRun(std::span<std::string* const> blocks);
  /// Bytes that stay where they are; `owner` keeps them.
  ByteRun(std::vector<std::string_view> blocks, std::shared_ptr<const void> owner);

  std::span<const std::string_view> blocks() const { return blocks_; }
  /// Of all blocks together.
  std::uint64_t size() const { return size_; }
  std::uint32_t crc32() const { return crc32_; }

 private:
  std::vector<std::string_view> blocks_;
  std::shared_ptr<const void> owner_;
  std::uint64_t size_ = 0;
  std::uint32_t crc32_ = 0;
};

/// A run on its way out, given away chunk by chunk. The run is shared, so that it can be sent more than once.
class OutgoingBytes {
 public:
  OutgoingBytes() : OutgoingBytes(std::make_shared<const ByteRun>()) {}
  explicit OutgoingBytes(std::shared_ptr<const ByteRun> run);

  const ByteRun& run() const { return *run_; }
  const std::shared_ptr<const ByteRun>& shared_run() const { return run_; }
  /// True once everything was given away.
  bool done() const { return block_ == run_->blocks().size(); }
  /// The next bytes, at most `max_bytes` (above 0) and not beyond the end of a block; valid as long as the run.
  /// Empty if done.
  std::string_view next(std::size_t max_bytes = kMaxChunkBytes);

 private:
  void skip_empty_blocks();

  std::shared_ptr<const ByteRun> run_;
  std::size_t block_ = 0, offset_ = 0;  // of the next byte
};

/// Blocks on their way in. Memory in use grows with the bytes that have come, not with those that were promised.
class IncomingBytes {
 public:
  IncomingBytes() = default;
  /// The sizes that the sender promised, block by block.
  explicit IncomingBytes(std::vector<std::uint64_t> sizes);

  /// Bytes to come; the largest number there is if the promised sizes overflow.
  std::uint64_t missing() const { return missing_; }
  /// Of what has come.
  std::uint32_t crc32() const { return crc32_; }
  /// False, and nothing is taken, if the chunk is longer than what is missing.
  [[nodiscard]] bool add(std::string_view chunk);
  /// Gives the blocks, complete or not, to the strings that `blocks` point to: as many as sizes were promised.
  void move_to(std::span<std::string* const> blocks);

 private:
  std::vector<std::uint64_t> sizes_;
  std::vector<std::string> blocks_;
  std::uint64_t missing_ = 0;
  std::uint32_t crc32_ = 0;
  std::size_t block_ = 0;  // that the next byte belongs to
};

}  // namespace segserve::wire
