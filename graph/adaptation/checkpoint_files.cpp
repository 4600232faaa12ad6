// Folders, manifests and records.
#include "graph/adaptation/checkpoint_files.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <locale>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "engine/base/text.h"
#include "graph/adaptation/word_packing.h"
#include "meshing/base/error.h"

namespace weft::graph::adaptation {
namespace {

namespace fs = std::filesystem;
using meshing::InputError;

constexpr std::uint64_t kMagic = 0x32'54'50'4B'43'54'46'57;  // "WFTCKPT2"

/// The last bytes of a rank's file.
struct Trailer {
  std::uint64_t index_begin = 0, records = 0, index_hash = 0, magic = kMagic;
};

std::optional<std::uint64_t> number_of(const fs::path& folder) {
  const std::string name = folder.filename().string();
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc() || end != name.data() + name.size() || number == 0) return {};
  if (std::to_string(number) != name) return {};  // 007 is somebody else's
  return number;
}

struct CloseFolder {
  void operator()(DIR* folder) const { ::closedir(folder); }
};

/// What is in a folder; nothing where it cannot be read. (libstdc++'s iterators end the program where an
/// allocation fails: they throw through functions that must not.)
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  const std::unique_ptr<DIR, CloseFolder> open(::opendir(folder.c_str()));
  while (const dirent* entry = open ? ::readdir(open.get()) : nullptr) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") entries.push_back(folder / name);
  }
  return entries;
}

bool is_of_checkpoint(const std::string& name) {
  const std::string_view rank = "rank-";
  const auto digits = [&] { return name.find_first_not_of("0123456789", rank.size()) == std::string::npos; };
  return name == kManifestName || (name.starts_with(rank) && digits()) ||
         (name.starts_with(".weft-") && name.ends_with(".tmp"));
}

/// The files of a checkpoint, as far as that can be done; a folder with a number may be somebody else's.
/// Returns whether there were any.
bool remove_files(const fs::path& folder) {
  std::error_code ignored;
  bool removed = fs::remove(folder / kManifestName, ignored);  // first: half of a checkpoint is none
  for (const fs::path& file : entries_of(folder))
    if (is_of_checkpoint(file.filename().string())) removed |= fs::remove(file, ignored);
  return removed;
}

std::vector<std::pair<std::uint64_t, fs::path>> numbered_folders(const fs::path& folder) {
  std::vector<std::pair<std::uint64_t, fs::path>> all;
  std::error_code ignored;
  for (const fs::path& entry : entries_of(folder))
    if (const auto number = number_of(entry); number && fs::is_directory(entry, ignored))
      all.emplace_back(*number, entry);
  std::sort(all.rbegin(), all.rend());
  return all;
}

std::optional<CheckpointManifest> read_manifest(const fs::path& folder) {
  std::ifstream in(folder / kManifestName);
  std::ostringstream text = engine::text_stream();
  text << in.rdbuf();
  std::optional<CheckpointManifest> manifest = CheckpointManifest::parse(text.str());
  if (!manifest) return {};
  for (std::size_t r = 0; r < manifest->file_sizes.size(); ++r) {
    std::error_code error;
    const auto size = fs::file_size(folder / rank_file(static_cast<int>(r)), error);
    if (error || size != manifest->file_sizes[r]) return {};
  }
  return manifest;
}

/// What CheckpointFile::pack() has made of it. Throws std::runtime_error for anything else.
engine::Payload unpacked_record(std::span<const std::byte> packed) {
  const auto require = [](bool good) {
    if (!good) throw std::runtime_error("is no record");
  };
  std::uint64_t segments = 0;
  require(packed.size() >= 2 * sizeof segments);
  std::memcpy(&segments, packed.data(), sizeof segments);
  require(segments <= packed.size() / sizeof segments - 2);
  std::vector<std::uint64_t> sizes(segments + 2);
  std::memcpy(sizes.data(), packed.data(), sizes.size() * sizeof sizes[0]);
  packed = packed.subspan(sizes.size() * sizeof sizes[0]);
  const auto room_for = [&](std::uint64_t size) {
    require(size / kMostUnpacked <= packed.size());
    return size;
  };
  engine::Payload payload;
  payload.bytes.resize(room_for(sizes[1]));
  packed = unpack_words(packed, payload.bytes);
  for (std::size_t s = 2; s < sizes.size(); ++s) {
    engine::Blob& segment = payload.segments.emplace_back(engine::Blob::allocate(room_for(sizes[s])));
    packed = unpack_words(packed, {segment.data(), segment.size()});
  }
  require(packed.empty());
  return payload;
}

}  // namespace

