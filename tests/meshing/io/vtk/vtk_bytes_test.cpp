// Ranges of stored arrays are what was stored, however that was done.
#include "meshing/io/vtk/vtk_bytes.h"

#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::vtk_bytes_test {
namespace {

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return i + k < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i + k])) : 0u;
    };
    const std::uint32_t bits = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int d = 0; d < 4; ++d) text += kDigits[bits >> (18 - 6 * d) & 63];
    for (std::size_t k = i + 3; k > bytes.size(); --k) text[text.size() - (k - bytes.size())] = '=';
  }
  return text;
}

std::string in_lines(const std::string& text, std::size_t length) {
  std::string lines;
  for (std::size_t i = 0; i < text.size(); i += length) lines += text.substr(i, length) + "\n";
  return lines;
}

std::string number(std::uint64_t value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }

/// Runs that compress, and noise that does not.
std::string some_bytes(std::size_t size) {
  std::mt19937 random(7);
  std::string bytes(size, 'a');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i / 1000 % 2 == 0 ? i / 50 : random());
  return bytes;
}

class VtkArrays : public testing::Test {
 protected:
  /// What is stored between other text reads back in any ranges.
  void expect_ranges(const std::string& bytes, const std::string& stored, bool base64, bool compressed) {
    put_bytes(directory / "a", "<DataArray>" + stored + "</DataArray>");
    const InputFile file(directory / "a");
    VtkBytes array(file, "array x",
                   {11, 11 + stored.size(), base64, compressed, /*swapped=*/false, /*wide_headers=*/true});
    ASSERT_EQ(array.size(), bytes.size());
    const auto read = [&](std::uint64_t first, std::uint64_t count) {
      std::string out(count, '\0');
      array.read(first, count, out.data());
      return out == bytes.substr(first, count);
    };
    EXPECT_TRUE(read(0, bytes.size()));
    for (std::uint64_t at = 0; at < bytes.size(); at += 70001)  // on and on, as cells are read
      EXPECT_TRUE(read(at, std::min<std::uint64_t>(70001, bytes.size() - at))) << at;
    std::mt19937 random(11);
    for (int i = 0; i < 20 && !bytes.empty(); ++i) {
      const std::uint64_t first = random() % bytes.size();
      EXPECT_TRUE(read(first, random() % std::min<std::uint64_t>(bytes.size() - first, 5000))) << first;
    }
  }

  TemporaryDirectory directory;
};

TEST_F(VtkArrays, ReadBackInRangesAsTheyAre) {
  for (const std::size_t size : {0u, 1u, 2u, 3u, 700000u}) {
    SCOPED_TRACE(size);
    const std::string bytes = some_bytes(size), header = number(size);
    expect_ranges(bytes, header + bytes, false, false);
    expect_ranges(bytes, base64(header) + base64(bytes), true, false);
    expect_ranges(bytes, base64(header + bytes), true, false);
    expect_ranges(bytes, "\n  " + base64(header) + base64(bytes) + "\n  ", true, false);
    for (const std::size_t line : {4u, 76u, 77u}) {
      expect_ranges(bytes, in_lines(base64(header) + base64(bytes), line), true, false);
      expect_ranges(bytes, in_lines(base64(header + bytes), line), true, false);
    }
  }
}

TEST_F(VtkArrays, ReadBackInRangesCompressed) {
  for (const std::size_t size : {0u, 1u, 700000u}) {
    SCOPED_TRACE(size);
    const std::string bytes = some_bytes(size);
    const std::vector<char> compressed = vtk_compressed({bytes.begin(), bytes.end()});
    const std::string stored(compressed.begin(), compressed.end());
    std::uint64_t num_blocks = 0;
    std::memcpy(&num_blocks, stored.data(), sizeof num_blocks);
    const std::size_t header = 8 * (3 + num_blocks);
    expect_ranges(bytes, stored, false, true);
    expect_ranges(bytes, base64(stored.substr(0, header)) + base64(stored.substr(header)), true, true);
    expect_ranges(bytes, base64(stored), true, true);
    expect_ranges(bytes, in_lines(base64(stored), 76), true, true);
  }
}

TEST_F(VtkArrays, CutShortAreRefused) {
  const std::string bytes = some_bytes(600000);
  const std::vector<char> compressed = vtk_compressed({bytes.begin(), bytes.end()});
  const std::string packed(compressed.begin(), compressed.end()), plain = number(bytes.size()) + bytes;
  const auto issue = [&](const std::string& stored, bool is_base64, bool is_compressed) {
    put_bytes(directory / "a", stored);
    return message_of([&] {
      const InputFile file(directory / "a");
      VtkBytes array(file, "array x", {0, stored.size(), is_base64, is_compressed, false, true});
      std::string out(100, '\0');
      array.read(bytes.size() - 100, 100, out.data());
    });
  };
  for (const std::size_t length : {std::size_t{0}, std::size_t{5}, std::size_t{1000}, packed.size() - 1}) {
    expect_contains(issue(packed.substr(0, length), false, true), "array x: the file is truncated");
    expect_contains(issue(plain.substr(0, length), false, false), "array x: the file is truncated");
    expect_contains(issue(base64(plain).substr(0, length), true, false), "array x: the file is truncated");
  }
  std::string damaged = packed;
  damaged[packed.size() - 1000] = static_cast<char>(damaged[packed.size() - 1000] ^ 1);
  expect_contains(issue(damaged, false, true), "array x: its compressed data are damaged");
}

}  // namespace
}  // namespace weft::meshing::vtk_bytes_test
