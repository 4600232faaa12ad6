// Groups of base64 have fixed places where no blanks are among them; zlib does the compression.
#include "meshing/io/vtk/vtk_bytes.h"

#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/files/byte_order.h"
#include "meshing/io/files/text_numbers.h"

namespace weft::meshing {
namespace {

constexpr std::uint64_t kWindow = std::uint64_t{1} << 16;  ///< bytes that are read, or passed over, at once

constexpr std::array<std::int8_t, 256> base64_digits() {
  std::array<std::int8_t, 256> digits{};
  for (auto& digit : digits) digit = -1;
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kAlphabet.size(); ++i) {
    digits[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::int8_t>(i);
  }
  return digits;
}
constexpr std::array<std::int8_t, 256> kDigits = base64_digits();

std::int8_t digit_of(char c) { return kDigits[static_cast<unsigned char>(c)]; }

}  // namespace

/// The bytes that follow one another in stored data. Headers are encoded by themselves, with padding behind
/// them, or together with the data, depending on who wrote the file: padding just ends a group.
class VtkBytes::Stored {
 public:
  Stored(const InputFile& file, const VtkStorage& storage)
      : file_(file), base64_(storage.base64), at_(storage.begin), end_(storage.end) {}

  /// The bytes that can follow at most.
  std::uint64_t most() const { return end_ - at_ + (in_group_ - taken_); }
  /// The next bytes; false where the data end before.
  bool read(char* out, std::uint64_t size) {
    passed_ += size;
    if (base64_) return read_base64(out, size);
    if (size > end_ - at_) return false;
    file_.read_at(at_, out, size);
    at_ += size;
    return true;
  }

  /// From here on bytes are counted, of which there are `size`.
  void begin_data(std::uint64_t size) {
    passed_ = 0;
    const bool within_group = taken_ < in_group_;
    data_ = base64_ && within_group ? group_at_ : at_;
    skipped_ = within_group ? taken_ : 0;
    direct_ = !base64_ || is_gapless(size);
  }
  /// Whether they end before the end of the file.
  bool has(std::uint64_t size) const { return base64_ || size <= end_ - at_; }
  /// To one of the bytes counted; false where the data end before.
  bool seek(std::uint64_t byte) {
    if (byte == passed_) return true;
    if (!direct_) return pass_to(byte);
    passed_ = byte;
    if (!base64_) return at_ = data_ + byte, true;
    in_group_ = taken_ = 0;
    at_ = data_ + (skipped_ + byte) / 3 * 4;
    const std::uint64_t before = (skipped_ + byte) % 3;
    if (before == 0) return true;
    if (!decode_group()) return false;
    taken_ = before;
    return taken_ <= in_group_;
  }
  void give_up_window() { std::string().swap(window_); }

 private:
  bool read_base64(char* out, std::uint64_t size) {
    for (char* const end = out + size; out != end;) {
      if (taken_ == in_group_ && !decode_group()) return false;
      while (taken_ < in_group_ && out != end) *out++ = group_[taken_++];
    }
    return true;
  }

  /// Whether the data's groups follow one another without blanks: then they end with a group that is padded
  /// as it should be, and behind it nothing can belong to them.
  bool is_gapless(std::uint64_t size) {
    const std::uint64_t bytes = skipped_ + size, groups = (bytes + 2) / 3;
    if (groups > (end_ - data_) / 4) return false;
    std::uint64_t at = data_ + 4 * groups;
    for (std::uint64_t i = 0; i < std::min<std::uint64_t>(groups, 1) * 4; ++i) {
      const bool padding = i >= 4 - (3 * groups - bytes);
      const char c = character(at - 4 + i);
      if (padding ? c != '=' : digit_of(c) < 0) return false;
    }
    while (at < end_ && is_space(character(at))) ++at;
    return at == end_ || character(at) == '<';
  }

  char character(std::uint64_t at) {
    if (at - window_at_ >= window_.size()) {
      window_at_ = at;
      window_.resize(std::min(kWindow, end_ - at));
      file_.read_at(at, window_.data(), window_.size());
    }
    return window_[at - window_at_];
  }

  bool decode_group() {
    std::uint32_t bits = 0;
    std::size_t digits = 0, padding = 0;
    while (digits + padding < 4) {
      if (at_ == end_) return false;
      const char c = character(at_++);
      if (is_space(c)) continue;
      if (digits + padding == 0) group_at_ = at_ - 1;
      const std::int8_t digit = digit_of(c);
      if (digit < 0 && c != '=') return false;
      padding += digit < 0;
      digits += digit >= 0;
      bits = bits << 6 | static_cast<std::uint32_t>(digit < 0 ? 0 : digit);
    }
    if (digits < 2) return false;
    in_group_ = digits - 1;
    taken_ = 0;
    for (std::size_t byte = 0; byte < in_group_; ++byte)
      group_[byte] = static_cast<char>(bits >> (16 - 8 * byte) & 0xFF);
    return true;
  }

