// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/compressed_file.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/text_parsing.hpp"

namespace segserve::codec {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view kGzipMagic = "\x1f\x8b"sv, kZstdMagic = "\x28\xb5\x2f\xfd"sv;
/// Whether a frame of zstd begins here; the first byte of a frame to skip tells how it is used.
bool is_zstd_frame(std::string_view bytes) {
  constexpr std::string_view kSkippable = "\x2a\x4d\x18"sv;  // behind a first byte of 0x50 to 0x5f
  if (bytes.starts_with(kZstdMagic)) return true;
  return bytes.size() >= 4 && (static_cast<unsigned char>(bytes[0]) & 0xF0U) == 0x50 &&
         bytes.substr(1).starts_with(kSkippable);
}

constexpr std::size_t kPiece = std::size_t{1} << 18U;
constexpr std::size_t kBytesPerUnit = 16;  // of work, see WorkMeter

absl::Status damage(std::string_view name, std::string_view words) {
  return absl::InvalidArgumentError(fmt::format("{}: {}", name, words));
}

/// Bytes that grow piece by piece up to a limit. The system moves large blocks by their addresses, and gives no memory
/// to what has not been written, so that they never take more than they are.
class Output {
 public:
  Output(std::string_view name, const DecodeLimits& limits) : name_(name), limits_(limits) {}

  /// Room for the next piece, behind what is there.
  absl::StatusOr<std::span<std::byte>> room() {
    if (capacity_ - used_ < kPiece) RETURN_IF_ERROR(grow(std::max(used_ + kPiece, used_ + used_ / 2)));
    return std::span(memory_.get() + used_, kPiece);
  }
  absl::Status take(std::size_t bytes, StopCheck& check) {
    used_ += bytes;
    if (check.after(bytes / kBytesPerUnit + 1)) return check.status();
    if (used_ <= limits_.max_bytes) return absl::OkStatus();
    return over_limit(fmt::format("{}: it decompresses to more bytes than the limit of {}", name_, limits_.max_bytes),
                      {"max_bytes", used_, limits_.max_bytes});
  }
  DecompressedBytes finish() { return {std::move(memory_), used_}; }

 private:
  absl::Status grow(std::size_t capacity) {
    void* const grown = std::realloc(memory_.get(), capacity);  // NOLINT(*-no-malloc, *-owning-memory)
    if (grown == nullptr) return absl::ResourceExhaustedError(fmt::format("{}: there is no memory", name_));
    (void)memory_.release();  // The block is another one now.
    memory_.reset(static_cast<std::byte*>(grown));
    capacity_ = capacity;
    return absl::OkStatus();
  }

  std::string_view name_;
  const DecodeLimits& limits_;
  DecompressedBytes::Memory memory_;
  std::size_t capacity_ = 0, used_ = 0;
};

/// A stream of zlib, which takes pieces of less than 4 GiB.
class Inflater {
 public:
  explicit Inflater(int window_bits) { ready_ = inflateInit2(&stream_, window_bits) == Z_OK; }
  ~Inflater() {
    if (ready_) inflateEnd(&stream_);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool ready() const { return ready_; }
  /// Begins another stream.
  bool reset() { return inflateReset(&stream_) == Z_OK; }

  struct Step {
    int result = Z_OK;
    std::size_t read = 0, written = 0;
  };
  Step run(std::span<const std::byte> in, std::span<std::byte> out) {
    const std::size_t given = std::min(in.size(), kPiece), room = std::min(out.size(), kPiece);
    // zlib does not write to its input.
    stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(in.data()));
    stream_.avail_in = static_cast<uInt>(given);
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(room);
    const int result = ::inflate(&stream_, Z_NO_FLUSH);
    return {result, given - stream_.avail_in, room - stream_.avail_out};
  }

