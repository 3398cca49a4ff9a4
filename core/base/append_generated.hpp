// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <iterator>
#include <type_traits>
#include <vector>

namespace segserve::math {

/// An iterator over function(i) for consecutive indices i, from which std::vector can make its elements one by one.
template <typename Function>
class GeneratingIterator {
 public:
  using iterator_category = std::forward_iterator_tag;
  using difference_type = std::ptrdiff_t;
  using value_type = std::invoke_result_t<const Function&, std::size_t>;
  using pointer = void;
  using reference = value_type;

  GeneratingIterator(const Function* function, std::size_t index) : function_(function), index_(index) {}
  value_type operator*() const { return (*function_)(index_); }
  GeneratingIterator& operator++() {
    ++index_;
    return *this;
  }
  GeneratingIterator operator++(int) { return {function_, index_++}; }
  bool operator==(const GeneratingIterator& other) const { return index_ == other.index_; }
  difference_type operator-(const GeneratingIterator& other) const {
    return static_cast<difference_type>(index_ - other.index_);
  }

 private:
  const Function* function_;
  std::size_t index_;
};

/// Appends function(i) for the indices i in [first, last). Each value is written once, whereas `resize` would write
/// zeros before.
template <typename T, typename Function>
void append_generated(std::vector<T>& values, std::size_t first, std::size_t last, const Function& function) {
  using Iterator = GeneratingIterator<Function>;
  values.insert(values.end(), Iterator(&function, first), Iterator(&function, last));
}

}  // namespace segserve::math
