#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

namespace segserve::server {

/// Frames and bytes of payload that a client may have on their way.
struct Credit {
  std::uint32_t frames = 0;
  std::uint64_t bytes = 0;
  bool operator==(const Credit&) const = default;
};

/// How credit is given to streams.
struct CreditLimits {
  Credit of_a_stream;         ///< the most that one stream gets
  std::uint64_t usual_bytes;  ///< what it gets unless it asks
  std::uint64_t all_bytes;    ///< of all streams together
};

/// Bounds the payload that all streams together may have on their way to this server, before it comes. Thread-safe.
class CreditBudget {
 public:
  /// Gives its bytes back when it ends. The budget must outlive it.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(CreditBudget& budget, const Credit& credit) : budget_(&budget), credit_(credit) {}
    Reservation(Reservation&& other) noexcept { *this = std::move(other); }
    Reservation& operator=(Reservation&& other) noexcept;
    ~Reservation() { release(); }

    const Credit& credit() const { return credit_; }
    void release();

   private:
    CreditBudget* budget_ = nullptr;
    Credit credit_;
  };

  explicit CreditBudget(const CreditLimits& limits) : limits_(limits), free_bytes_(limits.all_bytes) {}

  /// What is wanted (0: the usual), as far as the limits of a stream allow it. If less is left, then what is left, but
  /// at least a 16th; nullopt if there is not even that.
  std::optional<Reservation> reserve(const Credit& wanted);

  std::uint64_t free_bytes() const;

 private:
  const CreditLimits limits_;
  mutable std::mutex mutex_;
  std::uint64_t free_bytes_;
};

}  // namespace segserve::server
