// Packing: every kind of value there and back, large arrays as segments, damaged messages.
#include "engine/base/serialize.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "engine/base/rank.h"
#include "tests/support/failing_new.h"

namespace weft::engine::serialize_test {
namespace {

constexpr std::size_t kLarge = Packer::kSegmentBytes / sizeof(double);

template <class... Ts>
Payload packed_copies(Ts... values) {
  Packer packer;
  packer(values...);
  return packer.take();
}

template <class T>
T there_and_back(T value) {
  return unpacked<T>(packed_copies<T>(std::move(value)));
}

Payload copy_of(const Payload& payload) {
  Payload copy{payload.bytes, {}};
  for (const Blob& segment : payload.segments) {
    copy.segments.push_back(Blob::allocate(segment.size()));
    std::memcpy(copy.segments.back().data(), segment.data(), segment.size());
  }
  return copy;
}

struct Point {
  double x, y;
  friend bool operator==(const Point&, const Point&) = default;
};

/// Trivial to copy, but says itself what travels.
struct Cached {
  std::int32_t value = 0;
  std::int32_t cache = -1;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(value);
  }
  friend bool operator==(const Cached&, const Cached&) = default;
};

enum class Colour : std::uint8_t { red, green };

/// One of everything.
struct Everything {
  std::int32_t number = 0;
  bool flag = false;
  Colour colour = Colour::red;
  Point point{};
  std::string text;
  std::vector<double> values;
  std::vector<bool> flags;
  std::vector<std::string> texts;
  std::vector<std::vector<Point>> nested;
  std::array<std::string, 2> pair_of_texts;
  std::array<Cached, 2> cached;
  std::optional<std::string> maybe;
  std::optional<std::int32_t> maybe_number;
  std::unique_ptr<Point> owned;
  std::pair<std::int32_t, std::string> pair;
  std::tuple<std::int8_t, std::string, std::vector<Point>> tuple;
  std::variant<std::int32_t, std::string> variant;
  std::variant<std::int32_t, double> plain_variant;
  std::map<std::string, std::vector<std::int32_t>> map;
  std::map<std::int32_t, double> plain_map;
  std::set<std::string> set;
  std::unordered_map<std::int32_t, std::optional<bool>> hashed;
  std::vector<double> large;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(number, flag, colour, point, text, values, flags, texts, nested, pair_of_texts, cached, maybe,
            maybe_number, owned, pair, tuple, variant, plain_variant, map, plain_map, set, hashed, large);
  }
};

Everything everything() {
  Everything e;
  e.number = -7;
  e.flag = true;
  e.colour = Colour::green;
  e.point = {1, 2};
  e.text = std::string("with\0zero", 9);
  e.values = {1.5, -2.5};
  e.flags = {true, false, true};
  e.texts = {"", "one"};
  e.nested = {{}, {{3, 4}, {5, 6}}};
  e.pair_of_texts = {"a", "b"};
  e.cached = {Cached{8, 9}, Cached{10, 11}};
  e.maybe = "perhaps";
  e.maybe_number = 12;
  e.owned = std::make_unique<Point>(Point{7, 8});
  e.pair = {13, "second"};
  e.tuple = {std::int8_t{14}, "middle", {{9, 10}}};
  e.variant = "text";
  e.plain_variant = 0.25;
  e.map = {{"even", {2, 4}}, {"none", {}}};
  e.plain_map = {{1, 0.5}, {2, 0.75}};
  e.set = {"x", "y"};
  e.hashed = {{1, true}, {2, std::nullopt}};
  e.large.assign(kLarge + 3, 1.25);
  return e;
}

void expect_same(const Everything& a, const Everything& b) {
  EXPECT_EQ(std::tie(a.number, a.flag, a.colour, a.point, a.text, a.values, a.flags, a.texts, a.nested),
            std::tie(b.number, b.flag, b.colour, b.point, b.text, b.values, b.flags, b.texts, b.nested));
  EXPECT_EQ(std::tie(a.pair_of_texts, a.maybe, a.maybe_number, a.pair, a.tuple, a.variant, a.plain_variant),
            std::tie(b.pair_of_texts, b.maybe, b.maybe_number, b.pair, b.tuple, b.variant, b.plain_variant));
  EXPECT_EQ(std::tie(a.map, a.plain_map, a.set, a.hashed, a.large),
            std::tie(b.map, b.plain_map, b.set, b.hashed, b.large));
  ASSERT_TRUE(a.owned && b.owned);
  EXPECT_EQ(*a.owned, *b.owned);
}

