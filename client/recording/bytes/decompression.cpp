// SPDX-License-Identifier: Apache-2.0
#include "client/recording/bytes/decompression.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "core/base/status_macros.hpp"

namespace segserve::recording {
namespace {

/// Bytes that are decompressed between two looks at the stop token.
constexpr std::size_t kPart = std::size_t{1} << 20U;

/// The outcome of one step of a library.
struct Step {
  std::size_t consumed = 0;
  std::size_t produced = 0;
  bool failed = false;
  bool ended = false;  ///< a frame is complete
};

/// Calls step(input, output room) until the claimed bytes are there, or the input ends or is damaged.
template <typename StepFunction>
absl::StatusOr<Decompressed> run_steps(std::string_view input, std::uint64_t claimed, const StopToken& stop,
                                       StepFunction step) {
  Decompressed out;
  bool ended = false;
  while (true) {
    RETURN_IF_ERROR(stop.check());
    const std::size_t before = out.bytes.size();
    const std::size_t room = static_cast<std::size_t>(std::min<std::uint64_t>(kPart, claimed - before));
    out.bytes.resize(before + room);
    const Step done = step(input, out.bytes.data() + before, room);
    out.bytes.resize(before + done.produced);
    if (done.failed) return out;
    input.remove_prefix(done.consumed);
    ended = done.ended;
    const bool stuck = done.consumed == 0 && done.produced == 0;
    if ((ended && input.empty()) || stuck) break;
  }
  out.complete = ended && input.empty() && out.bytes.size() == claimed;
  return out;
}

absl::StatusOr<Decompressed> decompress_zstd(std::string_view bytes, std::uint64_t claimed, const StopToken& stop) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  return run_steps(bytes, claimed, stop, [&](std::string_view input, char* out, std::size_t room) {
    ZSTD_inBuffer in{input.data(), input.size(), 0};
    ZSTD_outBuffer to{out, room, 0};
    const std::size_t left = ZSTD_decompressStream(context.get(), &to, &in);
    return Step{in.pos, to.pos, ZSTD_isError(left) != 0, left == 0};
  });
}

absl::StatusOr<Decompressed> decompress_lz4(std::string_view bytes, std::uint64_t claimed, const StopToken& stop) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0U) {
    return absl::ResourceExhaustedError("there is not enough memory to decompress LZ4");
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     &LZ4F_freeDecompressionContext);
  return run_steps(bytes, claimed, stop, [&](std::string_view input, char* out, std::size_t room) {
    std::size_t consumed = input.size();
    std::size_t produced = room;
    const std::size_t left = LZ4F_decompress(context.get(), out, &produced, input.data(), &consumed, nullptr);
    if (LZ4F_isError(left) != 0U) return Step{.failed = true};
    return Step{consumed, produced, false, left == 0};
  });
}

absl::StatusOr<Decompressed> decompress_bz2(std::string_view bytes, std::uint64_t claimed, const StopToken& stop) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) {
    return absl::ResourceExhaustedError("there is not enough memory to decompress bzip2");
  }
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> end(&stream, &BZ2_bzDecompressEnd);
  bool done = false;
  return run_steps(bytes, claimed, stop, [&](std::string_view input, char* out, std::size_t room) {
    if (done) return Step{.ended = true};
    constexpr std::size_t kMostInput = std::size_t{1} << 30U;  // The library counts with 32 bits.
    const std::size_t given = std::min(input.size(), kMostInput);
    stream.next_in = const_cast<char*>(input.data());  // NOLINT(cppcoreguidelines-pro-type-const-cast): it only reads
    stream.avail_in = static_cast<unsigned>(given);
    stream.next_out = out;
    stream.avail_out = static_cast<unsigned>(room);
    const int result = BZ2_bzDecompress(&stream);
    done = result == BZ_STREAM_END;
    return Step{given - stream.avail_in, room - stream.avail_out, result != BZ_OK && !done, done};
  });
}

}  // namespace

absl::StatusOr<Decompressed> decompress(std::string_view compression, std::string_view bytes, std::uint64_t claimed,
                                        const StopToken& stop) {
  if (compression.empty() || compression == "none") {
    const std::string_view used =
        bytes.substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(claimed, bytes.size())));
    return Decompressed{std::string(used), bytes.size() == claimed};
  }
  if (compression == "zstd") return decompress_zstd(bytes, claimed, stop);
  if (compression == "lz4") return decompress_lz4(bytes, claimed, stop);
  if (compression == "bz2") return decompress_bz2(bytes, claimed, stop);
  return absl::InvalidArgumentError(
      fmt::format("chunks are compressed with '{}', which is not known: lz4, zstd, bz2 and none are", compression));
}

}  // namespace segserve::recording