std::string CheckpointManifest::text() const {
  std::ostringstream text = engine::text_stream();
  text << "weft-checkpoint 2\nrun " << run << "\nsubdomains " << subdomains << "\nhome_ranks " << home_ranks
       << "\nfiles " << file_sizes.size() << "\n";
  for (const std::uint64_t size : file_sizes) text << size << "\n";
  text << "end\n";
  return text.str();
}

std::optional<CheckpointManifest> CheckpointManifest::parse(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  const auto word_is = [&](const char* expected) {
    std::string word;
    return (in >> word) && word == expected;
  };
  CheckpointManifest m;
  std::size_t files = 0;
  constexpr std::size_t kMostFiles = 1u << 24;
  if (!word_is("weft-checkpoint") || !word_is("2") || !word_is("run") || !(in >> m.run) ||
      !word_is("subdomains") || !(in >> m.subdomains) || !word_is("home_ranks") || !(in >> m.home_ranks) ||
      !word_is("files") || !(in >> files) || files == 0 || files > kMostFiles || m.home_ranks < 1)
    return {};
  for (std::size_t i = 0; i < files; ++i) {
    std::uint64_t size = 0;
    if (!(in >> size)) return {};
    m.file_sizes.push_back(size);
  }
  if (!word_is("end")) return {};
  return m;
}

std::vector<CheckpointPlace> find_checkpoints(const fs::path& folder) {
  std::vector<CheckpointPlace> places;
  for (const auto& [number, path] : numbered_folders(folder))
    if (auto manifest = read_manifest(path)) places.push_back({number, path, std::move(*manifest)});
  return places;
}

std::uint64_t last_number(const fs::path& folder) {
  const auto all = numbered_folders(folder);
  return all.empty() ? 0 : all.front().first;
}

void remove_old_checkpoints(const fs::path& folder, std::size_t keep) {
  std::size_t kept = 0;
  for (const auto& [number, path] : numbered_folders(folder)) {
    const bool complete = read_manifest(path).has_value();
    if (complete && kept++ < keep) continue;
    if (!complete && kept == 0) continue;  // it may be on its way
    if (remove_files(path)) ::rmdir(path.c_str());
  }
}

void remove_checkpoint(const fs::path& folder) {
  remove_files(folder);
  ::rmdir(folder.c_str());
}

void remove_incomplete(const fs::path& folder, std::uint64_t after) {
  for (const auto& [number, path] : numbered_folders(folder))
    if (number > after && !read_manifest(path)) remove_checkpoint(path);
}

CheckpointLock::CheckpointLock(const fs::path& folder, std::chrono::milliseconds patience) {
  std::error_code ignored;  // the first checkpoint tells
  fs::create_directories(folder, ignored);
  descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) return;
  constexpr std::chrono::milliseconds kStep(100);
  for (; ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; patience -= kStep) {
    if (patience.count() <= 0) {
      ::close(descriptor_);
      throw InputError(folder.string(), "", "another run writes its checkpoints into this folder");
    }
    std::this_thread::sleep_for(kStep);
  }
}

CheckpointLock::~CheckpointLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

fs::path checkpoint_folder(const fs::path& folder, std::uint64_t number) {
  return folder / std::to_string(number);
}

std::string rank_file(int rank) { return "rank-" + std::to_string(rank); }

void sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);  // some file systems cannot, and need not
  ::close(descriptor);
}

