// SPDX-License-Identifier: Apache-2.0
//
// SIMD vectors, as wide as the instructions that this translation unit is compiled for.
//
// Only for kernels, whose sources are compiled once for each SimdTarget, and for elementary.cpp. Before they include
// this header they define SEGSERVE_SIMD_TARGET as the target's name, `baseline` or `avx2`. It becomes a namespace, so
// that the linker never replaces a function of one target by that of another. For the same reason kernels call no
// inline functions of other headers: the linker keeps one copy of these, which may be the one that was compiled for
// AVX2.
//
// Vectors are only used with the operations of IEEE 754, each lane on its own. So results do not depend on the width.
#pragma once

#include <cstddef>
#include <cstdint>

#define SEGSERVE_INLINE inline __attribute__((always_inline))
#define SEGSERVE_INLINE_LAMBDA __attribute__((always_inline))

namespace segserve::SEGSERVE_SIMD_TARGET {

#if defined(__AVX2__)
inline constexpr std::size_t kVectorBytes = 32;
#else
inline constexpr std::size_t kVectorBytes = 16;
#endif
inline constexpr std::size_t kDoubleLanes = kVectorBytes / sizeof(double);  ///< doubles in a vector
inline constexpr std::size_t kFloatLanes = kVectorBytes / sizeof(float);    ///< floats in a vector

using Doubles = double __attribute__((vector_size(kVectorBytes)));
using Int64s = std::int64_t __attribute__((vector_size(kVectorBytes)));  ///< also the masks of Doubles
using Floats = float __attribute__((vector_size(kVectorBytes)));
using Ints = std::int32_t __attribute__((vector_size(kVectorBytes)));     ///< also the masks of Floats
using HalfFloats = float __attribute__((vector_size(kVectorBytes / 2)));  ///< as many lanes as Doubles
using Double2 = double __attribute__((vector_size(2 * sizeof(double))));  ///< two lanes for every target

namespace {

/// `from` points to an object, or to the first of some, whose first bytes are the vector's lanes.
template <typename Vector, typename Object>
SEGSERVE_INLINE Vector load(const Object* from) {
  Vector v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

/// `to` points to an object, or to the first of some, whose first bytes take the vector's lanes.
template <typename Vector, typename Object>
SEGSERVE_INLINE void store(const Vector& v, Object* to) {
  __builtin_memcpy(to, &v, sizeof v);
}

// Double4 has four lanes for every target, such as x, y, z and a count. It is two vectors where one has only two
// lanes: a vector that is wider than the target's would be split by the compiler into single numbers.
#if defined(__AVX2__)
using Double4 = Doubles;
template <int a, int b, int c, int d>
SEGSERVE_INLINE Double4 shuffle(Double4 v) {
  return __builtin_shufflevector(v, v, a, b, c, d);
}
template <int a, int b>
SEGSERVE_INLINE Double2 pick(Double4 v) {
  return __builtin_shufflevector(v, v, a, b);
}
#else
struct Double4 {
  Double2 low, high;
};
SEGSERVE_INLINE Double4 operator+(Double4 a, Double4 b) { return {a.low + b.low, a.high + b.high}; }
SEGSERVE_INLINE Double4 operator-(Double4 a, Double4 b) { return {a.low - b.low, a.high - b.high}; }
SEGSERVE_INLINE Double4 operator*(Double4 a, Double4 b) { return {a.low * b.low, a.high * b.high}; }
SEGSERVE_INLINE Double4 operator*(double s, Double4 a) { return {s * a.low, s * a.high}; }
template <int a, int b>
SEGSERVE_INLINE Double2 pick(Double4 v) {
  return __builtin_shufflevector(v.low, v.high, a, b);
}
template <int a, int b, int c, int d>
SEGSERVE_INLINE Double4 shuffle(Double4 v) {
  return {pick<a, b>(v), pick<c, d>(v)};
}
#endif

SEGSERVE_INLINE double square_root(double v) { return __builtin_sqrt(v); }

SEGSERVE_INLINE Doubles square_root(Doubles v) {
#if defined(__AVX2__)
  return __builtin_ia32_sqrtpd256(v);
#elif defined(__SSE2__)
  return __builtin_ia32_sqrtpd(v);
#else
  for (std::size_t i = 0; i < kDoubleLanes; ++i) v[i] = __builtin_sqrt(v[i]);
  return v;
#endif
}

SEGSERVE_INLINE Floats square_root(Floats v) {
#if defined(__AVX2__)
  return __builtin_ia32_sqrtps256(v);
#elif defined(__SSE2__)
  return __builtin_ia32_sqrtps(v);  // GCC 12 would turn a loop into four scalar instructions
#else
  for (std::size_t i = 0; i < kFloatLanes; ++i) v[i] = __builtin_sqrtf(v[i]);
  return v;
#endif
}

/// Bit i of the result tells whether the mask is set in lane i.
SEGSERVE_INLINE std::uint32_t bits(Ints mask) {
#if defined(__AVX2__)
  return static_cast<std::uint32_t>(__builtin_ia32_movmskps256(reinterpret_cast<Floats>(mask)));
#elif defined(__SSE2__)
  return static_cast<std::uint32_t>(__builtin_ia32_movmskps(reinterpret_cast<Floats>(mask)));
#else
  const Ints bit = mask & Ints{1, 2, 4, 8};
  return static_cast<std::uint32_t>(bit[0] | bit[1] | bit[2] | bit[3]);
#endif
}

SEGSERVE_INLINE bool any(Ints mask) { return bits(mask) != 0; }

SEGSERVE_INLINE bool any(Int64s mask) {
#if defined(__AVX2__)
  return __builtin_ia32_movmskpd256(reinterpret_cast<Doubles>(mask)) != 0;
#elif defined(__SSE2__)
  return __builtin_ia32_movmskpd(reinterpret_cast<Doubles>(mask)) != 0;
#else
  return (mask[0] | mask[1]) != 0;
#endif
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
