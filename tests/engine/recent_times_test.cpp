#include "engine/schedule/recent_times.h"

#include <gtest/gtest.h>

namespace weft::engine {
namespace {

TEST(RecentTimes, MedianIsTheLowerOfTwoInTheMiddle) {
  RecentTimes times;
  times.add(7);
  EXPECT_EQ(times.median(), 7);
  times.add(3);
  EXPECT_EQ(times.median(), 3);
  times.add(1000);
  EXPECT_EQ(times.median(), 7) << "one that was long by chance";
  EXPECT_EQ(times.count(), 3u);
}

TEST(RecentTimes, ForgetWhatIsLongAgo) {
  RecentTimes times;
  for (int i = 0; i < 100; ++i) times.add(1000);
  for (int i = 0; i < 15; ++i) times.add(i);
  EXPECT_EQ(times.median(), 7);
  EXPECT_EQ(times.count(), 115u);
}

}  // namespace
}  // namespace weft::engine