TEST(Serialize, EverythingComesBackAsItWas) {
  Everything before = everything();
  Packer packer;
  packer(before);
  const Everything after = unpacked<Everything>(packer.take());
  expect_same(after, before);
  expect_same(before, everything());
  EXPECT_EQ(after.cached[0], (Cached{8, -1})) << "an array's elements use their own serialize()";
}

TEST(Serialize, EmptyValuesComeBackEmpty) {
  EXPECT_EQ(there_and_back(std::string()), "");
  EXPECT_EQ(there_and_back(std::vector<double>()), std::vector<double>());
  EXPECT_EQ(there_and_back(std::vector<std::string>()), std::vector<std::string>());
  EXPECT_EQ(there_and_back(std::optional<std::string>()), std::nullopt);
  EXPECT_EQ(there_and_back(std::map<int, int>()), (std::map<int, int>()));
  EXPECT_EQ(there_and_back(std::unique_ptr<Point>()), nullptr);
}

TEST(Serialize, WhatWasThereBeforeIsReplaced) {
  std::vector<std::string> texts = {"old", "older"};
  std::map<int, int> map = {{1, 1}};
  std::optional<int> maybe = 5;
  Unpacker unpacker(
      packed_copies(std::vector<std::string>{"new"}, std::map<int, int>{{2, 2}}, std::optional<int>()));
  unpacker(texts, map, maybe);
  EXPECT_EQ(texts, std::vector<std::string>{"new"});
  EXPECT_EQ(map, (std::map<int, int>{{2, 2}}));
  EXPECT_FALSE(maybe.has_value());
}

TEST(Serialize, NamesOfRanksAndObjectsTravel) {
  EXPECT_EQ(there_and_back(ObjectId{Rank(3), 17}), (ObjectId{Rank(3), 17}));
}

TEST(Serialize, AConstValueIsPackedLikeAnyOther) {
  const Cached value{4, 5};
  const bool flag = true;
  const std::string text = "text";
  Packer packer;
  packer(value, flag, text);
  Unpacker unpacker(packer.take());
  Cached cached;
  bool yes = false;
  std::string same;
  unpacker(cached, yes, same);
  unpacker.finish();
  EXPECT_EQ(cached, (Cached{4, -1}));
  EXPECT_TRUE(yes);
  EXPECT_EQ(same, text);
}

struct Holder {
  std::vector<double> values;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(values);
  }
};

TEST(Serialize, AConstValueIsNotConsumed) {
  const Holder holder{std::vector<double>(kLarge, 1.0)};
  Packer packer(true);
  packer(holder);
  EXPECT_EQ(holder.values.size(), kLarge);
  EXPECT_EQ(unpacked<Holder>(packer.take()).values, holder.values);
}

TEST(Serialize, ViewsAndPointersAreNoPlainData) {
  EXPECT_FALSE(PlainData<int*>);
  EXPECT_FALSE(PlainData<std::string_view>);
  EXPECT_FALSE(PlainData<std::span<const int>>);
  EXPECT_FALSE((PlainData<std::array<const char*, 2>>));
  EXPECT_FALSE(PlainData<std::reference_wrapper<int>>);
  EXPECT_TRUE(PlainData<Point>);
  EXPECT_TRUE((PlainData<std::array<Point, 2>>));
}

TEST(Serialize, LargeArraysBecomeSegmentsAndSmallOnesDoNot) {
  EXPECT_EQ(packed_copies(std::vector<double>(kLarge - 1)).segments.size(), 0u);
  const Payload payload = packed_copies(std::vector<double>(kLarge), std::vector<char>(3));
  ASSERT_EQ(payload.segments.size(), 1u);
  EXPECT_EQ(payload.segments[0].size(), Packer::kSegmentBytes);
  EXPECT_EQ(payload.size(), payload.bytes.size() + Packer::kSegmentBytes);
  EXPECT_EQ(there_and_back(std::vector<double>(kLarge, 0.5)), std::vector<double>(kLarge, 0.5));
}