  bool pass_to(std::uint64_t byte) {
    if (byte < passed_) {
      passed_ = 0;
      at_ = data_;
      in_group_ = taken_ = 0;
      if (skipped_ > 0 && !decode_group()) return false;
      taken_ = skipped_;
    }
    for (std::array<char, 3000> passed; passed_ < byte;)
      if (!read(passed.data(), std::min<std::uint64_t>(passed.size(), byte - passed_))) return false;
    return true;
  }

  const InputFile& file_;
  bool base64_, direct_ = false;
  std::uint64_t at_, end_;                  ///< in the file
  std::uint64_t data_ = 0, skipped_ = 0;    ///< where the data begin, and bytes before them in their group
  std::uint64_t passed_ = 0;                ///< of the bytes counted
  std::array<char, 3> group_{};             ///< decoded
  std::uint64_t group_at_ = 0;              ///< where it is
  std::uint64_t in_group_ = 0, taken_ = 0;  ///< bytes of it, and those that have been read
  std::string window_;                      ///< of the text
  std::uint64_t window_at_ = 0;
};

/// Passes through the compressed blocks.
class VtkBytes::Inflater {
 public:
  ~Inflater() { give_up(); }

  /// Bytes of a block of `full` bytes that is stored at `place`. False for damaged data.
  bool read(Stored& stored, std::uint64_t place, std::uint64_t length, std::uint64_t full,
            std::uint64_t first, std::uint64_t count, char* out) {
    if (!active_ || place != place_ || first < produced_)
      if (!begin(place, length)) return false;
    std::array<char, 4096> passed;
    while (produced_ < first)
      if (!inflate_some(stored, passed.data(), std::min<std::uint64_t>(passed.size(), first - produced_)))
        return false;
    if (!inflate_some(stored, out, count)) return false;
    return produced_ < full || ends(stored);
  }
  void give_up() {
    if (active_) inflateEnd(&stream_);
    active_ = false;
    std::vector<Bytef>().swap(input_);
  }

 private:
  bool begin(std::uint64_t place, std::uint64_t length) {
    if (!active_) stream_ = {};
    if ((active_ ? inflateReset(&stream_) : inflateInit(&stream_)) != Z_OK) return false;
    active_ = true;
    finished_ = false;
    place_ = next_ = place;
    left_ = length;
    produced_ = 0;
    stream_.avail_in = 0;
    return true;
  }

  /// Exactly so many bytes.
  bool inflate_some(Stored& stored, char* out, std::uint64_t count) {
    while (count > 0) {
      stream_.next_out = reinterpret_cast<Bytef*>(out);
      stream_.avail_out = static_cast<uInt>(std::min<std::uint64_t>(count, std::uint64_t{1} << 30));
      const uInt wanted = stream_.avail_out;
      if (!step(stored)) return false;
      const std::uint64_t got = wanted - stream_.avail_out;
      out += got;
      count -= got;
      produced_ += got;
      if (count > 0 && finished_) return false;
    }
    return true;
  }

  /// Whether the block ends here, with the right check sum.
  bool ends(Stored& stored) {
    Bytef none = 0;
    while (!finished_) {
      stream_.next_out = &none;
      stream_.avail_out = 1;
      if (!step(stored) || stream_.avail_out == 0) return false;
    }
    return true;
  }

  bool step(Stored& stored) {
    if (stream_.avail_in == 0 && left_ > 0) {
      input_.resize(std::min(kWindow, left_));
      if (!stored.seek(next_) || !stored.read(reinterpret_cast<char*>(input_.data()), input_.size()))
        return false;
      next_ += input_.size();
      left_ -= input_.size();
      stream_.next_in = input_.data();
      stream_.avail_in = static_cast<uInt>(input_.size());
    }
    const uInt in = stream_.avail_in, out = stream_.avail_out;
    const int result = inflate(&stream_, Z_NO_FLUSH);
    finished_ = result == Z_STREAM_END;
    return finished_ || (result == Z_OK && (stream_.avail_in < in || stream_.avail_out < out));
  }

