// What the processes of one node know of each other without the network: a doorbell each, and whether they
// live.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/sleeper.h"

namespace weft::engine {

/// One process's line of the table. All zero bytes are a valid, unused line.
struct alignas(64) NodePlace {
  Sleeper bell;
  std::atomic<std::int32_t> pid;
  std::atomic<std::uint64_t> started;  ///< tells the process from a later one with its pid
  std::atomic<bool> closed;            ///< it left as agreed, so its end is no accident
};

/// A table in memory shared by the processes of a node, one line a process. It stays mapped until it is
/// destroyed, longer than the network lasts: wake() may come at any time.
class NodeTable {
 public:
  /// A table of one line, in this process's memory only.
  NodeTable();

  /// How a table gets shared: one process creates it, tells the others its name, they attach, and when all
  /// have, the creator unlinks the name, after which nothing can be left behind however the processes end.
  /// Throws std::system_error.
  static NodeTable create(std::size_t lines, const std::string& name);
  static NodeTable attach(std::size_t lines, const std::string& name);
  static void unlink(const std::string& name) noexcept;

  std::size_t size() const { return lines_.size(); }
  NodePlace& operator[](std::size_t line) const { return lines_[line]; }

  /// Signs in as `line`.
  void enter(std::size_t line);

  /// From now on dead() reports lines whose processes are seen to be alive now. A process that cannot be seen
  /// (another process namespace) is never reported. Called when all have signed in.
  void watch(std::size_t self);

  bool watches(std::size_t line) const;

  /// A watched process that has ended without setting `closed`.
  std::optional<std::size_t> dead() const;

 private:
  struct Unmap {
    std::size_t bytes = 0;
    void operator()(void* memory) const noexcept;
  };
  using Memory = std::unique_ptr<void, Unmap>;

  NodeTable(Memory memory, std::size_t lines);
  static NodeTable map(int flags, std::size_t lines, const std::string& name);

  Memory memory_;
  std::span<NodePlace> lines_;
  std::vector<std::size_t> watched_;
};

}  // namespace weft::engine