 private:
  z_stream stream_{};
  bool ready_ = false;
};

void warn_of_rest(std::string_view name, std::span<const std::byte> rest, std::vector<Warning>& warnings) {
  if (std::ranges::all_of(rest, [](std::byte b) { return b == std::byte{0}; })) return;
  warnings.push_back(
      {WarningReason::kRowsNotUsed, fmt::format("{} bytes behind the {} data are not used", rest.size(), name)});
}

absl::StatusOr<DecompressedBytes> gunzip(std::span<const std::byte> rest, const DecodeLimits& limits, StopCheck& check,
                                         std::vector<Warning>& warnings) {
  constexpr int kGzipWindow = 16 + MAX_WBITS;
  Inflater inflater(kGzipWindow);
  if (!inflater.ready()) return absl::ResourceExhaustedError("gzip: there is no memory");
  Output out("gzip", limits);
  while (true) {
    ASSIGN_OR_RETURN(const std::span<std::byte> room, out.room());
    const Inflater::Step step = inflater.run(rest, room);
    rest = rest.subspan(step.read);
    RETURN_IF_ERROR(out.take(step.written, check));
    if (step.result == Z_STREAM_END) {
      if (!as_text(rest).starts_with(kGzipMagic)) break;
      if (!inflater.reset()) return absl::InternalError("gzip: it cannot be begun again");
    } else if (step.result != Z_OK) {
      return damage("gzip", step.result == Z_BUF_ERROR ? "the file ends too early" : "the file is damaged");
    }
  }
  warn_of_rest("gzip", rest, warnings);
  return out.finish();
}

struct FreeContext {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

absl::StatusOr<DecompressedBytes> unzstd(std::span<const std::byte> file, const DecodeLimits& limits, StopCheck& check,
                                         std::vector<Warning>& warnings) {
  constexpr int kMostWindowLog = 27;  // 128 MiB, as the program zstd accepts
  const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  if (!context) return absl::ResourceExhaustedError("zstd: there is no memory");
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kMostWindowLog);
  Output out("zstd", limits);
  ZSTD_inBuffer in{file.data(), file.size(), 0};
  while (true) {
    ASSIGN_OR_RETURN(const std::span<std::byte> room, out.room());
    ZSTD_outBuffer piece{room.data(), room.size(), 0};
    const std::size_t before = in.pos, hint = ZSTD_decompressStream(context.get(), &piece, &in);
    if (ZSTD_isError(hint) != 0U) return damage("zstd", ZSTD_getErrorName(hint));
    RETURN_IF_ERROR(out.take(piece.pos, check));
    if (hint == 0) {
      if (!is_zstd_frame(as_text(file.subspan(in.pos)))) break;
    } else if (in.pos == before && piece.pos == 0) {
      return damage("zstd", "the file ends too early");
    }
  }
  warn_of_rest("zstd", file.subspan(in.pos), warnings);
  return out.finish();
}

}  // namespace

std::optional<Compression> compression_of(std::string_view file) {
  if (file.starts_with(kGzipMagic)) return Compression::kGzip;
  if (is_zstd_frame(file)) return Compression::kZstd;
  return std::nullopt;
}

absl::StatusOr<DecompressedBytes> decompress(std::span<const std::byte> file, Compression compression,
                                             const DecodeLimits& limits, StopCheck& check,
                                             std::vector<Warning>& warnings) {
  return compression == Compression::kGzip ? gunzip(file, limits, check, warnings)
                                           : unzstd(file, limits, check, warnings);
}

absl::StatusOr<std::vector<std::byte>> inflate_exactly(std::span<const std::byte> stream, std::size_t size,
                                                       std::string_view name, StopCheck& check) {
  constexpr std::size_t kMostRatio = 1032;  // of deflate
  if (size / kMostRatio > stream.size()) {
    return damage(name, fmt::format("{} bytes cannot hold the claimed {} bytes", stream.size(), size));
  }
  Inflater inflater(-MAX_WBITS);
  if (!inflater.ready()) return absl::ResourceExhaustedError("deflate: there is no memory");
  std::vector<std::byte> out(size);
  std::size_t used = 0;
  while (true) {
    const Inflater::Step step = inflater.run(stream, std::span(out).subspan(used));
    stream = stream.subspan(step.read);
    used += step.written;
    if (check.after(step.written / kBytesPerUnit + 1)) return check.status();
    if (step.result == Z_STREAM_END) break;
    if (step.result != Z_OK) return damage(name, "its compressed bytes are damaged, or not as many as it says");
  }
  if (used != size) return damage(name, fmt::format("it decompresses to {} bytes, not the claimed {}", used, size));
  return out;
}

}  // namespace segserve::codec
