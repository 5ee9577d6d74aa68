#include "common/finite.h"

#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace sinew {
namespace {

template <typename T>
std::string Bytes(const std::vector<T>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()),
                     values.size() * sizeof(T));
}

// Every place in blocks that are full, partial and odd.
template <typename T, typename Check>
void FindsBadNumbersAnywhere(Check all_finite) {
  for (const T bad :
       {std::numeric_limits<T>::infinity(), -std::numeric_limits<T>::infinity(),
        std::numeric_limits<T>::quiet_NaN()}) {
    for (size_t size : {1u, 7u, 1024u, 1025u, 3000u}) {
      std::vector<T> values(size, T{1});
      EXPECT_TRUE(all_finite(Bytes(values)));
      for (size_t i : {size_t{0}, size / 2, size - 1}) {
        values[i] = bad;
        EXPECT_FALSE(all_finite(Bytes(values))) << size << " " << i;
        values[i] = 1;
      }
    }
  }
}

TEST(AllFinite, FindsBadNumbersAnywhere) {
  FindsBadNumbersAnywhere<float>(AllFinite32);
  FindsBadNumbersAnywhere<double>(AllFinite64);
}

TEST(AllFinite, AcceptsEveryOrdinaryNumber) {
  using Float = std::numeric_limits<float>;
  using Double = std::numeric_limits<double>;

  EXPECT_TRUE(AllFinite32(Bytes<float>(
      {0.f, -0.f, Float::max(), Float::lowest(), Float::denorm_min()})));
  EXPECT_TRUE(AllFinite64(Bytes<double>(
      {0., -0., Double::max(), Double::lowest(), Double::denorm_min()})));
  EXPECT_TRUE(AllFinite32(""));
  EXPECT_TRUE(AllFinite64(""));
}

TEST(AllFinite, ReadsFromAnyAlignment) {
  const std::string bytes =
      "x" + Bytes<float>({1.f, std::numeric_limits<float>::quiet_NaN()});

  EXPECT_FALSE(AllFinite32(absl::string_view(bytes).substr(1)));
}

}  // namespace
}  // namespace sinew