std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t seed) {
  constexpr std::uint64_t kFactor = 0x9E3779B97F4A7C15u;
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint64_t hash = seed ^ size * kFactor;
  for (; size >= 8; bytes += 8, size -= 8) {
    std::uint64_t word;
    std::memcpy(&word, bytes, 8);
    hash = (hash ^ word) * kFactor;
    hash ^= hash >> 29;
  }
  std::uint64_t last = 0;
  if (size > 0) std::memcpy(&last, bytes, size);
  hash = (hash ^ last) * kFactor;
  return hash ^ hash >> 32;
}

// --- Records

std::vector<std::byte> CheckpointFile::pack(const engine::Payload& payload) {
  std::vector<std::uint64_t> sizes = {payload.segments.size(), payload.bytes.size()};
  for (const engine::Blob& segment : payload.segments) sizes.push_back(segment.size());
  std::vector<std::byte> packed(sizes.size() * sizeof sizes[0]);
  std::memcpy(packed.data(), sizes.data(), packed.size());
  pack_words(payload.bytes, packed);
  for (const engine::Blob& segment : payload.segments) pack_words(segment.bytes(), packed);
  return packed;
}

void CheckpointFile::add(CheckpointRecord::Kind kind, engine::ObjectId object,
                         std::span<const std::byte> packed) {
  index_.push_back(
      {kind, object, file_.position(), packed.size(), hash_bytes(packed.data(), packed.size(), 0)});
  file_.write(packed.data(), packed.size());
}

void CheckpointFile::commit() {
  Trailer trailer;
  trailer.index_begin = file_.position();
  trailer.records = index_.size();
  trailer.index_hash = hash_bytes(index_.data(), index_.size() * sizeof index_[0], 0);
  file_.write(index_.data(), index_.size() * sizeof index_[0]);
  file_.write_value(trailer);
  file_.commit();
}

CheckpointReader::CheckpointReader(const fs::path& path)
    : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0)
    throw InputError(path.string(), "", std::string("cannot be read: ") + std::strerror(errno));
  struct stat info {};
  if (::fstat(descriptor_, &info) != 0 || static_cast<std::size_t>(info.st_size) < sizeof(Trailer))
    refuse("it is too short");
  const auto size = static_cast<std::uint64_t>(info.st_size);
  Trailer trailer;
  read_at(size - sizeof trailer, &trailer, sizeof trailer);
  const std::uint64_t most = (size - sizeof trailer) / sizeof(CheckpointRecord);
  if (trailer.magic != kMagic || trailer.records > most ||
      trailer.index_begin + trailer.records * sizeof(CheckpointRecord) + sizeof trailer != size)
    refuse("its index is damaged");
  index_.resize(trailer.records);
  read_at(trailer.index_begin, index_.data(), index_.size() * sizeof index_[0]);
  if (hash_bytes(index_.data(), index_.size() * sizeof index_[0], 0) != trailer.index_hash)
    refuse("its index is damaged");
}

CheckpointReader::~CheckpointReader() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void CheckpointReader::refuse(const char* why) const {
  throw InputError(path_.string(), "", std::string("is no whole part of a checkpoint: ") + why);
}

void CheckpointReader::read_at(std::uint64_t begin, void* to, std::size_t size) const {
  auto* at = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t got = ::pread(descriptor_, at, size, static_cast<off_t>(begin));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) refuse(got < 0 ? std::strerror(errno) : "it ends too soon");
    at += got;
    begin += static_cast<std::uint64_t>(got);
    size -= static_cast<std::size_t>(got);
  }
}

engine::Payload CheckpointReader::read(const CheckpointRecord& record) const {
  struct stat info {};
  if (::fstat(descriptor_, &info) != 0 || record.size > static_cast<std::uint64_t>(info.st_size))
    refuse("a record is damaged");
  std::vector<std::byte> packed(record.size);
  read_at(record.begin, packed.data(), packed.size());
  if (hash_bytes(packed.data(), packed.size(), 0) != record.hash) refuse("a record is damaged");
  try {
    return unpacked_record(packed);
  } catch (const std::runtime_error&) {
    refuse("a record is damaged");
  }
}

}  // namespace weft::graph::adaptation
