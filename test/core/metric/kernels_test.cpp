// The code for AVX2 gives the bytes of the code for any CPU, however many pairs there are. On a machine without AVX2
// both are the same code.
#include "segserve/metric/kernels/kernels.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <vector>

#include "segserve/math/cpu.hpp"
#include "segserve/metric/color.hpp"
#include "segserve/metric/paper_metric.hpp"

namespace segserve {
namespace {

/// Colours of all hues, greys, and opposites; places and directions, some of them the same.
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

/// Colour differences, then geometric terms by eq. 5 and 7: their bits.
std::vector<std::uint64_t> bits_of(const Regions& r, std::size_t pairs, Cpu cpu) {
  use_cpu(cpu);
  std::vector<double> values(3 * pairs);
  const MetricKernels& kernels = metric_kernels();
  use_cpu(best_cpu());
  const Surfaces surfaces{r.centroid.data(), r.normal.data()};
  kernels.color_differences(r.color.data(), r.pairs.data(), pairs, values.data());
  kernels.geometric_terms(surfaces, false, r.pairs.data(), pairs, values.data() + pairs);
  kernels.geometric_terms(surfaces, true, r.pairs.data(), pairs, values.data() + 2 * pairs);
  std::vector<std::uint64_t> bits;
  for (const double value : values) bits.push_back(std::bit_cast<std::uint64_t>(value));
  return bits;
}

TEST(MetricKernels, GiveTheSameBytesOnEveryCpu) {
  const Regions regions = random_regions(120);
  for (const std::size_t pairs : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{4},
                                  std::size_t{7}, regions.pairs.size()}) {
    EXPECT_EQ(bits_of(regions, pairs, Cpu::kAny), bits_of(regions, pairs, best_cpu())) << pairs;
  }
}

TEST(MetricKernels, GiveWhatOnePairAloneGetsInEitherOrder) {
  const Regions r = random_regions(60);
  const std::vector<std::uint64_t> bits = bits_of(r, r.pairs.size(), best_cpu());
  for (std::size_t i = 0; i < r.pairs.size(); ++i) {
    const auto [a, b] = r.pairs[i];
    EXPECT_EQ(std::bit_cast<std::uint64_t>(ciede2000(r.color[b], r.color[a])), bits[i]) << a << ", " << b;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(geometric_term(r.centroid[b], r.normal[b], r.centroid[a], r.normal[a])),
              bits[r.pairs.size() + i])
        << a << ", " << b;
  }
}

}  // namespace
}  // namespace segserve
