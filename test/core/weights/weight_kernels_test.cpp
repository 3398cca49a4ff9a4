// SPDX-License-Identifier: Apache-2.0
//
// The kernels for AVX2 give the same bytes as the baseline, however many pairs there are. On a machine without AVX2
// both are the same code.
#include "core/weights/simd/weight_kernels.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <vector>

#include "core/math/elementary.hpp"
#include "core/simd/simd_dispatch.hpp"
#include "core/weights/color_difference.hpp"
#include "core/weights/paper_metric.hpp"

namespace segserve {
namespace {

/// Colors of all hues, grays and opposite hues among them, and centroids and normals, some of which are equal.
struct Regions {
  std::vector<Lab> color;
  std::vector<Vec3> centroid, normal;
  std::vector<RegionEdge> pairs;
};

Regions random_regions(std::uint32_t count) {
  std::mt19937_64 random(1);
  const auto number = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 100'000) / 100'000;
  };
  Regions r;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double chroma = i % 7 == 0 ? 0 : 1;
    const Lab lab{number(0, 100), chroma * number(-110, 110), chroma * number(-110, 110)};
    r.color.push_back(i % 5 == 0 && i > 0 ? Lab{lab.l, -r.color[i - 1].a, -r.color[i - 1].b} : lab);
    r.centroid.push_back(i % 6 == 0 && i > 0 ? r.centroid[i - 1] : Vec3{number(-1, 1), number(-1, 1), number(1, 2)});
    r.normal.push_back(i % 8 == 0 ? Vec3{} : unit({number(-1, 1), number(-1, 1), -1}));
    for (std::uint32_t j = 0; j < i; ++j) r.pairs.push_back(random() % 2 == 0 ? RegionEdge{i, j} : RegionEdge{j, i});
  }
  return r;
}

/// The bits of the color differences and of the geometric terms by eq. 5 and 7.
std::vector<std::uint64_t> bits_of(const Regions& r, std::size_t pairs, SimdTarget target) {
  set_simd_target(target);
  std::vector<double> values(3 * pairs);
  const WeightKernels& kernels = weight_kernels();
  set_simd_target(best_simd_target());
  const RegionSurfaces surfaces{r.centroid.data(), r.normal.data()};
  kernels.color_differences(r.color.data(), r.pairs.data(), pairs, values.data());
  kernels.geometric_terms(surfaces, false, r.pairs.data(), pairs, values.data() + pairs);
  kernels.geometric_terms(surfaces, true, r.pairs.data(), pairs, values.data() + 2 * pairs);
  std::vector<std::uint64_t> bits;
  for (const double value : values) bits.push_back(std::bit_cast<std::uint64_t>(value));
  return bits;
}

TEST(WeightKernels, GiveTheSameBytesForEveryTarget) {
  const Regions regions = random_regions(120);
  for (const std::size_t pairs : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{4},
                                  std::size_t{7}, regions.pairs.size()}) {
    EXPECT_EQ(bits_of(regions, pairs, SimdTarget::kBaseline), bits_of(regions, pairs, best_simd_target())) << pairs;
  }
}

TEST(WeightKernels, GiveEachPairTheSameBytesAloneAndInEitherOrder) {
  const Regions r = random_regions(60);
  const std::vector<std::uint64_t> bits = bits_of(r, r.pairs.size(), best_simd_target());
  for (std::size_t i = 0; i < r.pairs.size(); ++i) {
    const auto [a, b] = r.pairs[i];
    EXPECT_EQ(std::bit_cast<std::uint64_t>(ciede2000(r.color[b], r.color[a])), bits[i]) << a << ", " << b;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(geometric_term(r.centroid[b], r.normal[b], r.centroid[a], r.normal[a])),
              bits[r.pairs.size() + i])
        << a << ", " << b;
  }
}

/// Converts sRGB to CIE 1976 L*a*b* by the formula, with the scalar functions of core/math/elementary.hpp.
Lab lab_by_formula(const Vec3& rgb) {
  const auto linear = [](double channel) {
    const double c = channel / 255;
    return c <= 0.04045 ? c / 12.92 : math::pow((c + 0.055) / 1.055, 2.4);
  };
  const auto curve = [](double t) {
    constexpr double kDelta = 6.0 / 29;
    return t > kDelta * kDelta * kDelta ? math::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const double r = linear(rgb.x), g = linear(rgb.y), b = linear(rgb.z);
  const double fx = curve((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
  const double fy = curve(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
  const double fz = curve((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

TEST(WeightKernels, ConvertColorsByTheFormulaBitForBit) {
  std::mt19937_64 random(2);
  std::vector<Vec3> rgb{{0, 0, 0}, {255, 255, 255}, {10.31, 10.32, 0.5}};
  const auto channel = [&] { return static_cast<double>(random() % 255'001) / 1000; };
  while (rgb.size() < 1000) rgb.push_back({channel(), channel(), channel()});
  for (const SimdTarget target : {SimdTarget::kBaseline, best_simd_target()}) {
    set_simd_target(target);
    const WeightKernels& kernels = weight_kernels();
    set_simd_target(best_simd_target());
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{3}, std::size_t{6}, rgb.size()}) {
      std::vector<Lab> colors(count + 1, Lab{-1, -1, -1});
      kernels.srgb_to_lab(rgb.data(), count, colors.data());
      for (std::size_t i = 0; i < count; ++i) {
        const Lab expected = lab_by_formula(rgb[i]);
        EXPECT_EQ(colors[i].l, expected.l) << i;
        EXPECT_EQ(colors[i].a, expected.a) << i;
        EXPECT_EQ(colors[i].b, expected.b) << i;
      }
      EXPECT_EQ(colors[count].l, -1);
    }
  }
}

}  // namespace
}  // namespace segserve