TEST(Serialize, ConsumedArraysMoveWithoutBeingCopied) {
  std::vector<double> values(kLarge, 2.5);
  const void* data = values.data();
  Packer packer(true);
  packer(values);
  Payload payload = packer.take();
  EXPECT_EQ(payload.segments.at(0).data(), data);
  EXPECT_TRUE(values.empty());
  EXPECT_EQ(unpacked<std::vector<double>>(std::move(payload)), std::vector<double>(kLarge, 2.5));
}

TEST(Serialize, ArraysThatAreNotConsumedAreCopied) {
  std::vector<double> values(kLarge, 2.5);
  Packer packer(false);
  packer(values);
  EXPECT_NE(packer.take().segments.at(0).data(), static_cast<void*>(values.data()));
  EXPECT_EQ(values.size(), kLarge);
}

TEST(Serialize, ABlobIsASegmentWhateverItsSize) {
  Blob blob = Blob::adopt(std::vector<char>{'a', 'b'});
  const std::byte* data = blob.data();
  Packer packer(true);
  packer(blob);
  Payload payload = packer.take();
  ASSERT_EQ(payload.segments.size(), 1u);
  EXPECT_EQ(payload.segments[0].data(), data);
  Blob back;
  Unpacker unpacker(std::move(payload));
  unpacker(back);
  unpacker.finish();
  EXPECT_EQ(back.data(), data) << "nor is it copied on the way back";
}

TEST(Serialize, ABlobThatIsNotConsumedStays) {
  Blob blob = Blob::adopt(std::vector<char>{'a', 'b'});
  Packer packer;
  packer(blob);
  const Payload payload = packer.take();
  ASSERT_EQ(blob.size(), 2u);
  EXPECT_NE(payload.segments.at(0).data(), blob.data());
  EXPECT_EQ(std::memcmp(payload.segments[0].data(), "ab", 2), 0);
  EXPECT_EQ(std::memcmp(blob.data(), "ab", 2), 0);
}

/// Freed blocks are kept for the next blobs, and to keep them may not fail: that would end the process.
TEST(Serialize, LargeBlobsAreFreedWithoutMemory) {
  constexpr int kBlobs = 120;  // some 30 MiB, all of which is kept
  std::vector<Blob> blobs;
  for (int i = 0; i < kBlobs; ++i) blobs.push_back(Blob::allocate(std::size_t{1} << 18));
  const weft::testing::FailingNew memory(0);
  blobs.clear();
  EXPECT_FALSE(memory.has_failed());
}

TEST(Serialize, WhatIsSharedStaysWhereItIsForAllWhoReadIt) {
  auto values = std::make_shared<const std::vector<double>>(3, 4.0);
  const std::byte* data = std::as_bytes(std::span(*values)).data();
  std::vector<std::shared_ptr<const void>> owners;
  for (int reader = 0; reader < 2; ++reader) {
    Packer packer(true);
    packer.share(std::as_bytes(std::span(*values)), values);
    Unpacker unpacker(packer.take());
    auto [bytes, owner] = unpacker.shared();
    unpacker.finish();
    EXPECT_EQ(bytes.data(), data);
    EXPECT_EQ(bytes.size(), 3 * sizeof(double));
    owners.push_back(std::move(owner));
  }
  const std::weak_ptr<const std::vector<double>> left = values;
  values.reset();
  owners.pop_back();
  EXPECT_FALSE(left.expired());
  owners.clear();
  EXPECT_TRUE(left.expired());
  Unpacker empty{Payload{}};
  EXPECT_THROW(empty.shared(), UnpackError);
}

TEST(Serialize, APayloadTravelsInAPayload) {
  Payload inner = packed_copies(std::vector<double>(kLarge, 3.0), std::string("text"));
  Packer packer(true);
  packer(inner);
  Payload back = unpacked<Payload>(packer.take());
  Unpacker unpacker(std::move(back));
  std::vector<double> values;
  std::string text;
  unpacker(values, text);
  unpacker.finish();
  EXPECT_EQ(values, std::vector<double>(kLarge, 3.0));
  EXPECT_EQ(text, "text");
}

