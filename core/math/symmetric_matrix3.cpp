#include "core/math/symmetric_matrix3.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace segserve {
namespace {

/// Smallest root of the characteristic polynomial t^3 - t^2 + c1 t - c0 of a matrix of trace 1.
/// From 0 on, left of all roots, Newton's steps rise towards it and never pass it.
double smallest_eigenvalue(const Symmetric3& a) {
  const double c1 = (a.xx * a.yy - a.xy * a.xy) + (a.xx * a.zz - a.xz * a.xz) + (a.yy * a.zz - a.yz * a.yz);
  const double c0 =
      a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) + a.xz * (a.xy * a.yz - a.yy * a.xz);
  double t = 0;
  for (int step = 0; step < 50; ++step) {
    const double value = ((t - 1) * t + c1) * t - c0;
    const double slope = (3 * t - 2) * t + c1;
    if (value >= 0 || slope <= 0) break;
    const double next = t - value / slope;
    if (next - t <= 1e-16 * next) break;
    t = next;
  }
  return t;
}

/// A symmetric matrix on its way to a diagonal one by rotations in its coordinate planes (Jacobi 1846).
class Diagonalisation {
 public:
  explicit Diagonalisation(const Symmetric3& a) : a_{{{a.xx, a.xy, a.xz}, {a.xy, a.yy, a.yz}, {a.xz, a.yz, a.zz}}} {
    constexpr int kSweeps = 16;  // five or six make it diagonal, as they converge quadratically
    for (int sweep = 0; sweep < kSweeps && !diagonal(); ++sweep) {
      rotate(0, 1);
      rotate(0, 2);
      rotate(1, 2);
    }
  }

  double value(std::size_t i) const { return a_[i][i]; }
  Vec3 vector(std::size_t i) const { return {v_[0][i], v_[1][i], v_[2][i]}; }

 private:
  using Matrix = std::array<std::array<double, 3>, 3>;

  bool diagonal() const { return a_[0][1] == 0 && a_[0][2] == 0 && a_[1][2] == 0; }

  /// Makes a_pq zero.
  void rotate(std::size_t p, std::size_t q) {
    constexpr double kNothing = 1e-18;  // in a matrix of trace 1
    if (std::fabs(a_[p][q]) <= kNothing) {
      a_[p][q] = a_[q][p] = 0;
      return;
    }
    const double theta = (a_[q][q] - a_[p][p]) / (2 * a_[p][q]);
    const double tangent = (theta < 0 ? -1 : 1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
    const double c = 1 / std::sqrt(tangent * tangent + 1);
    const double s = tangent * c;
    const double change = tangent * a_[p][q];
    a_[p][p] -= change;
    a_[q][q] += change;
    a_[p][q] = a_[q][p] = 0;
    const std::size_t r = 3 - p - q;
    const double rp = a_[r][p], rq = a_[r][q];
    a_[r][p] = a_[p][r] = c * rp - s * rq;
    a_[r][q] = a_[q][r] = s * rp + c * rq;
    for (auto& row : v_) {
      const double vp = row[p], vq = row[q];
      row[p] = c * vp - s * vq;
      row[q] = s * vp + c * vq;
    }
  }

  Matrix a_;
  Matrix v_{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // its columns are the eigenvectors
};

Vec3 with_largest_component_positive(const Vec3& v) {
  double largest = v.x;
  if (std::fabs(v.y) > std::fabs(largest)) largest = v.y;
  if (std::fabs(v.z) > std::fabs(largest)) largest = v.z;
  return largest < 0 ? -v : v;
}

}  // namespace

Vec3 smallest_eigenvector(const Symmetric3& a) {
  const double trace = a.xx + a.yy + a.zz;
  if (!(trace > 0)) return {};
  const Symmetric3 n = (1 / trace) * a;
  const double t = smallest_eigenvalue(n);
  // The rows of n - t I span the plane across the eigenvector; take the best conditioned product.
  const Vec3 rows[3] = {{n.xx - t, n.xy, n.xz}, {n.xy, n.yy - t, n.yz}, {n.xz, n.yz, n.zz - t}};
  const Vec3 products[3] = {cross(rows[0], rows[1]), cross(rows[0], rows[2]), cross(rows[1], rows[2])};
  const Vec3& best = *std::ranges::max_element(products, {}, [](const Vec3& p) { return dot(p, p); });
  // Its length is about (second - smallest)(largest - smallest) eigenvalue of the normalised matrix.
  constexpr double kUndefined = 1e-9;
  return dot(best, best) > kUndefined * kUndefined ? unit(best) : Vec3{};
}

std::array<Vec3, 3> principal_axes(const Symmetric3& a) {
  const double trace = a.xx + a.yy + a.zz;
  if (!(trace > 0)) return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const Diagonalisation diagonal((1 / trace) * a);
  std::array<std::size_t, 3> order{0, 1, 2};
  std::ranges::stable_sort(order, [&](std::size_t i, std::size_t j) { return diagonal.value(i) > diagonal.value(j); });
  const Vec3 first = with_largest_component_positive(unit(diagonal.vector(order[0])));
  const Vec3 second = with_largest_component_positive(unit(diagonal.vector(order[1])));
  return {first, second, unit(cross(first, second))};
}

}  // namespace segserve
