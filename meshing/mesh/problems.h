// What checks find, in words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace weft::meshing {

/// The sentences found so far: the first `limit` are kept, the others only counted.
class Problems {
 public:
  explicit Problems(std::size_t limit) : limit_(limit) {}

  template <class... Parts>
  void add(const Parts&... parts) {
    ++count_;
    if (sentences_.size() >= limit_) return;
    std::ostringstream sentence;
    (sentence << ... << parts);
    sentences_.push_back(std::move(sentence).str());
  }
  /// Adds what another list has found, each sentence behind `prefix`.
  void append(Problems&& other, const std::string& prefix = {}) {
    count_ += other.count_;
    for (std::string& sentence : other.sentences_) {
      if (sentences_.size() >= limit_) return;
      sentences_.push_back(prefix + std::move(sentence));
    }
  }
  /// An empty list with the same limit.
  Problems fresh() const { return Problems(limit_); }
  std::size_t limit() const { return limit_; }
  std::uint64_t count() const { return count_; }
  std::vector<std::string> take() { return std::move(sentences_); }

 private:
  std::size_t limit_;
  std::uint64_t count_ = 0;
  std::vector<std::string> sentences_;
};

}  // namespace weft::meshing
