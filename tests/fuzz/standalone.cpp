// A fuzz target without libFuzzer: PROGRAM RUNS SEED FOLDER gives it each file of a folder, and then files
// with a few changed, cut, doubled and foreign pieces, of all formats by turns. WEFT_FUZZ_KEEP names a file
// that has the input which is being tried, so that a crash leaves it.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;

/// All of it: .lb8.ugrid.
std::string extension_of(const std::filesystem::path& path) {
  const std::string name = path.filename();
  return name.substr(std::min(name.find('.'), name.size()));
}

/// As readers.cpp takes it.
Bytes read(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string extension = extension_of(path) + "\n";
  Bytes bytes(extension.begin(), extension.end());
  bytes.insert(bytes.end(), std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  return bytes;
}

/// Up to `length` bytes from `at` on.
Bytes piece_of(const Bytes& bytes, std::size_t at, std::size_t length) {
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(std::min(at, bytes.size()));
  return {begin, begin + static_cast<std::ptrdiff_t>(
                             std::min<std::size_t>(length, static_cast<std::size_t>(bytes.end() - begin)))};
}

void change(Bytes& bytes, const Bytes& other, std::mt19937_64& random) {
  const auto line = static_cast<std::size_t>(std::find(bytes.begin(), bytes.end(), '\n') - bytes.begin());
  const std::size_t begin = std::min(line + 1, bytes.size() - 1);
  const std::size_t at = begin + random() % (bytes.size() - begin), length = 1 + random() % 16;
  const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  Bytes piece;
  switch (random() % 6) {
    case 0:
      bytes[at] = static_cast<std::uint8_t>(random());
      return;
    case 1:
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1u << random() % 8);
      return;
    case 2:
      bytes.erase(place, place + static_cast<std::ptrdiff_t>(std::min(length, bytes.size() - at)));
      return;
    case 3:
      piece = piece_of(bytes, at, length);
      break;
    case 4:
      piece = piece_of(other, random() % other.size(), length);
      break;
    default:
      if (random() % 8 == 0) bytes.resize(at + 1);
      return;
  }
  bytes.insert(place, piece.begin(), piece.end());
}

void attempt(const Bytes& bytes) {
  if (const char* keep = std::getenv("WEFT_FUZZ_KEEP")) {
    std::ofstream file(keep, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: %s RUNS SEED FOLDER\n", argv[0]), 64;
  const std::uint64_t runs = std::strtoull(argv[1], nullptr, 10);
  std::mt19937_64 random(std::strtoull(argv[2], nullptr, 10));
  std::set<std::filesystem::path> files;  // in the same order everywhere
  for (const auto& entry : std::filesystem::directory_iterator(argv[3])) files.insert(entry.path());
  std::map<std::string, std::vector<Bytes>> corpus;
  for (const std::filesystem::path& file : files) corpus[extension_of(file)].push_back(read(file));
  const auto any = [&](const std::vector<Bytes>& of) -> const Bytes& { return of[random() % of.size()]; };
  for (const auto& [extension, inputs] : corpus) {
    for (const Bytes& bytes : inputs) attempt(bytes);
    const std::uint64_t share = (runs + corpus.size() - 1) / corpus.size();
    for (std::uint64_t i = 0; i < share; ++i) {
      Bytes bytes = any(inputs);
      const Bytes& other =
          any(std::next(corpus.begin(), static_cast<std::ptrdiff_t>(random() % corpus.size()))->second);
      for (std::uint64_t changes = 1 + random() % 6; changes > 0 && bytes.size() > 2; --changes)
        change(bytes, other, random);
      attempt(bytes);
    }
    std::printf("%-11s %zu files, %llu changed ones: no crash\n", extension.c_str(), inputs.size(),
                static_cast<unsigned long long>(share));
    std::fflush(stdout);
  }
  return 0;
}