TEST(Serialize, BytesAndSegmentsThatAreLeftAreFound) {
  std::int32_t number = 0;
  Unpacker bytes(packed_copies(std::int32_t{1}, std::int8_t{2}));
  bytes(number);
  EXPECT_THROW(bytes.finish(), UnpackError);
  Payload payload = packed_copies(std::int32_t{1});
  payload.segments.push_back(Blob::allocate(0));
  Unpacker segments(std::move(payload));
  segments(number);
  EXPECT_THROW(segments.finish(), UnpackError);
}

TEST(Serialize, AMessageThatIsCutAnywhereIsRefused) {
  const Payload whole = packed_copies(everything());
  for (std::size_t size = 0; size < whole.bytes.size(); ++size) {
    Payload cut = copy_of(whole);
    cut.bytes.resize(size);
    cut.bytes.shrink_to_fit();  // so that the sanitizer sees a byte too far
    EXPECT_THROW(unpacked<Everything>(std::move(cut)), UnpackError) << size;
  }
  Payload cut = copy_of(whole);
  cut.segments.clear();
  EXPECT_THROW(unpacked<Everything>(std::move(cut)), UnpackError);
}

TEST(Serialize, ADamagedByteIsRefusedOrGivesAnotherValueButDoesNoHarm) {
  const Payload whole = packed_copies(everything());
  for (std::size_t place = 0; place < whole.bytes.size(); ++place) {
    for (const unsigned char damage : {0x01, 0x80, 0xFF}) {
      Payload damaged = copy_of(whole);
      damaged.bytes[place] ^= std::byte{damage};
      try {
        unpacked<Everything>(std::move(damaged));
      } catch (const UnpackError&) {
      }
    }
  }
}

TEST(Serialize, ImpossibleCountsAreRefusedBeforeAnythingIsAllocated) {
  for (const std::uint64_t count :
       {std::uint64_t{9}, std::uint64_t{1} << 40, std::uint64_t{1} << 61, ~std::uint64_t{0}}) {
    const auto damaged = [&] { return packed_copies(count, std::uint64_t{0}); };
    EXPECT_THROW(unpacked<std::string>(damaged()), UnpackError) << count;
    EXPECT_THROW(unpacked<std::vector<double>>(damaged()), UnpackError) << count;
    EXPECT_THROW(unpacked<std::vector<bool>>(damaged()), UnpackError) << count;
    EXPECT_THROW(unpacked<std::vector<std::string>>(damaged()), UnpackError) << count;
    EXPECT_THROW((unpacked<std::map<int, int>>(damaged())), UnpackError) << count;
    EXPECT_THROW(unpacked<std::set<std::string>>(damaged()), UnpackError) << count;
    EXPECT_THROW((unpacked<std::unordered_map<int, int>>(damaged())), UnpackError) << count;
  }
}

TEST(Serialize, ALargeArrayMustHaveTheSizeThatItsCountSays) {
  for (const std::size_t size : {std::size_t{0}, Packer::kSegmentBytes - 1, Packer::kSegmentBytes + 8}) {
    Payload payload = packed_copies(std::uint64_t{kLarge});
    payload.segments.push_back(Blob::allocate(size));
    EXPECT_THROW(unpacked<std::vector<double>>(std::move(payload)), UnpackError) << size;
  }
  EXPECT_THROW(unpacked<std::vector<double>>(packed_copies(std::uint64_t{kLarge})), UnpackError);
}

TEST(Serialize, BytesThatStandForNoValueAreRefused) {
  EXPECT_THROW(unpacked<bool>(packed_copies(std::uint8_t{2})), UnpackError);
  EXPECT_THROW(unpacked<std::optional<int>>(packed_copies(std::uint8_t{2}, 1)), UnpackError);
  EXPECT_THROW(unpacked<std::unique_ptr<int>>(packed_copies(std::uint8_t{2}, 1)), UnpackError);
  EXPECT_THROW((unpacked<std::variant<int, double>>(packed_copies(std::uint32_t{2}, 1.0))), UnpackError);
  EXPECT_THROW((unpacked<std::array<bool, 2>>(packed_copies(std::uint16_t{0x0100 + 2}))), UnpackError);
  EXPECT_THROW(
      (unpacked<std::vector<std::optional<int>>>(packed_copies(std::uint64_t{1}, std::uint8_t{7}, 1))),
      UnpackError);
}

}  // namespace
}  // namespace weft::engine::serialize_test
