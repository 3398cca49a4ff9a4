// Vectors of numbers, each in a lane of its own, as wide as the instructions that this translation unit is compiled
// for. Only for the sources of kernels, which are compiled once for each kind of CPU (voxel/kernels/): they define
// SEGSERVE_KERNELS as a namespace, so that no function compiled for one kind is ever linked into another. For the
// same reason nothing here calls functions of other headers.
//
// Lanes hold operations of IEEE 754 alone, each lane as if it were alone: results do not depend on the width.
#pragma once

#include <cstddef>
#include <cstdint>

#define SEGSERVE_INLINE inline __attribute__((always_inline))
#define SEGSERVE_INLINE_LAMBDA __attribute__((always_inline))

namespace segserve::SEGSERVE_KERNELS {

#if defined(__AVX2__)
inline constexpr std::size_t kLaneBytes = 32;
#else
inline constexpr std::size_t kLaneBytes = 16;
#endif
inline constexpr std::size_t kReals = kLaneBytes / sizeof(double);  ///< doubles in a vector
inline constexpr std::size_t kFloats = kLaneBytes / sizeof(float);  ///< floats in a vector

using Real = double __attribute__((vector_size(kLaneBytes)));
using RealMask = std::int64_t __attribute__((vector_size(kLaneBytes)));
using Float = float __attribute__((vector_size(kLaneBytes)));
using Int = std::int32_t __attribute__((vector_size(kLaneBytes)));
using HalfFloat = float __attribute__((vector_size(kLaneBytes / 2)));  ///< as many floats as a Real has doubles

namespace {

template <typename Vector, typename Scalar>
SEGSERVE_INLINE Vector load(const Scalar* from) {
  Vector v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

template <typename Vector, typename Scalar>
SEGSERVE_INLINE void store(const Vector& v, Scalar* to) {
  __builtin_memcpy(to, &v, sizeof v);
}

using Real2 = double __attribute__((vector_size(2 * sizeof(double))));

// Real4: four numbers of one thing, such as x, y, z and a count. Where vectors are narrow it is two of them: left to
// the compiler, the lanes would be taken apart one by one.
#if defined(__AVX2__)
using Real4 = Real;
template <int a, int b, int c, int d>
SEGSERVE_INLINE Real4 shuffle(Real4 v) {
  return __builtin_shufflevector(v, v, a, b, c, d);
}
template <int a, int b>
SEGSERVE_INLINE Real2 pick(Real4 v) {
  return __builtin_shufflevector(v, v, a, b);
}
#else
struct Real4 {
  Real2 low, high;
};
SEGSERVE_INLINE Real4 operator+(Real4 a, Real4 b) { return {a.low + b.low, a.high + b.high}; }
SEGSERVE_INLINE Real4 operator-(Real4 a, Real4 b) { return {a.low - b.low, a.high - b.high}; }
SEGSERVE_INLINE Real4 operator*(Real4 a, Real4 b) { return {a.low * b.low, a.high * b.high}; }
SEGSERVE_INLINE Real4 operator*(double s, Real4 a) { return {s * a.low, s * a.high}; }
template <int a, int b>
SEGSERVE_INLINE Real2 pick(Real4 v) {
  return __builtin_shufflevector(v.low, v.high, a, b);
}
template <int a, int b, int c, int d>
SEGSERVE_INLINE Real4 shuffle(Real4 v) {
  return {pick<a, b>(v), pick<c, d>(v)};
}
#endif

/// The first three numbers of as many Real4 as a vector has lanes, each in vectors of its own.
struct Columns {
  Real x, y, z;
};
SEGSERVE_INLINE Columns transposed(const Real4 (&r)[kReals]) {
#if defined(__AVX2__)
  const Real xz01 = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6);
  const Real xz23 = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6);
  const Real yw01 = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
  const Real yw23 = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
  return {__builtin_shufflevector(xz01, xz23, 0, 1, 4, 5), __builtin_shufflevector(yw01, yw23, 0, 1, 4, 5),
          __builtin_shufflevector(xz01, xz23, 2, 3, 6, 7)};
#else
  return {__builtin_shufflevector(r[0].low, r[1].low, 0, 2), __builtin_shufflevector(r[0].low, r[1].low, 1, 3),
          __builtin_shufflevector(r[0].high, r[1].high, 0, 2)};
#endif
}

SEGSERVE_INLINE Real square_root(Real v) {
#if defined(__AVX2__)
  return __builtin_ia32_sqrtpd256(v);
#elif defined(__SSE2__)
  return __builtin_ia32_sqrtpd(v);
#else
  for (std::size_t i = 0; i < kReals; ++i) v[i] = __builtin_sqrt(v[i]);
  return v;
#endif
}

/// Bit i of the result: whether the mask is set in lane i.
SEGSERVE_INLINE std::uint32_t bits(Int mask) {
#if defined(__AVX2__)
  return static_cast<std::uint32_t>(__builtin_ia32_movmskps256(reinterpret_cast<Float>(mask)));
#elif defined(__SSE2__)
  return static_cast<std::uint32_t>(__builtin_ia32_movmskps(reinterpret_cast<Float>(mask)));
#else
  const Int bit = mask & Int{1, 2, 4, 8};
  return static_cast<std::uint32_t>(bit[0] | bit[1] | bit[2] | bit[3]);
#endif
}

SEGSERVE_INLINE bool any(Int mask) { return bits(mask) != 0; }

SEGSERVE_INLINE bool any(RealMask mask) {
#if defined(__AVX2__)
  return __builtin_ia32_movmskpd256(reinterpret_cast<Real>(mask)) != 0;
#elif defined(__SSE2__)
  return __builtin_ia32_movmskpd(reinterpret_cast<Real>(mask)) != 0;
#else
  return (mask[0] | mask[1]) != 0;
#endif
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