  z_stream stream_{};
  bool active_ = false, finished_ = false;
  std::vector<Bytef> input_;
  std::uint64_t place_ = 0, next_ = 0,
                left_ = 0;  ///< in stored data: the block, what follows of it, and its length
  std::uint64_t produced_ = 0;
};

VtkBytes::VtkBytes(const InputFile& file, std::string entity, const VtkStorage& storage)
    : file_(file.name()), entity_(std::move(entity)), stored_(std::make_unique<Stored>(file, storage)) {
  const auto next = [&] { return header(storage.wide_headers, storage.swapped); };
  if (storage.compressed) {
    const std::uint64_t num_blocks = next(), block_size = next(), last_size = next();
    inflater_ = std::make_unique<Inflater>();
    read_blocks(num_blocks, block_size, last_size, storage);
  } else {
    size_ = next();
    if (size_ > stored_->most() || !stored_->has(size_)) fail_truncated();
    stored_->begin_data(size_);
  }
}

VtkBytes::~VtkBytes() = default;
VtkBytes::VtkBytes(VtkBytes&&) noexcept = default;

void VtkBytes::read_blocks(std::uint64_t num_blocks, std::uint64_t block_size, std::uint64_t last_size,
                           const VtkStorage& storage) {
  const std::uint64_t most = stored_->most();
  if (num_blocks > most) fail("the number of its compressed blocks is damaged");
  block_size_ = block_size;
  last_size_ = last_size > 0 ? last_size : block_size;
  places_ = {0};
  for (std::uint64_t i = 0; i < num_blocks; ++i) {
    const std::uint64_t length = header(storage.wide_headers, storage.swapped);
    if (length > most - places_.back()) fail_truncated();
    places_.push_back(places_.back() + length);
    // Deflate makes nothing smaller than by a factor of 1032: a damaged size must not make us allocate.
    if ((i + 1 == num_blocks ? last_size_ : block_size) / 1032 > length + 16)
      fail("the size of a compressed block is damaged");
  }
  size_ = num_blocks == 0 ? 0 : (num_blocks - 1) * block_size_ + last_size_;
  if (!stored_->has(places_.back())) fail_truncated();
  stored_->begin_data(places_.back());
}

std::uint64_t VtkBytes::header(bool wide, bool swapped) {
  std::array<char, 8> bytes{};
  if (!stored_->read(bytes.data(), wide ? 8 : 4)) fail_truncated();
  return wide ? load<std::uint64_t>(bytes.data(), swapped) : load<std::uint32_t>(bytes.data(), swapped);
}

void VtkBytes::read(std::uint64_t first, std::uint64_t count, char* out) {
  const bool to_the_end = first + count == size_;
  if (!inflater_) {
    if (!stored_->seek(first) || !stored_->read(out, count)) fail_truncated();
  }
  while (inflater_ && count > 0) {
    const std::uint64_t last = places_.size() - 2;
    const std::uint64_t block = block_size_ == 0 ? last : std::min(first / block_size_, last);
    const std::uint64_t within = first - block * block_size_, full = block == last ? last_size_ : block_size_;
    const std::uint64_t here = std::min(count, full - within);
    if (!inflater_->read(*stored_, places_[block], places_[block + 1] - places_[block], full, within, here,
                         out))
      fail("its compressed data are damaged");
    first += here;
    count -= here;
    out += here;
  }
  if (!to_the_end) return;
  stored_->give_up_window();
  if (inflater_) inflater_->give_up();
}

void VtkBytes::fail(const std::string& reason) const { throw InputError(file_, entity_, reason); }
void VtkBytes::fail_truncated() const { fail("the file is truncated, or its data are damaged"); }

std::vector<char> vtk_block(std::span<const char> bytes) {
  uLongf length = compressBound(bytes.size());
  std::vector<char> block(length);
  // Cannot fail with this bound but for memory, of which the line before would have spoken.
  compress2(reinterpret_cast<Bytef*>(block.data()), &length, reinterpret_cast<const Bytef*>(bytes.data()),
            bytes.size(), Z_BEST_SPEED);
  block.resize(length);
  return block;
}

std::vector<char> vtk_compressed(std::span<const char> data) {
  std::vector<std::vector<char>> blocks(num_vtk_blocks(data.size()));
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    const std::uint64_t begin = i * kVtkBlockSize;
    blocks[i] = vtk_block(data.subspan(begin, std::min(kVtkBlockSize, data.size() - begin)));
  });
  const auto first = vtk_block_header(data.size());
  std::vector<std::uint64_t> header(first.begin(), first.end());
  for (const auto& block : blocks) header.push_back(block.size());
  std::vector<char> out(header.size() * sizeof(std::uint64_t));
  std::memcpy(out.data(), header.data(), out.size());
  for (const auto& block : blocks) out.insert(out.end(), block.begin(), block.end());
  return out;
}

}  // namespace weft::meshing
